// Live region: a text in one place of the page, written again when another language is chosen.
import { onLanguage } from "./i18n.js";

/**
 * @param {Element} place
 * @returns {(text?: () => string | (Node | string)[]) => void} writes a text there from now on; without one: nothing
 */
export function liveRegion(place) {
  /** @type {() => string | (Node | string)[]} */
  let current = () => "";
  const write = () => {
    const text = current();
    // Written only where it changed: a live region speaks on every write.
    if (typeof text !== "string") place.replaceChildren(...text);
    else if (place.textContent !== text) place.textContent = text;
  };
  onLanguage(write);
  return (text = () => "") => {
    current = text;
    write();
  };
}
