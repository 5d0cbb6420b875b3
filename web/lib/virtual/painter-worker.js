// Worker of the virtual camera's painter: a hundred milliseconds a picture would stop the page. Not named `.worker.js`,
// whose content security policy allows `eval`: this worker needs none.
import { Painter } from "./painter.js";
import { degrade, smear } from "./degrade.js";

/**
 * @import { Board } from "../board.js"
 * @import { Pose } from "../pose.js"
 * @import { LensParameters } from "./lens.js"
 */

/** @type {Painter | null} */
let painter = null;
/** @type {[number, number]} */
let size = [0, 0];

let fault = "";

/**
 * @typedef {{open: {board: Board, lens: LensParameters, size: [number, number], fault: string}}} Open
 * @typedef {{pose: Pose | null, blur: number}} Frame blur: px, across for even numbers, down for odd ones
 */

/** @param {MessageEvent<Open | Frame>} event */
self.onmessage = ({ data }) => {
  if ("open" in data) {
    ({ size, fault } = data.open);
    painter = new Painter(data.open.board, data.open.lens, size);
    self.postMessage({ ready: true });
    return;
  }
  const picture = new ImageData(...size);
  painter?.paint(data.pose, picture.data);
  if (data.blur > 0) smear(picture, data.blur, data.blur % 2 ? size[0] : 1);
  if (fault) degrade(picture, fault);
  self.postMessage({ picture }, { transfer: [picture.data.buffer] });
};
