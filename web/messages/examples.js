// Examples for application developers.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    three: "three.js over a calibrated camera",
    babylon: "Babylon.js over a calibrated camera",
    aframe: "A-Frame over a calibrated camera",
    arjs: "AR.js with your own camera_para.dat",
    lead:
      "A box on the board, drawn over the straightened picture of your camera. The adapter gives the engine's "
        + "camera this one's focal length and centre, however the picture lies in the page.",
    arjs_lead:
      "AR.js tracks markers with the camera parameters in camera_para.dat. The one it comes with is another "
        + "camera's. Here is yours.",
    start: "Open the camera",
    virtual: "Try the virtual camera",
    scene: "The camera's picture with a box over it",
    code: "What the page does",
    others: "Others",
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
    three: "three.js über einer kalibrierten Kamera",
    babylon: "Babylon.js über einer kalibrierten Kamera",
    aframe: "A-Frame über einer kalibrierten Kamera",
    arjs: "AR.js mit einer eigenen camera_para.dat",
    lead:
      "Ein Kasten auf der Tafel, über das entzerrte Bild Ihrer Kamera gezeichnet. Der Adapter gibt der Kamera "
        + "der Szene die Brennweite und die Bildmitte der echten, wie immer das Bild auf der Seite liegt.",
    arjs_lead:
      "AR.js verfolgt Marken mit den Kameraparametern in camera_para.dat. Die mitgelieferte ist die einer "
        + "anderen Kamera. Hier ist Ihre.",
    start: "Kamera öffnen",
    virtual: "Virtuelle Kamera ausprobieren",
    scene: "Das Bild der Kamera mit einem Kasten darüber",
    code: "Was die Seite tut",
    others: "Andere",
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
    three: "three.js поверх каліброваної камери",
    babylon: "Babylon.js поверх каліброваної камери",
    aframe: "A-Frame поверх каліброваної камери",
    arjs: "AR.js із власним camera_para.dat",
    lead:
      "Коробка на дошці, намальована поверх випрямленого зображення вашої камери. Адаптер дає камері сцени "
        + "фокусну відстань і центр справжньої, хоч як зображення лежить на сторінці.",
    arjs_lead:
      "AR.js стежить за мітками з параметрами камери у файлі camera_para.dat. Той, що йде в комплекті, — від "
        + "іншої камери. Ось ваш.",
    start: "Відкрити камеру",
    virtual: "Спробувати віртуальну камеру",
    scene: "Зображення камери з коробкою поверх нього",
    code: "Що робить сторінка",
    others: "Інші",
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
