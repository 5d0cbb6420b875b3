// Start of every page with a header: its menus close like menus, blocks of code can be copied, and the language can
// be chosen where no page's script offers that.
import { addCopyButton } from "./code-block.js";

const menus = () => /** @type {NodeListOf<HTMLDetailsElement>} */ (document.querySelectorAll("details.menu"));

document.addEventListener("click", ({ target }) => {
  for (const menu of menus()) if (menu.open && target instanceof Node && !menu.contains(target)) menu.open = false;
});
document.addEventListener("keydown", ({ key }) => {
  if (key !== "Escape") return;
  for (const menu of menus()) {
    if (!menu.open) continue;
    menu.open = false;
    menu.querySelector("summary")?.focus();
  }
});
for (const menu of menus()) {
  menu.addEventListener("focusout", ({ relatedTarget }) => {
    if (relatedTarget instanceof Node && !menu.contains(relatedTarget)) menu.open = false;
  });
}
document.addEventListener("change", ({ target }) => {
  // Pages with texts of their own change them in place (i18n.js).
  if (!(target instanceof HTMLSelectElement) || target.id !== "language" || target.dataset.inPlace !== undefined)
    return;
  const there = /** @type {HTMLLinkElement | null} */ (
    document.querySelector(`link[rel=alternate][hreflang="${target.value}"]`)
  );
  if (!there) return;
  const address = new URL(there.getAttribute("href") ?? "", location.href);
  location.assign(`${address.pathname}?lang=${target.value}`);
});
for (const code of document.querySelectorAll("pre > code")) if (code.parentElement) addCopyButton(code.parentElement);
