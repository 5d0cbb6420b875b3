// What a page says in one place, said again when another language is chosen.
import { onLanguage } from "./i18n.js";

/**
 * @param {Element} place
 * @returns {(words?: () => string | (Node | string)[]) => void} says something there from now on; without words: nothing
 */
export function sayIn(place) {
  /** @type {() => string | (Node | string)[]} */
  let said = () => "";
  const write = () => {
    const words = said();
    // Written only where it changed: a live region speaks on every write.
    if (typeof words !== "string") place.replaceChildren(...words);
    else if (place.textContent !== words) place.textContent = words;
  };
  onLanguage(write);
  return (words = () => "") => {
    said = words;
    write();
  };
}
