// View of one camera: what is missing, its sizes with their calibrations, the numbers for any model, a badge, and the
// lookup.
import { addCopyButton } from "../lib/code-block.js";
import { el } from "../lib/dom.js";
import { estimateView } from "../lib/estimate-view.js";
import { splitLabel, systemName, isVirtual } from "../lib/camera-name.js";
import { jsonText } from "../lib/result/values.js";
import { joinFacts, hasMessage, t, formatSize } from "../lib/i18n.js";
import { COEFFICIENTS } from "../sdk/projection.js";
import { againAddress } from "../lib/result/card.js";
import { downloadPart } from "../lib/result/download.js";
import { numbersPart } from "../lib/result/numbers-part.js";
import { membersView, nameOf } from "./members.js";
import { ring, spreadOf } from "./agreement.js";
import { estimateOf, withModel } from "./source.js";

/** @import { Calibration, CameraPage, Mode } from "./source.js" */

/** @param {CameraPage} page @param {(error: unknown) => string} explain @returns {HTMLElement} */
export function cameraView(page, explain) {
  const modes = [...page.modes].sort((a, b) => b.calibrations - a.calibrations);
  const practice = isVirtual(page.camera);
  const heading = el("h1", { id: "camera-name", tabindex: -1 }, splitLabel(page.camera).name);
  return el(
    "div",
    {},
    el(
      "header",
      { class: "opening" },
      heading,
      el("p", { class: "about" }, aboutText(page)),
      practice && el("p", { class: "lead" }, t("cameras.practice")),
      el("p", { class: "lead", id: "missing" }, missingText(modes[0])),
    ),
    summaryBar(page, modes[0], heading),
    ...(practice || (modes[0] && isReady(modes[0])) ? [] : [estimatePart(page, modes[0])]),
    ...(modes.length
      ? modes.map((mode, index) => modeView(page, mode, index === 0, explain))
      : [el("p", { class: "band" }, t("cameras.no_modes"))]),
    lookupView(page, modes[0]),
    el(
      "details",
      { class: "raw" },
      el("summary", {}, t("cameras.raw")),
      el("p", { class: "muted" }, `${page.camera} · ${page.platform}`),
    ),
  );
}

/**
 * "Linux · USB 046d:082d · Logitech, Inc."
 * @param {{camera: string, platform: string, usb_id?: string | null, vendor?: string | null}} page
 */
export function aboutText({ camera, platform, usb_id, vendor }) {
  const usb = usb_id ?? splitLabel(camera).usb;
  const files = { photographs: t("cameras.photographs"), video: t("cameras.video") }[platform];
  return [files ?? systemName(platform), ...(usb ? [`USB ${usb}`] : []), ...(vendor ? [vendor] : [])]
    .filter(Boolean)
    .join(" · ");
}

/**
 * "Ready to use", or how many of the required calibrations exist.
 * @param {{reliable: boolean, agreeing: number, required: number}} size
 */
export function stateText({ reliable, agreeing, required }) {
  if (reliable) return t("cameras.reliable");
  return agreeing >= required ? t("cameras.unreliable") : t("cameras.of", { count: agreeing, required });
}

/** @param {Mode} mode */
const isReady = (mode) => Object.values(mode.consensus).some((each) => each.reliable);

/** Sentence about the calibrations that are missing. @param {Mode | undefined} mode the one of most calibrations */
function missingText(mode) {
  if (!mode) return t("cameras.no_modes");
  if (isReady(mode)) return t("cameras.ready_text");
  const missing = mode.required - mode.agreeing;
  return missing > 0 ? t("cameras.missing_text", { count: missing, size: nameOf(mode) }) : reasonText(mode);
}

/**
 * Bar that stays in sight: how many calibrations agree, and the button that makes one. It has the name of the camera
 * once the heading is out of sight.
 * @param {CameraPage} page
 * @param {Mode | undefined} mode the one of most calibrations
 * @param {HTMLElement} heading
 */
function summaryBar({ camera, platform }, mode, heading) {
  const ready = mode !== undefined && isReady(mode);
  const model = mode?.members[0]?.model ?? "rectilinear";
  const href = againAddress(
    /** @type {Calibration} */ ({ camera, platform, img_size: mode?.img_size ?? [1280, 720], distortion_model: model }),
  );
  const name = el("strong", { hidden: true }, splitLabel(camera).name);
  const bar = el(
    "div",
    { class: ready ? "pinned known" : "pinned" },
    mode && ring(mode),
    el(
      "p",
      {},
      name,
      el("span", {}, mode ? stateText({ reliable: ready, agreeing: mode.agreeing, required: mode.required }) : ""),
    ),
    el(
      "a",
      { class: ready ? "button" : "button primary", id: "calibrate-this", href },
      t(ready ? "cameras.calibrate_again" : "cameras.calibrate_this"),
    ),
  );
  new IntersectionObserver(([{ isIntersecting }]) => (name.hidden = isIntersecting)).observe(heading);
  return bar;
}

