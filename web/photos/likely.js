// Estimate of the camera that took the photographs, by their EXIF data: there before any of them shows a board.
import { askJson } from "../lib/api.js";
import { estimateView } from "../lib/estimate-view.js";

/** @import { Found } from "./group.js" */

/** The camera that was asked for last. */
let asked = "";

/**
 * Body of the lookup of the first photograph that names its camera; null where none does.
 * @param {readonly Found[]} pictures
 */
export function questionOf(pictures) {
  const named = pictures.find(({ camera, kind }) => camera !== "" && kind === "photographs");
  if (!named) return null;
  const { camera, kind, size, focal, focal35 } = named;
  const reported = focal35 ? { reported: { focal_35mm: focal35 } } : {};
  return { camera, platform: kind, img_size: size, zoom: focal, ...reported, redirect: false, miss: "ok" };
}

/**
 * Shows what is likely of the camera, where it is not calibrated.
 * @param {HTMLElement} place
 * @param {readonly Found[]} pictures
 */
export async function showLikely(place, pictures) {
  const body = questionOf(pictures);
  const about = JSON.stringify(body);
  if (about === asked) return;
  asked = about;
  place.replaceChildren();
  if (!body) return;
  try {
    const { estimate } = await askJson("POST", "/lookup", { body });
    if (about === asked && estimate) place.replaceChildren(estimateView(estimate));
  } catch (error) {
    console.info("no estimate:", error instanceof Error ? error.message : error);
  }
}
