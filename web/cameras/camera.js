// View of one camera: its modes, the agreement of its calibrations, the numbers for any model, and the lookup request.
import { el } from "../lib/dom.js";
import { known, number, sized, t } from "../lib/i18n.js";
import { COEFFICIENTS } from "../sdk/projection.js";
import { downloadPart } from "../lib/result/download.js";
import { tables } from "../lib/result/view.js";
import { isVirtual } from "../lib/virtual/name.js";
import { centrePlot, focalPlot } from "./agreement.js";
import { withModel } from "./source.js";

/**
 * @typedef {import("./source.js").CameraPage} CameraPage
 * @typedef {import("./source.js").Mode} Mode
 * @typedef {import("./source.js").Calibration} Calibration
 */

/** @param {CameraPage} page @param {(error: unknown) => string} explain @returns {HTMLElement} */
export function cameraView(page, explain) {
  const modes = [...page.modes].sort((a, b) => b.calibrations - a.calibrations);
  return el("div", {},
    el("header", { class: "opening" }, el("h1", { id: "camera-name", tabindex: -1 }, page.camera), el("p", {}, page.platform),
      ...(isVirtual(page.camera) ? [el("p", { class: "lead" }, t("cameras.practice"))] : [])),
    ...(modes.length ? modes.map((mode) => modeView(page, mode, explain)) : [el("p", { class: "band" }, t("cameras.no_modes"))]),
    lookupView(page, modes[0]));
}

/** @param {Mode} mode */
export const nameOf = ({ img_size, zoom }) => sized(img_size) + (zoom ? t("cameras.at_zoom", { zoom: number(zoom, Number.isInteger(zoom) ? 0 : 2) }) : "");

/** @param {CameraPage} page @param {Mode} mode @param {(error: unknown) => string} explain */
function modeView(page, mode, explain) {
  const id = `mode-${mode.img_size.join("x")}-${mode.zoom}`;
  const agreed = Object.values(mode.consensus)[0] ?? null;
  const outside = mode.members.filter(({ in_group }) => !in_group).length;
  const reliable = Object.values(mode.consensus).some((each) => each.reliable);
  const facts = [
    t("cameras.calibrations", { count: mode.calibrations }), t("cameras.contributors", { count: mode.contributors }),
    ...(outside ? [t("cameras.outside", { count: outside })] : []),
    ...(mode.groups.length > 1 ? [t("cameras.groups", { count: mode.groups.length })] : []),
  ];
  return el("section", { class: "band", "aria-labelledby": id },
    el("div", {}, el("h2", { id, class: "number" }, nameOf(mode)), el("p", { class: `reliability ${reliable ? "known" : ""}` }, t(reliable ? "cameras.reliable" : reasonKey(mode)))),
    el("div", {}, el("p", { class: "number" }, facts.join(" · ")),
      ...(mode.members.length ? [agreement(mode, agreed)] : []),
      ...(agreed ? [modelView(page, mode, explain)] : [])));
}

/** Why it is not known. @param {Mode} mode */
const reasonKey = ({ reason }) => (reason && known(`cameras.reason_${reason}`) ? `cameras.reason_${reason}` : "cameras.unreliable");

/** @param {Mode} mode @param {Calibration | null} agreed */
function agreement({ members }, agreed) {
  const [[fx, , cx], [, , cy]] = agreed?.camera_matrix ?? [[0, 0, 0], [0, 0, 0]];
  const captioned = (/** @type {SVGElement} */ svg, /** @type {string} */ words) => el("figure", { class: "figure" }, svg, el("figcaption", {}, words));
  // Only what is drawn is spoken of.
  const outside = members.some(({ in_group }) => !in_group);
  const caption = (/** @type {string} */ plot) =>
    [t(plot === "focal" ? "cameras.focal_caption" : "cameras.centre_caption"), agreed && t(plot === "focal" ? "cameras.focal_agreed" : "cameras.centre_agreed"), outside && t("cameras.crossed")].filter(Boolean).join(" ");
  return el("div", { class: "columns" },
    captioned(focalPlot(members, agreed && fx), caption("focal")),
    captioned(centrePlot(members, agreed && [cx, cy]), caption("centre")));
}

/** @param {CameraPage} page @param {Mode} mode @param {(error: unknown) => string} explain */
function modelView(page, mode, explain) {
  const id = `model-${mode.img_size.join("x")}-${mode.zoom}`;
  const models = Object.keys(COEFFICIENTS);
  const select = el("select", { id }, ...models.map((model) => new Option(model, model)));
  const place = el("div", { class: "numbers" });
  const status = el("p", { role: "status" });
  /** @param {Calibration} calibration */
  const show = (calibration) => {
    status.textContent = "";
    place.replaceChildren(tables(calibration, null), downloadPart({ calibration, explain }, `-${id}`));
  };
  const choose = async () => {
    const stored = mode.consensus[select.value];
    if (stored) return show(stored);
    status.textContent = t("cameras.fitting");
    try {
      show(await withModel(page, mode, select.value));
    } catch (error) {
      place.replaceChildren();
      status.textContent = explain(error);
    }
  };
  select.value = models.find((model) => model in mode.consensus) ?? models[0];
  select.addEventListener("change", choose);
  void choose();
  return el("div", {}, el("div", { class: "field" }, el("label", { for: id }, t("cameras.model")), select), status, place);
}

/** @param {CameraPage} page @param {Mode | undefined} mode */
function lookupView({ camera, platform }, mode) {
  const key = { camera, platform, img_size: mode?.img_size ?? [1280, 720], zoom: mode?.zoom ?? 0 };
  const code = `import { lookup } from "${location.origin}/sdk/calibdb.js";

const key = ${JSON.stringify(key, null, 2).replace(/\[\s+(\d+),\s+(\d+)\s+\]/, "[$1, $2]")};
const { calibration } = await lookup(key, { token: "cdb_…" });`;
  return el("section", { class: "band", "aria-labelledby": "in-code" }, el("h2", { id: "in-code" }, t("cameras.in_code")),
    el("div", {}, el("p", {}, t("cameras.in_code_text")), el("pre", { tabindex: 0, "aria-label": t("cameras.in_code") }, el("code", {}, code))));
}
