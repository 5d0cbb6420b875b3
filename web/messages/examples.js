// Examples for application developers.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    calibrated: "Use the calibration",
    no_camera: "No camera was found. Plug one in, then try again.",
    source: "The whole source",
    install: "Import the modules from this service, or install its package: <0>how</0>.",
    all: "All examples",
    index: "Examples",
    index_lead: "A drawing over the camera's picture, with and without the calibration. Every example shows its source; all but AR.js run here without a camera, too.",
    ar: "What the calibration changes",
    three: "three.js over a calibrated camera",
    babylon: "Babylon.js over a calibrated camera",
    aframe: "A-Frame over a calibrated camera",
    arjs: "AR.js with your own camera_para.dat",
    stereo: "Depth from a rectified pair",
    stereo_lead: "Two simulated cameras with different lenses look at the board, one turned towards the other. Rectified, a point lies in the same row of both pictures, and the difference of its columns tells how far away it is. Choose a point in the left picture.",
    pair: "The pictures of two cameras side by side, with lines through the same rows",
    column: "Column",
    row: "Row",
    rectified: "Rectify the pair",
    depth: "Disparity {disparity} px: {depth} squares away. In truth: {truth}.",
    no_match: "Nothing here stands out from its row. Choose a point with some detail.",
    not_rectified: "The pictures as the cameras deliver them: the same point lies in other rows.",
    lead:
      "A box stands on the board, drawn over the straightened picture of your camera. The adapter gives the engine's "
        + "camera the focal length and centre of yours, whatever the layout. Switch the calibration off to see the difference.",
    arjs_lead:
      "AR.js tracks markers with the camera parameters in camera_para.dat. AR.js ships with another camera's file. "
        + "Download yours here.",
    start: "Open the camera",
    virtual: "Try the simulated camera",
    scene: "The camera's picture with a box over it",
    code: "What the page does",
    estimated: "This camera is not calibrated yet. This is drawn with an estimate, ± {percent} %.",
    unknown: "This camera is not calibrated yet, at this resolution.",
    calibrate: "Calibrate it",
    download: "Download camera_para.dat",
    exact: "It holds your camera's calibration, to a tenth of a pixel.",
    inexact: "ARToolKit's model has no third radial term: over the picture it differs by at most {error} px.",
    arjs_note:
      "AR.js needs <0>unsafe-eval</0> in the policy of the page that runs it, which this site does not grant: "
        + "this page gives the file, your page runs AR.js.",
  },
  de: {
    calibrated: "Kalibrierung verwenden",
    no_camera: "Es wurde keine Kamera gefunden. Schließen Sie eine an, und versuchen Sie es noch einmal.",
    source: "Der ganze Quelltext",
    install: "Importieren Sie die Module von diesem Dienst, oder installieren Sie sein Paket: <0>so geht es</0>.",
    all: "Alle Beispiele",
    index: "Beispiele",
    index_lead: "Eine Zeichnung über dem Bild der Kamera, mit und ohne Kalibrierung. Jedes Beispiel zeigt seinen Quelltext; alle außer AR.js laufen hier auch ohne Kamera.",
    ar: "Was die Kalibrierung ändert",
    three: "three.js über einer kalibrierten Kamera",
    babylon: "Babylon.js über einer kalibrierten Kamera",
    aframe: "A-Frame über einer kalibrierten Kamera",
    arjs: "AR.js mit einer eigenen camera_para.dat",
    stereo: "Tiefe aus einem rektifizierten Bildpaar",
    stereo_lead: "Zwei simulierte Kameras mit verschiedenen Objektiven sehen die Tafel, die eine ist zur anderen gedreht. Rektifiziert liegt ein Punkt in beiden Bildern in derselben Zeile, und der Unterschied der Spalten sagt, wie weit er entfernt ist. Wählen Sie einen Punkt im linken Bild.",
    pair: "Die Bilder zweier Kameras nebeneinander, mit Linien durch dieselben Zeilen",
    column: "Spalte",
    row: "Zeile",
    rectified: "Bildpaar rektifizieren",
    depth: "Disparität {disparity} px: {depth} Quadrate entfernt. In Wahrheit: {truth}.",
    no_match: "Hier hebt sich nichts von seiner Zeile ab. Wählen Sie einen Punkt mit mehr Details.",
    not_rectified: "Die Bilder, wie die Kameras sie liefern: Derselbe Punkt liegt in verschiedenen Zeilen.",
    lead:
      "Auf der Tafel steht ein Kasten, gezeichnet über das entzerrte Bild Ihrer Kamera. Der Adapter gibt der Kamera "
        + "der Szene Brennweite und Bildmitte der echten, unabhängig vom Layout. Schalten Sie die Kalibrierung aus, um den Unterschied zu sehen.",
    arjs_lead:
      "AR.js verfolgt Marken mit den Kameraparametern in camera_para.dat. Mitgeliefert wird die Datei einer anderen "
        + "Kamera. Hier laden Sie Ihre eigene herunter.",
    start: "Kamera öffnen",
    virtual: "Simulierte Kamera ausprobieren",
    scene: "Das Bild der Kamera mit einem Kasten darüber",
    code: "Was die Seite tut",
    estimated: "Diese Kamera ist noch nicht kalibriert. Gezeichnet wird mit einer Schätzung, ± {percent} %.",
    unknown: "Diese Kamera ist in dieser Auflösung noch nicht kalibriert.",
    calibrate: "Kalibrieren",
    download: "camera_para.dat herunterladen",
    exact: "Sie enthält die Kalibrierung Ihrer Kamera, auf ein Zehntel Pixel genau.",
    inexact: "ARToolKits Modell hat kein drittes radiales Glied: über dem Bild weicht es um höchstens {error} px ab.",
    arjs_note:
      "AR.js braucht <0>unsafe-eval</0> in den Regeln der Seite, auf der es läuft; diese Website erlaubt das "
        + "nicht. Diese Seite gibt die Datei, Ihre Seite führt AR.js aus.",
  },
  uk: {
    calibrated: "Використовувати калібрування",
    no_camera: "Камеру не знайдено. Під’єднайте її та спробуйте ще раз.",
    source: "Увесь код",
    install: "Імпортуйте модулі з цього сервісу або встановіть його пакет: <0>як це зробити</0>.",
    all: "Усі приклади",
    index: "Приклади",
    index_lead: "Малюнок поверх зображення камери, з калібруванням і без нього. Кожен приклад показує свій код; усі, крім AR.js, працюють тут і без камери.",
    ar: "Що змінює калібрування",
    three: "three.js поверх каліброваної камери",
    babylon: "Babylon.js поверх каліброваної камери",
    aframe: "A-Frame поверх каліброваної камери",
    arjs: "AR.js із власним camera_para.dat",
    stereo: "Глибина з ректифікованої пари",
    stereo_lead: "Дві імітовані камери з різними об’єктивами дивляться на дошку, одна повернута до іншої. Після ректифікації точка лежить в одному рядку обох зображень, а різниця стовпців показує відстань до неї. Виберіть точку на лівому зображенні.",
    pair: "Зображення двох камер поруч, з лініями через однакові рядки",
    column: "Стовпець",
    row: "Рядок",
    rectified: "Ректифікувати пару",
    depth: "Диспаратність {disparity} px: відстань {depth} клітинок. Насправді: {truth}.",
    no_match: "Тут ніщо не вирізняється у своєму рядку. Виберіть точку з деталями.",
    not_rectified: "Зображення такі, як їх дають камери: та сама точка лежить у різних рядках.",
    lead:
      "На дошці стоїть коробка, намальована поверх випрямленого зображення вашої камери. Адаптер дає камері сцени "
        + "фокусну відстань і центр справжньої, хоч би яким був макет. Вимкніть калібрування, щоб побачити різницю.",
    arjs_lead:
      "AR.js стежить за мітками з параметрами камери у файлі camera_para.dat. У комплекті йде файл іншої камери. "
        + "Завантажте тут свій.",
    start: "Відкрити камеру",
    virtual: "Спробувати імітовану камеру",
    scene: "Зображення камери з коробкою поверх нього",
    code: "Що робить сторінка",
    estimated: "Цю камеру ще не калібровано. Малюнок побудовано за оцінкою, ± {percent} %.",
    unknown: "Цю камеру з такою роздільністю ще не калібровано.",
    calibrate: "Калібрувати",
    download: "Завантажити camera_para.dat",
    exact: "Він містить калібрування вашої камери з точністю до десятої частки пікселя.",
    inexact: "У моделі ARToolKit немає третього радіального члена: на зображенні різниця щонайбільше {error} px.",
    arjs_note:
      "AR.js потребує <0>unsafe-eval</0> у правилах сторінки, на якій працює, а цей сайт його не дозволяє: ця "
        + "сторінка дає файл, а AR.js працює на вашій.",
  },
};
