// View of a result: verdict, numbers, plots, downloads.
import { ApiError } from "../api.js";
import { el } from "../dom.js";
import { number, onLanguage, pageUrl, sized, t } from "../i18n.js";
import { isKnownModel } from "../../sdk/projection.js";
import { isVirtual } from "../virtual/name.js";
import { returnAddress, withResult } from "./return-address.js";
import { comparison } from "./compare.js";
import { fieldOfView, intrinsics, levelOf } from "./numbers.js";
import { coveragePlot, distortionPlot, errorPlot } from "./plots.js";
import { reasonTexts } from "./reasons.js";
import { load } from "./source.js";
import { downloadPart } from "./download.js";
import { button, listViews, viewsPart } from "./views.js";

/**
 * @typedef {import("./numbers.js").Calibration} Calibration
 * @typedef {import("./numbers.js").Report} Report
 * @typedef {import("./views.js").Trial} Trial
 *
 * @typedef {object} Result
 * @property {Calibration} calibration
 * @property {Report | null} report null: not there, or not yet
 * @property {HTMLCanvasElement | null} [picture] one of this camera, which stays on this device
 * @property {"added" | "imported" | "practice" | "stored"} origin what becomes of it
 * @property {string | null} [returnTo] address of the application that asked
 * @property {readonly string[]} [returnOrigins] to which results may be handed
 * @property {{code: string, text: string}[]} [notes] what else is to be said
 * @property {{label: () => string, action: () => void}} [again]
 * @property {(without: number[]) => void} [goOn] with the views that are left, by whom they were taken; indices
 * @property {(error: unknown) => string} explain an error, in words for people
 */

/** Shows one result in an element, and whatever is shown there next. */
export class ResultView {
  #root;
  /** @type {Result | null} */
  #result = null;
  /** @type {Trial | null} */
  #trial = null;
  /** Trials so far: what arrives for an earlier one comes too late. */
  #tried = 0;
  /** @type {(() => void)[]} */
  #held = [];
  #unlisten;

  /** @param {HTMLElement} root */
  constructor(root) {
    this.#root = root;
    this.#unlisten = onLanguage(() => this.#draw());
  }

  /** @param {Result} result */
  show(result) {
    this.#result = result;
    this.#trial = null;
    this.#tried += 1;
    this.#draw();
  }

  #draw() {
    const result = this.#result;
    if (!result) return;
    this.#release();
    const trial = this.#trial;
    const { calibration, report } = trial ?? result;
    const knownModel = isKnownModel(calibration.distortion_model);
    const straight = result.picture && knownModel ? comparison(calibration, result.picture) : null;
    if (straight) this.#held.push(straight.dispose);
    // The report arrives while somebody is on the way to a button.
    const focused = this.#root.contains(document.activeElement) ? document.activeElement?.id : "";
    this.#root.replaceChildren(...[
      opening({ ...result, calibration, report }, trial),
      result.returnTo && !trial ? returning(result) : null,
      section("numbers", tables(calibration, report)),
      report && section("error", plot(errorPlot(calibration, report.error_map))),
      knownModel ? section("distortion", plot(distortionPlot(calibration))) : null,
      report && section("coverage", plot(coveragePlot(calibration, report))),
      result.report && section("views", viewsPart({ ...result, report: result.report }, trial, this.#choices(result))),
      straight && section("straight", straight.element),
      section("take", downloadPart({ calibration, explain: result.explain, of: { id: result.calibration.id, without: trial?.without ?? [] } })),
      section("help", el("p", { id: "summary" }, contributionText(result))),
    ].filter((element) => element !== null));
    if (focused) document.getElementById(focused)?.focus();
  }

  /** @param {Result} result @returns {import("./views.js").Choices | null} */
  #choices({ calibration, goOn }) {
    const { id, camera, img_size, distortion_model, platform } = calibration;
    if (!id) return null;
    const photographs = ["photographs", "video"].includes(platform);
    const query = new URLSearchParams({ camera, ...(photographs ? {} : { img_size: img_size.join("x"), distortion_model }) });
    const elsewhere = pageUrl(`${photographs ? "photos" : "calibrate"}/?${query}`).href;
    return { choose: (without) => void this.#leaveOut(id, without), goOn, elsewhere };
  }

  /** Shows what it is without some views. @param {string} id @param {number[]} without */
  async #leaveOut(id, without) {
    const own = ++this.#tried;
    const result = this.#result;
    const status = document.getElementById("without-status");
    try {
      if (status && without.length) status.textContent = t("result.fitting_without");
      const trial = without.length ? { without, ...await load(id, without) } : null;
      if (own !== this.#tried) return;
      this.#trial = trial;
      this.#inPlace(() => this.#draw());
    } catch (error) {
      if (own !== this.#tried || !result || !status) return;
      status.textContent = error instanceof ApiError && error.status === 422 ? t("result.without_impossible", { views: listViews(without) }) : result.explain(error);
    }
  }

  /** Draws, with the focus and the place on the page where they were. @param {() => void} draw */
  #inPlace(draw) {
    const { id = "" } = document.activeElement ?? {};
    const place = () => document.getElementById("result-views")?.getBoundingClientRect().top ?? 0;
    const before = place();
    draw();
    scrollBy(0, place() - before);
    // What was pressed may be gone with what it did.
    (document.getElementById(id) ?? document.getElementById("all-again") ?? document.getElementById("leave-these"))?.focus({ preventScroll: true });
  }

  /** Takes it all away. */
  clear() {
    this.#release();
    this.#tried += 1;
    [this.#result, this.#trial] = [null, null];
    this.#root.replaceChildren();
  }

  close() {
    this.clear();
    this.#unlisten();
  }

  #release() {
    for (const free of this.#held.splice(0)) free();
  }
}

