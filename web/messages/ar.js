// AR demo.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "Overlays that fit · calibDB",
    description:
      "See what a calibration does for your own camera: the same drawing with the camera matrix only, and with "
        + "the lens distortion.",
    viewfinder: "Viewfinder",
    layers: "The camera's picture with a drawing over the board",
    heading: "Overlays that fit",
    lead:
      "A grid and a house are drawn on the board in front of your camera, in three ways. With the camera matrix "
        + "only they drift off towards the picture's edge. With the lens distortion they stay where they belong.",
    need_board: "You need the <0>calibration board</0> on a second screen, on a tablet or on paper.",
    privacy:
      "<0>Pictures never leave this device.</0> To look your camera up, this page sends the name that your "
        + "browser gives it, its resolution and zoom, and the operating system that your browser reports.",
    looking_up: "Asking calibDB about this camera.",
    virtual: "Virtual camera",
    origin_truth: "calibration: exact, because the camera is simulated",
    origin_returned: "calibration: measured just now",
    origin_known: "calibration: from calibDB",
    measure: "Measure it yourself",
    unknown: "calibDB does not know this camera yet",
    unknown_text: "calibDB has no reliable calibration of {camera}.",
    unknown_next: "You can calibrate it in a minute with the same board, and then return here with the result.",
    calibrate: "Calibrate it",
    no_webgl: "This browser cannot draw the overlays because WebGL 2 is missing or switched off.",
    gpu_lost: "The graphics processor stopped responding. Try again; if that does not help, reload this page.",
    rms: "{px} px off",
    outermost: "rms; {px} px at the outermost corner",
    modes: "How it is drawn",
    matrix: "Matrix only",
    rectified: "Straightened",
    distorted: "Distorted",
    balance: "Edges kept",
    move: "Move the board",
    stop: "Stop",
  },
  de: {
    title: "Überlagerungen, die passen · calibDB",
    description:
      "Sehen Sie an Ihrer eigenen Kamera, was eine Kalibrierung bewirkt: dieselbe Zeichnung nur mit der "
        + "Kameramatrix und mit der Verzeichnung.",
    viewfinder: "Sucher",
    layers: "Das Kamerabild mit einer Zeichnung über der Tafel",
    heading: "Überlagerungen, die passen",
    lead:
      "Auf die Tafel vor Ihrer Kamera werden ein Gitter und ein Haus gezeichnet, auf drei Arten. Nur mit der "
        + "Kameramatrix driften sie zum Bildrand hin ab. Mit der Verzeichnung bleiben sie, wo sie hingehören.",
    need_board:
      "Sie brauchen die <0>Kalibriertafel</0> auf einem zweiten Bildschirm, auf einem Tablet oder auf Papier.",
    privacy:
      "<0>Bilder verlassen dieses Gerät nie.</0> Um Ihre Kamera nachzuschlagen, sendet diese Seite den Namen, "
        + "den Ihr Browser ihr gibt, ihre Auflösung und ihren Zoom und das Betriebssystem, das Ihr Browser meldet.",
    looking_up: "calibDB wird nach dieser Kamera gefragt.",
    virtual: "Virtuelle Kamera",
    origin_truth: "Kalibrierung: exakt, weil die Kamera simuliert ist",
    origin_returned: "Kalibrierung: eben gemessen",
    origin_known: "Kalibrierung: aus calibDB",
    measure: "Selbst messen",
    unknown: "calibDB kennt diese Kamera noch nicht",
    unknown_text: "calibDB hat keine verlässliche Kalibrierung von {camera}.",
    unknown_next:
      "Sie können sie mit derselben Tafel in einer Minute kalibrieren und kommen mit dem Ergebnis hierher zurück.",
    calibrate: "Kalibrieren",
    no_webgl: "Dieser Browser kann die Überlagerungen nicht zeichnen, weil WebGL 2 fehlt oder ausgeschaltet ist.",
    gpu_lost:
      "Der Grafikprozessor antwortet nicht mehr. Versuchen Sie es noch einmal; hilft das nicht, laden Sie diese "
        + "Seite neu.",
    rms: "{px} px daneben",
    outermost: "rms; {px} px an der äußersten Ecke",
    modes: "Wie gezeichnet wird",
    matrix: "Nur Matrix",
    rectified: "Entzerrt",
    distorted: "Verzeichnet",
    balance: "Rand behalten",
    move: "Tafel bewegen",
    stop: "Beenden",
  },
  uk: {
    title: "Накладання, що збігаються · calibDB",
    description:
      "Побачте на власній камері, що дає калібрування: той самий рисунок лише з матрицею камери та з дисторсією "
        + "об’єктива.",
    viewfinder: "Видошукач",
    layers: "Зображення камери з рисунком поверх дошки",
    heading: "Накладання, що збігаються",
    lead:
      "На дошці перед вашою камерою рисуються сітка й будиночок, трьома способами. Лише з матрицею камери вони "
        + "відходять від свого місця ближче до краю кадру. З дисторсією об’єктива вони лишаються там, де мають бути.",
    need_board: "Потрібна <0>калібрувальна дошка</0> на другому екрані, на планшеті або на папері.",
    privacy:
      "<0>Зображення ніколи не полишають цього пристрою.</0> Щоб знайти вашу камеру, сторінка надсилає назву, "
        + "яку дає їй браузер, її роздільність і масштаб та операційну систему, про яку повідомляє браузер.",
    looking_up: "Питаємо calibDB про цю камеру.",
    virtual: "Віртуальна камера",
    origin_truth: "калібрування: точне, бо камера імітована",
    origin_returned: "калібрування: щойно виміряне",
    origin_known: "калібрування: з calibDB",
    measure: "Виміряти самому",
    unknown: "calibDB ще не знає цієї камери",
    unknown_text: "calibDB не має надійного калібрування {camera}.",
    unknown_next: "Її можна за хвилину відкалібрувати з тією самою дошкою, а потім повернутися сюди з результатом.",
    calibrate: "Калібрувати",
    no_webgl: "Цей браузер не може намалювати накладання, бо WebGL 2 відсутній або вимкнений.",
    gpu_lost: "Графічний процесор перестав відповідати. Спробуйте ще раз; якщо не допоможе, перезавантажте сторінку.",
    rms: "похибка {px} px",
    outermost: "rms; {px} px на крайньому куті",
    modes: "Як рисується",
    matrix: "Лише матриця",
    rectified: "Випрямлено",
    distorted: "З дисторсією",
    balance: "Скільки краю",
    move: "Рухати дошку",
    stop: "Зупинити",
  },
};
