// Board page.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "The board · calibDB",
    description: "The calibration board, full screen, on a phone, or as a PDF.",
    heading: "The board",
    lead:
      "Show the board on a second screen, a tablet or a phone: glass is flatter than paper. Turn the brightness "
        + "down if the screen looks too bright to the camera.",
    full_screen: "Full screen",
    on_phone: "On a phone or tablet",
    on_phone_text:
      "Scan this code with the other device. It shows the board as large as possible and keeps its screen on.",
    only_here:
      "The address of this page works only on this computer. Open the page at an address that the other device "
        + "can reach.",
    qr: "QR code of this board's address",
    print: "On paper",
    print_text:
      "Print the board and glue it to something rigid. <0>Its size does not matter</0>; print it at any scale. "
        + "<1>It must be flat</1>: a sheet held in the hand bends, and makes the calibration wrong.",
    pdf: "PDF, {paper}",
    pdf_size: "{paper}: squares of {side} mm at 100 %",
    another: "Another board",
    another_text:
      "Any ChArUco board works, so you can use one that you have. The calibration uses the settings you make here.",
    columns: "Squares across",
    rows: "Squares down",
    dictionary: "Marker dictionary",
    ratio: "Marker side / square side",
    legacy: "Layout of OpenCV before 4.6",
    reset: "Back to the default board",
    what: "ChArUco, {columns} × {rows} squares, {dictionary}, markers {ratio} of a square, {layout}.",
    layout_new: "layout of OpenCV 4.6 and later",
    layout_legacy: "layout of OpenCV before 4.6",
    picture: "Chessboard with a marker in every white square",
    may_dim: "This device may dim its screen. Set it to stay on.",
    use: "Calibrate with this board",
    no_room: "On this paper the squares would be smaller than 5 mm.",
    still_last: "This board is not possible: {reason}. The picture still shows the last one.",
    close: "Touch the screen or press Esc to go back.",
    pdf_bar: "100 mm when printed at 100 %",
    pdf_board:
      "calibDB, ChArUco, {columns} × {rows} squares of {side} mm, markers of {marker} mm, {dictionary}, {layout}.",
    pdf_flat: "Any other scale works too. The board must be flat: glue it to something rigid, without bubbles.",
  },
  de: {
    title: "Die Tafel · calibDB",
    description: "Die Kalibriertafel: als Vollbild, auf dem Telefon oder als PDF.",
    heading: "Die Tafel",
    lead:
      "Zeigen Sie die Tafel auf einem zweiten Bildschirm, einem Tablet oder einem Telefon: Glas ist ebener als "
        + "Papier. Verringern Sie die Helligkeit, wenn der Bildschirm für die Kamera zu hell ist.",
    full_screen: "Vollbild",
    on_phone: "Auf Telefon oder Tablet",
    on_phone_text:
      "Scannen Sie diesen Code mit dem anderen Gerät. Es zeigt die Tafel so groß wie möglich und lässt den "
        + "Bildschirm an.",
    only_here:
      "Die Adresse dieser Seite gilt nur auf diesem Rechner. Öffnen Sie die Seite unter einer Adresse, die das "
        + "andere Gerät erreichen kann.",
    qr: "QR-Code der Adresse dieser Tafel",
    print: "Auf Papier",
    print_text:
      "Drucken Sie die Tafel und kleben Sie sie auf etwas Steifes. <0>Ihre Größe spielt keine Rolle</0>; "
        + "drucken Sie in beliebigem Maßstab. <1>Sie muss eben sein</1>: Ein Blatt in der Hand biegt sich und "
        + "verfälscht die Kalibrierung.",
    pdf: "PDF, {paper}",
    pdf_size: "{paper}: Felder von {side} mm bei 100 %",
    another: "Eine andere Tafel",
    another_text:
      "Jede ChArUco-Tafel ist geeignet, auch eine vorhandene. Die Kalibrierung verwendet, was Sie hier einstellen.",
    columns: "Felder waagerecht",
    rows: "Felder senkrecht",
    dictionary: "Marker-Wörterbuch",
    ratio: "Marker / Feld, Seitenlängen",
    legacy: "Anordnung von OpenCV vor 4.6",
    reset: "Zurück zur Standardtafel",
    what: "ChArUco, {columns} × {rows} Felder, {dictionary}, Marker {ratio} eines Feldes, {layout}.",
    layout_new: "Anordnung von OpenCV ab 4.6",
    layout_legacy: "Anordnung von OpenCV vor 4.6",
    picture: "Schachbrett mit einem Marker in jedem weißen Feld",
    may_dim: "Dieses Gerät könnte seinen Bildschirm abdunkeln. Stellen Sie ein, dass er an bleibt.",
    use: "Mit dieser Tafel kalibrieren",
    no_room: "Auf diesem Papier wären die Felder kleiner als 5 mm.",
    still_last: "Diese Tafel ist nicht möglich: {reason}. Das Bild zeigt noch die letzte.",
    close: "Zurück: den Bildschirm berühren oder Esc drücken.",
    pdf_bar: "100 mm, wenn mit 100 % gedruckt",
    pdf_board:
      "calibDB, ChArUco, {columns} × {rows} Felder von {side} mm, Marker von {marker} mm, {dictionary}, {layout}.",
    pdf_flat: "Jeder andere Maßstab geht auch. Die Tafel muss eben sein: Kleben Sie sie ohne Blasen auf etwas Steifes.",
  },
  uk: {
    title: "Дошка · calibDB",
    description: "Калібрувальна дошка: на весь екран, на телефоні або як PDF.",
    heading: "Дошка",
    lead:
      "Покажіть дошку на другому екрані, планшеті чи телефоні: скло рівніше за папір. Зменште яскравість, якщо "
        + "екран надто яскравий для камери.",
    full_screen: "На весь екран",
    on_phone: "На телефоні чи планшеті",
    on_phone_text: "Скануйте цей код іншим пристроєм. Він покаже дошку якнайбільшою й не дасть екрану згаснути.",
    only_here:
      "Адреса цієї сторінки діє лише на цьому комп’ютері. Відкрийте сторінку за адресою, доступною іншому "
        + "пристрою.",
    qr: "QR-код адреси цієї дошки",
    print: "На папері",
    print_text:
      "Надрукуйте дошку й наклейте її на щось жорстке. <0>Розмір не має значення</0>; друкуйте в будь-якому "
        + "масштабі. <1>Вона має бути пласкою</1>: аркуш у руці згинається й спотворює калібрування.",
    pdf: "PDF, {paper}",
    pdf_size: "{paper}: клітинки по {side} мм за масштабу 100 %",
    another: "Інша дошка",
    another_text: "Підійде будь-яка дошка ChArUco, зокрема та, що вже є. Калібрування використає задані тут параметри.",
    columns: "Клітинок уширину",
    rows: "Клітинок заввишки",
    dictionary: "Словник маркерів",
    ratio: "Сторона маркера / клітинки",
    legacy: "Розкладка OpenCV до 4.6",
    reset: "Повернути стандартну дошку",
    what: "ChArUco, {columns} × {rows} клітинок, {dictionary}, маркери {ratio} клітинки, {layout}.",
    layout_new: "розкладка OpenCV від 4.6",
    layout_legacy: "розкладка OpenCV до 4.6",
    picture: "Шахівниця з маркером у кожній білій клітинці",
    may_dim: "Цей пристрій може пригасити екран. Налаштуйте, щоб він не гаснув.",
    use: "Калібрувати з цією дошкою",
    no_room: "На такому папері клітинки були б менші за 5 мм.",
    still_last: "Така дошка неможлива: {reason}. На зображенні ще попередня.",
    close: "Назад: торкніться екрана або натисніть Esc.",
    pdf_bar: "100 мм за масштабу друку 100 %",
    pdf_board:
      "calibDB, ChArUco, {columns} × {rows} клітинок по {side} мм, маркери по {marker} мм, {dictionary}, {layout}.",
    pdf_flat:
      "Будь-який інший масштаб теж підійде. Дошка має бути пласкою: наклейте її на щось жорстке, без бульбашок.",
  },
};
