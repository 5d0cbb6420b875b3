// Clicks and chosen files that come before the page's modules run: kept, and given to them once they do. Without this
// a button pressed at once on a slow line does nothing, or sends its form to nowhere. A classic script, for it must
// run before the page.
(() => {
  /**
   * Elements in the order in which they were used first.
   * @type {Set<HTMLButtonElement | HTMLFormElement | HTMLInputElement>}
   */
  const early = new Set();
  /** @param {Event} event */
  const keep = (event) => {
    if (event.type === "change") {
      if (event.target instanceof HTMLInputElement && event.target.type === "file") early.add(event.target);
      return;
    }
    const used =
      event.type === "submit" ? event.target : event.target instanceof Element && event.target.closest("button");
    if (!(used instanceof HTMLButtonElement || used instanceof HTMLFormElement)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    early.add(used);
  };
  const types = ["click", "submit", "change"];
  for (const type of types) addEventListener(type, keep, true);
  // Modules have run by then.
  document.addEventListener(
    "DOMContentLoaded",
    () => {
      for (const type of types) removeEventListener(type, keep, true);
      for (const used of early) {
        if (used instanceof HTMLFormElement) used.requestSubmit();
        else if (used instanceof HTMLInputElement) used.dispatchEvent(new Event("change", { bubbles: true }));
        else used.click();
      }
    },
    { once: true },
  );
})();
