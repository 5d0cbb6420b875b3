// A calibration from views that are all there already: every view counts that agrees with the others.
import { Api } from "./api.js";
import { consentFields } from "./consent.js";
import { keepReceipt } from "./receipts.js";
import { number, t } from "./i18n.js";

/**
 * @import { BatchAnswer, Pose, SessionRequest } from "../vendor/api.js"
 * @import { SessionState } from "./session.js"
 * @import { Settings } from "./settings.js"
 */

/**
 * @typedef {{ids: number[], points: number[][]}} View
 * @typedef {{view: number, accepted: boolean, reason: string | null, before: number | null, after: number | null}}
 *   Judgement view: its number; before, after: predicted error, px
 *
 * @typedef {object} Outcome
 * @property {SessionState} state converged, or as far as these views lead
 * @property {Pose | null} wanted the photograph that would help most
 * @property {Map<number, number>} numbers of the views, by the indices that the session gave them
 */

const MIN_VIEWS = 4; // that agree, of which the service makes a calibration
export const MAX_VIEWS = 150; // offered, of the 200 that a session holds: a video of more says little more
const MAX_POINTS = 20_000; // of all views, that a session holds

/**
 * Offers all views, and ends the session with those that agree if they are enough.
 * @param {Api} api @param {string} token @param {SessionRequest} request @param {View[]} views best first
 * @param {(judgement: Judgement) => void} onJudgement
 * @param {{detectModel?: boolean}} [options] detectModel: where the views say that the lens model is too simple,
 *   begin again with the one that explains them
 * @returns {Promise<Outcome>} rejects as Api does
 */
export async function calibrate(api, token, request, views, onJudgement, { detectModel = false } = {}) {
  const { session_id: credential } = await api.json("POST", "/auth", token);
  /** @type {SessionState} */
  const begun = await api.json("POST", "/session", credential, {
    body: { ...request, ...consentFields(), capture: "recorded" },
  });
  const { state, numbers } = await offer(api, credential, begun, views, onJudgement);
  const { suggested_model: suggested } = state;
  if (detectModel && suggested && suggested !== request.distortion_model) {
    return calibrate(api, token, { ...request, distortion_model: suggested }, views, onJudgement);
  }
  const wanted = await api.json("GET", "/session/pose", credential);
  const used = state.views.filter((view) => !view.set_aside).length;
  if (used < MIN_VIEWS || !state.uncertainty) return { state, wanted, numbers };
  const ended = await api.json("POST", "/session/finish", credential);
  keepReceipt(credential, ended);
  return { state: ended, wanted, numbers };
}

export const AUTOMATIC = "auto"; // of the lens models: the one that explains the views

/**
 * Calibrates as `calibrate` does, and says on the page how far that is.
 * @template {View} V
 * @param {Settings} settings @param {Omit<SessionRequest, "distortion_model">} request
 * @param {string} model of the lens, or `AUTOMATIC` @param {V[]} views best first
 * @param {{judgements: Map<V, Judgement>, tell: (text: () => string) => void, isCurrent: () => boolean, onJudgement:
 *   () => void}} page judgements: filled; isCurrent: false once the page shows something else
 */
export function calibrateOnPage({ api, token }, request, model, views, { judgements, tell, isCurrent, onJudgement }) {
  const progress = () => t("photos.calibrating", { done: judgements.size, all: views.length });
  tell(progress);
  const onRetry = (/** @type {object | null} */ retry) => {
    if (isCurrent()) tell(retry ? () => t("faults.retry") : progress);
  };
  const take = (/** @type {Judgement} */ judgement) => {
    if (!isCurrent()) return;
    judgements.set(views[judgement.view], judgement);
    tell(progress);
    onJudgement();
  };
  const detectModel = model === AUTOMATIC;
  const distortion_model = /** @type {SessionRequest["distortion_model"]} */ (detectModel ? "rectilinear" : model);
  return calibrate(new Api(api, { onRetry }), token, { ...request, distortion_model }, views, take, { detectModel });
}

/**
 * Offers views to a session. Those that contradict the ones before them are offered again until none is taken any more:
 * the first views may be the wrong ones, or too few to tell.
 * @param {Api} api @param {string} credential @param {SessionState} state @param {View[]} views
 * @param {(judgement: Judgement) => void} onJudgement
 */
async function offer(api, credential, state, views, onJudgement) {
  /** @type {Map<number, number>} numbers of views by their indices, in the order in which they were taken */
  const numbers = new Map();
  let room = MAX_POINTS;
  let waiting = [...views.keys()].filter((view) => (room -= views[view].points.length) >= 0);
  let before = state.uncertainty?.rms ?? null;
  for (let more = true; more && waiting.length;) {
    more = false;
    /** @type {number[]} */
    const contradicting = [];
    while (waiting.length) {
      const body = {
        index: numbers.size,
        views: waiting.map((view) => ({ ids: views[view].ids, points: views[view].points })),
      };
      /** @type {BatchAnswer} */
      const answer = await api.json("POST", "/session/batch", credential, { body });
      state = answer;
      for (const { accepted, index, reason, error } of answer.results) {
        const view = /** @type {number} */ (waiting.shift());
        onJudgement({ view, accepted, reason, before, after: error });
        if (accepted) {
          numbers.set(/** @type {number} */ (index), view);
          before = error;
          more = true;
        } else if (reason === "outlier") contradicting.push(view);
      }
    }
    waiting = contradicting;
  }
  return { state, numbers };
}

/**
 * Sentence about one view: whether it was taken, and what it did to the predicted error.
 * @param {Judgement} judgement
 */
export function viewOutcome({ accepted, reason, before, after }) {
  const px = (/** @type {number} */ value) => number(value, value < 1 ? 2 : 1);
  if (!accepted) return t(`photos.refused_${reason === "no_information" ? "no_information" : "other"}`);
  if (after === null) return t("photos.taken");
  return before === null
    ? t("photos.first", { after: px(after) })
    : t("photos.added", { before: px(before), after: px(after) });
}
