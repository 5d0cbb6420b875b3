// A webcam as a WebXR device: its video behind the layer, its intrinsics in the projection, its pose that of the tracker.
import { projectionMatrix } from "../sdk/calibration.js";
import { XRDevice } from "../vendor/webxr/polyfill.js";

/**
 * @typedef {import("../sdk/straight.js").Pinhole} Pinhole
 *
 * @typedef {object} Setup
 * @property {HTMLVideoElement} video playing the camera
 * @property {() => Pinhole | null} pinhole what is known of the camera; null: nothing
 * @property {() => Float32Array | null} [pose] camera → world, column-major, the camera looking along −z; null: at the origin
 * @property {HTMLElement} [place] where immersive sessions are shown: the page's body unless told
 *
 * @typedef {object} Session
 * @property {boolean} immersive
 * @property {Set<string>} features
 * @property {any} layer
 * @property {(() => void) | null} leave takes away what is shown
 */

const FIELD_OF_VIEW = 60; // degrees from left to right, where nothing is known: webcams have 50 to 78
const SPACES = ["viewer", "local"];
const FEATURES = [...SPACES, "dom-overlay", "camera-access"];
const IDENTITY = Float32Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);

export class WebcamDevice extends XRDevice {
  #setup;
  /** @type {Map<number, Session>} */
  #sessions = new Map();
  #last = 0;
  /** By the eye that the polyfill asks for. @type {Record<string, Float32Array>} */
  #projections = { none: IDENTITY, left: IDENTITY, right: IDENTITY };

  /** @param {Setup} setup */
  constructor(setup) {
    super(globalThis);
    this.#setup = setup;
    this.environmentBlendMode = "alpha-blend";
  }

  /** @param {string} mode */
  isSessionSupported(mode) {
    return mode === "inline" || mode === "immersive-ar";
  }

  /** @param {string} feature */
  isFeatureSupported(feature) {
    return FEATURES.includes(feature);
  }

  /** @param {string} mode @param {Set<string>} features @returns {Promise<number>} its id */
  async requestSession(mode, features) {
    if (!this.isSessionSupported(mode)) throw new DOMException(`${mode} is not supported`, "NotSupportedError");
    const id = ++this.#last;
    this.#sessions.set(id, { immersive: mode !== "inline", features, layer: null, leave: null });
    if (mode !== "inline") this.dispatchEvent("@@webxr-polyfill/vr-present-start", id);
    return id;
  }

  /** @param {number} id @param {string} type */
  doesSessionSupportReferenceSpace(id, type) {
    return SPACES.includes(type) && this.#sessions.get(id)?.features.has(type) === true;
  }

  /** @returns {Promise<void>} the polyfill's own, then */
  async requestFrameOfReferenceTransform() {}

  requestStageBounds() {
    return null;
  }

  /** @param {FrameRequestCallback} callback */
  requestAnimationFrame(callback) {
    return globalThis.requestAnimationFrame(callback);
  }

  /** @param {number} handle */
  cancelAnimationFrame(handle) {
    globalThis.cancelAnimationFrame(handle);
  }

  /** @param {number} id @param {any} layer */
  onBaseLayerSet(id, layer) {
    const session = this.#sessions.get(id);
    if (!session) return;
    session.leave?.();
    session.layer = layer;
    session.leave = session.immersive ? this.#show(layer.context.canvas) : null;
  }

  /** @param {number} id @param {{depthNear: number, depthFar: number, inlineVerticalFieldOfView: number | null}} state */
  onFrameStart(id, { depthNear: near, depthFar: far, inlineVerticalFieldOfView: angle }) {
    const session = this.#sessions.get(id);
    if (!session?.layer) return;
    const { drawingBufferWidth: width, drawingBufferHeight: height } = session.layer.context;
    const viewport = /** @type {[number, number]} */ ([width, height]);
    const pinhole = session.immersive ? this.#setup.pinhole() ?? this.#guess() : inline(viewport, angle ?? Math.PI / 2);
    const matrix = Float32Array.from(projectionMatrix(pinhole, { near, far, viewport, fit: "cover" }));
    for (const eye of session.immersive ? ["left", "right"] : ["none"]) this.#projections[eye] = matrix;
  }

  onFrameEnd() {}

  /** @param {number} id */
  async endSession(id) {
    const session = this.#sessions.get(id);
    if (!session) return;
    session.leave?.();
    this.#sessions.delete(id);
    if (session.immersive) this.dispatchEvent("@@webxr-polyfill/vr-present-end", id);
  }

  /** @param {number} id @param {string} eye @param {any} layer @param {{x: number, y: number, width: number, height: number}} target */
  getViewport(id, eye, layer, target) {
    if (eye === "right") return false; // a camera has one
    const { drawingBufferWidth: width, drawingBufferHeight: height } = layer.context;
    Object.assign(target, { x: 0, y: 0, width, height });
    return true;
  }

  /** @param {string} eye */
  getProjectionMatrix(eye) {
    return this.#projections[eye];
  }

  getBasePoseMatrix() {
    return this.#setup.pose?.() ?? IDENTITY;
  }

  getBaseViewMatrix() {
    return inverse(this.getBasePoseMatrix());
  }

  getInputSources() {
    return [];
  }

  getInputPose() {
    return null;
  }

  onWindowResize() {}

  /** The video and the layer over it, on all of the window. @param {HTMLCanvasElement} canvas @returns {() => void} puts all back */
  #show(canvas) {
    const { video, place = document.body } = this.#setup;
    const stage = document.createElement("div");
    const full = { position: "fixed", inset: "0", width: "100%", height: "100%", objectFit: "cover", margin: "0" };
    Object.assign(stage.style, full, { zIndex: "2147483647", background: "black" });
    const homes = [video, canvas].map((element) => {
      const { parentNode, nextSibling } = element;
      const style = element.getAttribute("style");
      Object.assign(element.style, full);
      stage.append(element);
      return () => {
        if (style === null) element.removeAttribute("style");
        else element.style.cssText = style;
        if (parentNode) parentNode.insertBefore(element, nextSibling?.parentNode === parentNode ? nextSibling : null);
        else element.remove();
      };
    });
    place.append(stage);
    void video.play(); // moving it has paused it
    return () => {
      for (const home of homes) home();
      stage.remove();
      void video.play();
    };
  }

  /** @returns {Pinhole} */
  #guess() {
    const { videoWidth: width, videoHeight: height } = this.#setup.video;
    const f = width / 2 / Math.tan((FIELD_OF_VIEW / 360) * Math.PI);
    return { img_size: [width, height], camera_matrix: [[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1]] };
  }
}

/** @param {[number, number]} size @param {number} angle from top to bottom, radians @returns {Pinhole} */
function inline(size, angle) {
  const f = size[1] / 2 / Math.tan(angle / 2);
  return { img_size: size, camera_matrix: [[f, 0, (size[0] - 1) / 2], [0, f, (size[1] - 1) / 2], [0, 0, 1]] };
}

/** Of a rigid motion. @param {ArrayLike<number>} m column-major 4x4 */
function inverse(m) {
  const moved = [0, 1, 2].map((row) => -(m[4 * row] * m[12] + m[4 * row + 1] * m[13] + m[4 * row + 2] * m[14]));
  return Float32Array.of(m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, ...moved, 1);
}
