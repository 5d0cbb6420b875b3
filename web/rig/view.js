// View of a moment in one camera: a fresh frame, searched thoroughly, and refused if the hand has jerked since.
import { motion } from "../lib/capture/stillness.js";

/** @typedef {import("../lib/board-outline.js").Corners} Corners */

const MAX_MOTION_PX = 3; // between the last frame and the one that is taken, at 1280 px width

/**
 * @param {import("./streams.js").Stream} stream @param {number} half index of the camera's picture in the stream
 * @param {import("./moments.js").Sight} sight of the board in the last frame
 * @param {(picture: VideoFrame | ImageBitmap) => Promise<import("../lib/detector.js").Detection | null>} detect takes
 *   the picture over
 * @returns {Promise<{corners: Corners, picture: ImageBitmap} | null>} null: this frame will not do
 */
export async function takeView(stream, half, sight, detect) {
  const pictures = await stream.grab();
  pictures.forEach((each, index) => index !== half && each.close());
  const picture = await createImageBitmap(pictures[half]);
  const detection = await detect(pictures[half]);
  const corners = detection && { ids: detection.ids, points: detection.points };
  if (corners && motion(sight.corners, corners) <= (MAX_MOTION_PX * sight.width) / 1280) return { corners, picture };
  picture.close();
  return null;
}
