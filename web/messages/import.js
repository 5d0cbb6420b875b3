// Import and conversion of another program's calibration file.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "Import or convert a calibration · calibDB",
    description:
      "Calibrate from another program's corners, or convert a calibration file: OpenCV, ROS, Kalibr, COLMAP, "
        + "mrcal and more.",
    heading: "Import or convert a calibration",
    lead:
      "Bring a file from another program. If it has the corners that were measured, calibDB calibrates from "
        + "them and judges the result. If it only has the camera, you can view it, convert it, and compare it with "
        + "the database.",
    choose: "A calibration file",
    stays:
      "<0>The file is opened on this device.</0> Nothing is sent until you ask for it: corner positions to "
        + "calibrate, the text of the file to convert it. A conversion stores nothing.",
    reading: "Reading {name}.",
    found: {
      one: "{count} view of a board of {squares} squares, {size} px.",
      other: "{count} views of a board of {squares} squares, {size} px.",
    },
    was_read: "{name} was read.",
    best: "Only the {most} most informative ones are used.",
    which_board:
      "A table of corners leaves something out. Enter the squares of the board and the size of the pictures.",
    squares: "Squares of the board, across and down",
    columns: "Squares across",
    rows: "Squares down",
    size: "Size of the pictures, px",
    width: "Width",
    height: "Height",
    read_table: "Read the table",
    view_label: { one: "{name}: {count} corner", other: "{name}: {count} corners" },
    kind: "The camera is",
    kind_webcam: "a webcam of this device",
    kind_photographs: "a camera that took photographs",
    kind_video: "a camera that took a video",
    webcam: "Its name, as the browser shows it",
    not_enough: "A calibration needs four views that agree. The file has fewer. Nothing was stored.",
    nothing_taken: "None of these views is enough to fit a camera. Nothing was stored.",
    guess: "Results, but no measurements",
    guess_text:
      "This file has results but no measurements, so we can't verify it. You can still view it, convert it, "
        + "and compare it with the database.",
    packed: "The corners are packed",
    packed_text:
      "mrcal packs its measurements into the file. calibDB can unpack them and calibrate from them; a larger file it "
        + "takes as a table of corners (.vnl).",
    matrix: "Its camera matrix, px",
    wrong_large: "The file is larger than {most} MB. Nothing was sent.",
    wrong_unreadable: "The browser could not read the file. Choose it again.",
    wrong_unknown: "This page does not recognise the file as a calibration file. Nothing was sent.",
    wrong_json: "The file is damaged: it starts like JSON, but is not valid JSON. Nothing was sent.",
    wrong_number: "The file is damaged: “{what}” is missing or invalid. Nothing was sent.",
    wrong_many: "The file has more than {most} views. Nothing was sent.",
    wrong_count:
      "The file is damaged: view {index} has different numbers of points in the picture and on the board. "
        + "Nothing was sent.",
    wrong_fields: "Line {line} of the table does not contain the position of a corner. Nothing was sent.",
    wrong_lines: "A board of these squares has {corners} corners, but {name} has {lines} lines. Is it another board?",
    wrong_empty: "The file contains no corners. Nothing was sent.",
    wrong_practice: "The file comes from a practice run with the simulated camera. It tells nothing of a real camera. Nothing was sent.",
    wrong_outside: "{name} has corners outside of a picture of {size} px. Is the size right?",
    wrong_line: "All corners lie on one line, so this is not a board. Nothing was sent.",
    wrong_flat: "The board is not flat. calibDB supports flat boards only. Nothing was sent.",
    wrong_board: "calibDB does not support a board of {columns} × {rows} corners. Nothing was sent.",
    wrong_rows: "The corners are not evenly spaced in rows and columns like those of a chessboard. Nothing was sent.",
    wrong_twice: "{name} contains the same corner twice. Nothing was sent.",
    drop_hint: "or drop it here",
    kinds_corners: "PhotonVision (JSON), tables of corners (.vnl)",
    kinds_corners_text: "calibrated anew and verified",
    kinds_camera: "OpenCV, ROS, Kalibr, COLMAP, mrcal, Gyroflow and others",
    kinds_camera_text: "viewed, converted, compared",
    photos_instead: "Calibrate with photos instead",
    own_page: "This is a calibDB file. Open its page",
    open: "Open and convert",
    unpack: "Calibrate from its corners",
    open_text: "To open the camera, the text of the file is sent to calibDB. Nothing is stored.",
    needs_size: "This file does not say how large the pictures are. Enter their size in pixels.",
    no_camera: "No camera was found in this file. Choose a calibration file with a camera matrix.",
    part_camera: "Camera",
    part_convert: "Convert",
    part_view: "View",
    part_compare: "Compare with the database",
    value_name: "Name",
    value_size: "Picture size",
    value_model: "Lens",
    format: "Format",
    convert: "Convert and download",
    compare_text: "See how far this camera is from the one that calibDB knows under a name.",
    compare_label: "Camera",
    compare_example: "e.g. C920",
    compare_search: "Search",
    compare_none: "No camera of this name is in the database.",
    compare_no_size: "The database has no calibration of this camera at {size} px.",
    difference_label: "Difference of the two cameras: {rms} px typically, {max} px at most",
    difference_caption:
      "Difference from the database: typically {rms} px, at most {max} px. A rotation of the camera is left "
        + "out.",
  },
  de: {
    title: "Kalibrierung importieren oder umwandeln · calibDB",
    description:
      "Aus den Ecken eines anderen Programms kalibrieren oder eine Kalibrierdatei umwandeln: OpenCV, ROS, "
        + "Kalibr, COLMAP, mrcal und mehr.",
    heading: "Kalibrierung importieren oder umwandeln",
    lead:
      "Bringen Sie die Datei eines anderen Programms mit. Enthält sie die gemessenen Ecken, kalibriert calibDB "
        + "daraus neu und beurteilt das Ergebnis. Enthält sie nur die Kamera, können Sie sie ansehen, umwandeln "
        + "und mit der Datenbank vergleichen.",
    choose: "Eine Kalibrierdatei",
    stays:
      "<0>Die Datei wird auf diesem Gerät geöffnet.</0> Gesendet wird erst, wenn Sie es wollen: zum "
        + "Kalibrieren die Positionen der Ecken, zum Umwandeln der Text der Datei. Beim Umwandeln wird nichts "
        + "gespeichert.",
    reading: "{name} wird gelesen.",
    found: {
      one: "{count} Ansicht einer Tafel mit {squares} Feldern, {size} px.",
      other: "{count} Ansichten einer Tafel mit {squares} Feldern, {size} px.",
    },
    was_read: "{name} wurde gelesen.",
    best: "Verwendet werden nur die {most} aussagekräftigsten.",
    which_board: "In einer Eckentabelle steht nicht alles. Geben Sie die Felder der Tafel und die Größe der Bilder an.",
    squares: "Felder der Tafel, waagerecht und senkrecht",
    columns: "Felder waagerecht",
    rows: "Felder senkrecht",
    size: "Größe der Bilder, px",
    width: "Breite",
    height: "Höhe",
    read_table: "Tabelle lesen",
    view_label: { one: "{name}: {count} Ecke", other: "{name}: {count} Ecken" },
    kind: "Die Kamera ist",
    kind_webcam: "eine Webcam dieses Geräts",
    kind_photographs: "eine Kamera, die Fotos gemacht hat",
    kind_video: "eine Kamera, die ein Video gemacht hat",
    webcam: "Ihr Name, wie ihn der Browser zeigt",
    not_enough: "Eine Kalibrierung braucht vier Ansichten, die zueinander passen. Die Datei hat weniger. Es wurde nichts gespeichert.",
    nothing_taken: "Keine dieser Ansichten genügt, um eine Kamera zu bestimmen. Es wurde nichts gespeichert.",
    guess: "Ergebnisse, aber keine Messungen",
    guess_text:
      "Diese Datei enthält Ergebnisse, aber keine Messungen, deshalb können wir sie nicht prüfen. Ansehen, "
        + "umwandeln und mit der Datenbank vergleichen können Sie sie trotzdem.",
    packed: "Die Ecken sind verpackt",
    packed_text:
      "mrcal verpackt seine Messungen in der Datei. calibDB kann sie auspacken und daraus kalibrieren; eine größere Datei "
        + "exportieren Sie bitte als Eckentabelle (.vnl).",
    matrix: "Ihre Kameramatrix, px",
    wrong_large: "Die Datei ist größer als {most} MB. Nichts wurde gesendet.",
    wrong_unreadable: "Der Browser konnte die Datei nicht lesen. Wählen Sie sie noch einmal.",
    wrong_unknown: "Diese Seite erkennt die Datei nicht als Kalibrierdatei. Es wurde nichts gesendet.",
    wrong_json:
      "Die Datei ist beschädigt: Sie beginnt wie JSON, ist aber kein gültiges JSON. Es wurde nichts gesendet.",
    wrong_number: "Die Datei ist beschädigt: „{what}“ fehlt oder ist ungültig. Es wurde nichts gesendet.",
    wrong_many: "Die Datei hat mehr als {most} Ansichten. Es wurde nichts gesendet.",
    wrong_count:
      "Die Datei ist beschädigt: Ansicht {index} hat im Bild und auf der Tafel verschieden viele Punkte. Es "
        + "wurde nichts gesendet.",
    wrong_fields: "Zeile {line} der Tabelle enthält keine Position einer Ecke. Es wurde nichts gesendet.",
    wrong_lines:
      "Eine Tafel mit diesen Feldern hat {corners} Ecken, aber {name} hat {lines} Zeilen. Ist es eine andere "
        + "Tafel?",
    wrong_empty: "Die Datei enthält keine Ecken. Es wurde nichts gesendet.",
    wrong_practice: "Die Datei stammt aus einem Übungslauf mit der simulierten Kamera. Über eine echte Kamera sagt sie nichts. Es wurde nichts gesendet.",
    wrong_outside: "{name} hat Ecken außerhalb eines Bildes von {size} px. Stimmt die Größe?",
    wrong_line: "Alle Ecken liegen auf einer Geraden; das ist keine Tafel. Es wurde nichts gesendet.",
    wrong_flat: "Die Tafel ist nicht eben. calibDB unterstützt nur ebene Tafeln. Es wurde nichts gesendet.",
    wrong_board: "calibDB unterstützt keine Tafel mit {columns} × {rows} Ecken. Es wurde nichts gesendet.",
    wrong_rows:
      "Die Ecken liegen nicht in gleichmäßigen Zeilen und Spalten wie die eines Schachbretts. Es wurde nichts "
        + "gesendet.",
    wrong_twice: "{name} enthält dieselbe Ecke zweimal. Es wurde nichts gesendet.",
    drop_hint: "oder hier ablegen",
    kinds_corners: "PhotonVision (JSON), Eckentabellen (.vnl)",
    kinds_corners_text: "neu kalibriert und geprüft",
    kinds_camera: "OpenCV, ROS, Kalibr, COLMAP, mrcal, Gyroflow und andere",
    kinds_camera_text: "angesehen, umgewandelt, verglichen",
    photos_instead: "Stattdessen aus Fotos kalibrieren",
    own_page: "Das ist eine Datei von calibDB. Zur Seite der Kalibrierung",
    open: "Öffnen und umwandeln",
    unpack: "Aus diesen Ecken kalibrieren",
    open_text: "Zum Öffnen der Kamera wird der Text der Datei an calibDB gesendet. Gespeichert wird nichts.",
    needs_size: "In der Datei steht nicht, wie groß die Bilder sind. Geben Sie ihre Größe in Pixeln an.",
    no_camera: "In dieser Datei wurde keine Kamera gefunden. Wählen Sie eine Kalibrierdatei mit Kameramatrix.",
    part_camera: "Kamera",
    part_convert: "Umwandeln",
    part_view: "Ansehen",
    part_compare: "Mit der Datenbank vergleichen",
    value_name: "Name",
    value_size: "Bildgröße",
    value_model: "Objektiv",
    format: "Format",
    convert: "Umwandeln und herunterladen",
    compare_text: "So weit ist diese Kamera von der entfernt, die calibDB unter einem Namen kennt.",
    compare_label: "Kamera",
    compare_example: "z. B. C920",
    compare_search: "Suchen",
    compare_none: "In der Datenbank gibt es keine Kamera dieses Namens.",
    compare_no_size: "Für diese Kamera gibt es keine Kalibrierung mit {size} px.",
    difference_label: "Abweichung der beiden Kameras: typisch {rms} px, höchstens {max} px",
    difference_caption:
      "Abweichung von der Datenbank: typisch {rms} px, höchstens {max} px. Eine Drehung der Kamera ist "
        + "herausgerechnet.",
  },
  uk: {
    title: "Імпорт і перетворення калібрувань · calibDB",
    description:
      "Калібрування за кутами з іншої програми або перетворення калібрувального файлу: OpenCV, ROS, Kalibr, "
        + "COLMAP, mrcal тощо.",
    heading: "Імпорт і перетворення калібрувань",
    lead:
      "Візьміть файл іншої програми. Якщо в ньому є виміряні кути, calibDB відкалібрує за ними камеру наново й "
        + "оцінить результат. Якщо ж там лише камера, її можна переглянути, перетворити й порівняти з базою.",
    choose: "Калібрувальний файл",
    stays:
      "<0>Файл відкривається на цьому пристрої.</0> Надсилається лише те, про що ви попросите: для "
        + "калібрування — положення кутів, для перетворення — текст файлу. Під час перетворення нічого не "
        + "зберігається.",
    reading: "Читаємо {name}.",
    found: {
      one: "{count} знімок дошки {squares} клітинок, {size} px.",
      few: "{count} знімки дошки {squares} клітинок, {size} px.",
      many: "{count} знімків дошки {squares} клітинок, {size} px.",
      other: "{count} знімка дошки {squares} клітинок, {size} px.",
    },
    was_read: "{name} прочитано.",
    best: "Використано лише {most} найінформативніших.",
    which_board: "У таблиці кутів є не все. Вкажіть кількість клітинок дошки й розмір зображень.",
    squares: "Клітинок на дошці, впоперек і вниз",
    columns: "Клітинок упоперек",
    rows: "Клітинок униз",
    size: "Розмір знімків, px",
    width: "Ширина",
    height: "Висота",
    read_table: "Прочитати таблицю",
    view_label: {
      one: "{name}: {count} кут",
      few: "{name}: {count} кути",
      many: "{name}: {count} кутів",
      other: "{name}: {count} кута",
    },
    kind: "Камера — це",
    kind_webcam: "вебкамера цього пристрою",
    kind_photographs: "камера, що робила фотографії",
    kind_video: "камера, що знімала відео",
    webcam: "Її назва, як показує браузер",
    not_enough: "Для калібрування потрібно чотири узгоджені знімки. У файлі їх менше. Нічого не збережено.",
    nothing_taken: "Жодного з цих знімків не досить, щоб визначити камеру. Нічого не збережено.",
    guess: "Результати без вимірювань",
    guess_text:
      "У цьому файлі є результати, але немає вимірювань, тож перевірити його ми не можемо. Проте його можна "
        + "переглянути, перетворити й порівняти з базою.",
    packed: "Кути запаковано",
    packed_text:
      "mrcal запаковує вимірювання у файл. calibDB може розпакувати їх і відкалібрувати камеру; більший файл "
        + "експортуйте як таблицю кутів (.vnl).",
    matrix: "Його матриця камери, px",
    wrong_large: "Файл більший за {most} МБ. Нічого не надіслано.",
    wrong_unreadable: "Браузер не зміг прочитати файл. Виберіть його ще раз.",
    wrong_unknown: "Сторінка не розпізнала файл як калібрувальний. Нічого не надіслано.",
    wrong_json: "Файл пошкоджено: він починається як JSON, але не є дійсним JSON. Нічого не надіслано.",
    wrong_number: "Файл пошкоджено: «{what}» бракує або воно неправильне. Нічого не надіслано.",
    wrong_many: "У файлі понад {most} знімків. Нічого не надіслано.",
    wrong_count:
      "Файл пошкоджено: у знімку {index} різна кількість точок на зображенні й на дошці. Нічого не надіслано.",
    wrong_fields: "Рядок {line} таблиці не містить положення кута. Нічого не надіслано.",
    wrong_lines: "Дошка з такими клітинками має кутів: {corners}, а {name} має рядків: {lines}. Може, це інша дошка?",
    wrong_empty: "Файл не містить кутів. Нічого не надіслано.",
    wrong_practice: "Файл походить із тренування з імітованою камерою. Про справжню камеру він нічого не каже. Нічого не надіслано.",
    wrong_outside: "У {name} є кути поза знімком розміром {size} px. Чи правильний розмір?",
    wrong_line: "Усі кути лежать на одній прямій, тож це не дошка. Нічого не надіслано.",
    wrong_flat: "Дошка не пласка. calibDB підтримує лише пласкі дошки. Нічого не надіслано.",
    wrong_board: "calibDB не підтримує дошку з {columns} × {rows} кутів. Нічого не надіслано.",
    wrong_rows: "Кути не розташовані рівномірними рядками й стовпцями, як на шахівниці. Нічого не надіслано.",
    wrong_twice: "{name} містить той самий кут двічі. Нічого не надіслано.",
    drop_hint: "або перетягніть його сюди",
    kinds_corners: "PhotonVision (JSON), таблиці кутів (.vnl)",
    kinds_corners_text: "нове калібрування з перевіркою",
    kinds_camera: "OpenCV, ROS, Kalibr, COLMAP, mrcal, Gyroflow та інші",
    kinds_camera_text: "перегляд, перетворення, порівняння",
    photos_instead: "Натомість калібрувати за фото",
    own_page: "Це файл calibDB. Відкрити його сторінку",
    open: "Відкрити й перетворити",
    unpack: "Калібрувати за цими кутами",
    open_text: "Щоб відкрити камеру, текст файлу надсилається до calibDB. Нічого не зберігається.",
    needs_size: "У файлі не сказано, якого розміру зображення. Вкажіть їхній розмір у пікселях.",
    no_camera: "Камери в цьому файлі не знайдено. Виберіть калібрувальний файл із матрицею камери.",
    part_camera: "Камера",
    part_convert: "Перетворення",
    part_view: "Перегляд",
    part_compare: "Порівняння з базою",
    value_name: "Назва",
    value_size: "Розмір зображення",
    value_model: "Об’єктив",
    format: "Формат",
    convert: "Перетворити й завантажити",
    compare_text: "Дізнайтеся, наскільки ця камера відрізняється від тієї, яку calibDB знає під такою назвою.",
    compare_label: "Камера",
    compare_example: "напр. C920",
    compare_search: "Знайти",
    compare_none: "Камери з такою назвою в базі немає.",
    compare_no_size: "У базі немає калібрування цієї камери для {size} px.",
    difference_label: "Різниця двох камер: зазвичай {rms} px, щонайбільше {max} px",
    difference_caption: "Різниця з базою: зазвичай {rms} px, щонайбільше {max} px. Поворот камери не враховано.",
  },
};
