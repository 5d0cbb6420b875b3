// The board page: full screen at whole device pixels, and PDF.
import { boardFrom, boardQuery, raster } from "./geometry.js";
import { PAPERS, boardPdf, squareSide } from "./pdf.js";

const MARGIN = 0.5; // squares of white around the board on a screen
const { board, problem } = boardFrom(new URLSearchParams(location.search));
const frame = /** @type {HTMLElement} */ (document.getElementById("frame"));
const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("board"));
const status = /** @type {HTMLElement} */ (document.getElementById("status"));
/** @type {WakeLockSentinel | null} */
let awake = null;
/** Does the board fill the window, where no full screen is to be had? */
let filling = false;

function isFull() {
  return filling || document.fullscreenElement === frame;
}

/** Draws the board so that a cell's edge falls on a device pixel, and one canvas pixel is one device pixel. */
function draw() {
  const full = isFull();
  const density = window.devicePixelRatio || 1;
  const whole = filling ? [innerWidth, innerHeight] : [screen.width, screen.height];
  const room = full ? whole : [frame.clientWidth, Infinity];
  const turned = full && whole[0] < whole[1] !== board.squares[0] < board.squares[1];
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

/** Draws the board anew, and keeps the screen bright for as long as it is all that is shown. */
async function arrange() {
  frame.classList.toggle("filling", filling);
  draw();
  if (isFull()) return stayAwake();
  const held = awake;
  awake = null;
  await held?.release();
}

/** @param {boolean} whether */
function fill(whether) {
  if (filling === whether) return;
  filling = whether;
  void arrange();
}

document.getElementById("full-screen")?.addEventListener("click", (event) => {
  event.stopPropagation(); // or this very click would close it again
  // iPhones have full screen for videos only, and a page in a frame may be refused it.
  if (!frame.requestFullscreen) return fill(true);
  frame.requestFullscreen({ navigationUI: "hide" }).catch(() => fill(true));
});
document.addEventListener("click", () => fill(false));
document.addEventListener("keydown", ({ key }) => key === "Escape" && fill(false));
document.addEventListener("fullscreenchange", arrange);
// The lock is lost with the page's being seen.
document.addEventListener("visibilitychange", () => document.visibilityState === "visible" && isFull() && stayAwake());
window.addEventListener("resize", draw);
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
const complaint = document.getElementById("problem");
if (complaint) {
  complaint.textContent = problem;
  complaint.hidden = problem === "";
}
/** @type {HTMLAnchorElement | null} */
const calibrate = document.querySelector('nav a[href="../calibrate/"]');
if (calibrate) calibrate.search = boardQuery(board).toString();
const description = document.getElementById("description");
if (description) {
  const [columns, rows] = board.squares;
  description.textContent = `ChArUco, ${columns} × ${rows} squares, ${board.dictionary}, markers ${board.marker_ratio} ` +
    `of a square, ${board.legacy ? "layout of OpenCV before 4.6" : "layout of OpenCV 4.6 and later"}.`;
}
