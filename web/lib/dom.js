// DOM elements: making them, finding them, writing texts into them, and pressing them by keys.
import { onLanguage } from "./i18n.js";

const SVG = "http://www.w3.org/2000/svg";

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} name
 * @param {Record<string, string | number | boolean | undefined>} [attributes] false and undefined: left out
 * @param {...(Node | string | false | null | undefined)} content false, null and undefined: left out
 * @returns {HTMLElementTagNameMap[K]}
 */
export function el(name, attributes = {}, ...content) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== false && value !== undefined) made.setAttribute(key, value === true ? "" : String(value));
  }
  made.append(...content.filter((each) => each !== false && each !== null && each !== undefined));
  return made;
}

/**
 * Makes a button that does something.
 * @param {string} label @param {() => unknown} action @param {Record<string, string>} [attributes]
 */
export function button(label, action, attributes = {}) {
  const made = el("button", { type: "button", ...attributes }, label);
  made.addEventListener("click", () => void action());
  return made;
}

/**
 * Makes an element of SVG.
 * @param {string} name @param {Record<string, string | number>} [attributes] @param {(Node | string)[]} [content]
 * @returns {SVGElement}
 */
export function make(name, attributes = {}, content = []) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.append(...content);
  return made;
}

/**
 * @template {Element} E
 * @param {string} id
 * @param {new () => E} type
 * @returns {E} of the page; a page that lacks it says so
 */
export function part(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new TypeError(`the page has no ${type.name} #${id}`);
  return found;
}

/**
 * @template {string} S
 * @typedef {S extends `${infer A}-${infer B}` ? `${A}${Capitalize<CamelCase<B>>}` : S} CamelCase
 */

/**
 * Elements of the page, each named after its id: "go-on" is `goOn`.
 * @template {Element} E @template {string} I
 * @param {new () => E} type @param {readonly I[]} ids
 */
export function partsOf(type, ids) {
  const found = ids.map((id) => [id.replace(/-(.)/g, (_, letter) => letter.toUpperCase()), part(id, type)]);
  return /** @type {{[id in I as CamelCase<id>]: E}} */ (Object.fromEntries(found));
}

/**
 * Writes a text only where it changed: a live region speaks on every write.
 * @param {Element} place @param {string} text
 */
export function write(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

/**
 * Says the reason of a failure in the heading of a place, and what to do about it in its paragraph.
 * @param {HTMLElement} place @param {string} text its first sentence is the reason
 */
export function sayFailure(place, text) {
  const [reason = text, remedy = ""] = /^((?:\([^)]*\)|[^(])+?[.!?]) (.+)$/s.exec(text)?.slice(1) ?? [];
  const [heading, paragraph] = place.children;
  write(heading, reason);
  write(paragraph, remedy);
}

/**
 * Live region: a text in one place of the page, written again when another language is chosen.
 * @param {Element} place
 * @returns {(text?: () => string | (Node | string)[]) => void} writes a text there from now on; without one: nothing
 */
export function liveRegion(place) {
  /** @type {() => string | (Node | string)[]} */
  let current = () => "";
  const speak = () => {
    const text = current();
    if (typeof text === "string") write(place, text);
    else place.replaceChildren(...text);
  };
  onLanguage(speak);
  return (text = () => "") => {
    current = text;
    speak();
  };
}

const FIELDS = "input:not([type=checkbox]), select, textarea, [contenteditable]";

/**
 * Lets keys press buttons: during a capture both hands hold the board.
 * @param {Record<string, HTMLButtonElement>} buttons by key, in lower case
 * @param {AbortSignal} signal after which keys press nothing
 */
export function pressByKeys(buttons, signal) {
  document.addEventListener(
    "keydown",
    (event) => {
      if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.target instanceof Element && event.target.closest(FIELDS)) return;
      const button = buttons[event.key.toLowerCase()];
      if (!button || button.hidden || button.disabled) return;
      button.click();
      event.preventDefault();
    },
    { signal },
  );
}
