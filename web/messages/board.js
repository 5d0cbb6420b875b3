// Board page.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "Calibration board · calibDB",
    description:
      "The calibration board for a screen, a phone or a printer, and the other way round: a phone's camera "
        + "calibrated with your screen.",
    heading: "Calibration board",
    lead:
      "Show the board on a second screen, a tablet or a phone, or print it. Screens are perfectly flat. If the "
        + "board looks washed out, lower the brightness.",
    full_screen: "Show full screen",
    on_phone: "On a phone or tablet",
    on_phone_text:
      "Scan this code with the phone or tablet. It then shows the board as large as it can, and keeps its screen on.",
    phone_camera: "Calibrate a phone's camera with this screen",
    phone_camera_text:
      "This screen shows the board, and the phone looks at it. Scan the code with the phone: the page that "
        + "opens uses the rear camera and knows this board.",
    full_screen_code: "Show full screen with this code",
    qr_phone: "QR code that opens the calibration on a phone",
    scan_me: "Scan with the phone to calibrate it",
    only_here:
      "This computer's own address works on no other device. Open this page at an address that the other "
        + "device can reach.",
    qr: "QR code of this board's address",
    print: "On paper",
    print_text:
      "Print in landscape at 100% (“actual size”) on matt paper. <0>Any other size works too.</0> <1>The "
        + "board must be flat</1>: glue the sheet to foam board or glass, or clip it to a clipboard. A sheet held "
        + "in the hand bends and spoils the calibration.",
    print_check: "Check the scale with a ruler: the bar below the board has its length printed beside it.",
    pdf: "PDF, {paper}",
    pdf_size: "{side} mm squares at 100%",
    another: "Use another board",
    another_text: "ChArUco, a plain chessboard or an AprilGrid: use the one that you have. These settings carry over to calibration.",
    reset: "Reset to default",
    picture: "The calibration board",
    may_dim: "This device may dim its screen. Set it to stay on.",
    use: "Calibrate with this board",
    use_photos: "Calibrate from photos of this board",
    no_room: "On this paper the squares would be smaller than 5 mm.",
    still_last: "Not possible: {reason}. The picture still shows the last board.",
    close: "Touch the screen or press Esc to go back.",
    pdf_bar: "100 mm when printed at 100 %",
    layout_new: "layout of OpenCV 4.6 and later",
    layout_legacy: "layout of OpenCV before 4.6",
    pdf_chessboard: "calibDB, chessboard, {columns} × {rows} squares of {side} mm.",
    pdf_aprilgrid: "calibDB, AprilGrid, {columns} × {rows} tags of {side} mm, gaps of {gap} mm, {dictionary}.",
    pdf_charuco:
      "calibDB, ChArUco, {columns} × {rows} squares of {side} mm, markers of {marker} mm, {dictionary}, {layout}.",
    pdf_flat: "Any other scale works too. The board must be flat: glue it to something rigid, without bubbles.",
  },
  de: {
    title: "Kalibriertafel · calibDB",
    description:
      "Die Kalibriertafel für Bildschirm, Handy oder Drucker, und umgekehrt: die Kamera eines Handys, "
        + "kalibriert mit Ihrem Bildschirm.",
    heading: "Kalibriertafel",
    lead:
      "Zeigen Sie die Tafel auf einem zweiten Bildschirm, Tablet oder Handy, oder drucken Sie sie. "
        + "Bildschirme sind völlig eben. Wirkt die Tafel überstrahlt, verringern Sie die Helligkeit.",
    full_screen: "Im Vollbild zeigen",
    on_phone: "Auf Handy oder Tablet",
    on_phone_text:
      "Scannen Sie diesen Code mit dem Handy oder Tablet. Es zeigt die Tafel dann so groß wie möglich und "
        + "lässt den Bildschirm an.",
    phone_camera: "Die Kamera eines Handys mit diesem Bildschirm kalibrieren",
    phone_camera_text:
      "Dieser Bildschirm zeigt die Tafel, und das Handy sieht sie an. Scannen Sie den Code mit dem Handy: "
        + "Die Seite, die sich öffnet, verwendet die Rückkamera und kennt diese Tafel.",
    full_screen_code: "Mit diesem Code im Vollbild zeigen",
    qr_phone: "QR-Code, der die Kalibrierung auf einem Handy öffnet",
    scan_me: "Mit dem Handy scannen und kalibrieren",
    only_here:
      "Die eigene Adresse dieses Computers gilt auf keinem anderen Gerät. Öffnen Sie diese Seite unter einer "
        + "Adresse, die das andere Gerät erreicht.",
    qr: "QR-Code der Adresse dieser Tafel",
    print: "Auf Papier",
    print_text:
      "Drucken Sie im Querformat mit 100 % („tatsächliche Größe“) auf mattes Papier. <0>Jede andere Größe geht "
        + "auch.</0> <1>Die Tafel muss eben sein</1>: Kleben Sie das Blatt auf eine Hartschaumplatte oder auf "
        + "Glas, oder klemmen Sie es auf ein Klemmbrett. Ein Blatt in der Hand biegt sich und verdirbt die "
        + "Kalibrierung.",
    print_check: "Prüfen Sie den Maßstab mit einem Lineal: Neben dem Balken unter der Tafel steht seine Länge.",
    pdf: "PDF, {paper}",
    pdf_size: "Felder von {side} mm bei 100 %",
    another: "Eine andere Tafel verwenden",
    another_text: "ChArUco, ein einfaches Schachbrett oder ein AprilGrid: Nehmen Sie, was Sie haben. Diese Einstellungen gelten auch für die Kalibrierung.",
    reset: "Auf Standard zurücksetzen",
    picture: "Die Kalibriertafel",
    may_dim: "Dieses Gerät könnte den Bildschirm abdunkeln. Stellen Sie ein, dass er an bleibt.",
    use: "Mit dieser Tafel kalibrieren",
    use_photos: "Mit Fotos dieser Tafel kalibrieren",
    no_room: "Auf diesem Papier wären die Felder kleiner als 5 mm.",
    still_last: "Nicht möglich: {reason}. Das Bild zeigt noch die letzte Tafel.",
    close: "Zurück: Bildschirm berühren oder Esc drücken.",
    pdf_bar: "100 mm, wenn mit 100 % gedruckt",
    layout_new: "Anordnung von OpenCV ab 4.6",
    layout_legacy: "Anordnung von OpenCV vor 4.6",
    pdf_chessboard: "calibDB, Schachbrett, {columns} × {rows} Felder von {side} mm.",
    pdf_aprilgrid: "calibDB, AprilGrid, {columns} × {rows} Tags von {side} mm, Abstand {gap} mm, {dictionary}.",
    pdf_charuco:
      "calibDB, ChArUco, {columns} × {rows} Felder von {side} mm, Marker von {marker} mm, {dictionary}, {layout}.",
    pdf_flat: "Jeder andere Maßstab geht auch. Die Tafel muss eben sein: Kleben Sie sie ohne Blasen auf etwas Steifes.",
  },
  uk: {
    title: "Калібрувальна дошка · calibDB",
    description:
      "Калібрувальна дошка для екрана, телефона чи принтера, і навпаки: камера телефона, відкалібрована за "
        + "допомогою вашого екрана.",
    heading: "Калібрувальна дошка",
    lead:
      "Покажіть дошку на другому екрані, планшеті чи телефоні або надрукуйте її. Екрани ідеально рівні. Якщо "
        + "дошка здається засвіченою, зменште яскравість.",
    full_screen: "Показати на весь екран",
    on_phone: "На телефоні чи планшеті",
    on_phone_text: "Скануйте цей код телефоном чи планшетом. Він покаже дошку якнайбільшою й не дасть екрану згаснути.",
    phone_camera: "Калібрування камери телефона за допомогою цього екрана",
    phone_camera_text:
      "Цей екран показує дошку, а телефон дивиться на неї. Скануйте код телефоном: сторінка, що відкриється, "
        + "використає задню камеру й уже знатиме цю дошку.",
    full_screen_code: "Показати на весь екран із цим кодом",
    qr_phone: "QR-код, що відкриває калібрування на телефоні",
    scan_me: "Скануйте телефоном, щоб відкалібрувати його",
    only_here:
      "Власна адреса цього комп’ютера не діє на інших пристроях. Відкрийте сторінку за адресою, доступною "
        + "іншому пристрою.",
    qr: "QR-код адреси цієї дошки",
    print: "На папері",
    print_text:
      "Друкуйте в альбомній орієнтації, 100 % («фактичний розмір»), на матовому папері. <0>Підійде й будь-який "
        + "інший розмір.</0> <1>Дошка має бути рівною</1>: наклейте аркуш на пінокартон чи скло або затисніть у "
        + "планшеті для паперів. Аркуш у руках згинається й псує калібрування.",
    print_check: "Перевірте масштаб лінійкою: поруч зі смужкою під дошкою надруковано її довжину.",
    pdf: "PDF, {paper}",
    pdf_size: "клітинки {side} мм за 100 %",
    another: "Інша дошка",
    another_text: "ChArUco, звичайна шахівниця чи AprilGrid: беріть ту, яку маєте. Ці налаштування перейдуть до калібрування.",
    reset: "Повернути стандартну",
    picture: "Калібрувальна дошка",
    may_dim: "Цей пристрій може пригасити екран. Налаштуйте, щоб він не гаснув.",
    use: "Калібрувати з цією дошкою",
    use_photos: "Калібрувати за фотографіями цієї дошки",
    no_room: "На такому папері клітинки були б менші за 5 мм.",
    still_last: "Неможливо: {reason}. На зображенні ще попередня дошка.",
    close: "Назад: торкніться екрана або натисніть Esc.",
    pdf_bar: "100 мм за масштабу друку 100 %",
    layout_new: "розкладка OpenCV від 4.6",
    layout_legacy: "розкладка OpenCV до 4.6",
    pdf_chessboard: "calibDB, шахівниця, {columns} × {rows} клітинок по {side} мм.",
    pdf_aprilgrid: "calibDB, AprilGrid, {columns} × {rows} міток по {side} мм, проміжки {gap} мм, {dictionary}.",
    pdf_charuco:
      "calibDB, ChArUco, {columns} × {rows} клітинок по {side} мм, маркери по {marker} мм, {dictionary}, {layout}.",
    pdf_flat:
      "Будь-який інший масштаб теж підійде. Дошка має бути пласкою: наклейте її на щось жорстке, без бульбашок.",
  },
};
