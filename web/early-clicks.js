// Clicks that come before the page's modules run: kept, and given to them once they do. Without this a button pressed at once
// on a slow line does nothing, or sends its form to nowhere. A classic script, for it must run before the page.
(() => {
  /** Buttons and forms, in the order in which they were used first. @type {Set<HTMLButtonElement | HTMLFormElement>} */
  const early = new Set();
  /** @param {Event} event */
  const keep = (event) => {
    const used = event.type === "submit" ? event.target : event.target instanceof Element && event.target.closest("button");
    if (!(used instanceof HTMLButtonElement || used instanceof HTMLFormElement)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    early.add(used);
  };
  const types = ["click", "submit"];
  for (const type of types) addEventListener(type, keep, true);
  // Modules have run by then.
  document.addEventListener("DOMContentLoaded", () => {
    for (const type of types) removeEventListener(type, keep, true);
    for (const used of early) {
      if (used instanceof HTMLFormElement) used.requestSubmit();
      else used.click();
    }
  }, { once: true });
})();
