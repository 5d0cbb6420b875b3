// What folds out over the picture folds in again by Escape, and by a press anywhere else.

const OPEN = ".rim details[open]";

/** @param {() => void} onEscape where there was nothing to fold in */
export function openDrawers(onEscape) {
  document.addEventListener("keydown", ({ key }) => {
    if (key !== "Escape") return;
    const drawers = document.querySelectorAll(OPEN);
    for (const drawer of drawers) {
      if (drawer.contains(document.activeElement)) drawer.querySelector("summary")?.focus();
      drawer.removeAttribute("open");
    }
    if (drawers.length === 0) onEscape();
  });
  document.addEventListener("pointerdown", ({ target }) => {
    for (const drawer of document.querySelectorAll(OPEN)) if (target instanceof Node && !drawer.contains(target)) drawer.removeAttribute("open");
  });
}
