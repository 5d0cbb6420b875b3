// Depth from the rectified pair of two cameras.
import { part, liveRegion } from "../../lib/dom.js";
import { explain } from "../../lib/faults.js";
import { number, t } from "../../lib/i18n.js";
import { openPage } from "../../lib/page.js";
import { rectifyPair } from "../../sdk/rig.js";
import { disparityOf } from "./matching.js";
import { distanceToBoard, openPair } from "./pair.js";

const LINES = 9; // through both pictures
const [AMBER, PALE] = ["#ffb000", "rgb(255 255 255 / 45%)"];

openPage();
show().catch((error) => {
  const problem = part("problem", HTMLElement);
  problem.textContent = explain(error);
  problem.hidden = false;
});

async function show() {
  const { canvases, calibrations, board } = await openPair(part("virtual", HTMLElement));
  const pair = await rectifyPair(canvases[0], canvases[1], calibrations);
  const [width, height] = pair.img_size;
  const [left, right, overlay] = ["left", "right", "overlay"].map((id, index) =>
    contextOf(id, index < 2 ? width : 2 * width, height),
  );
  const [column, row, rectified] = ["column", "row", "rectified"].map((id) => part(id, HTMLInputElement));
  const say = liveRegion(part("depth", HTMLElement));

  const draw = () => {
    pair.draw();
    const sources = rectified.checked ? [pair.left, pair.right] : canvases;
    [left, right].forEach((context, index) => context.drawImage(sources[index], 0, 0));
    measure();
  };
  const measure = () => {
    const at = /** @type {[number, number]} */ ([Number(column.value), Number(row.value)]);
    drawLines(overlay, at[1]);
    if (!rectified.checked) return say(() => t("examples.not_rectified"));
    const [a, b] = [left, right].map((context) => context.getImageData(0, 0, width, height));
    const disparity = disparityOf(a, b, at);
    drawMark(overlay, at);
    if (disparity === null) return say(() => t("examples.no_match"));
    drawMark(overlay, [width + at[0] - disparity, at[1]]);
    const point = pair.point(at, disparity);
    const depth = Math.hypot(...point);
    const truth = distanceToBoard(point, board) * depth;
    say(() =>
      t("examples.depth", { disparity: number(disparity, 1), depth: number(depth, 2), truth: number(truth, 2) }),
    );
  };
  for (const input of [column, row]) input.addEventListener("input", measure);
  rectified.addEventListener("change", draw);
  overlay.canvas.addEventListener("click", ({ offsetX, offsetY }) => {
    const { clientWidth, clientHeight } = overlay.canvas;
    const u = (offsetX / clientWidth) * 2 * width;
    if (u >= width) return;
    [column.value, row.value] = [`${Math.round(u)}`, `${Math.round((offsetY / clientHeight) * height)}`];
    measure();
  });
  draw();
}

/** @param {string} id @param {number} width @param {number} height @returns {CanvasRenderingContext2D} */
function contextOf(id, width, height) {
  const canvas = part(id, HTMLCanvasElement);
  Object.assign(canvas, { width, height });
  return /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: id !== "overlay" }));
}

/** @param {CanvasRenderingContext2D} context @param {number} chosen row */
function drawLines(context, chosen) {
  const { width, height } = context.canvas;
  context.clearRect(0, 0, width, height);
  for (let line = 1; line <= LINES; line++) drawLine(context, (line * height) / (LINES + 1), PALE);
  drawLine(context, chosen, AMBER);
}

/** @param {CanvasRenderingContext2D} context @param {number} row @param {string} colour */
function drawLine(context, row, colour) {
  context.fillStyle = colour;
  context.fillRect(0, Math.round(row), context.canvas.width, 1);
}

/** @param {CanvasRenderingContext2D} context @param {readonly [number, number]} at */
function drawMark(context, [u, v]) {
  context.strokeStyle = AMBER;
  context.lineWidth = 3;
  context.strokeRect(u - 12, v - 12, 24, 24);
}
