// Finds the ChArUco board in camera frames. Runs in a Worker of its own: OpenCV.js blocks while it computes, and its
// bindings need `unsafe-eval`, which this file alone is served with.
import createOpenCV from "../vendor/opencv/opencv.js";
import { frameMetrics } from "./frame-metrics.js";
import { refine } from "./subpixel.js";

/**
 * @typedef {import("./board.js").Board} Board
 * @typedef {import("./subpixel.js").Grey} Grey
 * @typedef {{id: number, open: Board, wasm: string, bytes: number}} OpenRequest
 * @typedef {{id: number, frame: VideoFrame | ImageBitmap, full: boolean, probe: string | null}} DetectRequest
 */

/** @type {any} OpenCV's module; its bindings are made at run time */
let cv = null;
/** @type {ReturnType<typeof createFinder> | null} */
let finder = null;

class LoadError extends Error {
  /** @param {string} message @param {string} code for the page's words */
  constructor(message, code) {
    super(message);
    this.code = code;
  }
}

/** Compiles the WebAssembly while it arrives. @param {string} address @param {number} bytes its size, uncompressed */
async function loadOpenCV(address, bytes) {
  const response = await fetch(address).catch(lost);
  if (!response.ok || !response.body) throw new LoadError(`OpenCV is not there (${response.status}).`, "detector_missing");
  let loaded = 0;
  let reported = 0;
  const counted = response.body.pipeThrough(new TransformStream({
    transform(chunk, controller) {
      loaded += chunk.length;
      if (loaded - reported > bytes / 50 || loaded === bytes) {
        reported = loaded;
        self.postMessage({ progress: loaded / bytes });
      }
      controller.enqueue(chunk);
    },
  }));
  const wasm = new Response(counted, { headers: { "content-type": "application/wasm" } });
  const compiled = await WebAssembly.compileStreaming(wasm).catch(lost);
  return createOpenCV({
    /**
     * @param {WebAssembly.Imports} imports
     * @param {(instance: WebAssembly.Instance, module: WebAssembly.Module) => void} done
     */
    instantiateWasm(imports, done) {
      WebAssembly.instantiate(compiled, imports).then((instance) => done(instance, compiled));
      return {};
    },
  });
}

/** Rejections of `fetch` and of the stream it fills are TypeErrors. @param {unknown} error @returns {never} */
function lost(error) {
  if (!(error instanceof TypeError)) throw error;
  throw new LoadError("OpenCV could not be loaded.", "detector_lost");
}

/**
 * The detectors for one board, and the memory they share.
 * @param {Board} board
 */
