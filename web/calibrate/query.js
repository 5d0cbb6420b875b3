// Query parameters of the capture page.

/** @param {URLSearchParams} query @returns {import("./state.js").Wanted} the camera that the page was opened for */
export function parseWanted(query) {
  const [, width, height] = /^(\d{1,5})[x×,](\d{1,5})$/.exec(query.get("img_size") ?? "") ?? [];
  const model = query.get("distortion_model");
  return {
    camera: query.get("camera"),
    img_size: width ? [Number(width), Number(height)] : null,
    distortion_model: model === "fisheye" || model === "rational" || model === "omnidirectional" ? model : "rectilinear",
  };
}

/** Goal of the session, px, where the address gives one. @param {URLSearchParams} query */
export function parseTargetError(query) {
  const value = Number(query.get("target_error"));
  return value > 0 ? { target_error: value } : {};
}
