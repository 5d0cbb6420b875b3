// Calibrations of one camera at one size: plots, a table, and the comparison of two that are ticked.
import { el } from "../lib/dom.js";
import { dateText, number, rough, formatSize, t } from "../lib/i18n.js";
import { load } from "../lib/result/source.js";
import { comparisonView } from "../lib/result/comparison.js";
import { centrePlot, focalPlot } from "./agreement.js";

/**
 * @import { Member } from "./agreement.js"
 * @import { Calibration, Mode } from "./source.js"
 */

const MIN_PLOTTED = 3; // calibrations: fewer are read from the table

/** "1280 × 720, zoom 2". @param {Pick<Mode, "img_size" | "zoom">} mode */
export const nameOf = ({ img_size, zoom }) =>
  formatSize(img_size) + (zoom ? t("cameras.at_zoom", { zoom: number(zoom, Number.isInteger(zoom) ? 0 : 2) }) : "");

/**
 * @param {Mode} mode
 * @param {Calibration | null} agreed
 * @param {string} id of the mode's elements
 * @param {(error: unknown) => string} explain
 */
export function membersView(mode, agreed, id, explain) {
  const { members } = mode;
  const place = el("div", { class: "comparison" });
  /** @type {Set<string>} */
  const ticked = new Set();
  const status = el("p", { class: "muted", role: "status" }, t("cameras.tick_two"));
  /** @param {Member} member @param {HTMLInputElement} box */
  const tick = async (member, box) => {
    if (box.checked) ticked.add(member.id);
    else ticked.delete(member.id);
    for (const other of table.querySelectorAll("input")) other.disabled = ticked.size === 2 && !other.checked;
    place.replaceChildren();
    if (ticked.size < 2) {
      status.textContent = t("cameras.tick_two");
      return;
    }
    const asked = [...ticked];
    status.textContent = t("cameras.comparing");
    try {
      const [first, second] = await Promise.all(asked.map((each) => load(each)));
      if (asked.join() !== [...ticked].join()) return;
      status.textContent = "";
      place.replaceChildren(comparisonView(first, second));
    } catch (error) {
      if (asked.join() === [...ticked].join()) status.textContent = explain(error);
    }
  };
  const table = membersTable(
    [...members].sort((a, b) => b.time - a.time),
    id,
    tick,
  );
  return el(
    "div",
    { class: "members" },
    ...(members.length < MIN_PLOTTED ? [] : [plots(members, agreed)]),
    status,
    el(
      "div",
      { class: "scroll", tabindex: 0, role: "region", "aria-label": `${t("cameras.members")}: ${nameOf(mode)}` },
      table,
    ),
    place,
  );
}

/** @param {Member[]} members @param {Calibration | null} agreed */
function plots(members, agreed) {
  const [[fx, , cx], [, , cy]] = agreed?.camera_matrix ?? [
    [0, 0, 0],
    [0, 0, 0],
  ];
  const captioned = (/** @type {SVGElement} */ svg, /** @type {string} */ words) =>
    el("figure", { class: "figure" }, svg, el("figcaption", {}, words));
  // Only what is drawn is spoken of.
  const outside = members.some(({ in_group }) => !in_group);
  const caption = (/** @type {string} */ plot) =>
    [
      t(plot === "focal" ? "cameras.focal_caption" : "cameras.centre_caption"),
      agreed && t(plot === "focal" ? "cameras.focal_agreed" : "cameras.centre_agreed"),
      outside && t("cameras.crossed"),
    ]
      .filter(Boolean)
      .join(" ");
  return el(
    "div",
    { class: "columns" },
    captioned(focalPlot(members, agreed && fx), caption("focal")),
    captioned(centrePlot(members, agreed && [cx, cy]), caption("centre")),
  );
}

/** @param {Member[]} members @param {string} id @param {(member: Member, box: HTMLInputElement) => void} tick */
function membersTable(members, id, tick) {
  const head = [
    "",
    t("cameras.date"),
    "fx, px",
    "cx, px",
    "cy, px",
    t("cameras.reprojection"),
    t("cameras.model_column"),
    t("cameras.agrees"),
  ];
  return el(
    "table",
    { class: "values" },
    el("caption", {}, t("cameras.members")),
    el(
      "thead",
      {},
      el(
        "tr",
        {},
        ...head.map((text, index) =>
          text ? el("th", { scope: "col", class: index > 1 && index < 6 ? "number" : "words" }, text) : el("td", {}),
        ),
      ),
    ),
    el(
      "tbody",
      {},
      ...members.map((member, index) => {
        const date = dateText(member.time);
        const box = el("input", {
          type: "checkbox",
          id: `${id}-tick-${index}`,
          "aria-label": t("cameras.compare_this", { date, number: index + 1 }),
        });
        box.addEventListener("change", () => tick(member, box));
        return el(
          "tr",
          {},
          el("td", { class: "words" }, el("label", { class: "tick" }, box)),
          el("th", { scope: "row" }, el("a", { href: `../result/?${new URLSearchParams({ id: member.id })}` }, date)),
          ...[member.fx, member.cx, member.cy].map((value) => el("td", {}, number(value, 1))),
          el("td", {}, `${rough(member.rms)}\u00a0px`),
          el("td", { class: "words" }, member.model),
          el("td", { class: "words" }, t(member.in_group ? "cameras.yes" : "cameras.no")),
        );
      }),
    ),
  );
}
