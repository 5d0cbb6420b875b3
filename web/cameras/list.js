// Entries of lists of cameras: those of the database, and the calibrations that were made in this browser.
import { el } from "../lib/dom.js";
import { splitLabel } from "../lib/camera-name.js";
import { number, rough, formatSize, t } from "../lib/i18n.js";
import { forgetOwn, ownCalibrations } from "../lib/own-calibrations.js";
import { isVirtual } from "../lib/virtual/name.js";
import { aboutText, stateText } from "./camera.js";
import { dateText, nameOf } from "./members.js";

/** @typedef {import("./source.js").Found} Found */

/** @param {Found} found */
export function cameraItem(found) {
  const { key, camera, sizes } = found;
  const about = [aboutText(found), ...(isVirtual(camera) ? [t("cameras.practice")] : [])];
  const newest = Math.max(0, ...sizes.map(({ calibration_time }) => calibration_time ?? 0));
  const first = sizes.find(({ fx }) => fx !== null);
  return el("li", {},
    el("a", { href: `./?${new URLSearchParams({ key })}` }, el("strong", {}, splitLabel(camera).name), el("span", { class: "muted" }, about.join(" · "))),
    el("ul", { class: "sizes number" }, ...sizes.map((size) =>
      el("li", { class: size.reliable ? "known" : "" }, nameOf(size), " ", el("span", { class: "state" }, stateText(size))))),
    el("span", { class: "count number muted" }, ...[
      ...(first?.fx ? [`fx ${number(first.fx, 0)}\u00a0px`] : []), ...(newest ? [dateText(newest)] : []),
    ].flatMap((text, index) => (index ? [el("br"), text] : [text]))));
}

/** @param {HTMLElement} place filled with the calibrations made here, hidden where there is none */
export function showOwn(place) {
  const own = ownCalibrations();
  place.hidden = own.length === 0;
  if (place.hidden) return place.replaceChildren();
  const forget = (/** @type {string | undefined} */ id) => () => {
    forgetOwn(id);
    showOwn(place);
    (place.hidden ? document.getElementById("query") : place.querySelector("h2"))?.focus();
  };
  const button = (/** @type {string} */ label, /** @type {string} */ name, /** @type {() => void} */ action) => {
    const made = el("button", { type: "button", class: "small", "aria-label": name }, label);
    made.addEventListener("click", action);
    return made;
  };
  place.replaceChildren(el("h2", { id: "own-title", tabindex: -1 }, t("cameras.own")), el("p", { class: "muted" }, t("cameras.own_text")),
    el("ul", { class: "own" }, ...own.map(({ id, camera, img_size, time, level, rms }) => el("li", {},
      el("a", { href: `../result/?${new URLSearchParams({ id })}` }, el("strong", {}, splitLabel(camera).name), ` ${formatSize(img_size)}`),
      el("span", { class: "muted number" }, [t(`result.level_${level}`), `± ${rough(rms)}\u00a0px`, dateText(time)].join(" · ")),
      button(t("cameras.forget"), t("cameras.forget_this", { camera: splitLabel(camera).name }), forget(id))))),
    ...(own.length > 1 ? [button(t("cameras.forget_all"), t("cameras.forget_all"), forget(undefined))] : []));
}
