// Messages of the consent block, which every page that calibrates has.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    ask: "Publish my measurements as open data (CC0)",
    terms: "Optional. <0>What this means</0>",
    not_given: "Not ticked: your camera is calibrated all the same, and the result helps others who have it. Your measurements stay out of the public download.",
    given: "Thank you. The positions of the corners, the camera's name and its settings become part of the weekly public download. Untick this to keep later calibrations out of it.",
  },
  de: {
    ask: "Meine Messungen als offene Daten veröffentlichen (CC0)",
    terms: "Freiwillig. <0>Was das bedeutet</0>",
    not_given: "Nicht angekreuzt: Ihre Kamera wird trotzdem kalibriert, und das Ergebnis hilft anderen mit der gleichen Kamera. Ihre Messungen kommen nicht in den öffentlichen Download.",
    given: "Vielen Dank. Die Positionen der Ecken, der Name der Kamera und ihre Einstellungen kommen in den wöchentlichen öffentlichen Download. Entfernen Sie das Häkchen, wenn spätere Kalibrierungen nicht dazugehören sollen.",
  },
  uk: {
    ask: "Опублікувати мої вимірювання як відкриті дані (CC0)",
    terms: "Необов’язково. <0>Що це означає</0>",
    not_given: "Не позначено: камеру все одно буде відкалібровано, і результат допоможе іншим, хто має таку саму. Ваші вимірювання не потраплять до публічного архіву.",
    given: "Дякуємо! Положення кутів, назва камери та її налаштування потраплять до щотижневого публічного архіву. Зніміть позначку, щоб наступні калібрування до нього не потрапляли.",
  },
};