function createFinder(board) {
  const [columns, rows] = board.squares;
  const noIds = new cv.Mat();
  const size = new cv.Size(columns, rows);
  const refinement = new cv.aruco_RefineParameters(10, 3, true);
  const charucoParameters = new cv.aruco_CharucoParameters();
  /** @type {{delete: () => void}[]} */
  const held = [noIds, refinement, charucoParameters];

  /**
   * @param {{full?: boolean, legacy?: boolean, name?: string}} options full: all window sizes of the adaptive threshold, or
   *   the one that serves nearly always
   */
  const makeDetector = ({ full = false, legacy = board.legacy, name = board.dictionary }) => {
    const dictionary = cv.getPredefinedDictionary(cv[name]);
    const charuco = new cv.aruco_CharucoBoard(size, 1, board.marker_ratio, dictionary, noIds);
    charuco.setLegacyPattern(legacy);
    const parameters = new cv.aruco_DetectorParameters();
    if (!full) {
      parameters.adaptiveThreshWinSizeMin = 13;
      parameters.adaptiveThreshWinSizeMax = 13;
    }
    const detector = new cv.aruco_CharucoDetector(charuco, charucoParameters, parameters, refinement);
    parameters.delete();
    held.push(detector, charuco, dictionary);
    return detector;
  };
  const detectors = { tracking: makeDetector({}), full: makeDetector({ full: true }) };
  /** Made when first needed: most captures never look for anything else. @type {Map<string, any>} */
  const others = new Map();
  /** @param {string} kind */
  const other = (kind) => {
    if (kind === "mirrored") return detectors.tracking;
    const made = others.get(kind) ?? makeDetector(kind === "legacy" ? { legacy: !board.legacy } : { name: kind });
    others.set(kind, made);
    return made;
  };
  let input = new cv.Mat();

  /**
   * @param {any} detector @param {Grey} image
   * @returns {{ids: number[], points: number[][], markers: number, side: number}} side: of the markers, median, px
   */
  const detect = (detector, image) => {
    if (input.rows !== image.height || input.cols !== image.width) {
      input.delete();
      input = new cv.Mat(image.height, image.width, cv.CV_8UC1);
    }
    input.data.set(image.data);
    // New for every frame: markers that are there already are taken as found, and corners that are there already stay
    // there when none is seen.
    const found = { corners: new cv.Mat(), ids: new cv.Mat() };
    const markers = { corners: new cv.MatVector(), ids: new cv.Mat() };
    try {
      detector.detectBoard(input, found.corners, found.ids, markers.corners, markers.ids);
      const ids = length(found.ids) > 0 ? Array.from(/** @type {Int32Array} */ (found.ids.data32S)) : [];
      const positions = ids.length > 0 ? found.corners.data32F : [];
      const points = ids.map((_, index) => [positions[2 * index], positions[2 * index + 1]]);
      return { ids, points, markers: markers.corners.size(), side: ids.length > 0 ? 0 : markerSide(markers.corners) };
    } finally {
      for (const each of [found.corners, found.ids, markers.corners, markers.ids]) each.delete();
    }
  };

  return {
    /** @param {Grey} image @param {boolean} full */
    find(image, full) {
      const { ids, points, markers, side } = detect(full ? detectors.full : detectors.tracking, image);
      const seen = full ? refine(image, { ids, points }, columns - 1) : { ids, points };
      return { ...seen, markers, metrics: frameMetrics(image, board, seen, side) };
    },
    /**
     * Looks for something else than the board.
     * @param {Grey} image
     * @param {string} kind "mirrored", "legacy", a dictionary
     */
    probe(image, kind) {
      const { ids, markers } = detect(other(kind), kind === "mirrored" ? flipped(image) : image);
      return { kind, markers, corners: ids.length };
    },
    /** Bytes that OpenCV's heap has grown to. */
    get memory() {
      return input.data.buffer.byteLength;
    },
    delete() {
      for (const each of [...held, input]) each.delete();
    },
  };
}

/**
 * Median length of the markers' first sides, px; 0 where there are none.
 * @param {any} corners vector of 1 x 4 points
 */
function markerSide(corners) {
  /** @type {number[]} */
  const sides = [];
  for (let index = 0; index < corners.size(); index++) {
    const marker = corners.get(index);
    const [x1, y1, x2, y2] = marker.data32F;
    sides.push(Math.hypot(x2 - x1, y2 - y1));
    marker.delete();
  }
  return sides.sort((a, b) => a - b)[sides.length >> 1] ?? 0;
}

let mirror = new Uint8Array(0);

/** @param {Grey} image @returns {Grey} memory that the next call writes over */
function flipped({ width, height, data }) {
  if (mirror.length !== width * height) mirror = new Uint8Array(width * height);
  for (let y = 0, at = 0; y < height; y++) {
    for (let x = width - 1; x >= 0; x--, at++) mirror[at] = data[y * width + x];
  }
  return { width, height, data: mirror };
}

/** Elements of a vector: 1 x n in OpenCV 5, n x 1 before; an empty one may be 1 x 0. @param {any} mat */
function length(mat) {
  return mat.rows * mat.cols;
}

/** @type {OffscreenCanvasRenderingContext2D | null} */
let canvas = null;
let planes = new Uint8Array(0);
let grey = new Uint8Array(0);

