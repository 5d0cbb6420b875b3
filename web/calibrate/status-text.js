// Texts of the capture page: by its state, and about what it sends.
import { formatSize, hasMessage, number, t } from "../lib/i18n.js";
import { boardWords } from "../lib/board-text.js";
import { asMirrored } from "../lib/capture/target.js";
import { MIN_VIEWS, expectedViews, isAccurate, isEnough, isRestless, offlineGoal, viewCount } from "./state.js";
import { el } from "../lib/dom.js";

/**
 * @import { Board } from "../lib/board.js"
 * @import { SessionRequest } from "../lib/session.js"
 * @import { State } from "./state.js"
 */

/** Advice about the current trouble, `capture.do_<code>`. @param {State} state */
export function remedy(state) {
  const { code } = state.ui.instruction;
  // Once a view was taken, there is a board.
  if (code === "show" && viewCount(state) > 0) return "";
  const { suggestion } = state.detector;
  if (code === "wrong_board" && suggestion) {
    const question = t("capture.looks_like", { board: boardWords(suggestion.board) });
    return [question, suggestion.isCut && t("capture.board_cut")].filter(Boolean).join(" ");
  }
  if (code === "mirrored" && suggestion) return t("capture.turn_back");
  return hasMessage(`capture.do_${code}`) ? t(`capture.do_${code}`) : "";
}

/** True if another target is being chosen: the user has nothing to do meanwhile. @param {State} state */
const isChoosing = ({ capture: { skipAfter }, ui: { notice } }) =>
  skipAfter !== null && notice?.key === "capture.useless";

/** The one instruction. @param {State} state */
export function instruction(state) {
  const {
    link,
    detector,
    capture: { skipAfter },
    ui: {
      instruction: { code },
      notice: refusal,
    },
  } = state;
  if (detector.stalled) return t("capture.say_stalled");
  if (link.attempts > 0 && !link.offline) return t("capture.say_retry");
  if (isChoosing(state)) return t("capture.useless");
  if (skipAfter !== null && refusal?.hint) return t(`capture.say_${refusal.hint}`);
  return code === "" ? "" : t(`capture.say_${code}`);
}

/**
 * Sentence about what has happened; never what to do, which is the instruction.
 * @param {State["ui"]["notice"]} notice
 */
export const notice = (notice) => (notice && notice.key !== "capture.useless" ? t(notice.key, notice.values) : "");

/** The step of opening that is waited for. @param {State} state */
export function opening({ link, ui: { waiting } }) {
  if (link.attempts > 0) return t("capture.opening_retry");
  return t(waiting === "camera" ? "capture.opening_camera" : "capture.opening_service");
}

/** @param {State} state */
export const failure = ({ failure }) => (failure ? t(`capture.fault_${failure.code}`, { detail: failure.detail }) : "");

/** Views that a failure has not lost. @param {State} state */
export function saved(state) {
  const count = viewCount(state);
  return count === 0 ? "" : t("capture.kept", { count });
}

/** @param {State} state */
export const interrupted = ({ ui: { interrupted } }) =>
  interrupted ? t("capture.interrupted", { camera: interrupted.camera, count: interrupted.views }) : "";

/** Label of the stop button: nothing is lost by it before the first view. @param {State} state */
export function stopLabel(state) {
  if (viewCount(state) === 0) return t("capture.cancel");
  return t(state.ui.stopAskedAt === null ? "capture.stop" : "capture.stop_really");
}

/**
 * Views so far, how many there will be, and remarks on that.
 * @param {State} state
 * @returns {string[]}
 */
export function counts(state) {
  const {
    capture: { session },
    link: { stored, offline },
  } = state;
  const used = session?.views.filter(({ set_aside }) => !set_aside).length ?? 0;
  const aside = (session?.views.length ?? 0) - used;
  const missing = MIN_VIEWS - used - stored;
  return [
    offline
      ? t("capture.kept_of", { count: stored, wanted: offlineGoal(state) })
      : t("capture.view_of", { number: used + stored, total: expectedViews(state) }),
    aside > 0 ? t("capture.set_aside", { count: aside }) : "",
    !offline && stored > 0 ? t("capture.waiting_views", { count: stored }) : "",
    !offline && stored === 0 && missing > 0 ? leastViews(state, missing) : "",
  ].filter(Boolean);
}

/** Reason why a capture continues before the fourth view. @param {State} state @param {number} missing views */
const leastViews = (state, missing) =>
  isAccurate(state) ? t("capture.goal_early", { count: missing }) : t("capture.at_least", { count: MIN_VIEWS });

/** The accuracy that the views have reached, for the details. @param {State} state */
export function accuracy({ capture: { session } }) {
  if (!session?.uncertainty) return "";
  const reached = t("capture.reached", {
    reached: rounded(session.uncertainty.rms),
    goal: rounded(session.target_error),
  });
  return `${t("capture.accuracy")}: ${reached}`;
}

/** An uncertainty to its significant digits. @param {number} value */
const rounded = (value) => number(value, value < 1 ? 2 : value < 10 ? 1 : 0);

