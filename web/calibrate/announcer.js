// What a screen reader says: the newest of what there is to say, and not more often than one can listen.

const PAUSE = 2_500; // ms

export class Announcer {
  #place;
  #wait;
  #text = "";
  /** What is said once, and not lost to what comes after it. */
  #news = "";
  #told = "";
  /** @type {ReturnType<typeof setTimeout> | null} */
  #timer = null;

  /** @param {{textContent: string | null}} place a polite live region @param {number} [pause] ms */
  constructor(place, pause = PAUSE) {
    this.#place = place;
    this.#wait = pause;
  }

  /** @param {string} text what holds now @param {string} [news] what has just happened: said once, before it */
  say(text, news = "") {
    const isNew = news !== "" && news !== this.#told;
    this.#told = news;
    if (isNew) this.#news = news;
    if (text === this.#text && !isNew) return;
    this.#text = text;
    if (this.#timer !== null) return;
    this.#write();
  }

  #write() {
    const said = this.#text;
    this.#place.textContent = [this.#news, said].filter(Boolean).join(" ");
    this.#news = "";
    this.#timer = setTimeout(() => {
      this.#timer = null;
      if (this.#text !== said || this.#news) this.#write();
    }, this.#wait);
  }
}
