// The board page: full screen at whole device pixels, and PDF.
import { DEFAULT_BOARD, blackRectangles, raster } from "./geometry.js";
import { PAPERS, boardPdf, squareSide } from "./pdf.js";

/** @typedef {import("./geometry.js").Board} Board */

const MARGIN = 0.5; // squares of white around the board on a screen
const board = boardFrom(new URLSearchParams(location.search));
const frame = /** @type {HTMLElement} */ (document.getElementById("frame"));
const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("board"));
const status = /** @type {HTMLElement} */ (document.getElementById("status"));
/** @type {WakeLockSentinel | null} */
let awake = null;

/** The board an address asks for; the default where it asks for one that does not exist. @param {URLSearchParams} query @returns {Board} */
function boardFrom(query) {
  const [, columns, rows] = /^(\d{1,2})x(\d{1,2})$/.exec(query.get("squares") ?? "") ?? [];
  /** @type {Board} */
  const asked = {
    squares: columns ? [Number(columns), Number(rows)] : DEFAULT_BOARD.squares,
    marker_ratio: Number(query.get("marker_ratio")) || DEFAULT_BOARD.marker_ratio,
    dictionary: query.get("dictionary") ?? DEFAULT_BOARD.dictionary,
    legacy: query.get("legacy") === "true",
  };
  try {
    if (Math.min(...asked.squares) < 3 || !(asked.marker_ratio >= 0.3 && asked.marker_ratio <= 0.95)) throw new RangeError();
    blackRectangles(asked);
    return asked;
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
    return DEFAULT_BOARD;
  }
}

/** Draws the board so that a cell's edge falls on a device pixel, and one canvas pixel is one device pixel. */
function draw() {
  const full = document.fullscreenElement === frame;
  const density = window.devicePixelRatio || 1;
  const room = full ? [screen.width, screen.height] : [frame.clientWidth, Infinity];
  const turned = full && screen.width < screen.height !== board.squares[0] < board.squares[1];
  const [columns, rows] = turned ? [...board.squares].reverse() : board.squares;
  const scale = Math.max(8, Math.floor(Math.min(
    (room[0] * density) / (columns + 2 * MARGIN),
    (room[1] * density) / (rows + 2 * MARGIN),
  )));
  const upright = raster(board, scale, Math.round(MARGIN * scale));
  const { width, height, data } = turned ? quarterTurn(upright) : upright;
  canvas.width = width;
  canvas.height = height;
  canvas.style.width = full ? `${width / density}px` : "";
  canvas.style.height = full ? `${height / density}px` : "";
  const context = canvas.getContext("2d", { alpha: false });
  if (!context) return;
  const picture = context.createImageData(width, height);
  const pixels = new Uint32Array(picture.data.buffer);
  data.forEach((value, index) => {
    pixels[index] = value ? 0xffffffff : 0xff000000;
  });
  context.putImageData(picture, 0, 0);
}

/** Clockwise: on a phone held upright the board is larger so. @param {ReturnType<typeof raster>} picture */
function quarterTurn({ width, height, data }) {
  const turned = new Uint8Array(data.length);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) turned[x * height + height - 1 - y] = data[y * width + x];
  }
  return { width: height, height: width, data: turned };
}

/** A screen that dims in the middle of a capture ends it. */
async function stayAwake() {
  if (!("wakeLock" in navigator)) return;
  try {
    awake = await navigator.wakeLock.request("screen");
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    status.textContent = "This device may dim its screen: touch it now and then.";
  }
}

document.getElementById("full-screen")?.addEventListener("click", async () => {
  await frame.requestFullscreen({ navigationUI: "hide" });
});
document.addEventListener("fullscreenchange", async () => {
  draw();
  if (document.fullscreenElement) await stayAwake();
  else await awake?.release();
});
new ResizeObserver(draw).observe(frame);

const papers = document.getElementById("papers");
for (const [name, size] of Object.entries(PAPERS)) {
  if (squareSide(board, size) < 5) continue;
  const link = document.createElement("a");
  link.className = "button";
  link.textContent = `PDF, ${name}`;
  link.href = URL.createObjectURL(new Blob([boardPdf(board, size)], { type: "application/pdf" }));
  link.download = `calibdb-board-${name.toLowerCase()}.pdf`;
  papers?.append(link);
}
const description = document.getElementById("description");
if (description) {
  const [columns, rows] = board.squares;
  description.textContent = `ChArUco, ${columns} × ${rows} squares, ${board.dictionary}, markers ${board.marker_ratio} ` +
    `of a square, ${board.legacy ? "layout of OpenCV before 4.6" : "layout of OpenCV 4.6 and later"}.`;
}
