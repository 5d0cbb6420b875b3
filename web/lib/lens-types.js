// Types of lenses, as the pages name them: models of the service, the simplest first.

/** @typedef {"rectilinear" | "rational" | "fisheye" | "omnidirectional"} LensType */

/** @type {readonly LensType[]} */
export const LENS_TYPES = ["rectilinear", "rational", "fisheye", "omnidirectional"];

/** @param {string | null} name @returns {name is LensType} */
export const isLensType = (name) => LENS_TYPES.some((type) => type === name);
