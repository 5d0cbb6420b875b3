// The board detector as the page sees it: one call a frame, answered from a Worker.
import { reach } from "./network.js";

/** @import { Board } from "./board.js" */

/**
 * @typedef {object} Detection
 * @property {number[]} ids board corners, id = row * (columns - 1) + column
 * @property {number[][]} points px, pixel centres at whole numbers
 * @property {number} markers how many markers were recognised
 * @property {import("./frame-metrics.js").FrameMetrics} [metrics] what the frame looks like
 * @property {[number, number]} size of the frame
 * @property {number} elapsed ms in the worker
 * @property {number} memory bytes that OpenCV holds
 */

const START_TIMEOUT_MS = 20_000; // ms; a worker that a content policy blocks neither answers nor fails
// ms for one frame: ten times what a slow phone needs. A killed worker reports nothing
const FRAME_TIMEOUT_MS = 4_000;
// ms for one picture in which boards of every kind are looked for, which takes much longer
const SIGHT_TIMEOUT_MS = 30_000;
const CLOSE_TIMEOUT_MS = 1_000; // ms for the frames that are still there when it is closed
const OPENCV = new URL("../vendor/opencv/", import.meta.url);

/** Codes name texts: `capture.fault_<code>`. */
export class DetectorError extends Error {
  /** @param {string} message @param {string} [code] */
  constructor(message, code = "detector") {
    super(message);
    this.code = code;
  }
}

export class Detector {
  /**
   * @type {Map<number, {resolve: (value: any) => void, reject: (error: Error) => void, timer: ReturnType<typeof
   *   setTimeout>, end: number}>}
   */
  #waiting = new Map();
  #next = 0;
  #worker;
  #onProgress;

  /** @param {(fraction: number) => void} [onProgress] */
  constructor(onProgress = () => {}) {
    this.#onProgress = onProgress;
    this.#worker = new Worker(new URL("./detector.worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => this.#receive(data);
    this.#worker.onerror = (event) => this.#fail(event.message || "The board detector could not be started.");
  }

  /**
   * Loads OpenCV and makes a detector for one board.
   * @param {Board} board
   * @param {(fraction: number) => void} [onProgress] 0…1 while OpenCV arrives
   */
  static async open(board, onProgress) {
    const detector = new Detector(onProgress); // its modules are loaded meanwhile
    try {
      const response = await reach(new URL("opencv.json", OPENCV));
      if (!response.ok)
        throw new DetectorError(`The board detector is not there (${response.status}).`, "detector_missing");
      const { bytes } = await response.json();
      await detector.#ask({ open: board, wasm: new URL("opencv.wasm", OPENCV).href, bytes }, []);
    } catch (error) {
      detector.close();
      throw error;
    }
    return detector;
  }

  /**
   * Finds the board's corners. Takes over the frame and closes it.
   * @param {VideoFrame | ImageBitmap} frame
   * @param {{full?: boolean, flip?: boolean, timeout?: number}} [options] full: all threshold windows and a sub-pixel
   * second pass, for a view that is kept; flip: the frame is mirrored, and is turned back; timeout: ms
   * @returns {Promise<Detection>}
   */
  detect(frame, { full = false, flip = false, timeout = FRAME_TIMEOUT_MS } = {}) {
    return this.#look({ frame, full, flip }, timeout);
  }

  /**
   * Looks for boards of any kind; `recognise` of board-recognition.js concludes from several pictures. Takes over the
   * frame and closes it.
   * @param {VideoFrame | ImageBitmap} frame
   * @param {{flip?: boolean, timeout?: number}} [options] as of `detect`
   * @returns {Promise<import("./board-recognition.js").Sighting>}
   */
  sight(frame, { flip = false, timeout = SIGHT_TIMEOUT_MS } = {}) {
    return this.#look({ frame, recognise: true, flip }, timeout);
  }

