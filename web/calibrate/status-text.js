// What the page says about itself, by its state.
import { known, number, sized, t } from "../lib/i18n.js";
import { asMirrored } from "./instruction.js";
import { isEnough, viewCount, wantedAway } from "../lib/session.js";

/** @typedef {import("./state.js").State} State */

/** Troubles name what to do about them: `capture.do_<code>`. @param {State} state */
export function remedy(state) {
  const { code } = state.instruction;
  // Who has shown it once has a board.
  if (code === "show" && viewCount(state) > 0) return "";
  return known(`capture.do_${code}`) ? t(`capture.do_${code}`) : "";
}

/** The one instruction. @param {State} state */
export function instruction({ patience, away, stalled, instruction: { code } }) {
  if (stalled) return t("capture.say_stalled");
  if (patience > 0 && !away) return t("capture.say_patience");
  return code === "" ? "" : t(`capture.say_${code}`);
}

/** @param {State["notice"]} notice */
export function notice(notice) {
  if (!notice) return "";
  return [t(notice.key, notice.values), notice.hint && `${t(`capture.say_${notice.hint}`)}.`].filter(Boolean).join(" ");
}

/** What is being waited for before a capture. @param {State} state */
export function opening({ waiting, patience, loading }) {
  if (patience > 0) return t("capture.opening_patience");
  if (waiting === "camera") return t("capture.opening_camera");
  if (waiting === "service") return t("capture.opening_service");
  return loading < 1 ? t("capture.opening_loading") : t("capture.opening_starting");
}

/** @param {State} state */
export const failure = ({ failure }) => (failure ? t(`capture.fault_${failure.code}`, { detail: failure.detail }) : "");

/** @param {State} state */
export function kept(state) {
  const count = viewCount(state);
  return count === 0 ? "" : t("capture.kept", { count });
}

/** @param {State} state */
export const interrupted = ({ interrupted }) =>
  (interrupted ? t("capture.interrupted", { camera: interrupted.camera, count: interrupted.views }) : "");

/** @param {State} state */
export function stopping(state) {
  return state.stopAsked === null ? t("capture.stop") : t("capture.stop_really");
}

/** @param {State} state */
export function counts(state) {
  const { session, stored, away } = state;
  const used = session?.views.filter(({ set_aside }) => !set_aside).length ?? 0;
  const aside = (session?.views.length ?? 0) - used;
  return [
    t("capture.views", { count: used }),
    aside > 0 && t("capture.set_aside", { count: aside }),
    away && t("capture.kept_of", { count: stored, wanted: wantedAway(state) }),
    !away && stored > 0 && t("capture.waiting_views", { count: stored }),
    // Without the service it does not change, and there is more to say.
    !away && session?.uncertainty && t("capture.reached", { reached: rounded(session.uncertainty.rms), goal: rounded(session.target_error) }),
  ].filter(Boolean).join(" · ");
}

/** To what an uncertainty itself is worth. @param {number} value */
const rounded = (value) => number(value, value < 1 ? 2 : value < 10 ? 1 : 0);

/** What stays true for a while. @param {State} state */
export function standing(state) {
  if (state.sending) return t("capture.sending");
  if (state.away) return t(isEnough(state) ? "capture.away_enough" : "capture.away_now");
  return state.kept ? advice(state) : t("capture.not_kept");
}

/** What the service advises; in its own words where the page has none. @param {State} state */
function advice({ session }) {
  const first = session?.advice?.[0];
  if (!first) return "";
  const key = `capture.advice_${first.code}`;
  return known(key) ? t(key, { model: session?.suggested_model ?? "" }) : first.text;
}

/** @param {string} camera @param {[number, number] | null} size */
const described = (camera, size) => (size ? t("capture.camera_at", { camera, size: sized(size) }) : camera);

/** What the page was opened for, and whether it is there. @param {State} state */
export function wanted({ wanted: { camera, img_size }, cameras }) {
  const real = cameras.filter(({ id }) => id !== "virtual");
  if (!camera) return cameras.length > real.length && real.length === 0 ? t("capture.none_at_all") : "";
  const absent = cameras.length > 0 && !cameras.some(({ label }) => label === camera) && real.every(({ named }) => named);
  const asked = t("capture.asked_for", { camera: described(camera, img_size) });
  if (!absent) return asked;
  return `${asked} ${real.length ? t("capture.not_among") : t("capture.none_here")}`;
}

/** A camera by the name that people choose it by. @param {import("../lib/camera.js").Choice} choice */
export const named = ({ id, label }) => (id === "virtual" ? t("capture.virtual_name") : label);

/** The same, until a view was taken after it was read; again when that one is taken back. @param {State} state */
export const warning = (state) => (viewCount(state) > state.begunWith ? "" : another(state));

/** That it is another camera which was opened; "" where it is the one. @param {State} state */
export function another({ wanted: { camera, img_size }, key }) {
  if (!camera || !key) return "";
  if (camera === key.camera && (img_size ?? key.img_size).join() === key.img_size.join()) return "";
  return t("capture.another_opened", { asked: described(camera, img_size), opened: described(key.camera, key.img_size) });
}

/** The open camera. @param {State} state */
export function facts({ key, cropped }) {
  if (!key) return "";
  return [
    key.camera, sized(key.img_size), key.zoom && t("capture.zoom", { zoom: key.zoom }), cropped && t("capture.cropped"),
  ].filter(Boolean).join(" · ");
}

/** All that is sent besides the corners: the very object. @param {State} state */
export const sent = ({ request }) =>
  (request ? Object.entries(request).map(([name, value]) => `${name}: ${JSON.stringify(value)}`).join("\n") : "");

/** How to begin again with the model that the service suggests; "" where it suggests none. @param {State} state */
export function withModel({ session, wanted }) {
  const model = session?.suggested_model;
  return model && model !== wanted.distortion_model ? t("capture.with_model", { model }) : "";
}

/** An instruction about the camera's picture. @param {State} state */
export const unmirrored = ({ mirrored, instruction: { code } }) => (mirrored ? asMirrored(code) : code);
