// Arrival of the visitor at a page, before its modules run: a page that captures is laid out for the visitor before
// anything is drawn, and early clicks are kept. A classic script, for it must run before the page.
(() => {
  const query = new URLSearchParams(location.search);
  const { classList } = document.documentElement;
  classList.toggle("loopback", /^(localhost|127\.0\.0\.1|\[::1\])$/.test(location.hostname));
  classList.toggle("sent", query.has("return_to"));
  // A phone that was sent here by the screen that shows the board needs no other one.
  classList.toggle("sent-by-screen", query.has("facing"));
  classList.toggle("joins", query.has("code") || query.has("join"));
  // A result of a rig, or a capture of one that this browser takes up again: the first sheet would only flash.
  classList.toggle("arrives", query.has("id") || query.get("virtual") === "1");
})();

// Clicks and chosen files that come before the page's modules run: kept, and given to them once they do. Without this
// a button pressed at once on a slow line does nothing, or sends its form to nowhere.
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
