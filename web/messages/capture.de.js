// Guided capture, in German.

/** @type {Record<string, import("../lib/i18n.js").Text>} */
export default {
  title: "Eine Kamera kalibrieren · calibDB",
  description: "Halten Sie eine Tafel dorthin, wo der Umriss sie zeigt, und calibDB kalibriert die Kamera.",
  viewfinder: "Sucher",
  video: "Das Bild der Kamera",
  follow: "Folgen Sie dem Umriss",
  sent_lead: "Außer den Positionen der Ecken wird nur dies gesendet:",
  sent_label: "Was über die Kamera gesendet wird",
  progress: "Fortschritt der Kalibrierung",

  heading: "Eine Kamera kalibrieren",
  lead:
    "Halten Sie die Tafel dorthin, wo der Umriss sie zeigt, und halten Sie still. Die Seite nimmt Ansichten "
      + "selbst auf; vier oder fünf genügen.",
  need_board:
    "Zeigen Sie die <0>Kalibriertafel</0> auf einem zweiten Bildschirm oder Tablet, oder drucken Sie sie und "
      + "kleben sie auf etwas Steifes.",
  permission:
    "Öffnen Sie die Kamera. Ihr Browser fragt, ob diese Seite sie benutzen darf. <0>Bilder verlassen dieses "
      + "Gerät nie.</0>",
  what_is_sent: "Was wird gesendet?",
  privacy:
    "Die Positionen der Ecken der Tafel; der Name, den Ihr Browser der Kamera gibt; ihre Einstellungen "
      + "(Auflösung, Zoom, Fokus, Bildrate); das Betriebssystem, das Ihr Browser meldet; sowie Tafel, "
      + "Objektivmodell und Genauigkeit, die verlangt sind. Nie ein Bild.",
  resolution: "Auflösung",
  largest: "Die größte der Kamera",
  got_size: "Die Kamera liefert {size}, also kalibriert diese Seite diese Größe.",
  photos: "Haben Sie stattdessen Fotos?",
  camera: "Kamera",
  open: "Kamera öffnen",
  try_virtual: "Keine Kamera? Die virtuelle ausprobieren",
  virtual: "Die virtuelle Kamera ausprobieren",
  virtual_name: "Virtuelle Kamera, zum Üben",
  camera_number: "Kamera {number}",
  no_camera: "Keine Kamera gefunden",
  camera_at: "{camera} mit {size}",
  asked_for: "Verlangt: {camera}.",
  not_among: "Sie ist nicht unter den Kameras, die hier gefunden wurden.",
  none_here: "Hier wurde keine Kamera gefunden. Schließen Sie sie an.",
  none_at_all: "Keine Kamera gefunden. Schließen Sie eine an oder üben Sie mit der virtuellen Kamera.",
  another_opened: "Verlangt: {asked}. Geöffnet: {opened}. Das Ergebnis gilt für die geöffnete Kamera.",
  interrupted: {
    one:
      "Eine Aufnahme mit {camera} wurde unterbrochen. Ihre {count} Ansicht ist auf diesem Gerät gespeichert. "
        + "Öffnen Sie dieselbe Kamera, um fortzufahren.",
    other:
      "Eine Aufnahme mit {camera} wurde unterbrochen. Ihre {count} Ansichten sind auf diesem Gerät gespeichert. "
        + "Öffnen Sie dieselbe Kamera, um fortzufahren.",
  },
  go_on: "Fortfahren",
  forget: "Verwerfen",

  getting_ready: "Gleich geht es los",
  opening_camera: "Warten auf die Kamera. Wenn Ihr Browser fragt, erlauben Sie sie.",
  opening_loading: "Die Tafelerkennung wird geladen, beim ersten Mal 12 MB.",
  opening_starting: "Die Tafelerkennung startet.",
  opening_service: "Bei calibDB wird eine Sitzung geöffnet.",
  opening_retry: "Die Verbindung zu calibDB ist abgebrochen. Neuer Versuch.",
  loading: "Tafelerkennung laden",
  cancel: "Abbrechen",

  say_show: "Zeigen Sie der Kamera die Tafel",
  say_slower: "Näher, oder etwas langsamer",
  say_more: "Mehr von der Tafel zeigen",
  say_wait: "Einen Moment",
  say_enough: "Genug Ansichten. Warten auf calibDB",
  say_away: "Warten auf calibDB",
  say_retry: "Verbindung weg. Neuer Versuch",
  say_stalled: "Die Tafelerkennung startet neu",
  say_hold: "Still halten",
  say_match: "Mit dem Umriss zur Deckung bringen",
  say_first: "Mit dem Umriss zur Deckung bringen",
  say_left: "Nach links",
  say_right: "Nach rechts",
  say_up: "Nach oben",
  say_down: "Nach unten",
  say_up_left: "Nach links oben",
  say_up_right: "Nach rechts oben",
  say_down_left: "Nach links unten",
  say_down_right: "Nach rechts unten",
  say_closer: "Näher an die Kamera",
  say_farther: "Weiter weg von der Kamera",
  say_tilt_top: "Obere Kante näher heran",
  say_tilt_bottom: "Untere Kante näher heran",
  say_tilt_left: "Linke Kante näher heran",
  say_tilt_right: "Rechte Kante näher heran",
  say_turn_clockwise: "Nach rechts drehen",
  say_turn_counterclockwise: "Nach links drehen",
  say_dark: "Zu dunkel",
  say_bright: "Zu hell",
  say_blurred: "Unscharf",
  say_far: "Zu weit weg",
  say_wrong_board: "Das ist eine andere Tafel",
  say_legacy: "Diese Tafel hat die ältere Anordnung",
  say_mirrored: "Das Bild ist gespiegelt",
  say_moire: "Streifen im Bild",
  say_moving: "Langsamer bewegen",

  do_show: "Noch keine Tafel? „Tafel“ oben öffnet eine, für einen anderen Bildschirm oder zum Drucken.",
  do_dark: "Machen Sie Licht, oder drehen Sie die Tafel zum Fenster.",
  do_bright: "Drehen Sie die Tafel vom Licht weg, oder verringern Sie die Helligkeit ihres Bildschirms.",
  do_blurred:
    "Halten Sie still und etwas weiter weg; wischen Sie das Objektiv ab; lassen Sie die Kamera scharfstellen.",
  do_far: "Die Felder sind zu klein zum Messen. Kommen Sie näher.",
  do_wrong_board:
    "Ihre Marken gehören zu einer anderen Tafel als der verlangten. Öffnen Sie die richtige über den Link oben.",
  do_legacy:
    "Sie wurde für OpenCV vor 4.6 gemacht. Die Seite stellt sich von selbst darauf ein; Sie können auch eine "
      + "neue drucken.",
  do_mirrored: "Schalten Sie die Spiegelung in den Einstellungen oder im Programm der Kamera aus.",
  do_moire:
    "Gehen Sie etwas näher oder weiter weg, oder verringern Sie die Helligkeit des Bildschirms: Seine Pixel "
      + "überlagern sich mit denen der Kamera.",
  do_moving: "Die Kamera liest das Bild zeilenweise aus; schnelle Bewegung verzerrt es.",

  view_taken: "Ansicht {number} aufgenommen.",
  view_stored: "Ansicht gespeichert. Sie wird gesendet, sobald calibDB wieder da ist.",
  view_undone: "Die letzte Ansicht wurde zurückgenommen.",
  undo_away: "Die letzte Ansicht lässt sich erst zurücknehmen, wenn calibDB wieder da ist.",
  view_set_aside: "Ansicht {number} passt nicht zu den anderen und wurde ausgelassen.",
  refused: "Diese Ansicht wurde nicht genommen.",
  refused_too_few_points: "Von der Tafel war zu wenig zu sehen.",
  refused_degenerate: "Diese Ansicht allein genügt nicht. Kippen Sie die Tafel.",
  refused_mirrored: "Das Bild ist gespiegelt. Schalten Sie das in den Einstellungen der Kamera aus.",
  refused_outlier: "Diese Ansicht passte nicht zu den anderen. Ist die Tafel eben?",
  refused_no_information: "Diese Ansicht bringt nichts Neues. Folgen Sie dem Umriss.",
  useless: "Eine bessere Stellung wird gesucht.",
  press_again: {
    one: "Noch einmal drücken beendet die Aufnahme; {count} Ansicht geht verloren.",
    other: "Noch einmal drücken beendet die Aufnahme; {count} Ansichten gehen verloren.",
  },
  came_back_only: "calibDB ist wieder da.",
  sending: "calibDB ist wieder da. Die gespeicherten Ansichten werden gesendet.",
  came_back: "calibDB ist wieder da. Alle Ansichten wurden gesendet.",
  came_back_less: {
    one: "calibDB ist wieder da. {count} Ansicht brachte nichts Neues.",
    other: "calibDB ist wieder da. {count} Ansichten brachten nichts Neues.",
  },
  away_now: "Keine Verbindung. Machen Sie weiter: Ansichten werden auf diesem Gerät gespeichert.",
  away_enough:
    "Keine Verbindung. Auf diesem Gerät sind genug Ansichten gespeichert; sie werden gesendet, sobald calibDB "
      + "wieder da ist.",
  begun_anew: "Die Sitzung war abgelaufen. Eine neue Sitzung hat Ihre Ansichten.",
  was_hidden: "Solange diese Seite verborgen war, wurden keine Ansichten aufgenommen. Sie können weitermachen.",
  not_kept: "Dieser Browser kann keine Ansichten speichern. Schließen Sie die Seite nicht.",
  resized:
    "Das Bild hat jetzt eine andere Größe; das ist eine eigene Kalibrierung. Drehen Sie das Gerät zurück, um "
      + "die erste fortzusetzen.",
  legacy_taken: "Die Tafel hat die ältere Anordnung. Die Seite verwendet sie jetzt.",
  advice_prediction_disagrees:
    "Die Ansichten stimmen nicht so gut überein, wie sie sollten. calibDB braucht noch einige.",
  advice_model_too_simple: "Dieses Modell ist zu einfach für das Objektiv. „{model}“ würde besser passen.",
  advice_board_bent: "Die Tafel ist nicht eben. Kleben Sie sie auf etwas Steifes, etwa Glas oder ein Tablett.",
  advice_motion: "Tafel oder Kamera bewegen sich während der Aufnahme. Halten Sie länger still.",
  advice_focus_changed: "Die Schärfe ändert sich zwischen den Ansichten. Schalten Sie den Autofokus aus.",
  advice_limit_reached: "Die Aufnahme hat ihre Grenze von 15 Ansichten erreicht.",

  views: { one: "{count} Ansicht", other: "{count} Ansichten" },
  set_aside: { one: "{count} ausgelassen", other: "{count} ausgelassen" },
  waiting_views: { one: "{count} wartet", other: "{count} warten" },
  kept_of: "{count} von {wanted} hier gespeichert",
  with_model: "Neu beginnen mit „{model}“",
  zoom: "Zoom {zoom}",
  cropped: "vom Browser beschnitten",
  undo: "Zurücknehmen",
  skip: "Andere Stellung",
  stop: "Aufhören",
  stop_really: "Aufhören?",
  reached: "± {reached}, Ziel {goal} px",
  senses: "Zeichen",
  sound: "Ton",
  vibration: "Vibration",
  voice: "Gesprochene Hinweise",

  failed: "Das hat nicht geklappt",
  again: "Noch einmal versuchen",
  other: "Andere Kamera wählen",
  kept: {
    one: "{count} Ansicht ist gespeichert. Versuchen Sie es mit derselben Kamera noch einmal, um fortzufahren.",
    other: "{count} Ansichten sind gespeichert. Versuchen Sie es mit derselben Kamera noch einmal, um fortzufahren.",
  },
  fault_not_allowed:
    "Der Browser durfte die Kamera nicht verwenden. Erlauben Sie es in der Adresszeile oder in den "
      + "Systemeinstellungen, und versuchen Sie es dann noch einmal.",
  fault_not_found: "Es wurde keine Kamera gefunden. Schließen Sie eine an, oder probieren Sie die virtuelle.",
  fault_in_use: "Ein anderes Programm benutzt die Kamera. Schließen Sie es, und versuchen Sie es noch einmal.",
  fault_too_strict: "Die Kamera kann diese Auflösung nicht liefern. Wählen Sie eine andere.",
  fault_interrupted:
    "Die Kamera ist nicht angelaufen. Schließen Sie andere Programme, die sie benutzen könnten, und versuchen "
      + "Sie es noch einmal.",
  fault_no_picture:
    "Die Kamera ist geöffnet, sendet aber kein Bild. Ziehen Sie sie ab und stecken Sie sie wieder ein, oder "
      + "schließen Sie andere Programme, die sie verwenden könnten.",
  fault_insecure:
    "Browser lassen nur sichere Seiten Kameras verwenden. Öffnen Sie diese Seite über HTTPS oder auf localhost.",
  fault_elsewhere:
    "Diese Kamera wird in einem anderen Tab kalibriert. Machen Sie dort weiter, oder schließen Sie ihn und "
      + "versuchen Sie es noch einmal.",
  fault_gone: "Diese Kamera ist nicht mehr angeschlossen. Schließen Sie sie an, oder wählen Sie eine andere.",
  fault_not_opened: "Die Kamera ließ sich nicht öffnen ({detail}).",
  fault_unplugged: "Die Kamera wurde abgezogen. Stecken Sie sie wieder ein, und diese Seite macht von selbst weiter.",
  fault_resized: "Die Größe des Bildes hat sich geändert.",
  fault_offline: "calibDB ist nicht zu erreichen. Prüfen Sie die Verbindung, und versuchen Sie es noch einmal.",
  fault_settings: "Die Einstellungen der Seite fehlen. Versuchen Sie es später noch einmal.",
  fault_service: "{detail}",
  fault_detector: "Die Tafelerkennung hat versagt ({detail}). Versuchen Sie es noch einmal.",
  fault_detector_missing: "Die Tafelerkennung fehlt. Versuchen Sie es später noch einmal.",
  fault_detector_lost:
    "Die Tafelerkennung ließ sich nicht laden. Prüfen Sie die Verbindung, und versuchen Sie es noch einmal.",
  fault_detector_silent: "Die Tafelerkennung antwortet nicht. Laden Sie die Seite neu.",
  fault_unforeseen: "Auf dieser Seite ist etwas schiefgegangen ({detail}).",

  practice: "Das war Übung mit einer simulierten Kamera. Die Kalibrierung gilt für keine echte Kamera.",
  once_more: "Noch einmal kalibrieren",
};
