// Landing page.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    title: "calibDB · camera calibration for the web",
    description:
      "Exact focal length and lens distortion of any webcam, straight from the browser: looked up, or calibrated in "
        + "a minute.",
    heading: "Every lens bends the world.",
    lead:
      "Get the exact focal length and lens distortion of any webcam, straight from the browser. If your camera isn't "
        + "in the database yet, calibrating it takes a minute.",
    calibrate: "Calibrate your camera",
    watch: "Watch it without a camera",
    loop:
      "A calibration board in a camera's picture. It moves into an amber outline and is held still there; then "
        + "another outline appears.",
    loop_caption: "Guided capture: hold the board where the outline is. Four or five views are enough.",
    loop_pause: "Stop the animation",
    loop_follow: "Follow the outline",
    loop_hold: "Hold still",
    loop_taken: "✓ View {count}",
    loop_done: "✓ Camera calibrated",
    ways: "Get started",
    way_person: "You have a camera",
    way_person_text: "<0>Calibrate it</0>, <1>look it up</1>, or use <2>your photos</2>.",
    way_developer: "You build a web app",
    way_developer_text: "Copy <0>ten lines</0>, and your app knows its visitor's camera.",
    way_operator: "You want to host it yourself",
    way_operator_text: "<0>One command</0> starts it on your machine; another deploys it to AWS.",
    counts: "In the database",
    count_cameras: { one: "camera", other: "cameras" },
    count_ready: { one: "ready to use", other: "ready to use" },
    count_calibrations: { one: "calibration", other: "calibrations" },
    known: "Is your camera in the database?",
    known_text: "Your camera opens for a moment. This page reads its name and resolution and searches the database.",
    look: "Look up my camera",
    asking: "Opening your camera.",
    known_yes: "{camera} is ready to use",
    card_size: "Resolution",
    card_focal: "Focal length",
    card_view: "Horizontal field of view",
    card_error: "Typical error",
    card_calibrations: "Calibrations that agree",
    card_open: "Download and details",
    card_ar: "See it in AR",
    not_yet: "We don't know {camera} yet.",
    not_yet_text: "Be the first: calibrate it, and every web app can use the result once others confirm it.",
    calibrate_it: "Calibrate it (1 min)",
    fault_not_found: "No camera was found. Plug one in and try again.",
    fault_too_strict: "The camera cannot deliver a picture of this size.",
    search_all: "Search all cameras",
    otherwise:
      "No webcam? <0>Search all cameras</0>, or calibrate one <1>from photos</1> or <2>from another program's "
        + "file</2>.",
    uses: "What it is good for",
    figure: "A regular grid, and the same grid as a wide-angle lens shows it: pulled in at the corners",
    slide_lens: "Distortion of the lens",
    use_straight: "Straight lines stay straight.",
    caption: "Move the slider to see a regular grid through different lenses.",
    without: "Without lens correction: a grid and a box drawn over a board miss its squares",
    with: "With lens correction: the grid and the box lie on the squares",
    slide_overlay: "Before and after",
    use_overlay: "<0>AR that sticks.</0> Left without lens correction, right with it. <1>See it with your camera</1>",
    how: "How it works",
    step_board: "Show the board",
    step_board_text: "On a second screen, on a tablet, or <0>on paper</0>. Any size works.",
    step_follow: "Follow the outline",
    step_follow_text: "Photos are taken automatically whenever you hold still. Four or five are enough.",
    step_done: "Calibrate once, everyone benefits",
    step_done_text:
      "Once five calibrations agree, every web app can look your camera up. Your pictures never leave your device.",
    developers: "For developers",
    developers_text:
      "Your web app asks about the visitor's camera and gets its intrinsics, lens distortion, and a confidence level.",
    example: "Example: look up a camera",
    next_steps: "<0>Get a free token</0>, read the <1>documentation</1>, or try the <2>live examples</2>.",
    conventions:
      "Values follow OpenCV's conventions: pixel centres at integer coordinates, row-major <0>camera_matrix</0>.",
    host: "Host it yourself",
    commands: "Commands: run and deploy",
    host_text:
      "Python functions, one table and one bucket, described by one template. An idle deployment costs at most 12 USD a "
        + "month.",
  },
  de: {
    title: "calibDB · Kamerakalibrierung für das Web",
    description:
      "Genaue Brennweite und Verzeichnung jeder Webcam, direkt im Browser: nachgeschlagen oder in einer Minute "
        + "kalibriert.",
    heading: "Jede Linse verbiegt die Welt.",
    lead:
      "Brennweite und Verzeichnung jeder Webcam, exakt und direkt im Browser. Ist Ihre Kamera noch nicht in der "
        + "Datenbank, kalibrieren Sie sie in einer Minute.",
    calibrate: "Kamera kalibrieren",
    watch: "Ohne Kamera zusehen",
    loop:
      "Eine Kalibriertafel im Bild einer Kamera. Sie bewegt sich in einen gelben Umriss und wird dort still gehalten; "
        + "dann erscheint ein anderer Umriss.",
    loop_caption: "Geführte Aufnahme: Halten Sie die Tafel in den Umriss. Vier oder fünf Ansichten genügen.",
    loop_pause: "Animation anhalten",
    loop_follow: "Dem Umriss folgen",
    loop_hold: "Stillhalten",
    loop_taken: "✓ Ansicht {count}",
    loop_done: "✓ Kamera kalibriert",
    ways: "So fangen Sie an",
    way_person: "Sie haben eine Kamera",
    way_person_text: "<0>Kalibrieren Sie sie</0>, <1>schlagen Sie sie nach</1> oder verwenden Sie <2>Ihre Fotos</2>.",
    way_developer: "Sie entwickeln eine Web-App",
    way_developer_text: "Kopieren Sie <0>zehn Zeilen</0>, und Ihre App kennt die Kamera ihrer Besucher.",
    way_operator: "Sie möchten calibDB selbst betreiben",
    way_operator_text: "<0>Ein Befehl</0> startet alles auf Ihrem Rechner, ein weiterer stellt es auf AWS bereit.",
    counts: "In der Datenbank",
    count_cameras: { one: "Kamera", other: "Kameras" },
    count_ready: { one: "einsatzbereit", other: "einsatzbereit" },
    count_calibrations: { one: "Kalibrierung", other: "Kalibrierungen" },
    known: "Ist Ihre Kamera in der Datenbank?",
    known_text:
      "Ihre Kamera wird kurz geöffnet. Diese Seite liest ihren Namen und ihre Auflösung und durchsucht die Datenbank.",
    look: "Meine Kamera nachschlagen",
    asking: "Ihre Kamera wird geöffnet.",
    known_yes: "{camera} ist einsatzbereit",
    card_size: "Auflösung",
    card_focal: "Brennweite",
    card_view: "Horizontaler Bildwinkel",
    card_error: "Typischer Fehler",
    card_calibrations: "Übereinstimmende Kalibrierungen",
    card_open: "Download und Einzelheiten",
    card_ar: "In AR ansehen",
    not_yet: "{camera} kennen wir noch nicht.",
    not_yet_text:
      "Machen Sie den Anfang: Sobald andere Ihr Ergebnis bestätigen, kann jede Web-App diese Kamera nachschlagen.",
    calibrate_it: "Jetzt kalibrieren (1 min)",
    fault_not_found: "Es wurde keine Kamera gefunden. Schließen Sie eine an, und versuchen Sie es noch einmal.",
    fault_too_strict: "Die Kamera kann kein Bild dieser Größe liefern.",
    search_all: "Alle Kameras durchsuchen",
    otherwise:
      "Keine Webcam? <0>Durchsuchen Sie alle Kameras</0>, oder kalibrieren Sie eine <1>aus Fotos</1> oder <2>aus der "
        + "Datei eines anderen Programms</2>.",
    uses: "Wofür es gut ist",
    figure: "Ein regelmäßiges Gitter, und wie ein Weitwinkelobjektiv es zeigt: an den Ecken nach innen gezogen",
    slide_lens: "Verzeichnung des Objektivs",
    use_straight: "Gerade Linien bleiben gerade.",
    caption: "Ziehen Sie den Regler, um ein Gitter durch verschiedene Linsen zu sehen.",
    without: "Ohne Korrektur: Ein Gitter und ein Quader über einer Tafel verfehlen deren Felder",
    with: "Mit Korrektur: Gitter und Quader liegen auf den Feldern",
    slide_overlay: "Vorher und nachher",
    use_overlay: "<0>AR, die haftet.</0> Links ohne, rechts mit Korrektur der Linse. <1>Mit Ihrer Kamera ansehen</1>",
    how: "So funktioniert es",
    step_board: "Die Tafel zeigen",
    step_board_text: "Auf einem zweiten Bildschirm, auf einem Tablet oder <0>auf Papier</0>. Jede Größe ist recht.",
    step_follow: "Dem Umriss folgen",
    step_follow_text: "Aufgenommen wird von selbst, sobald Sie stillhalten. Vier oder fünf Aufnahmen genügen.",
    step_done: "Einmal kalibrieren, allen nützen",
    step_done_text:
      "Sobald fünf Kalibrierungen übereinstimmen, kann jede Web-App Ihre Kamera nachschlagen. Ihre Bilder verlassen "
        + "das Gerät nie.",
    developers: "Für Entwickler",
    developers_text:
      "Ihre Web-App fragt nach der Kamera des Besuchers und erhält Brennweite und Bildmitte, Verzeichnung und ein Maß "
        + "der Verlässlichkeit.",
    example: "Beispiel: eine Kamera nachschlagen",
    next_steps:
      "<0>Holen Sie sich ein kostenloses Token</0>, lesen Sie die <1>Dokumentation</1> oder probieren Sie die "
        + "<2>Beispiele</2> aus.",
    conventions:
      "Die Werte folgen den Konventionen von OpenCV: ganzzahlige Koordinaten in den Pixelmitten, <0>camera_matrix</0> "
        + "zeilenweise.",
    host: "Selbst betreiben",
    commands: "Befehle: starten und bereitstellen",
    host_text:
      "Python-Funktionen, eine Tabelle und ein Bucket, in einer Vorlage beschrieben. Im Leerlauf kostet das höchstens "
        + "12 USD im Monat.",
  },
  uk: {
    title: "calibDB · калібрування камер для вебу",
    description:
      "Точна фокусна відстань і дисторсія будь-якої вебкамери просто в браузері: знайдені в базі або виміряні за "
        + "хвилину.",
    heading: "Кожен об’єктив викривляє світ.",
    lead:
      "Точна фокусна відстань і дисторсія будь-якої вебкамери — просто в браузері. Якщо вашої камери ще немає в базі, "
        + "калібрування займе хвилину.",
    calibrate: "Калібрувати камеру",
    watch: "Подивитися без камери",
    loop:
      "Калібрувальна дошка на зображенні камери. Вона входить у жовтий контур і завмирає в ньому; потім з’являється "
        + "інший контур.",
    loop_caption: "Калібрування з підказками: тримайте дошку в контурі. Досить чотирьох чи п’яти знімків.",
    loop_pause: "Зупинити анімацію",
    loop_follow: "Тримайтеся контуру",
    loop_hold: "Не рухайте",
    loop_taken: "✓ Знімок {count}",
    loop_done: "✓ Камеру відкалібровано",
    ways: "З чого почати",
    way_person: "У вас є камера",
    way_person_text: "<0>Відкалібруйте її</0>, <1>знайдіть у базі</1> або візьміть <2>свої фото</2>.",
    way_developer: "Ви створюєте вебзастосунок",
    way_developer_text: "Скопіюйте <0>десять рядків</0>, і застосунок знатиме камеру свого відвідувача.",
    way_operator: "Ви хочете власний сервіс",
    way_operator_text: "<0>Одна команда</0> запускає все на вашому комп’ютері, інша розгортає це в AWS.",
    counts: "У базі даних",
    count_cameras: { one: "камера", few: "камери", many: "камер", other: "камери" },
    count_ready: { one: "готова", few: "готові", many: "готових", other: "готових" },
    count_calibrations: { one: "калібрування", few: "калібрування", many: "калібрувань", other: "калібрування" },
    known: "Чи є ваша камера в базі?",
    known_text: "Камера відкриється на мить. Сторінка прочитає її назву й роздільність і пошукає їх у базі.",
    look: "Знайти мою камеру",
    asking: "Відкриваємо камеру.",
    known_yes: "{camera}: готова до використання",
    card_size: "Роздільність",
    card_focal: "Фокусна відстань",
    card_view: "Кут огляду по горизонталі",
    card_error: "Типова похибка",
    card_calibrations: "Узгоджені калібрування",
    card_open: "Завантажити й докладніше",
    card_ar: "Подивитися в AR",
    not_yet: "Ми ще не знаємо камери {camera}.",
    not_yet_text:
      "Станьте першими: щойно інші підтвердять ваш результат, кожен вебзастосунок зможе знайти цю камеру.",
    calibrate_it: "Калібрувати (1 хв)",
    fault_not_found: "Камери не знайдено. Під’єднайте її й спробуйте знову.",
    fault_too_strict: "Камера не дає зображення такого розміру.",
    search_all: "Шукати серед усіх камер",
    otherwise:
      "Немає вебкамери? <0>Шукайте серед усіх камер</0> або калібруйте <1>за фотографіями</1> чи <2>за файлом іншої "
        + "програми</2>.",
    uses: "Для чого це",
    figure: "Рівна сітка і та сама сітка крізь ширококутний об’єктив: кути стягнуто всередину",
    slide_lens: "Дисторсія об’єктива",
    use_straight: "Прямі лінії лишаються прямими.",
    caption: "Рухайте повзунок, щоб побачити рівну сітку крізь різні об’єктиви.",
    without: "Без корекції: сітка й куб, намальовані поверх дошки, не збігаються з її клітинками",
    with: "З корекцією: сітка й куб лежать на клітинках",
    slide_overlay: "До і після",
    use_overlay: "<0>AR, що тримається.</0> Ліворуч без корекції об’єктива, праворуч із нею. <1>Перевірте своєю камерою</1>",
    how: "Як це працює",
    step_board: "Покажіть дошку",
    step_board_text: "На другому екрані, на планшеті або <0>на папері</0>. Розмір будь-який.",
    step_follow: "Тримайтеся контуру",
    step_follow_text: "Знімки робляться самі, щойно ви тримаєте дошку нерухомо. Досить чотирьох чи п’яти.",
    step_done: "Відкалібруйте раз — знадобиться всім",
    step_done_text:
      "Щойно п’ять калібрувань збігаються, кожен вебзастосунок може знайти вашу камеру. Ваші зображення не залишають "
        + "пристрою.",
    developers: "Для розробників",
    developers_text:
      "Ваш вебзастосунок запитує про камеру відвідувача й отримує її внутрішні параметри, дисторсію об’єктива та оцінку "
        + "надійності.",
    example: "Приклад: пошук камери",
    next_steps: "<0>Отримайте безплатний токен</0>, прочитайте <1>документацію</1> або спробуйте <2>приклади</2>.",
    conventions:
      "Значення відповідають домовленостям OpenCV: центри пікселів у цілих координатах, <0>camera_matrix</0> рядок за "
        + "рядком.",
    host: "Власний сервіс",
    commands: "Команди: запуск і розгортання",
    host_text:
      "Функції на Python, одна таблиця й одне сховище, описані одним шаблоном. Без навантаження це коштує щонайбільше "
        + "12 USD на місяць.",
  },
};
