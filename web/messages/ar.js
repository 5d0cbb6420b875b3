// AR demo.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "Overlays that fit · calibDB",
    description: "See on your own camera what a calibration does: the same drawing with and without lens correction.",
    viewfinder: "Viewfinder",
    layers: "The camera's picture with a drawing over the board",
    heading: "Overlays that fit",
    lead:
      "A grid and a house are drawn on the board in front of your camera. Without lens correction they drift "
        + "off towards the edge of the picture. With it they stay where they belong.",
    need_board: "You need the <0>calibration board</0> on a second screen, on a phone or tablet, or on paper.",
    privacy:
      "<0>Pictures never leave this device.</0> To look your camera up, this page sends its name, resolution "
        + "and zoom, and your operating system.",
    looking_up: "Looking your camera up in calibDB.",
    virtual: "Simulated camera",
    origin_truth: "calibration: exact, because the camera is simulated",
    origin_returned: "calibration: measured just now",
    origin_known: "calibration: from calibDB",
    measure: "Calibrate my camera",
    unknown: "We don't know this camera yet",
    unknown_text: "calibDB has no reliable calibration of {camera}.",
    unknown_next: "Calibrate it in a minute with the same board. Then you return here with the result.",
    calibrate: "Calibrate it (1 min)",
    no_webgl: "This browser cannot draw the overlays: WebGL 2 is missing or switched off.",
    gpu_lost: "The graphics processor stopped responding. Try again. If that does not help, reload this page.",
    rms: "{px} px off",
    outermost: "rms; {px} px at the outermost corner",
    modes: "Correction",
    matrix: "Without lens correction",
    rectified: "Straighten the video",
    distorted: "Bend the graphics",
    balance: "Keep the edges",
    move: "Move the board",
    stop: "Stop",
  },
  de: {
    title: "Überlagerungen, die passen · calibDB",
    description:
      "Sehen Sie an Ihrer eigenen Kamera, was eine Kalibrierung bewirkt: dieselbe Zeichnung mit und ohne "
        + "Korrektur des Objektivs.",
    viewfinder: "Sucher",
    layers: "Das Kamerabild mit einer Zeichnung über der Tafel",
    heading: "Überlagerungen, die passen",
    lead:
      "Auf die Tafel vor Ihrer Kamera werden ein Gitter und ein Haus gezeichnet. Ohne Korrektur des Objektivs "
        + "driften sie zum Bildrand hin ab. Mit ihr bleiben sie, wo sie hingehören.",
    need_board:
      "Sie brauchen die <0>Kalibriertafel</0> auf einem zweiten Bildschirm, auf Handy oder Tablet oder auf Papier.",
    privacy:
      "<0>Bilder verlassen dieses Gerät nie.</0> Um Ihre Kamera nachzuschlagen, sendet diese Seite deren "
        + "Namen, Auflösung und Zoom sowie Ihr Betriebssystem.",
    looking_up: "Ihre Kamera wird in calibDB nachgeschlagen.",
    virtual: "Simulierte Kamera",
    origin_truth: "Kalibrierung: exakt, weil die Kamera simuliert ist",
    origin_returned: "Kalibrierung: eben gemessen",
    origin_known: "Kalibrierung: aus calibDB",
    measure: "Meine Kamera kalibrieren",
    unknown: "Diese Kamera kennen wir noch nicht",
    unknown_text: "calibDB hat keine verlässliche Kalibrierung von {camera}.",
    unknown_next:
      "Kalibrieren Sie sie in einer Minute mit derselben Tafel. Danach kehren Sie mit dem Ergebnis hierher zurück.",
    calibrate: "Kalibrieren (1 Min.)",
    no_webgl: "Dieser Browser kann die Überlagerungen nicht zeichnen: WebGL 2 fehlt oder ist ausgeschaltet.",
    gpu_lost:
      "Der Grafikprozessor antwortet nicht mehr. Versuchen Sie es noch einmal. Hilft das nicht, laden Sie diese "
        + "Seite neu.",
    rms: "{px} px daneben",
    outermost: "rms; {px} px an der äußersten Ecke",
    modes: "Korrektur",
    matrix: "Ohne Korrektur",
    rectified: "Video entzerren",
    distorted: "Grafik mitbiegen",
    balance: "Ränder behalten",
    move: "Tafel bewegen",
    stop: "Beenden",
  },
  uk: {
    title: "Накладання, що збігаються · calibDB",
    description: "Побачте на власній камері, що дає калібрування: той самий рисунок із корекцією об’єктива й без неї.",
    viewfinder: "Видошукач",
    layers: "Зображення камери з рисунком поверх дошки",
    heading: "Накладання, що збігаються",
    lead:
      "На дошці перед вашою камерою малюються сітка й будиночок. Без корекції об’єктива вони відходять від "
        + "свого місця ближче до краю кадру. З нею вони лишаються там, де мають бути.",
    need_board: "Потрібна <0>калібрувальна дошка</0> на другому екрані, телефоні чи планшеті або на папері.",
    privacy:
      "<0>Зображення ніколи не залишають цей пристрій.</0> Щоб знайти вашу камеру, сторінка надсилає її назву, "
        + "роздільність і масштаб та вашу операційну систему.",
    looking_up: "Шукаємо вашу камеру в calibDB.",
    virtual: "Імітована камера",
    origin_truth: "калібрування: точне, бо камера імітована",
    origin_returned: "калібрування: щойно виміряне",
    origin_known: "калібрування: з calibDB",
    measure: "Відкалібрувати мою камеру",
    unknown: "Ми ще не знаємо цієї камери",
    unknown_text: "calibDB не має надійного калібрування {camera}.",
    unknown_next: "Відкалібруйте її за хвилину тією самою дошкою, а тоді поверніться сюди з результатом.",
    calibrate: "Відкалібрувати (1 хв)",
    no_webgl: "Цей браузер не може намалювати накладання: WebGL 2 відсутній або вимкнений.",
    gpu_lost: "Графічний процесор перестав відповідати. Спробуйте ще раз. Якщо не допоможе, перезавантажте сторінку.",
    rms: "похибка {px} px",
    outermost: "rms; {px} px на крайньому куті",
    modes: "Корекція",
    matrix: "Без корекції",
    rectified: "Випрямити відео",
    distorted: "Вигнути графіку",
    balance: "Зберегти краї",
    move: "Рухати дошку",
    stop: "Зупинити",
  },
};
