// Announcements to a screen reader: only the newest text, and no faster than a person can listen.

const ANNOUNCEMENT_PAUSE_MS = 2_500; // ms

export class Announcer {
  #place;
  #wait;
  #text = "";
  /** Texts announced once, by kind, and not lost to later ones. @type {string[]} */
  #news = [];
  /** @type {string[]} */
  #lastNews = [];
  /** @type {ReturnType<typeof setTimeout> | null} */
  #timer = null;

  /** @param {{textContent: string | null}} place a polite live region @param {number} [pause] ms */
  constructor(place, pause = ANNOUNCEMENT_PAUSE_MS) {
    this.#place = place;
    this.#wait = pause;
  }

  /**
   * @param {string} text what holds now
   * @param {string[]} news what has happened, of several kinds: each is said once, before it
   */
  say(text, ...news) {
    const isFresh = news.map((each, kind) => each !== "" && each !== this.#lastNews[kind]);
    this.#lastNews = news;
    news.forEach((each, kind) => {
      if (isFresh[kind]) this.#news[kind] = each;
    });
    if (text === this.#text && !isFresh.includes(true)) return;
    this.#text = text;
    if (this.#timer !== null) return;
    this.#write();
  }

  #write() {
    const said = this.#text;
    this.#place.textContent = [...this.#news, said].filter(Boolean).join(" ");
    this.#news = [];
    this.#timer = setTimeout(() => {
      this.#timer = null;
      if (this.#text !== said || this.#news.some(Boolean)) this.#write();
    }, this.#wait);
  }
}
