// Badge of a camera at a size, with the Markdown that shows it in a README.
import { addCopyButton } from "../lib/copy-button.js";
import { el } from "../lib/dom.js";
import { formatSize, t } from "../lib/i18n.js";

/** @param {string} key of the camera @param {[number, number]} size px @param {string} name of the camera */
export function badgeView(key, size, name) {
  const address = `${location.origin}/badge/${encodeURIComponent(key)}/${size.join("x")}.svg`;
  const page = `${location.origin}/cameras/?${new URLSearchParams({ key })}`;
  const alt = t("cameras.badge_alt", { camera: name, size: formatSize(size) });
  const markdown = `[![${alt.replace(/[[\]]/g, "")}](${address})](${page})`;
  return el(
    "details",
    { class: "badge" },
    el("summary", {}, t("cameras.badge")),
    el("p", {}, el("img", { src: address, alt, height: 20, loading: "lazy" })),
    addCopyButton(el("pre", { tabindex: 0, "aria-label": "Markdown" }, el("code", {}, markdown))),
  );
}
