// What a screen reader says: the newest of what there is to say, and not more often than one can listen.

const PAUSE = 2_500; // ms

export class Announcer {
  #place;
  #wait;
  #text = "";
  /** @type {ReturnType<typeof setTimeout> | null} */
  #timer = null;

  /** @param {{textContent: string | null}} place a polite live region @param {number} [pause] ms */
  constructor(place, pause = PAUSE) {
    this.#place = place;
    this.#wait = pause;
  }

  /** @param {string} text */
  say(text) {
    if (text === this.#text) return;
    this.#text = text;
    if (this.#timer !== null) return;
    this.#write();
  }

  #write() {
    const said = this.#text;
    this.#place.textContent = said;
    this.#timer = setTimeout(() => {
      this.#timer = null;
      if (this.#text !== said) this.#write();
    }, this.#wait);
  }
}