/** Estimate of a camera that is not ready, once it is there. @param {CameraPage} page @param {Mode | undefined} mode */
function estimatePart(page, mode) {
  const place = el("div", {});
  estimateOf(page, mode ?? { img_size: [1280, 720], zoom: 0 }).then(
    (estimate) => estimate && place.replaceChildren(estimateView(estimate)),
    (error) => console.info("no estimate:", error.message),
  );
  return place;
}

/** Reason why a camera is not ready. @param {Mode} mode */
const reasonText = ({ reason }) =>
  t(reason && hasMessage(`cameras.reason_${reason}`) ? `cameras.reason_${reason}` : "cameras.unreliable");

/** @param {CameraPage} page @param {Mode} mode @param {boolean} open @param {(error: unknown) => string} explain */
function modeView(page, mode, open, explain) {
  const id = `mode-${mode.img_size.join("x")}-${mode.zoom}`;
  const ready = isReady(mode);
  const outside = mode.members.filter(({ in_group }) => !in_group).length;
  const facts = [
    t("cameras.calibrations", { count: mode.calibrations }),
    t("cameras.contributors", { count: mode.contributors }),
    ...(outside ? [t("cameras.outside", { count: outside })] : []),
    ...(mode.groups.length > 1 ? [t("cameras.groups", { count: mode.groups.length })] : []),
    ...(mode.group_names ?? []).filter((name) => name !== null).map((name) => `“${name}”`),
  ];
  const agreed = Object.values(mode.consensus)[0] ?? null;
  const body = el("div", { class: "inside" });
  const fill = () =>
    body.replaceChildren(
      el("p", { class: "number" }, joinFacts([...facts, ...(ready ? [] : [reasonText(mode)])])),
      ...(agreed ? [modelView(page, mode, explain)] : []),
      ...(mode.members.length ? [membersView(mode, agreed, id, explain)] : []),
      badgeView(page.key, mode.img_size, splitLabel(page.camera).name),
    );
  const details = el(
    "details",
    { class: "mode", open },
    el(
      "summary",
      {},
      el("h2", { id, class: "number" }, nameOf(mode)),
      el(
        "span",
        { class: `reliability number ${ready ? "known" : ""}` },
        stateText({ reliable: ready, agreeing: mode.agreeing, required: mode.required }),
      ),
    ),
    body,
  );
  // The content is created when the visitor opens it.
  if (open) fill();
  else details.addEventListener("toggle", fill, { once: true });
  return details;
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
    const std = spreadOf(mode.members, calibration.distortion_model);
    place.replaceChildren(
      downloadPart({ calibration, explain }, `-${id}`, { primary: isReady(mode) }),
      numbersPart(calibration, std ? { std } : null),
      ...(std ? [el("p", { class: "muted" }, t("cameras.spread_text", { count: std.count }))] : []),
    );
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
  return el(
    "div",
    {},
    el("div", { class: "field" }, el("label", { for: id }, t("cameras.model")), select),
    status,
    place,
  );
}

/** @param {CameraPage} page @param {Mode | undefined} mode */
function lookupView({ camera, platform }, mode) {
  const key = { camera, platform, img_size: mode?.img_size ?? [1280, 720], zoom: mode?.zoom ?? 0 };
  const code = `import { lookup } from "${location.origin}/sdk/calibdb.js";

const key = ${jsonText(key)};
const { calibration } = await lookup(key, { token: "cdb_…" });`;
  return el(
    "section",
    { class: "band", "aria-labelledby": "in-code" },
    el("h2", { id: "in-code" }, t("cameras.in_code")),
    el(
      "div",
      {},
      el("p", {}, t("cameras.in_code_text")),
      addCopyButton(el("pre", { tabindex: 0, "aria-label": t("cameras.in_code") }, el("code", {}, code))),
    ),
  );
}

/**
 * Badge of a camera at a size, with the Markdown that shows it in a README.
 * @param {string} key of the camera @param {[number, number]} size px @param {string} name of the camera
 */
function badgeView(key, size, name) {
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
