// Tabs: panels of which one is shown.
import { el } from "../dom.js";

let last = ""; // name of the chosen panel, for the next list of this page

/**
 * @param {string} label of the list, for those who cannot see it
 * @param {{name: string, title: string, content: Node}[]} panels
 * @returns {HTMLElement}
 */
export function tabs(label, panels) {
  const buttons = panels.map(({ name, title }) =>
    el("button", { type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `result-${name}` }, title),
  );
  const bodies = panels.map(({ name, content }) =>
    el("div", { role: "tabpanel", id: `result-${name}`, "aria-labelledby": `tab-${name}` }, content),
  );
  const choose = (/** @type {number} */ chosen) =>
    buttons.forEach((button, index) => {
      button.setAttribute("aria-selected", String(index === chosen));
      button.tabIndex = index === chosen ? 0 : -1;
      bodies[index].hidden = index !== chosen;
    });
  buttons.forEach((button, index) => {
    button.addEventListener("click", () => {
      last = panels[index].name;
      choose(index);
    });
    button.addEventListener("keydown", ({ key }) => {
      const to = { ArrowRight: index + 1, ArrowLeft: index - 1, Home: 0, End: -1 }[key];
      if (to === undefined) return;
      const next = buttons[(to + buttons.length) % buttons.length];
      next.focus();
      next.click();
    });
  });
  choose(
    Math.max(
      0,
      panels.findIndex(({ name }) => name === last),
    ),
  );
  return el("section", { class: "tabs" }, el("div", { role: "tablist", "aria-label": label }, ...buttons), ...bodies);
}
