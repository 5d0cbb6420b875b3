// Calibration from another program's file.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "Calibrate from another program's file · calibDB",
    description: "Calibrate a camera from another program's measurements: PhotonVision files and tables of corners.",
    heading: "From another program",
    lead:
      "A file of another calibration program may contain the positions of the board's corners. calibDB "
        + "calibrates the camera anew from these, and judges the result like every other.",
    choose: "Choose the file, or drop it here",
    kinds:
      "This page reads corners from PhotonVision's JSON files and from tables of corners (.vnl). For other "
        + "files it tells you what you can do with them.",
    stays:
      "<0>The file stays on this device.</0> What is sent: the positions of the corners, and the camera details "
        + "that you see below.",
    reading: "Reading {name}.",
    found: {
      one: "{count} view of a board of {squares} squares, {size} px.",
      other: "{count} views of a board of {squares} squares, {size} px.",
    },
    was_read: "{name} was read.",
    best: "Only the {most} most informative ones are used.",
    which_board:
      "A table of corners does not contain everything. Enter the squares of the board and the size of the "
        + "pictures.",
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
    not_enough: "These corners are not enough: the expected error is {rms} px. Nothing was stored.",
    nothing_taken: "None of these views is enough to fit a camera. Nothing was stored.",
    guess: "A camera, but no corners",
    guess_text:
      "This file contains another program's result, but not the measurements behind it. calibDB cannot check "
        + "such a result, so it only serves as an initial guess: a capture may start from it, but calibDB never "
        + "sends it to a web page. Nothing was sent.",
    packed: "This page cannot unpack the corners",
    packed_text:
      "mrcal stores its measurements in an archive inside the file, which this page cannot open. Nothing was "
        + "sent. This page can read a table of its corners (.vnl).",
    matrix: "Its camera matrix, px",
    operator: "The operator of this service can import the file:",
    command: "The command",
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
    wrong_outside: "{name} has corners outside of a picture of {size} px. Is the size right?",
    wrong_line: "All corners lie on one line, so this is not a board. Nothing was sent.",
    wrong_flat: "The board is not flat. calibDB supports flat boards only. Nothing was sent.",
    wrong_board: "calibDB does not support a board of {columns} × {rows} corners. Nothing was sent.",
    wrong_rows: "The corners are not evenly spaced in rows and columns like those of a chessboard. Nothing was sent.",
    wrong_twice: "{name} contains the same corner twice. Nothing was sent.",
  },
  de: {
    title: "Aus der Datei eines anderen Programms kalibrieren · calibDB",
    description:
      "Eine Kamera aus den Messungen eines anderen Programms kalibrieren: Dateien von PhotonVision und Tabellen "
        + "von Ecken.",
    heading: "Aus einem anderen Programm",
    lead:
      "Die Datei eines anderen Kalibrierprogramms kann die Positionen der Ecken der Tafel enthalten. calibDB "
        + "kalibriert die Kamera daraus neu und beurteilt das Ergebnis wie jedes andere.",
    choose: "Die Datei wählen oder hier ablegen",
    kinds:
      "Diese Seite liest Ecken aus JSON-Dateien von PhotonVision und aus Tabellen von Ecken (.vnl). Bei anderen "
        + "Dateien sagt sie Ihnen, was Sie damit tun können.",
    stays:
      "<0>Die Datei bleibt auf diesem Gerät.</0> Gesendet werden: die Positionen der Ecken und die Angaben zur "
        + "Kamera, die Sie unten sehen.",
    reading: "{name} wird gelesen.",
    found: {
      one: "{count} Ansicht einer Tafel mit {squares} Feldern, {size} px.",
      other: "{count} Ansichten einer Tafel mit {squares} Feldern, {size} px.",
    },
    was_read: "{name} wurde gelesen.",
    best: "Nur die {most} aufschlussreichsten werden verwendet.",
    which_board:
      "Eine Tabelle von Ecken enthält nicht alles. Geben Sie die Felder der Tafel und die Größe der Bilder an.",
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
    not_enough: "Diese Ecken genügen nicht: Der erwartete Fehler ist {rms} px. Es wurde nichts gespeichert.",
    nothing_taken: "Keine dieser Ansichten genügt, um eine Kamera zu bestimmen. Es wurde nichts gespeichert.",
    guess: "Eine Kamera, aber keine Ecken",
    guess_text:
      "Diese Datei enthält das Ergebnis eines anderen Programms, aber nicht die Messungen dahinter. calibDB "
        + "kann ein solches Ergebnis nicht prüfen; es dient daher nur als Startwert: Eine Aufnahme kann davon "
        + "ausgehen, aber calibDB gibt es nie an eine Webseite. Es wurde nichts gesendet.",
    packed: "Diese Seite kann die Ecken nicht entpacken",
    packed_text:
      "mrcal speichert seine Messungen in einem Archiv in der Datei, das diese Seite nicht öffnen kann. Es "
        + "wurde nichts gesendet. Diese Seite kann eine Tabelle seiner Ecken (.vnl) lesen.",
    matrix: "Ihre Kameramatrix, px",
    operator: "Der Betreiber dieses Dienstes kann die Datei einlesen:",
    command: "Der Befehl",
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
    wrong_outside: "{name} hat Ecken außerhalb eines Bildes von {size} px. Stimmt die Größe?",
    wrong_line: "Alle Ecken liegen auf einer Geraden; das ist keine Tafel. Es wurde nichts gesendet.",
    wrong_flat: "Die Tafel ist nicht eben. calibDB unterstützt nur ebene Tafeln. Es wurde nichts gesendet.",
    wrong_board: "calibDB unterstützt keine Tafel mit {columns} × {rows} Ecken. Es wurde nichts gesendet.",
    wrong_rows:
      "Die Ecken liegen nicht in gleichmäßigen Zeilen und Spalten wie die eines Schachbretts. Es wurde nichts "
        + "gesendet.",
    wrong_twice: "{name} enthält dieselbe Ecke zweimal. Es wurde nichts gesendet.",
  },
  uk: {
    title: "Калібрування з файлу іншої програми · calibDB",
    description: "Калібрування камери з вимірювань іншої програми: файли PhotonVision і таблиці кутів.",
    heading: "З іншої програми",
    lead:
      "Файл іншої програми калібрування може містити положення кутів дошки. calibDB калібрує за ними камеру "
        + "наново й оцінює результат, як будь-який інший.",
    choose: "Виберіть файл або перетягніть його сюди",
    kinds:
      "Сторінка читає кути з JSON-файлів PhotonVision і з таблиць кутів (.vnl). Для інших файлів вона підкаже, "
        + "що з ними можна зробити.",
    stays:
      "<0>Файл залишається на цьому пристрої.</0> Надсилаються: положення кутів і відомості про камеру, які ви "
        + "бачите нижче.",
    reading: "Читаємо {name}.",
    found: {
      one: "{count} знімок дошки {squares} клітинок, {size} px.",
      few: "{count} знімки дошки {squares} клітинок, {size} px.",
      many: "{count} знімків дошки {squares} клітинок, {size} px.",
      other: "{count} знімка дошки {squares} клітинок, {size} px.",
    },
    was_read: "{name} прочитано.",
    best: "Використовуються лише {most} найінформативніших.",
    which_board: "Таблиця кутів містить не все. Вкажіть кількість клітинок дошки та розмір знімків.",
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
    not_enough: "Цих кутів не досить: очікувана похибка {rms} px. Нічого не збережено.",
    nothing_taken: "Жодного з цих знімків не досить, щоб визначити камеру. Нічого не збережено.",
    guess: "Камера, але без кутів",
    guess_text:
      "Цей файл містить результат іншої програми, але не вимірювання, за якими його отримано. calibDB не може "
        + "перевірити такий результат, тож він лише початкове наближення: знімання може починатися з нього, але "
        + "calibDB ніколи не надсилає його вебсторінкам. Нічого не надіслано.",
    packed: "Сторінка не може розпакувати кути",
    packed_text:
      "mrcal зберігає вимірювання в архіві всередині файлу, якого ця сторінка не відкриває. Нічого не "
        + "надіслано. Сторінка може прочитати таблицю його кутів (.vnl).",
    matrix: "Його матриця камери, px",
    operator: "Оператор цього сервісу може імпортувати файл:",
    command: "Команда",
    wrong_large: "Файл більший за {most} МБ. Нічого не надіслано.",
    wrong_unreadable: "Браузер не зміг прочитати файл. Виберіть його ще раз.",
    wrong_unknown: "Сторінка не розпізнає цей файл як файл калібрування. Нічого не надіслано.",
    wrong_json: "Файл пошкоджено: він починається як JSON, але не є дійсним JSON. Нічого не надіслано.",
    wrong_number: "Файл пошкоджено: «{what}» бракує або воно неправильне. Нічого не надіслано.",
    wrong_many: "У файлі понад {most} знімків. Нічого не надіслано.",
    wrong_count:
      "Файл пошкоджено: у знімку {index} різна кількість точок на зображенні й на дошці. Нічого не надіслано.",
    wrong_fields: "Рядок {line} таблиці не містить положення кута. Нічого не надіслано.",
    wrong_lines: "Дошка з такими клітинками має кутів: {corners}, а {name} має рядків: {lines}. Може, це інша дошка?",
    wrong_empty: "Файл не містить кутів. Нічого не надіслано.",
    wrong_outside: "У {name} є кути поза знімком розміром {size} px. Чи правильний розмір?",
    wrong_line: "Усі кути лежать на одній прямій, тож це не дошка. Нічого не надіслано.",
    wrong_flat: "Дошка не пласка. calibDB підтримує лише пласкі дошки. Нічого не надіслано.",
    wrong_board: "calibDB не підтримує дошку з {columns} × {rows} кутів. Нічого не надіслано.",
    wrong_rows: "Кути не розташовані рівномірними рядками й стовпцями, як на шахівниці. Нічого не надіслано.",
    wrong_twice: "{name} містить той самий кут двічі. Нічого не надіслано.",
  },
};
