// What several pages say.

/** @type {import("../i18n.js").Room} */
export default {
  en: {
    pages: "Pages",
    calibrate: "Calibrate",
    cameras: "Cameras",
    photos: "Photos",
    board: "Board",
    licence: "calibDB is free software, Apache-2.0.",
    method: "Method: Rojtberg & Gorschlüter, Web3D 2019; Rojtberg & Kuijper, ISMAR 2018.",
    went_wrong: "Something went wrong in this page ({message}).",
  },
  de: {
    pages: "Seiten",
    calibrate: "Kalibrieren",
    cameras: "Kameras",
    photos: "Fotos",
    board: "Tafel",
    licence: "calibDB ist freie Software, Apache-2.0.",
    method: "Verfahren: Rojtberg & Gorschlüter, Web3D 2019; Rojtberg & Kuijper, ISMAR 2018.",
    went_wrong: "Auf dieser Seite ist etwas schiefgegangen ({message}).",
  },
  uk: {
    pages: "Сторінки",
    calibrate: "Калібрування",
    cameras: "Камери",
    photos: "Фото",
    board: "Дошка",
    licence: "calibDB — вільне програмне забезпечення, Apache-2.0.",
    method: "Метод: Rojtberg & Gorschlüter, Web3D 2019; Rojtberg & Kuijper, ISMAR 2018.",
    went_wrong: "На цій сторінці щось пішло не так ({message}).",
  },
};
