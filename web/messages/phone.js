// Question about a phone's model, which its browser does not say.

/** @type {import("../lib/i18n.js").Catalog} */
export default {
  en: {
    question: "Which iPhone is this?",
    why: "Safari does not say. With the model, this camera can be told from those of other iPhones.",
    unknown: "I don't know",
    answer: "Continue",
  },
  de: {
    question: "Welches iPhone ist das?",
    why: "Safari verrät es nicht. Mit dem Modell lässt sich diese Kamera von denen anderer iPhones unterscheiden.",
    unknown: "Ich weiß es nicht",
    answer: "Weiter",
  },
  uk: {
    question: "Який це iPhone?",
    why: "Safari цього не повідомляє. За моделлю цю камеру можна відрізнити від камер інших iPhone.",
    unknown: "Не знаю",
    answer: "Далі",
  },
};
