// Landing page.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "calibDB · camera calibration for the web",
    description:
      "Camera matrix and lens distortion of the camera a web page has open: looked up, or measured in a minute.",
    heading: "Every lens bends the world.",
    lead:
      "calibDB measures how. A web page asks calibDB about the camera it has open and receives the camera "
        + "matrix, the lens distortion and how reliable both are. If nobody has calibrated that camera yet, the "
        + "visitor can do it in a minute, in the browser.",
    calibrate: "Calibrate your camera",
    watch: "Try it without a camera",
    figure: "A regular grid, and the same grid as a wide-angle lens shows it: pulled in at the corners",
    caption: "A regular grid through a lens with k1 = −0.25. At the corner the difference is 107 pixels of 1280.",
    ways: "Get started",
    way_person: "You have a camera",
    way_person_text:
      "<0>Calibrate it</0> in a minute, <1>check whether calibDB knows it</1>, or use <2>photographs</2> taken "
        + "with it.",
    way_developer: "You write a web application",
    way_developer_text: "Look up your visitor's camera in <0>ten lines</0>. The <1>demo</1> draws over its picture.",
    way_operator: "You run services",
    way_operator_text: "<0>One command</0> starts everything on your machine; another deploys it to AWS.",
    operators: "For operators",
    commands: "Commands: run and deploy",
    operators_text:
      "calibDB consists of Python functions, one table and one bucket, all described by one template. In the "
        + "source code, <0>docs/operations.md</0> explains how to deploy, monitor and restore it, and "
        + "<1>docs/security.md</1> what it protects against. The API: <2>openapi.json</2>.",
    how: "How it works",
    step_board: "Show the board",
    step_board_text: "On a second screen, on a tablet, or <0>on paper</0>. Its size does not matter.",
    step_follow: "Follow the outline",
    step_follow_text:
      "calibDB chooses the pose that reveals most about your lens. It takes a view whenever you hold still; "
        + "four or five are enough.",
    step_done: "Done, for everyone",
    step_done_text:
      "Once five calibrations agree, every web page can look the camera up. Pictures stay on your device; none "
        + "is sent.",
    known: "Does calibDB know your camera?",
    known_text: "This opens your camera for a moment, reads its name and resolution, and searches the database.",
    look: "Look up my camera",
    asking: "Asking for the camera.",
    yes: { one: "Yes: {camera}. {count} calibration agrees.", other: "Yes: {camera}. {count} calibrations agree." },
    not_yet: "Not yet: {camera}.",
    calibrate_it: "Calibrate it",
    fault_not_found: "No camera was found. Plug one in and try again.",
    fault_too_strict: "The camera cannot deliver a picture of this size.",
    search_all: "Search all cameras",
    otherwise:
      "Without a webcam: <0>search all cameras</0>, or calibrate one <1>from photographs</1> or <2>another "
        + "program's file</2>.",
    developers: "For developers",
    example: "Example: look up a camera",
    examples:
      "Demos: <0>a scene drawn over the camera's picture</0>, and the same with <1>three.js</1>, "
        + "<2>Babylon.js</2>, <3>A‑Frame</3> and <4>AR.js</4>.",
    conventions:
      "All numbers follow OpenCV's conventions: pixel centres are whole numbers, and <0>camera_matrix</0> is "
        + "row by row. calibDB fits any <1>distortion_model</1> you ask for to the stored corner positions.",
    models: "Distortion models",
    model: "Model",
    coefficients: "Coefficients",
    for_lenses: "Suitable for",
    rectilinear: "webcams, phones, most lenses",
    rational: "wide-angle lenses, up to about 120°",
    fisheye: "fisheye lenses, up to 180° and beyond",
    omnidirectional: "fisheye lenses and mirrors with a 360° view",
  },
  de: {
    title: "calibDB · Kamerakalibrierung für das Web",
    description:
      "Kameramatrix und Verzeichnung der Kamera, die eine Webseite geöffnet hat: nachgeschlagen oder in einer "
        + "Minute gemessen.",
    heading: "Jede Linse verbiegt die Welt.",
    lead:
      "calibDB misst, wie. Eine Webseite fragt calibDB nach der Kamera, die sie geöffnet hat, und erhält die "
        + "Kameramatrix, die Verzeichnung und wie verlässlich beide sind. Hat noch niemand diese Kamera kalibriert, "
        + "kann es der Besucher in einer Minute im Browser tun.",
    calibrate: "Ihre Kamera kalibrieren",
    watch: "Ohne Kamera ausprobieren",
    figure: "Ein regelmäßiges Gitter, und wie ein Weitwinkelobjektiv es zeigt: an den Ecken nach innen gezogen",
    caption: "Ein regelmäßiges Gitter durch eine Linse mit k1 = −0,25. In der Ecke sind es 107 von 1280 Pixeln.",
    ways: "So fangen Sie an",
    way_person: "Sie haben eine Kamera",
    way_person_text:
      "<0>Kalibrieren Sie sie</0> in einer Minute, <1>prüfen Sie, ob calibDB sie kennt</1>, oder verwenden Sie "
        + "<2>Fotos</2>, die sie gemacht hat.",
    way_developer: "Sie schreiben eine Webanwendung",
    way_developer_text:
      "Schlagen Sie die Kamera Ihres Besuchers in <0>zehn Zeilen</0> nach. Die <1>Vorführung</1> zeichnet über "
        + "ihr Bild.",
    way_operator: "Sie betreiben Dienste",
    way_operator_text: "<0>Ein Befehl</0> startet alles auf Ihrem Rechner, ein weiterer stellt es auf AWS bereit.",
    operators: "Für Betreiber",
    commands: "Befehle: starten und bereitstellen",
    operators_text:
      "calibDB besteht aus Python-Funktionen, einer Tabelle und einem Bucket, alle in einer Vorlage "
        + "beschrieben. Im Quelltext erklärt <0>docs/operations.md</0>, wie man es bereitstellt, überwacht und "
        + "wiederherstellt, und <1>docs/security.md</1>, wovor es schützt. Die API: <2>openapi.json</2>.",
    how: "So funktioniert es",
    step_board: "Die Tafel zeigen",
    step_board_text:
      "Auf einem zweiten Bildschirm, auf einem Tablet oder <0>auf Papier</0>. Die Größe spielt keine Rolle.",
    step_follow: "Dem Umriss folgen",
    step_follow_text:
      "calibDB wählt die Lage, die am meisten über Ihr Objektiv verrät. Es nimmt eine Ansicht auf, sobald Sie "
        + "stillhalten; vier oder fünf genügen.",
    step_done: "Fertig, für alle",
    step_done_text:
      "Sobald fünf Kalibrierungen übereinstimmen, kann jede Webseite die Kamera nachschlagen. Bilder bleiben "
        + "auf Ihrem Gerät; keines wird gesendet.",
    known: "Kennt calibDB Ihre Kamera?",
    known_text:
      "Dies öffnet Ihre Kamera für einen Augenblick, liest ihren Namen und ihre Auflösung und sucht in der "
        + "Datenbank.",
    look: "Meine Kamera nachschlagen",
    asking: "Die Kamera wird gefragt.",
    yes: {
      one: "Ja: {camera}. {count} Kalibrierung stimmt überein.",
      other: "Ja: {camera}. {count} Kalibrierungen stimmen überein.",
    },
    not_yet: "Noch nicht: {camera}.",
    calibrate_it: "Jetzt kalibrieren",
    fault_not_found: "Es wurde keine Kamera gefunden. Schließen Sie eine an, und versuchen Sie es noch einmal.",
    fault_too_strict: "Die Kamera kann kein Bild dieser Größe liefern.",
    search_all: "Alle Kameras durchsuchen",
    otherwise:
      "Ohne Webcam: <0>alle Kameras durchsuchen</0> oder eine <1>aus Fotos</1> oder <2>der Datei eines anderen "
        + "Programms</2> kalibrieren.",
    developers: "Für Entwickler",
    example: "Beispiel: eine Kamera nachschlagen",
    examples:
      "Beispiele: <0>eine Szene über dem Kamerabild</0> und dasselbe mit <1>three.js</1>, <2>Babylon.js</2>, "
        + "<3>A‑Frame</3> und <4>AR.js</4>.",
    conventions:
      "Alle Zahlen folgen den Konventionen von OpenCV: Pixelmitten sind ganze Zahlen, <0>camera_matrix</0> "
        + "steht zeilenweise. calibDB passt jedes <1>distortion_model</1>, das Sie verlangen, an die gespeicherten "
        + "Eckpositionen an.",
    models: "Verzeichnungsmodelle",
    model: "Modell",
    coefficients: "Koeffizienten",
    for_lenses: "Geeignet für",
    rectilinear: "Webcams, Telefone, die meisten Objektive",
    rational: "Weitwinkel, bis etwa 120°",
    fisheye: "Fischaugen, bis 180° und darüber",
    omnidirectional: "Fischaugen und Spiegel mit Rundumsicht",
  },
  uk: {
    title: "calibDB · калібрування камер для вебу",
    description:
      "Матриця камери та дисторсія об’єктива для камери, яку відкрила вебсторінка: знайдені в базі або виміряні "
        + "за хвилину.",
    heading: "Кожен об’єктив викривляє світ.",
    lead:
      "calibDB вимірює, як саме. Вебсторінка запитує calibDB про відкриту нею камеру й отримує матрицю камери, "
        + "дисторсію об’єктива та їхню надійність. Якщо цю камеру ще ніхто не калібрував, відвідувач може зробити "
        + "це за хвилину в браузері.",
    calibrate: "Калібрувати камеру",
    watch: "Спробувати без камери",
    figure: "Рівна сітка і та сама сітка крізь ширококутний об’єктив: кути стягнуто всередину",
    caption: "Рівна сітка крізь об’єктив із k1 = −0,25. У куті різниця становить 107 пікселів із 1280.",
    ways: "З чого почати",
    way_person: "У вас є камера",
    way_person_text:
      "<0>Відкалібруйте її</0> за хвилину, <1>перевірте, чи знає її calibDB</1>, або використайте зроблені нею "
        + "<2>фотографії</2>.",
    way_developer: "Ви пишете вебзастосунок",
    way_developer_text:
      "Знайдіть камеру відвідувача за <0>десять рядків</0>. <1>Демонстрація</1> малює поверх її зображення.",
    way_operator: "Ви обслуговуєте сервіси",
    way_operator_text: "<0>Одна команда</0> запускає все на вашому комп’ютері, інша розгортає це в AWS.",
    operators: "Для операторів",
    commands: "Команди: запуск і розгортання",
    operators_text:
      "calibDB складається з функцій на Python, однієї таблиці та одного сховища; усе описано одним шаблоном. У "
        + "вихідному коді <0>docs/operations.md</0> пояснює, як його розгорнути, контролювати й відновити, а "
        + "<1>docs/security.md</1> — від чого він захищає. API: <2>openapi.json</2>.",
    how: "Як це працює",
    step_board: "Покажіть дошку",
    step_board_text: "На другому екрані, на планшеті або <0>на папері</0>. Розмір не має значення.",
    step_follow: "Тримайтеся контуру",
    step_follow_text:
      "calibDB обирає положення, яке найбільше розкаже про ваш об’єктив. Він робить знімок щоразу, коли ви "
        + "тримаєте дошку нерухомо; чотирьох чи п’яти досить.",
    step_done: "Готово, для всіх",
    step_done_text:
      "Щойно п’ять калібрувань збігаються, кожна вебсторінка може знайти цю камеру. Зображення залишаються на "
        + "вашому пристрої; жодне не надсилається.",
    known: "Чи знає calibDB вашу камеру?",
    known_text: "Камера відкриється на мить, сторінка прочитає її назву й роздільність і пошукає їх у базі даних.",
    look: "Знайти мою камеру",
    asking: "Звертаємося до камери.",
    yes: {
      one: "Так: {camera}. Збігається {count} калібрування.",
      few: "Так: {camera}. Збігаються {count} калібрування.",
      many: "Так: {camera}. Збігаються {count} калібрувань.",
      other: "Так: {camera}. Збігаються {count} калібрування.",
    },
    not_yet: "Ще ні: {camera}.",
    calibrate_it: "Калібрувати",
    fault_not_found: "Камери не знайдено. Під’єднайте її й спробуйте знову.",
    fault_too_strict: "Камера не дає зображення такого розміру.",
    search_all: "Шукати серед усіх камер",
    otherwise:
      "Без вебкамери: <0>шукайте серед усіх камер</0> або калібруйте <1>за фотографіями</1> чи <2>файлом іншої "
        + "програми</2>.",
    developers: "Для розробників",
    example: "Приклад: пошук камери",
    examples:
      "Приклади: <0>сцена поверх зображення камери</0> і те саме з <1>three.js</1>, <2>Babylon.js</2>, "
        + "<3>A‑Frame</3> та <4>AR.js</4>.",
    conventions:
      "Усі числа відповідають домовленостям OpenCV: центри пікселів — цілі числа, <0>camera_matrix</0> записано "
        + "рядок за рядком. calibDB підганяє будь-яку запитану <1>distortion_model</1> до збережених положень кутів.",
    models: "Моделі дисторсії",
    model: "Модель",
    coefficients: "Коефіцієнти",
    for_lenses: "Для чого",
    rectilinear: "вебкамер, телефонів, більшості об’єктивів",
    rational: "ширококутних об’єктивів, приблизно до 120°",
    fisheye: "об’єктиви «риб’яче око», до 180° і більше",
    omnidirectional: "«риб’яче око» та дзеркала з оглядом 360°",
  },
};
