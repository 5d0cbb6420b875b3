// Rows of the table of cameras.
import { el, make } from "../lib/dom.js";
import { splitLabel, isVirtual } from "../lib/camera-name.js";
import { dateText, language, number, rough, t } from "../lib/i18n.js";
import { short } from "../lib/svg.js";
import { aboutText, stateText } from "./camera.js";
import { nameOf } from "./members.js";
import { ring } from "./agreement.js";

/** @import { Found, Size } from "./source.js" */

/** Columns by which the table is sorted. @typedef {"name" | "width" | "agreeing" | "date"} Column */

/** A row of the table. @param {Found} found */
export function cameraRow(found) {
  const { key, camera, sizes } = found;
  const about = [aboutText(found), ...(isVirtual(camera) ? [t("cameras.practice")] : [])];
  const [newest, width] = [newestOf(found), rowWidthOf(found)];
  return el(
    "tr",
    {},
    el(
      "th",
      { scope: "row" },
      el(
        "a",
        { href: `./?${new URLSearchParams({ key })}` },
        el("strong", {}, splitLabel(camera).name),
        el("span", { class: "muted" }, about.join(" · ")),
      ),
    ),
    el("td", { class: "number" }, ...(width === null ? ["–"] : [fan(width), `${number(width, 0)}°`])),
    el(
      "td",
      { class: "words" },
      el(
        "ul",
        { class: "sizes number" },
        ...sizes.map((size) =>
          el(
            "li",
            { class: size.reliable ? "known" : "" },
            ring(size),
            el("span", {}, nameOf(size)),
            el("span", {}, size.uncertainty === null ? "–" : `± ${rough(size.uncertainty)}\u00a0px`),
            el("span", { class: "state" }, stateText(size)),
          ),
        ),
      ),
    ),
    el("td", { class: "number muted" }, newest ? dateText(newest) : "–"),
  );
}

/** Unix seconds, 0: never. @param {Found} found */
const newestOf = ({ sizes }) => Math.max(0, ...sizes.map(({ calibration_time }) => calibration_time ?? 0));

/** Degrees of the first size that has them. @param {Found} found */
const rowWidthOf = ({ sizes }) => sizes.map(widthOf).find((angle) => angle !== null) ?? null;

/**
 * Cameras in the order of a column, ascending; what has no value comes first.
 * @param {Found[]} found @param {Column} column
 */
export function sortedBy(found, column) {
  const name = (/** @type {Found} */ each) => splitLabel(each.camera).name;
  const value = {
    width: (/** @type {Found} */ each) => rowWidthOf(each) ?? 0,
    agreeing: (/** @type {Found} */ each) => Math.max(0, ...each.sizes.map(({ agreeing }) => agreeing)),
    date: newestOf,
  };
  return [...found].sort((a, b) =>
    column === "name" ? name(a).localeCompare(name(b), language()) : value[column](a) - value[column](b),
  );
}

/**
 * Horizontal field of view by the focal length alone, degrees; null where its model leaves it open.
 * @param {Pick<Size, "fx" | "img_size" | "models">} size
 */
export function widthOf({ fx, img_size: [width], models: [model] }) {
  if (!fx || model === "omnidirectional") return null;
  const radians = model === "fisheye" ? width / fx : 2 * Math.atan(width / 2 / fx);
  return (radians * 180) / Math.PI;
}

/** Glyph of a field of view, up to a half circle. @param {number} degrees */
function fan(degrees) {
  const half = (Math.min(degrees, 180) * Math.PI) / 360;
  const [x, y] = [12 * Math.sin(half), 13 - 12 * Math.cos(half)].map(short);
  return make("svg", { viewBox: "0 0 24 14", class: "fan", "aria-hidden": "true" }, [
    make("path", { d: `M12 13L${12 - Number(x)} ${y}A12 12 0 0 1 ${12 + Number(x)} ${y}Z` }),
  ]);
}
