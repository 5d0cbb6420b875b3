// The board on this screen: at whole device pixels, as large as there is room, and awake.
import { sizeOf } from "../lib/board.js";
import { exactScale, raster } from "../lib/board-drawing.js";

/** @import { Board } from "../lib/board.js" */

const MARGIN_SQUARES = 0.5; // squares of white around the board
const MAX_CODE_PX = 220; // CSS pixels: side of the QR code next to the board
const MIN_CODE_PX = 120; // that a phone reads from half a metre
const CODE_SHARE = 0.2; // of the window's shorter side
const READING = 6000; // ms for which the page says how to return; then only the board is shown

export class BoardScreen {
  #frame;
  #canvas;
  #hint;
  #code;
  #board;
  #onDimming;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #read;
  /** @type {WakeLockSentinel | null} */
  #awake = null;
  /** True if the board fills the window, because full screen is not available. */
  #filling = false;
  /** The removal of the history entry of the last full screen. @type {Promise<void> | null} */
  #back = null;
  /** True if the code for a phone is shown next to the board while it fills the screen. */
  #coded = false;

  /**
   * @param {{frame: HTMLElement, canvas: HTMLCanvasElement, hint: HTMLElement, code: HTMLElement}} parts hint: how to
   *   get back from the whole window; code: for a phone that is to look at the board
   * @param {Board} board @param {() => void} onDimming the screen cannot be kept on
   */
  constructor({ frame, canvas, hint, code }, board, onDimming) {
    this.#frame = frame;
    this.#canvas = canvas;
    this.#hint = hint;
    this.#code = code;
    this.#board = board;
    this.#onDimming = onDimming;
    document.addEventListener("click", () => this.fill(false));
    document.addEventListener("keydown", ({ key }) => key === "Escape" && this.fill(false));
    document.addEventListener("fullscreenchange", () => this.#arrange());
    window.addEventListener("popstate", () => this.#leave());
    // Browsers release the wake lock when the page is hidden.
    document.addEventListener(
      "visibilitychange",
      () => document.visibilityState === "visible" && this.#isFull() && this.#stayAwake(),
    );
    window.addEventListener("resize", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(frame);
  }

  /** @param {Board} board */
  show(board) {
    this.#board = board;
    this.draw();
  }

  /**
   * Fills the screen, or else the window: iPhones allow full screen for videos only.
   * @param {{code?: boolean}} [options] code: show the code for a phone in the white next to the board
   */
  async enter({ code = false } = {}) {
    this.#coded = code;
    await this.#back;
    // The Back button closes the full view, instead of leaving the page.
    history.pushState({ isBoardFull: true }, "");
    if (!this.#frame.requestFullscreen) return this.fill(true);
    this.#frame.requestFullscreen({ navigationUI: "hide" }).catch(() => this.fill(true));
  }

  /** @param {boolean} whether */
  fill(whether) {
    if (this.#filling === whether) return;
    this.#filling = whether;
    clearTimeout(this.#read);
    this.#hint.hidden = !whether; // in full screen, the browser itself says how to leave
    this.#read = setTimeout(() => this.#hint.toggleAttribute("hidden", true), READING);
    void this.#arrange();
  }

  #leave() {
    this.fill(false);
    if (document.fullscreenElement === this.#frame) void document.exitFullscreen();
  }

  #isFull() {
    return this.#filling || document.fullscreenElement === this.#frame;
  }

  /** Draws the board so that a cell's edge falls on a device pixel, and one canvas pixel is one device pixel. */
  draw() {
    const full = this.#isFull();
    const size = sizeOf(this.#board);
    const density = window.devicePixelRatio || 1;
    const whole = this.#filling ? [innerWidth, innerHeight] : [screen.width, screen.height];
    const side =
      full && this.#coded ? Math.min(MAX_CODE_PX, Math.max(MIN_CODE_PX, CODE_SHARE * Math.min(...whole))) : 0;
    this.#showCode(side, whole[0] > whole[1]);
    const strip = whole[0] > whole[1] ? [side, 0] : [0, side];
    const room = full ? whole.map((length, axis) => length - strip[axis]) : [this.#frame.clientWidth, Infinity];
    const turned = full && whole[0] < whole[1] !== size[0] < size[1];
    const [columns, rows] = turned ? [...size].reverse() : size;
    const scale = exactScale(
      this.#board,
      Math.max(
        8,
        Math.floor(
          Math.min(
            (room[0] * density) / (columns + 2 * MARGIN_SQUARES),
            (room[1] * density) / (rows + 2 * MARGIN_SQUARES),
          ),
        ),
      ),
    );
    const upright = raster(this.#board, scale, Math.round(MARGIN_SQUARES * scale));
    const { width, height, data } = turned ? quarterTurn(upright) : upright;
    this.#canvas.width = width;
    this.#canvas.height = height;
    this.#canvas.style.width = full ? `${width / density}px` : "";
    this.#canvas.style.height = full ? `${height / density}px` : "";
    const context = this.#canvas.getContext("2d", { alpha: false });
    if (!context) return;
    const picture = context.createImageData(width, height);
    const pixels = new Uint32Array(picture.data.buffer);
    data.forEach((value, index) => {
      pixels[index] = value ? 0xffffffff : 0xff000000;
    });
    context.putImageData(picture, 0, 0);
  }

  /**
   * @param {number} side CSS pixels; 0: not shown
   * @param {boolean} isWide the code is next to the board, or else below it
   */
  #showCode(side, isWide) {
    this.#code.hidden = side === 0;
    this.#code.style.width = `${side}px`;
    this.#frame.classList.toggle("coded", side > 0 && isWide);
    this.#frame.classList.toggle("coded-below", side > 0 && !isWide);
  }

  /** Draws the board again, and keeps the screen awake while the board fills it. */
  async #arrange() {
    this.#frame.classList.toggle("filling", this.#filling);
    this.draw();
    if (this.#isFull()) return this.#stayAwake();
    if (history.state?.isBoardFull) this.#back ??= goBack().finally(() => (this.#back = null)); // closed in another way
    const held = this.#awake;
    this.#awake = null;
    await held?.release();
  }

  /** A screen that dims in the middle of a capture ends it. */
  async #stayAwake() {
    if (!("wakeLock" in navigator)) return this.#onDimming();
    try {
      this.#awake = await navigator.wakeLock.request("screen");
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      this.#onDimming();
    }
  }
}

/** @returns {Promise<void>} when the page is at the history entry before */
function goBack() {
  return new Promise((resolve) => {
    window.addEventListener("popstate", () => resolve(), { once: true });
    history.back();
  });
}

/** Clockwise: on a phone held upright the board is larger so. @param {ReturnType<typeof raster>} picture */
function quarterTurn({ width, height, data }) {
  const turned = new Uint8Array(data.length);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) turned[x * height + height - 1 - y] = data[y * width + x];
  }
  return { width: height, height: width, data: turned };
}