/**
 * The luma of a frame.
 * @param {VideoFrame | ImageBitmap} frame
 * @returns {Promise<Grey>} memory that the next call writes over
 */
async function luma(frame) {
  if ("format" in frame && /^(I4|NV12)/.test(frame.format ?? "") && upright(frame)) {
    // Camera frames: the first plane is what we want, without any conversion.
    const rect = frame.visibleRect ?? new DOMRectReadOnly(0, 0, frame.codedWidth, frame.codedHeight);
    const bytes = frame.allocationSize({ rect });
    if (planes.length < bytes) planes = new Uint8Array(bytes);
    const [{ offset, stride }] = await frame.copyTo(planes, { rect });
    const { width, height } = rect;
    if (stride === width) return { width, height, data: planes.subarray(offset, offset + width * height) };
    if (grey.length !== width * height) grey = new Uint8Array(width * height);
    for (let row = 0; row < height; row++) {
      const start = offset + row * stride;
      grey.set(planes.subarray(start, start + width), row * width);
    }
    return { width, height, data: grey };
  }
  const [width, height] = "displayWidth" in frame
    ? [frame.displayWidth, frame.displayHeight]
    : [frame.width, frame.height];
  if (!canvas || canvas.canvas.width !== width || canvas.canvas.height !== height) {
    canvas = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    if (!canvas) throw new Error("this browser has no 2D canvas in workers");
    canvas.globalCompositeOperation = "copy"; // nothing of the frame before shines through
  }
  canvas.drawImage(frame, 0, 0);
  const { data } = canvas.getImageData(0, 0, width, height);
  if (grey.length !== width * height) grey = new Uint8Array(width * height);
  // ITU-R BT.601 luma in 16 bit fixed point, as cv::cvtColor has it.
  for (let i = 0, j = 0; i < grey.length; i++, j += 4) {
    grey[i] = (data[j] * 19595 + data[j + 1] * 38470 + data[j + 2] * 7471 + 32768) >> 16;
  }
  return { width, height, data: grey };
}

/** A frame that is shown as it is stored: no rotation, no stretched pixels. @param {VideoFrame} frame */
function upright(frame) {
  const { rotation = 0, flip = false } = /** @type {{rotation?: number, flip?: boolean}} */ (/** @type {unknown} */ (frame));
  return !rotation && !flip && frame.visibleRect?.width === frame.displayWidth
    && frame.visibleRect?.height === frame.displayHeight;
}

/** @param {OpenRequest | DetectRequest} request */
async function answer(request) {
  if ("open" in request) {
    cv ??= await loadOpenCV(request.wasm, request.bytes);
    finder?.delete();
    finder = createFinder(request.open);
    return {};
  }
  try {
    if (!finder) throw new Error("no board to look for");
    const start = performance.now();
    const image = await luma(request.frame);
    const found = finder.find(image, request.full);
    return {
      ...found,
      probe: request.probe && found.ids.length === 0 ? finder.probe(image, request.probe) : null,
      size: [image.width, image.height],
      elapsed: performance.now() - start,
      memory: finder.memory,
    };
  } finally {
    request.frame.close();
  }
}

/** @param {{close: true} | OpenRequest | DetectRequest} data */
async function reply(data) {
  if ("close" in data) return self.postMessage({ closed: true });
  try {
    self.postMessage({ id: data.id, result: await answer(data) });
  } catch (error) {
    // OpenCV throws numbers (addresses of C++ exceptions); the page needs words.
    const message = error instanceof Error ? error.message : `OpenCV failed (${String(error)})`;
    self.postMessage({ id: data.id, error: message, code: error instanceof LoadError ? error.code : undefined });
  }
}

/** One after the other: frames are read into the same memory, and the end comes when the last one was let go of. */
let last = Promise.resolve();
self.onmessage = ({ data }) => {
  last = last.then(() => reply(data));
};
