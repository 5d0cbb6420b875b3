// Why a board cannot be: said on every page that can be asked for one.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    because_squares: "a board has 3 to 50 squares across and down, such as 9x6",
    because_few_corners: "a board has at least six inner corners",
    because_ratio: "a marker is 0.3 to 0.95 of its square",
    because_dictionary: "no marker dictionary is called {dictionary}",
    because_few_markers: "{dictionary} has {has} markers, and it needs {needed}",
    default_instead: "The board asked for cannot be: {reason}. The default board is taken instead.",
  },
  de: {
    because_squares: "eine Tafel hat 3 bis 50 Felder in jeder Richtung, etwa 9x6",
    because_few_corners: "eine Tafel hat mindestens sechs innere Ecken",
    because_ratio: "ein Marker nimmt 0,3 bis 0,95 seines Feldes ein",
    because_dictionary: "kein Marker-Wörterbuch heißt {dictionary}",
    because_few_markers: "{dictionary} hat {has} Marker, und sie braucht {needed}",
    default_instead: "Die gewünschte Tafel kann es nicht geben: {reason}. Stattdessen gilt die übliche.",
  },
  uk: {
    because_squares: "дошка має від 3 до 50 клітинок уширину й заввишки, наприклад 9x6",
    because_few_corners: "дошка має щонайменше шість внутрішніх кутів",
    because_ratio: "маркер займає від 0,3 до 0,95 клітинки",
    because_dictionary: "словника маркерів {dictionary} немає",
    because_few_markers: "{dictionary} має {has} маркерів, а треба {needed}",
    default_instead: "Такої дошки не буває: {reason}. Замість неї взято звичайну.",
  },
};
