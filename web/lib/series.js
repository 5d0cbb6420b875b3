// A calibration from views that are all there already. The service is a guided capture's: it judges each view by what it
// adds to those before it, and a calibration is stored when the error it is after is reached.

/**
 * @typedef {import("./api.js").Api} Api
 * @typedef {import("../vendor/api.js").SessionRequest} SessionRequest
 * @typedef {import("./session.js").SessionState} SessionState
 * @typedef {import("./session.js").ViewAnswer} ViewAnswer
 * @typedef {import("../vendor/api.js").Pose} Pose
 *
 * @typedef {{ids: number[], points: number[][]}} View
 * @typedef {{view: number, accepted: boolean, reason: string | null, before: number | null, after: number | null}} Judgement
 *   view: its number; before, after: predicted error, px
 *
 * @typedef {object} Outcome
 * @property {SessionState} state converged, or as far as these views lead
 * @property {Pose | null} wanted the photograph that would help most, where they do not lead far enough
 * @property {Map<number, number>} numbers of the views, by the indices that the session gave them
 */

/**
 * Error up to which a calibration is worth storing, px at 1280 px width: beyond it the service's verdict is that it is
 * poor.
 */
const WORTHWHILE = 2;
const UNREACHABLE_ERROR_PX = 0.01; // so that every view enters that helps
const MIN_TARGET_ERROR_PX = 1e-3; // px that the service takes
const MARGIN = 1.001; // the same views come to the same error but for the last digits

/**
 * All views that help are taken first; then, if they are good enough, once more for the error that they reach.
 * @param {Api} api @param {string} token @param {SessionRequest} request @param {View[]} views best first
 * @param {(judgement: Judgement) => void} onJudgement
 * @returns {Promise<Outcome>} rejects as Api does
 */
export async function calibrate(api, token, request, views, onJudgement) {
  const scale = request.img_size[0] / 1280;
  const first = await offer(api, token, { ...request, target_error: Math.max(MIN_TARGET_ERROR_PX, UNREACHABLE_ERROR_PX * scale) }, views, onJudgement);
  if (first.state.status === "converged") return { state: first.state, wanted: null, numbers: first.taken };
  const reached = first.state.uncertainty?.rms ?? Infinity;
  if (first.taken.size === 0 || reached > WORTHWHILE * scale) {
    const wanted = await api.json("GET", "/session/pose", first.credential);
    return { state: first.state, wanted, numbers: first.taken };
  }
  await api.json("DELETE", "/session", first.credential);
  const used = [...first.taken.values()];
  const second = await offer(api, token, { ...request, target_error: MARGIN * reached }, used.map((view) => views[view]), () => {});
  const numbers = new Map([...second.taken].map(([index, view]) => [index, used[view]]));
  if (second.state.status === "converged") return { state: second.state, wanted: null, numbers };
  return { state: second.state, wanted: await api.json("GET", "/session/pose", second.credential), numbers };
}

/**
 * Offers views to a new session, those refused again beside later targets, until it is done or none is taken any more.
 * @param {Api} api @param {string} token @param {SessionRequest} request @param {View[]} views
 * @param {(judgement: Judgement) => void} onJudgement
 */
async function offer(api, token, request, views, onJudgement) {
  const { session_id: credential } = await api.json("POST", "/auth", token);
  /** @type {SessionState} */
  let state = await api.json("POST", "/session", credential, { body: request });
  /** @type {Map<number, number>} numbers of views by their indices, in the order in which they were taken */
  const taken = new Map();
  const waiting = new Set(views.keys());
  for (let more = true; more && state.status === "capturing";) {
    more = false;
    for (const view of [...waiting]) {
      const { ids, points } = views[view];
      const { index } = await api.json("GET", "/session/pose", credential);
      const before = state.uncertainty?.rms ?? null;
      /** @type {ViewAnswer} */
      const answer = await api.json("POST", "/session/views", credential, { body: { index, ids, points } });
      state = answer;
      onJudgement({ view, accepted: answer.accepted, reason: answer.reason, before, after: answer.uncertainty?.rms ?? null });
      if (answer.accepted) {
        taken.set(index, view);
        waiting.delete(view);
        more = true;
      }
      if (state.status === "converged") break;
    }
  }
  return { state, taken, credential };
}
