// Query parameters of the capture page.

/** @typedef {import("./state.js").Wanted["distortion_model"]} LensType */

/** Views from which a type of lens is detected: with fewer, noise may look like a lens. */
export const MIN_DETECTING_VIEWS = 3;
const LENS_TYPES = ["rectilinear", "rational", "fisheye", "omnidirectional"];

/** @param {string | null} name @returns {name is LensType} */
export const isLensType = (name) => LENS_TYPES.includes(name ?? "");

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
