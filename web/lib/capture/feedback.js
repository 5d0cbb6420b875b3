// Haptic and audible feedback when the board is to be held still and when a view is taken: both hands hold the board,
// and the eyes may be on it.
import { language } from "../i18n.js";
import { keepItem, readJson } from "../storage.js";

/** @typedef {"sound" | "vibration" | "voice"} Sense */

/** Defaults until the visitor chooses. @type {Record<Sense, boolean>} */
const AT_FIRST = { sound: true, vibration: true, voice: false };
const SENSES_KEY = "calibdb.senses";
const SPEECH_PAUSE_MS = 1_800; // ms between two spoken hints: a person must be able to follow
const NOTES = { hold: [659.3], taken: [1046.5, 1568], refused: [311.1], done: [784, 1046.5, 1568] }; // Hz
const NOTE = 0.09; // s
const LOUDNESS = 0.12; // of full scale

/** @typedef {keyof typeof NOTES} Sign */

export class Feedback {
  #senses;
  /** @type {AudioContext | null} */
  #audio = null;
  /**
   * Number of notes that sound or will. Without any, the audio output is suspended: it takes power even when silent.
   */
  #sounding = 0;
  #spoken = "";
  #spokenAt = -Infinity;

  constructor() {
    this.#senses = { ...AT_FIRST, ...readJson(SENSES_KEY) };
  }

  /** @param {Sense} sense */
  has(sense) {
    return this.#senses[sense];
  }

  /** True if this device has a sense. @param {Sense} sense */
  static offers(sense) {
    if (sense === "sound") return typeof AudioContext === "function";
    return sense === "vibration" ? "vibrate" in navigator : "speechSynthesis" in globalThis;
  }

  /** Lets boxes switch the senses that this device has. @param {Record<Sense, HTMLInputElement>} boxes */
  bind(boxes) {
    for (const [sense, box] of /** @type {[Sense, HTMLInputElement][]} */ (Object.entries(boxes))) {
      box.checked = this.has(sense);
      box.parentElement?.toggleAttribute("hidden", !Feedback.offers(sense));
      box.addEventListener("change", () => this.switch(sense, box.checked));
    }
  }

  /** @param {Sense} sense @param {boolean} on */
  switch(sense, on) {
    this.#senses[sense] = on;
    keepItem(SENSES_KEY, JSON.stringify(this.#senses));
    if (sense === "sound" && on) this.give("taken");
    if (sense === "voice" && !on) globalThis.speechSynthesis?.cancel();
  }

  /** A sign by sound and by touch. @param {Sign} sign */
  give(sign) {
    // Browsers allow sound and vibration only after the visitor has touched the page.
    if (!navigator.userActivation?.hasBeenActive) return;
    if (this.#senses.sound && Feedback.offers("sound")) this.#play(NOTES[sign]);
    if (this.#senses.vibration && Feedback.offers("vibration"))
      navigator.vibrate(sign === "refused" ? [30, 60, 30] : sign === "hold" ? 25 : 60);
  }

  /** Says a hint, unless it has just been said or another one still is. @param {string} text */
  say(text) {
    const time = performance.now();
    if (!this.#senses.voice || !Feedback.offers("voice") || !text || text === this.#spoken) return;
    if (time - this.#spokenAt < SPEECH_PAUSE_MS || speechSynthesis.speaking) return;
    this.#spoken = text;
    this.#spokenAt = time;
    const utterance = new SpeechSynthesisUtterance(text);
    utterance.lang = language();
    speechSynthesis.speak(utterance);
  }

  /** @param {number[]} notes */
  #play(notes) {
    const audio = (this.#audio ??= new AudioContext());
    void audio.resume();
    notes.forEach((frequency, index) => {
      const [tone, volume] = [audio.createOscillator(), audio.createGain()];
      const start = audio.currentTime + index * NOTE;
      tone.frequency.value = frequency;
      volume.gain.setValueAtTime(LOUDNESS, start);
      volume.gain.exponentialRampToValueAtTime(0.001, start + 2 * NOTE);
      this.#sounding += 1;
      tone.onended = () => {
        if (--this.#sounding === 0) void audio.suspend();
      };
      tone.connect(volume).connect(audio.destination);
      tone.start(start);
      tone.stop(start + 2 * NOTE);
    });
  }
}

const ANNOUNCEMENT_PAUSE_MS = 2_500; // ms

/** Announcements to a screen reader: only the newest text, and no faster than a person can listen. */
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
