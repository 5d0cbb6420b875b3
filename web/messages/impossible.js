// Impossible boards: shown on every page whose address can name a board.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    because_squares: "a board has 3 to 50 squares across and down, such as 9x6",
    because_few_corners: "a board has at least six inner corners",
    because_ratio: "the side of a marker is 0.3 to 0.95 of its square",
    because_dictionary: "no marker dictionary is called {dictionary}",
    because_few_markers: "{dictionary} has {has} markers, and the board needs {needed}",
    default_instead: "The requested board is not possible: {reason}. This page uses the default board instead.",
  },
  de: {
    because_squares: "eine Tafel hat 3 bis 50 Felder in jeder Richtung, etwa 9x6",
    because_few_corners: "eine Tafel hat mindestens sechs innere Ecken",
    because_ratio: "die Seite einer Marke ist das 0,3- bis 0,95-Fache ihres Felds",
    because_dictionary: "kein Marker-Wörterbuch heißt {dictionary}",
    because_few_markers: "{dictionary} hat {has} Marken, und die Tafel braucht {needed}",
    default_instead:
      "Die verlangte Tafel ist nicht möglich: {reason}. Diese Seite verwendet stattdessen die Standardtafel.",
  },
  uk: {
    because_squares: "дошка має від 3 до 50 клітинок уширину й заввишки, наприклад 9x6",
    because_few_corners: "дошка має щонайменше шість внутрішніх кутів",
    because_ratio: "сторона маркера — від 0,3 до 0,95 сторони клітинки",
    because_dictionary: "словника маркерів {dictionary} немає",
    because_few_markers: "{dictionary} має {has} маркерів, а дошці потрібно {needed}",
    default_instead: "Запитана дошка неможлива: {reason}. Сторінка використовує стандартну.",
  },
};
