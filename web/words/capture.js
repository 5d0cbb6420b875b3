// The guided capture in three languages.

/** @type {import("../i18n.js").Room} */
export default {
  en: { title: "Calibrate a camera · calibDB" },
  de: { title: "Eine Kamera kalibrieren · calibDB" },
  uk: { title: "Калібрування камери · calibDB" },
};
