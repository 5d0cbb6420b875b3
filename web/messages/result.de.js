// Result page, in German.

/** @type {Record<string, import("../lib/i18n.js").Text>} */
export default {
  title: "Eine Kalibrierung · calibDB",
  description: "Eine Kalibrierung: wie gut sie ist, ihre Zahlen und die Bilder dahinter.",
  loading: "Die Kalibrierung wird geholt.",
  heading: "Eine Kalibrierung",
  no_id: "Die Adresse enthält keine Kennung einer Kalibrierung.",
  level_good: "Gut",
  level_fair: "Brauchbar",
  level_poor: "Schlecht",
  means_good: "Sie können sich darauf verlassen.",
  means_fair: "Sie ist brauchbar, könnte aber besser sein.",
  means_poor: "Verlassen Sie sich nicht darauf.",
  sentence: "Der erwartete Fehler ist {rms} px im Mittel über das Bild und {max} px an der schlechtesten Stelle.",
  reason_too_few_views: "So wenige Ansichten könnten zufällig übereinstimmen. Nehmen Sie mehr auf.",
  reason_no_tilt: "Die Tafel war kaum gekippt, daher ist die Brennweite geraten. Kippen Sie die Tafel stärker.",
  reason_edges_not_covered: "Die Tafel war kaum in der Nähe der Bildränder. Bringen Sie sie dorthin.",
  reason_uncertain:
    "Die Ansichten bestimmen das Objektiv nicht genau genug. Nehmen Sie mehr auf, von verschiedenen Seiten.",
  reason_over_fitted:
    "Die Kalibrierung erklärt Testansichten viel schlechter als die Ansichten in der Anpassung. Nehmen Sie mehr "
      + "auf.",
  reason_model_too_simple:
    "Alle Ansichten haben dasselbe Fehlermuster: Entweder ist dieses Modell zu einfach für das Objektiv, oder die "
      + "Tafel ist nicht eben. Wählen Sie das Modell {models}, oder kleben Sie die Tafel auf etwas Steifes.",
  reason_choose_model: "Das Objektiv verzeichnet stärker, als dieses Modell folgen kann. Wählen Sie das Modell {model}.",
  reason_board_bent: "Die Tafel ist nicht eben. Kleben Sie sie auf etwas Steifes, etwa Glas oder ein Tablett.",
  reason_motion: "Tafel oder Kamera haben sich während der Aufnahmen bewegt. Halten Sie länger still.",
  reason_focus_changed: "Die Schärfe hat sich zwischen den Ansichten geändert. Schalten Sie den Autofokus aus.",
  reason_board_not_flat: "Die Tafel ist gebogen oder verzerrt gedruckt. Das wurde berücksichtigt. Kleben Sie sie auf etwas Steifes.",
  reason_noisy:
    "Die Ecken sind ungenau: Unschärfe, Bewegung oder eine Tafel, die nicht eben ist. Sorgen Sie für mehr Licht "
      + "und halten Sie still.",
  reason_outliers: "Viele Ecken widersprechen den übrigen und wurden ausgelassen.",
  reason_views_left_out: "Ganze Ansichten widersprechen den übrigen und wurden ausgelassen. Sie sind unten markiert.",
  reason_limit_reached: "Fünfzehn Ansichten genügten nicht, um den Zielfehler zu erreichen.",
  reason_prediction_disagrees: "Der Fehler war größer als vorhergesagt.",
  part_numbers: "Zahlen",
  part_error: "Erwarteter Fehler",
  part_distortion: "Verzeichnung des Objektivs",
  part_coverage: "Abdeckung",
  part_views: "Ansichten",
  part_straight: "Vorher und nachher",
  part_take: "Herunterladen",
  part_help: "Ihr Beitrag",
  intrinsics: "Kameramatrix und Verzeichnung, {model}",
  quality: "Güte",
  reprojection: "Rückprojektionsfehler, alle Ecken einschließlich der ausgelassenen",
  held_out: "Fehler in Testansichten, die nicht in der Anpassung waren",
  uncertainty: "Erwarteter Fehler im Bild",
  spread: "Streuung der übereinstimmenden Kalibrierungen",
  across: "Bildwinkel, waagerecht",
  down: "Bildwinkel, senkrecht",
  diagonal: "Bildwinkel, von Ecke zu Ecke",
  error_label: "Erwarteter Fehler im Bild: im Mittel {mean} px, höchstens {max} px",
  error_caption:
    "Erwarteter Fehler eines Punkts nach seiner Lage im Bild: {mean} px im Mittel, {max} px höchstens. "
      + "Kräftigere Farbe bedeutet einen größeren Fehler.",
  distortion_label: "Verzeichnung der Linse: bis zu {max} px",
  distortion_caption:
    "Jede Linie führt von dort, wo ein Objektiv ohne Verzeichnung einen Punkt zeigen würde, dorthin, wo dieses "
      + "ihn zeigt: bis zu {max} px. Das Kreuz ist der Bildhauptpunkt.",
  magnified: "{factor}-fach vergrößert gezeichnet.",
  coverage_label: "Die Ecken decken {share} % des Bildes ab",
  coverage_caption: "Alle {count} gemessenen Ecken. Sie decken {share} % des Bildes ab.",
  views_text:
    "Jede Linie ist ein Residuum: Sie führt von einer gemessenen Ecke dorthin, wo die Kalibrierung sie "
      + "erwartet, {factor}-fach verlängert. Kurz und ungeordnet ist gut.",
  view: "Ansicht {index}",
  view_label: "Abweichungen der Ansicht {index}: {rms} px",
  view_left_out: "Ausgelassen: widerspricht den übrigen. Noch einmal aufnehmen.",
  view_stands_out: "Viel schlechter als die übrigen. Noch einmal aufnehmen.",
  view_some_cut: {
    one: "{count} Ecke ausgelassen, mit × markiert.",
    other: "{count} Ecken ausgelassen, mit × markiert.",
  },
  practice: "Das war ein Übungslauf mit einer simulierten Kamera.",
  worth: {
    one: "Nehmen Sie Ansicht {views} möglichst noch einmal auf.",
    other: "Nehmen Sie die Ansichten {views} möglichst noch einmal auf.",
  },
  leave_these: { one: "Ergebnis ohne diese Ansicht zeigen", other: "Ergebnis ohne sie zeigen" },
  leave_out: "Weglassen",
  take_back: "Wieder aufnehmen",
  fitting_without: "Die übrigen Ansichten werden angepasst.",
  without: {
    one: "Das Ergebnis ohne Ansicht {views}. Nur Sie sehen es.",
    other: "Das Ergebnis ohne die Ansichten {views}. Nur Sie sehen es.",
  },
  without_now: {
    one:
      "Ohne Ansicht {views} ist der erwartete Fehler {after} px, mit ihr {before} px. Die Brennweite fx ist "
        + "{fx} px, mit ihr {was} px.",
    other:
      "Ohne die Ansichten {views} ist der erwartete Fehler {after} px, mit ihnen {before} px. Die Brennweite fx "
        + "ist {fx} px, mit ihnen {was} px.",
  },
  without_impossible: "Ohne die Ansichten {views} bleibt zu wenig für eine Kalibrierung.",
  go_on_without: { one: "Ohne sie weitermachen", other: "Ohne sie weitermachen" },
  go_on_text: "Die anderen Ansichten bleiben. Genügen sie nicht, fragt die Seite nach neuen.",
  all_again: "Zurück zu allen Ansichten",
  calibrate_again: "Diese Kamera noch einmal kalibrieren",
  before: "Wie die Kamera es sieht",
  after: "Entzerrt",
  slider: "Wie viel des Bildes entzerrt ist",
  keep_edges: "Das ganze Bild behalten, mit schwarzen Rändern",
  no_webgl: "Dieser Browser kann das nicht zeigen, weil er kein WebGL hat.",
  trial: "Ausprobieren",
  trial_text:
    "Wählen Sie ein Bild, das diese Kamera in dieser Auflösung aufgenommen hat, und sehen Sie es entzerrt. Es "
      + "bleibt auf Ihrem Gerät.",
  picture: "Ein Bild",
  picture_shape: "Dieses Bild hat ein anderes Seitenverhältnis: Die Kalibrierung gilt für {size}.",
  picture_unreadable: "Dieser Browser kann das Bild nicht lesen.",
  format: "Format",
  download: "Herunterladen",
  address: "Dieses Ergebnis hat eine eigene Seite",
  as_answered: "Wie die API sie liefert",
  as_json: "Die Kalibrierung als JSON",
  back: "In {host} verwenden",
  back_text: "{host} hat um diese Kalibrierung gebeten. Es erhält ihre Kennung und sonst nichts.",
  back_refused:
    "{host} hat um diese Kalibrierung gebeten, aber dieser Dienst gibt keine Ergebnisse an diese Anwendung.",
  help_added:
    "Sie haben die Lage der Ecken, Namen und Einstellungen Ihrer Kamera und das System, das Ihr Browser nennt, "
      + "beigetragen. Kein Bild hat dieses Gerät verlassen. Sobald fünf Kalibrierungen dieser Kamera "
      + "übereinstimmen, kann jede Webseite sie nachschlagen.",
  missing: "Diese Kalibrierung gibt es nicht.",
  search: "Alle Kameras durchsuchen",
  calibrate: "Eine Kamera kalibrieren",
  help_photographs:
    "Sie haben die Lage der Ecken und die Größe der Bilder beigetragen, ob es Fotos oder ein Video sind, und "
      + "was Sie über Kamera, Objektiv und Brennweite angegeben haben. Kein Bild hat dieses Gerät verlassen. Sobald "
      + "fünf Kalibrierungen dieser Kamera übereinstimmen, kann jede Webseite sie nachschlagen.",
  help_imported:
    "Sie haben die Lage der Ecken, die Größe der Bilder, den Namen Ihrer Kamera und das System, das Ihr Browser "
      + "nennt, beigetragen. Die Datei hat dieses Gerät nicht verlassen. Sobald fünf Kalibrierungen dieser Kamera "
      + "übereinstimmen, kann jede Webseite sie nachschlagen.",
  help_practice: "Das war ein Übungslauf mit einer simulierten Kamera. Ihre eigene Kamera ist noch nicht kalibriert.",
  help_stored: {
    one:
      "Dahinter steht {count} Kalibrierung. Sobald fünf einer Kamera übereinstimmen, kann jede Webseite sie "
        + "nachschlagen.",
    other:
      "Dahinter stehen {count} Kalibrierungen. Sobald fünf einer Kamera übereinstimmen, kann jede Webseite sie "
        + "nachschlagen.",
  },
};