/** State of the connection, the storage or the views, shown for as long as it lasts. @param {State} state */
export function statusLine(state) {
  if (state.detector.loading > 0 && state.detector.loading < 1) return t("capture.opening_loading");
  if (state.link.sending) return t("capture.sending");
  if (state.link.offline) return t(isEnough(state) ? "capture.away_enough" : "capture.away_now");
  if (isRestless(state)) return t("capture.never_still");
  return state.ui.saved ? advice(state) : t("capture.not_kept");
}

/**
 * Advice of the service, in its own words if the page has no message for it. Motion is its guess from the fit: it is
 * shown only if the corners have moved. With fewer views than a result needs, the cause is unknown.
 * @param {State} state
 */
function advice({ capture: { session, unsteady } }) {
  if ((session?.views.length ?? 0) < MIN_VIEWS) return "";
  const first = session?.advice?.find(({ code }) => code !== "motion" || unsteady);
  if (!first) return "";
  const key = `capture.advice_${first.code}`;
  return hasMessage(key) ? t(key, { model: lensName(session?.suggested_model ?? "") }) : first.text;
}

/** @param {string} camera @param {[number, number] | null} size */
const describe = (camera, size) => (size ? t("capture.camera_at", { camera, size: formatSize(size) }) : camera);

/**
 * The camera that the page was opened for, and whether it is there.
 * @param {State} state @param {boolean} [isSent] an application sent the visitor, and has been named with its camera
 */
export function wanted({ wanted: { camera, img_size }, ui: { cameras } }, isSent = false) {
  const real = cameras.filter(({ id }) => id !== "virtual");
  if (!camera) return cameras.length > real.length && real.length === 0 ? t("capture.none_at_all") : "";
  const absent =
    cameras.length > 0 && !cameras.some(({ label }) => label === camera) && real.every(({ named }) => named);
  const asked = isSent ? "" : t("capture.asked_for", { camera: describe(camera, img_size) });
  if (!absent) return asked;
  return [asked, real.length ? t("capture.not_among") : t("capture.none_here")].filter(Boolean).join(" ");
}

/** Name of a lens type. @param {string} model */
const lensName = (model) => (hasMessage(`capture.lens_${model}`) ? t(`capture.lens_${model}`) : model);

/**
 * Says that another camera was opened, until a view was taken after it was read; again if that view is undone.
 * @param {State} state
 */
export const mismatchWarning = (state) => (viewCount(state) > state.capture.initialViews ? "" : cameraMismatch(state));

/** Says that another camera than the wanted one was opened; "" if it is that one. @param {State} state */
export function cameraMismatch({ wanted: { camera, img_size }, capture: { key } }) {
  if (!camera || !key) return "";
  if (camera === key.camera && (img_size ?? key.img_size).join() === key.img_size.join()) return "";
  return t("capture.another_opened", { asked: describe(camera, img_size), opened: describe(key.camera, key.img_size) });
}

/** The open camera. @param {State} state */
export function cameraFacts({ capture: { key, cropped } }) {
  if (!key) return "";
  const { camera, img_size, zoom } = key;
  return [camera, formatSize(img_size), zoom && t("capture.zoom", { zoom }), cropped && t("capture.cropped")]
    .filter(Boolean)
    .join(" · ");
}

/**
 * Label of the button that starts again with the suggested model; "" if there is no suggestion.
 * @param {State} state
 */
export function suggestedModel({ capture: { session }, wanted }) {
  const model = session?.suggested_model;
  return model && model !== wanted.distortion_model ? t("capture.with_model", { model: lensName(model) }) : "";
}

/** Code of the instruction, about the camera's image. @param {State} state */
export const unmirrored = ({
  capture: { mirrored },
  ui: {
    instruction: { code },
  },
}) => (mirrored ? asMirrored(code) : code);

const MAX_DIGITS = 2; // after the point, of settings of the camera

/**
 * All that is sent besides the corners, for people.
 * @param {SessionRequest} request @returns {[name: string, value: string][]}
 */
export function requestFacts({ track, ...request }) {
  return Object.entries({ ...request, ...track }).map(([name, value]) => [
    hasMessage(`capture.fact_${name}`) ? t(`capture.fact_${name}`) : name,
    factText(name, value),
  ]);
}

/** @param {string} name @param {unknown} value */
function factText(name, value) {
  if (name === "distortion_model") return lensName(String(value));
  if (name === "target_error") return `${number(Number(value), MAX_DIGITS)}\u00a0px`;
  if (name === "board") return boardText(/** @type {Board} */ (value));
  if (Array.isArray(value)) return formatSize(value);
  if (typeof value === "number") return number(value, Number.isInteger(value) ? 0 : MAX_DIGITS);
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

/** @param {Board} board */
function boardText({ squares: [columns, rows], dictionary, marker_ratio }) {
  return t("capture.board_facts", { columns, rows, dictionary, ratio: number(marker_ratio, MAX_DIGITS) });
}

/** @param {SessionRequest} request @returns {HTMLTableRowElement[]} */
export const factRows = (request) =>
  requestFacts(request).map(([name, value]) =>
    el("tr", {}, el("th", { scope: "row" }, name), el("td", { class: "words" }, value)),
  );

/** The request as JSON. @param {SessionRequest | null} request */
export const requestText = (request) => (request ? JSON.stringify(request, null, 2) : "");
