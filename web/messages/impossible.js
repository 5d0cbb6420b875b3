// Impossible boards: shown on every page whose address can name a board.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    because_kind: "there is no kind of board called {kind}",
    because_squares: "a board has {fewest} to 50 squares or tags across and down, such as 9x6",
    because_few_corners: "a board needs at least six corners to measure",
    because_many_corners: "a board has at most {most} corners",
    because_spacing: "the gap between tags is 0.05 to 2 times the side of a tag",
    because_family: "the tags of an AprilGrid come from an AprilTag family, and {dictionary} is none",
    because_ratio: "the side of a marker is 0.3 to 0.95 of its square",
    because_dictionary: "no marker dictionary is called {dictionary}",
    because_few_markers: "{dictionary} has {has} markers, and the board needs {needed}",
    default_instead: "The requested board is not possible: {reason}. This page uses the default board instead.",
  },
  de: {
    because_kind: "es gibt keine Tafelart namens {kind}",
    because_squares: "eine Tafel hat {fewest} bis 50 Felder oder Tags in jeder Richtung, etwa 9x6",
    because_few_corners: "eine Tafel braucht mindestens sechs messbare Ecken",
    because_many_corners: "eine Tafel hat höchstens {most} Ecken",
    because_spacing: "der Abstand der Tags ist das 0,05- bis 2-Fache ihrer Seitenlänge",
    because_family: "die Tags eines AprilGrids stammen aus einer AprilTag-Familie; {dictionary} ist keine",
    because_ratio: "die Seite einer Marke ist das 0,3- bis 0,95-Fache ihres Felds",
    because_dictionary: "kein Marker-Wörterbuch heißt {dictionary}",
    because_few_markers: "{dictionary} hat {has} Marken, und die Tafel braucht {needed}",
    default_instead:
      "Die verlangte Tafel ist nicht möglich: {reason}. Diese Seite verwendet stattdessen die Standardtafel.",
  },
  uk: {
    because_kind: "виду дошки «{kind}» немає",
    because_squares: "дошка має від {fewest} до 50 клітинок чи міток уширину й заввишки, наприклад 9x6",
    because_few_corners: "дошці потрібно щонайменше шість кутів, які можна виміряти",
    because_many_corners: "дошка має щонайбільше {most} кутів",
    because_spacing: "проміжок між мітками — від 0,05 до 2 сторін мітки",
    because_family: "мітки AprilGrid належать до родини AprilTag, а {dictionary} — ні",
    because_ratio: "сторона маркера — від 0,3 до 0,95 сторони клітинки",
    because_dictionary: "словника маркерів {dictionary} немає",
    because_few_markers: "{dictionary} має {has} маркерів, а дошці потрібно {needed}",
    default_instead: "Запитана дошка неможлива: {reason}. Сторінка використовує стандартну.",
  },
};
