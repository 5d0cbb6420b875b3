// Card at the head of a result: which camera, how good, what to do with it, and what is known of its making.
import { button, el } from "../dom.js";
import { splitLabel, isVirtual } from "../camera-name.js";
import { dateText, joinFacts, language, number, pageUrl, rough, formatSize, t } from "../i18n.js";
import { boardSentence, meaning } from "./meaning.js";
import { hint, moreMenu, shareButton } from "./menu.js";
import { isFairInside, levelOf } from "./numbers.js";
import { downloadPart } from "./download.js";
import { reasonTexts } from "./reasons.js";
import { returnAddress, withResult } from "./return-address.js";
import { factsOf } from "./source.js";
import { listViews } from "./views.js";

/**
 * @import { Agreement } from "./agreement.js"
 * @import { Calibration, Report, Result } from "./numbers.js"
 * @import { Trial } from "./views.js"
 */

const FILES = ["photographs", "video"]; // platforms of calibrations from files, not from a camera
const BOARDS = /** @type {Record<string, string>} */ ({
  charuco: "ChArUco",
  chessboard: "Chessboard",
  aprilgrid: "AprilGrid",
});

/** Level of a result. @param {Calibration} calibration @param {Report | null} report */
export const verdictOf = (calibration, report) => report?.verdict.level ?? levelOf(calibration);

/** Title of a page that shows it. @param {Calibration} calibration @param {Report | null} report */
export const pageTitle = (calibration, report) =>
  t("result.title_of", {
    camera: splitLabel(calibration.camera).name,
    size: formatSize(calibration.img_size),
    level: t(`result.level_${verdictOf(calibration, report)}`),
  });

/** Address of the result's own page, in the language of the visitor who opens it. @param {string} id */
export const resultAddress = (id) => new URL(`../../result/?${new URLSearchParams({ id })}`, import.meta.url).href;

/** Address of the page that calibrates this camera again. @param {Calibration} calibration */
export function againAddress({ camera, img_size, distortion_model, platform }) {
  const photographs = FILES.includes(platform);
  const query = new URLSearchParams({
    camera,
    ...(photographs ? {} : { img_size: img_size.join("x"), distortion_model }),
    ...(isVirtual(camera) ? { virtual: "1" } : {}),
  });
  return pageUrl(`${photographs ? "photos" : "calibrate"}/?${query}`).href;
}

/**
 * @param {Result} result with the calibration and report that are shown @param {Trial | null} trial
 * @param {string | null} id where it is stored
 */
export function card(result, trial, id) {
  const { calibration, report, origin, notes = [] } = result;
  const { camera, img_size, uncertainty } = calibration;
  const level = verdictOf(calibration, report);
  const practice = isVirtual(camera);
  const reasons = reasonTexts(report, notes, calibration);
  const details = [...insideSentence(calibration), ...boardSentence(report?.board)];
  return el(
    "header",
    { class: "opening card" },
    // The page that captured it has already said so.
    practice && origin !== "practice" && el("p", { class: "practice" }, t("result.practice")),
    trial &&
      el(
        "p",
        { class: "trial" },
        t("result.without", { count: trial.without.length, views: listViews(trial.without) }),
      ),
    el(
      "h1",
      { id: "result-name", tabindex: -1 },
      splitLabel(camera).name,
      " ",
      el("span", { class: "number size" }, formatSize(img_size)),
    ),
    el(
      "div",
      { class: "judgement" },
      el("p", { id: "verdict", class: `verdict tint ${level}`, tabindex: -1 }, t(`result.level_${level}`)),
      el(
        "p",
        { class: "lead" },
        el("span", {}, t("result.sentence", { rms: rough(uncertainty.rms), max: rough(uncertainty.max) })),
        hint(t("result.uncertainty"), t("result.uncertainty_hint")),
        ...(practice
          ? []
          : [
              " ",
              el(
                "span",
                { class: "means" },
                t(`result.means_${level === "fair" && isFairInside(calibration) ? "fair_inside" : level}`),
              ),
            ]),
      ),
    ),
    meaning(calibration),
    details.length > 0 && el("p", { class: "errors" }, details.join(" ")),
    reasons.length > 1 && el("p", { class: "improve" }, t("result.improve")),
    reasons.length > 0 && el("ul", { class: "reasons" }, ...reasons.map((text) => el("li", {}, text))),
    nextSteps(result, trial, id),
    el("p", { class: "facts muted number" }, factsText(calibration, report, factsOf(id)?.board ?? null)),
    ...(practice || trial || !id ? [] : [el("p", { class: "agreement", id: "agreement" }, "\u00a0")]),
  );
}

