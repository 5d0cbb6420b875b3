// The virtual camera's painter in a Worker: a hundred milliseconds a picture would stop the page.
import { Painter } from "./painter.js";

/**
 * @typedef {import("../board/geometry.js").Board} Board
 * @typedef {import("./lens.js").Lens} Lens
 * @typedef {import("./pose.js").Pose} Pose
 */

/** @type {Painter | null} */
let painter = null;
/** @type {[number, number]} */
let size = [0, 0];

/** @param {MessageEvent<{open: {board: Board, lens: Lens, size: [number, number]}} | {pose: Pose | null}>} event */
self.onmessage = ({ data }) => {
  if ("open" in data) {
    size = data.open.size;
    painter = new Painter(data.open.board, data.open.lens, size);
    self.postMessage({ ready: true });
    return;
  }
  const picture = new ImageData(...size);
  painter?.paint(data.pose, picture.data);
  self.postMessage({ picture }, { transfer: [picture.data.buffer] });
};
