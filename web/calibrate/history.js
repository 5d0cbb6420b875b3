// Address of the capture page: what it asks for, and of the result once there is one, so that a reload shows what is
// there.
import { pageUrl } from "../lib/i18n.js";
import { isVirtual } from "../lib/camera-name.js";
import { isLensType } from "../lib/camera.js";
import { isLoopback } from "../lib/result/return-address.js";

/** Fragment of an address that resumes the saved capture. */
export const RESUME = "#go-on";

/** @param {URLSearchParams} parameters */
const queryOf = (parameters) => (parameters.size > 0 ? `?${parameters}` : "");

/**
 * The part of the address that says what is captured: the language does not.
 * @param {URLSearchParams | string} parameters
 */
export function captureQuery(parameters) {
  const own = new URLSearchParams(parameters);
  own.delete("lang");
  return queryOf(own);
}

/**
 * This page's address with a query, in the language spoken now.
 * @param {URLSearchParams | string} parameters
 * @param {string} [fragment]
 */
const captureAddress = (parameters, fragment = "") => pageUrl(`calibrate/${captureQuery(parameters)}${fragment}`);

/** @param {URLSearchParams} parameters */
export function showCaptureAddress(parameters) {
  history.replaceState(null, "", captureAddress(parameters));
}

/** @param {URLSearchParams} parameters @param {import("./state.js").State} state of a capture that is done */
export function showResultAddress(parameters, { capture: { session, key }, wanted }) {
  const id = session?.calibration_id;
  if (!id) return;
  const query = new URLSearchParams({ id });
  const back = parameters.get("return_to");
  const isKept = isVirtual(key?.camera ?? "") && !isPracticeReturned(back, wanted.camera);
  if (back !== null && !isKept) query.set("return_to", back);
  history.replaceState(null, "", pageUrl(`result/?${query}`));
}

/**
 * Reloads this page with another query, and resumes the capture there.
 * @param {string} query as `captureQuery` gives it
 */
export function resumeAt(query) {
  location.assign(captureAddress(query, RESUME));
}

/**
 * True if an application gets the result of a practice run: if it asked for the virtual camera, and if it is still
 * being developed, so that its way there and back can be tried without a webcam.
 * @param {string | null} returnTo @param {string | null} asked label of the camera that the page was opened for
 */
export function isPracticeReturned(returnTo, asked) {
  return (
    isVirtual(asked ?? "") ||
    (returnTo !== null && URL.canParse(returnTo, location.href) && isLoopback(new URL(returnTo, location.href)))
  );
}

/** @param {URLSearchParams} query @returns {import("./state.js").Wanted} the camera that the page was opened for */
export function parseWanted(query) {
  const [, width, height] = /^(\d{1,5})[x×,](\d{1,5})$/.exec(query.get("img_size") ?? "") ?? [];
  const model = query.get("distortion_model");
  return {
    camera: query.get("camera"),
    img_size: width ? [Number(width), Number(height)] : null,
    distortion_model: isLensType(model) ? model : "rectilinear",
    automatic: !isLensType(model),
    flipped: query.get("flipped") === "true",
  };
}

/** Goal of the session, px, where the address gives one. @param {URLSearchParams} query */
export function parseTargetError(query) {
  const value = Number(query.get("target_error"));
  return value > 0 ? { target_error: value } : {};
}