  /** @param {{frame: VideoFrame | ImageBitmap, [option: string]: unknown}} message @param {number} timeout ms */
  #look(message, timeout) {
    const { frame } = message;
    if (!this.closed) return this.#ask(message, [frame], timeout);
    frame.close();
    return Promise.reject(new DetectorError("The board detector was closed."));
  }

  /**
   * Looks for another board from now on.
   * @param {Board} board
   * @returns {Promise<void>}
   */
  async change(board) {
    await this.#ask({ open: board, wasm: new URL("opencv.wasm", OPENCV).href, bytes: 1 }, []);
  }

  /** Number of frames in the worker: above 0, drop the next one rather than queue it. */
  get busy() {
    return this.#waiting.size;
  }

  /** True once it is closed. */
  closed = false;

  /**
   * Ends the worker once it has released its frames, or does not answer: a frame that it still has would keep the
   * camera's memory.
   */
  close() {
    if (this.closed) return;
    this.closed = true;
    this.#fail("The board detector was closed.");
    const end = () => this.#worker.terminate();
    const timer = setTimeout(end, CLOSE_TIMEOUT_MS);
    this.#worker.onmessage = ({ data }) => {
      if (!data.closed) return;
      clearTimeout(timer);
      end();
    };
    this.#worker.postMessage({ close: true });
  }

  /** @param {object} message @param {Transferable[]} transfer @param {number} timeout ms @returns {Promise<any>} */
  #ask(message, transfer, timeout = START_TIMEOUT_MS) {
    const id = this.#next++;
    const now = performance.now();
    // The worker handles one request at a time: the timeout of this one begins after the previous answers.
    const end = Math.max(now, ...[...this.#waiting.values()].map((each) => each.end)) + timeout;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => this.#silent(id), end - now);
      this.#waiting.set(id, { resolve, reject, timer, end });
      this.#worker.postMessage({ id, ...message }, transfer);
    });
  }

  /** @param {number} id */
  #silent(id) {
    this.#waiting.get(id)?.reject(new DetectorError("The board detector does not answer.", "detector_silent"));
    this.#waiting.delete(id);
  }

  /** @param {{id?: number, progress?: number, result?: any, error?: string, code?: string}} message */
  #receive({ id, progress, result, error, code }) {
    if (progress !== undefined) {
      for (const [each, waiting] of this.#waiting) {
        clearTimeout(waiting.timer);
        waiting.timer = setTimeout(() => this.#silent(each), START_TIMEOUT_MS);
      }
      this.#onProgress(progress);
      return;
    }
    const waiting = this.#waiting.get(id ?? -1);
    if (!waiting) return;
    this.#waiting.delete(id ?? -1);
    clearTimeout(waiting.timer);
    if (error === undefined) waiting.resolve(result);
    else waiting.reject(new DetectorError(error, code));
  }

  /** @param {string} reason */
  #fail(reason) {
    for (const { reject, timer } of this.#waiting.values()) {
      clearTimeout(timer);
      reject(new DetectorError(reason));
    }
    this.#waiting.clear();
  }
}

/**
 * A frame of a playing video, in the form that costs least.
 * @param {HTMLVideoElement} video
 * @returns {Promise<VideoFrame | ImageBitmap>}
 */
export async function grab(video) {
  return typeof VideoFrame === "function" ? new VideoFrame(video) : createImageBitmap(video);
}

/** Board detector of a page: OpenCV is loaded once for several captures. */
export class PageDetector {
  #make;
  /** @type {Promise<Detector> | null} */
  #last = null;

  /** @param {() => Promise<Detector>} make */
  constructor(make) {
    this.#make = make;
  }

  /** The detector; another one if the last has failed or was closed. @returns {Promise<Detector>} */
  open() {
    const opening = this.#last ? this.#reopen(this.#last) : this.#make();
    this.#last = opening;
    opening.catch(() => {
      if (this.#last === opening) this.#last = null;
    });
    return opening;
  }

  /** @param {Promise<Detector>} last */
  async #reopen(last) {
    const detector = await last.catch(() => null);
    return detector && !detector.closed ? detector : this.#make();
  }

  /** Closes the detector, as after a failure or for another board: the next capture makes a new one. */
  close() {
    void this.#last?.then(
      (detector) => detector.close(),
      () => {},
    );
    this.#last = null;
  }
}
