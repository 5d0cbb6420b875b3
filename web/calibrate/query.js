// What the page's address asks for.

/** @param {URLSearchParams} query @returns {import("./state.js").Wanted} */
export function wantedFrom(query) {
  const [, width, height] = /^(\d{1,5})[x×,](\d{1,5})$/.exec(query.get("img_size") ?? "") ?? [];
  const model = query.get("distortion_model");
  return {
    camera: query.get("camera"),
    img_size: width ? [Number(width), Number(height)] : null,
    distortion_model: model === "fisheye" || model === "rational" || model === "omnidirectional" ? model : "rectilinear",
  };
}

/** What the session is to reach, where the address says so, px. @param {URLSearchParams} query */
export function targetError(query) {
  const value = Number(query.get("target_error"));
  return value > 0 ? { target_error: value } : {};
}