/** The result that was given to others, unchanged. @param {Result} result */
function contributionText({ origin, calibration: { camera, platform, calibrations } }) {
  if (origin === "practice" || isVirtual(camera)) return t("result.help_practice");
  const kind = origin !== "stored" && ["photographs", "video"].includes(platform) ? "photographs" : origin;
  return t(`result.help_${kind}`, { count: calibrations });
}

/** The verdict, and why. @param {Result} result @param {Trial | null} trial */
function opening({ calibration, report, origin, again, notes = [] }, trial) {
  const level = report?.verdict.level ?? levelOf(calibration);
  const practice = isVirtual(calibration.camera);
  const { uncertainty: { rms, max }, img_size } = calibration;
  const values = { rms: number(rms, rms < 0.1 ? 2 : 1), max: number(max, max < 0.1 ? 2 : 1) };
  const reasons = reasonTexts(report, notes, calibration.distortion_model);
  return el("header", { class: "opening" },
    // Where it was captured the page itself has said so.
    ...(practice && origin !== "practice" ? [el("p", { class: "practice" }, t("result.practice"))] : []),
    el("p", { class: "label" }, [calibration.camera, sized(img_size), calibration.distortion_model].join(" · ")),
    ...(trial ? [el("p", { class: "trial" }, t("result.without", { count: trial.without.length, views: listViews(trial.without) }))] : []),
    el("h1", { id: "verdict", class: `verdict ${level}`, tabindex: -1 }, t(`result.level_${level}`)),
    el("p", { class: "lead" }, ...(practice ? [] : [t(`result.means_${level}`), " "]), t("result.sentence", values)),
    ...(reasons.length ? [el("ul", { class: "reasons" }, ...reasons.map((text) => el("li", {}, text)))] : []),
    ...(again && !trial ? [el("div", { class: "actions" }, button(again.label(), again.action, { id: "once-more" }))] : []),
  );
}

/** @param {Result} result */
function returning({ calibration, returnTo, returnOrigins = [] }) {
  const found = returnAddress(returnTo ?? null, location.origin, returnOrigins);
  if (!found || !calibration.id) return null;
  const { url: { host }, url, allowed } = found;
  if (!allowed) return el("p", { class: "return problem" }, t("result.back_refused", { host }));
  return el("section", { class: "return" },
    el("a", { class: "button primary", id: "return", href: withResult(url, calibration.id) }, t("result.back", { host })),
    el("p", { class: "muted" }, t("result.back_text", { host })));
}

/**
 * @param {"numbers" | "error" | "distortion" | "coverage" | "views" | "straight" | "take" | "help"} name
 * @param {Node} content
 */
function section(name, content) {
  const id = `result-${name}`;
  return el("section", { class: "band", "aria-labelledby": id }, el("h2", { id }, t(`result.part_${name}`)), el("div", {}, content));
}

/** @param {{svg: Node, caption: string, scale?: Node}} made */
function plot({ svg, caption, scale }) {
  return el("figure", { class: "figure measured" }, svg, ...(scale ? [scale] : []), el("figcaption", {}, caption));
}

/** @param {Calibration} calibration @param {Report | null} report */
export function tables(calibration, report) {
  const { horizontal, vertical, diagonal } = fieldOfView(calibration);
  const degrees = (/** @type {number | null} */ angle) => (angle === null ? "–" : number(angle, 1));
  /** @param {string} name @param {string} value @param {string} more @param {string} unit */
  const row = (name, value, more, unit) => el("tr", {}, el("th", { scope: "row" }, name), el("td", {}, value), el("td", { class: "std" }, more), el("td", { class: "unit" }, unit));
  const px = (/** @type {string} */ name, /** @type {number | null | undefined} */ value) =>
    (typeof value === "number" ? [row(t(name), number(value, 3), "", "px rms")] : []);
  return el("div", { class: "columns" },
    el("table", {}, el("caption", {}, t("result.intrinsics", { model: calibration.distortion_model })),
      el("tbody", {}, ...intrinsics(calibration, report).map(({ name, value, std, digits, unit }) =>
        row(name, number(value, digits), std ? `± ${number(std, digits)}` : "", unit)))),
    el("table", {}, el("caption", {}, t("result.quality")),
      el("tbody", {}, ...px("result.reprojection", calibration.avg_reprojection_error), ...px("result.held_out", report?.held_out ?? calibration.held_out_error), ...px("result.spread", calibration.spread),
        ...px("result.uncertainty", calibration.uncertainty.rms),
        row(t("result.across"), degrees(horizontal), "", "°"), row(t("result.down"), degrees(vertical), "", "°"), row(t("result.diagonal"), degrees(diagonal), "", "°"))));
}