/** The error where the board was. @param {Calibration} calibration */
const insideSentence = ({ uncertainty: { inside, covered } }) =>
  typeof inside === "number" && typeof covered === "number"
    ? [t("result.inside_sentence", { inside: rough(inside), covered: number(100 * covered, 0) })]
    : [];

/** @param {Result} result @param {Trial | null} trial @param {string | null} id */
function nextSteps(result, trial, id) {
  const { calibration, again, origin } = result;
  const practice = isVirtual(calibration.camera);
  const back = trial ? null : returning(result, id);
  const first = back?.link ? "return" : practice ? "own" : "download";
  const camera = pageUrl("calibrate/").href;
  const more = [
    ...(id && !FILES.includes(calibration.platform) && origin !== "imported"
      ? [el("a", { id: "to-ar", href: arAddress(calibration, id) }, t("result.see_in_ar"))]
      : []),
    ...(again && !trial
      ? [button(again.label(), again.action, { id: "once-more" })]
      : practice
        ? []
        : [el("a", { href: againAddress(calibration) }, t("result.calibrate_again"))]),
    ...(practice
      ? []
      : [el("a", { href: pageUrl(`mine/?${new URLSearchParams(id ? { with: id } : {})}`).href }, t("result.compare"))]),
    el("a", { href: pageUrl("rig/").href }, t("result.several")),
  ];
  return el(
    "div",
    { class: "next" },
    back?.element,
    downloadPart({ calibration, explain: result.explain, of: { id, without: trial?.without ?? [] } }, "", {
      primary: first === "download",
      before:
        practice && !trial && !result.ownCameraOffered
          ? [
              el(
                "a",
                { class: first === "own" ? "button primary" : "button", id: "own-camera", href: camera },
                t("result.own_camera"),
              ),
            ]
          : [],
      after: [
        ...(id ? [shareButton(pageTitle(calibration, result.report), resultAddress(id), { id: "copy-link" })] : []),
        ...(more.length ? [moreMenu(more)] : []),
      ],
    }),
  );
}

/** @param {Calibration} calibration @param {string} id */
function arAddress({ camera }, id) {
  const query = new URLSearchParams({ camera, ...(isVirtual(camera) ? { virtual: "1" } : {}) });
  return pageUrl(`ar/?${query}#${new URLSearchParams({ calibration: id })}`).href;
}

/**
 * @param {Result} result
 * @param {string | null} id
 * @returns {{element: HTMLElement, link: boolean} | null} null: no page asked for the result
 */
function returning({ returnTo, returnOrigins = [] }, id) {
  const found = returnAddress(returnTo ?? null, location.origin, returnOrigins);
  if (!found || !id) return null;
  const { url, host, allowed } = found;
  if (!allowed)
    return { element: el("p", { class: "return problem" }, t("result.back_refused", { host })), link: false };
  return {
    link: true,
    element: el(
      "div",
      { class: "return" },
      el("a", { class: "button primary", id: "return", href: withResult(url, id) }, t("result.back", { host })),
      el("p", { class: "muted" }, t("result.back_text", { host })),
    ),
  };
}

/**
 * "4 views · ChArUco 9 × 6 · 22 Nov 2026".
 * @param {Calibration} calibration
 * @param {Report | null} report
 * @param {any} board
 */
function factsText(calibration, report, board) {
  return joinFacts([
    ...(report ? [t("result.views_count", { count: report.views.length })] : []),
    ...(board ? [`${BOARDS[board.kind ?? "charuco"] ?? board.kind} ${formatSize(board.squares)}`] : []),
    dateText(calibration.calibration_time),
    calibration.distortion_model,
  ]);
}

/**
 * "2 of 5 calibrations needed", and the way to the next one.
 * @param {HTMLElement} place @param {Calibration} calibration @param {Agreement | null} agreement null: not known
 */
export function showAgreement(place, calibration, agreement) {
  if (!agreement) return place.replaceChildren("\u00a0");
  const { key, agreeing, required, reliable } = agreement;
  const camera = pageUrl(`cameras/?${new URLSearchParams({ key })}`).href;
  const text = reliable
    ? t("result.agreement_ready", { count: agreeing })
    : agreeing >= required
      ? t("result.agreement_enough", { count: agreeing })
      : t("result.agreement", { count: agreeing, required });
  place.replaceChildren(
    el("strong", { class: "number" }, text),
    " ",
    ...(reliable ? [] : [el("a", { href: againAddress(calibration), id: "confirm" }, t("result.confirm")), " · "]),
    el("a", { href: camera }, t("result.camera_page")),
  );
}
