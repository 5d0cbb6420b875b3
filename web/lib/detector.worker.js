// Worker that finds the board in camera frames and photographs: OpenCV blocks while it computes.
import createOpenCV from "../vendor/opencv/opencv.js";
import { createFinder } from "./board-finder.js";
import { flipped } from "./charuco-finder.js";

/**
 * @import { Board } from "./board.js"
 * @import { Grey } from "./subpixel.js"
 */

/**
 * @typedef {{id: number, open: Board, wasm: string, bytes: number}} OpenRequest
 * @typedef {{id: number, frame: VideoFrame | ImageBitmap, full: boolean, flip: boolean}} DetectRequest
 * @typedef {{id: number, frame: VideoFrame | ImageBitmap, recognise: true, flip: boolean}} RecogniseRequest
 */

/** @type {any} OpenCV's module */
let cv = null;
/** @type {import("./charuco-finder.js").Finder | null} */
let finder = null;
/** @type {import("./recogniser.js").Recogniser | null} loaded when it is first asked for: it knows all dictionaries */
let recogniser = null;

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
  if (!response.ok || !response.body)
    throw new LoadError(`OpenCV is not there (${response.status}).`, "detector_missing");
  let loaded = 0;
  let reported = 0;
  const counted = response.body.pipeThrough(
    new TransformStream({
      transform(chunk, controller) {
        loaded += chunk.length;
        if (loaded - reported > bytes / 50 || loaded === bytes) {
          reported = loaded;
          self.postMessage({ progress: loaded / bytes });
        }
        controller.enqueue(chunk);
      },
    }),
  );
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
  const [width, height] =
    "displayWidth" in frame ? [frame.displayWidth, frame.displayHeight] : [frame.width, frame.height];
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
  const { rotation = 0, flip = false } = /** @type {{rotation?: number, flip?: boolean}} */ (
    /** @type {unknown} */ (frame)
  );
  return (
    !rotation &&
    !flip &&
    frame.visibleRect?.width === frame.displayWidth &&
    frame.visibleRect?.height === frame.displayHeight
  );
}

/** @param {OpenRequest | DetectRequest | RecogniseRequest} request */
async function answer(request) {
  if ("open" in request) {
    cv ??= await loadOpenCV(request.wasm, request.bytes);
    finder?.delete();
    finder = createFinder(cv, request.open);
    return {};
  }
  try {
    if (!finder) throw new Error("no board to look for");
    const start = performance.now();
    const delivered = await luma(request.frame);
    const image = request.flip ? flipped(delivered) : delivered;
    if ("recognise" in request) {
      recogniser ??= new (await import("./recogniser.js")).Recogniser(cv);
      return recogniser.look(image);
    }
    return {
      ...finder.find(image, request.full),
      size: [image.width, image.height],
      elapsed: performance.now() - start,
      memory: finder.memory,
    };
  } finally {
    request.frame.close();
  }
}

/** @param {{close: true} | OpenRequest | DetectRequest | RecogniseRequest} data */
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
