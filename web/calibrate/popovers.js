// Popovers at the rim of the viewfinder: Escape and a press anywhere else close them.

const OPEN = ".rim details[open]";

/** @param {() => void} onEscape called when no popover was open */
export function watchPopovers(onEscape) {
  document.addEventListener("keydown", ({ key }) => {
    if (key !== "Escape") return;
    const popovers = document.querySelectorAll(OPEN);
    for (const popover of popovers) {
      if (popover.contains(document.activeElement)) popover.querySelector("summary")?.focus();
      popover.removeAttribute("open");
    }
    if (popovers.length === 0) onEscape();
  });
  document.addEventListener("pointerdown", ({ target }) => {
    for (const popover of document.querySelectorAll(OPEN)) {
      if (target instanceof Node && !popover.contains(target)) popover.removeAttribute("open");
    }
  });
}
