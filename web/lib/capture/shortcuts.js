// Keys that press buttons during a capture: both hands hold the board, and one key is found without looking.

const FIELDS = "input:not([type=checkbox]), select, textarea, [contenteditable]";

/**
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
