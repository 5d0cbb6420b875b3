// A webcam as a WebXR device: its video behind the layer, its intrinsics in the projection, its pose that of the
// tracker. Two cameras of a rig are two eyes, side by side.
import { projectionMatrix } from "../sdk/pinhole.js";
import { XRDevice } from "../vendor/webxr/polyfill.js";
import { Stage } from "./stage.js";

/**
 * @import { Pinhole } from "../sdk/pinhole.js"
 * @import { View, ViewOptions } from "../sdk/views.js"
 */

/**
 * @typedef {object} Setup
 * @property {HTMLVideoElement} video playing the camera
 * @property {() => Pinhole | null} pinhole what is known of the camera; null: nothing
 * @property {() => Float32Array | null} [pose] camera → world, column-major, the camera looking along −z; null: at the
 *   origin
 * @property {() => Straight | null} [straight] what straightens the picture, and is shown in its place; null: nothing
 *   yet
 * @property {Eyes} [eyes] two cameras in the place of the video's, in immersive sessions
 * @property {HTMLElement} [place] where immersive sessions are shown: the page's body by default
 *
 * @typedef {Pinhole & {canvas: HTMLCanvasElement | OffscreenCanvas, draw: (video: HTMLVideoElement) => void}} Straight
 *   a Rectifier
 *
 * @typedef {object} Eyes
 * @property {HTMLElement} element with the pictures of both, each in its half
 * @property {() => void} draw
 * @property {(options: ViewOptions) => View[]} views
 *
 * @typedef {object} Session
 * @property {boolean} immersive
 * @property {Set<string>} features
 * @property {any} layer
 * @property {HTMLElement | null} overlay what of the page stays over it
 * @property {Stage | null} stage where it is shown
 * @property {AbortController} over ends what listens for it
 */

const FIELD_OF_VIEW = 60; // degrees from left to right, where nothing is known: webcams have 50 to 78
const SPACES = ["viewer", "local", "local-floor"]; // the floor is where the polyfill thinks it, 1.6 m below
const FEATURES = [...SPACES, "dom-overlay"];
const IDENTITY = Float32Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);

export class WebcamDevice extends XRDevice {
  #setup;
  /** @type {Map<number, Session>} */
  #sessions = new Map();
  #last = 0;
  /** By the eye that the polyfill asks for. @type {Record<string, Float32Array>} */
  #projections = { none: IDENTITY, left: IDENTITY, right: IDENTITY };
  /** World → eye, of two eyes. @type {Record<string, Float32Array>} */
  #inverses = {};

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
    const running = [...this.#sessions.values()].some(({ immersive }) => immersive);
    if (mode !== "inline" && running)
      throw new DOMException("there is an immersive session already", "InvalidStateError");
    const id = ++this.#last;
    const over = new AbortController();
    this.#sessions.set(id, { immersive: mode !== "inline", features, layer: null, overlay: null, stage: null, over });
    if (mode === "inline") return id;
    this.dispatchEvent("@@webxr-polyfill/vr-present-start", id);
    // As browsers do: the page's own buttons are covered.
    addEventListener("keydown", ({ key }) => key === "Escape" && this.endSession(id), { signal: over.signal });
    return id;
  }

  /** Number of views of an immersive session. */
  get count() {
    return this.#setup.eyes ? 2 : 1;
  }

  /** @param {number} id @returns {string[]} what the session was given */
  featuresOf(id) {
    return [...(this.#sessions.get(id)?.features ?? [])];
  }

  /** Part of the page that stays over the session. @param {number} id @param {HTMLElement} root */
  setOverlay(id, root) {
    const session = this.#sessions.get(id);
    if (session) session.overlay = root;
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
    if (!session || session.layer === layer) return; // called again with every change of the render state
    session.stage?.leave();
    session.layer = layer;
    const { video, place = document.body } = this.#setup;
    session.stage = session.immersive ? new Stage(place, video, layer.context.canvas, session.overlay) : null;
  }

  /**
   * @param {number} id
   * @param {{depthNear: number, depthFar: number, inlineVerticalFieldOfView: number | null}} state
   */
  onFrameStart(id, { depthNear: near, depthFar: far, inlineVerticalFieldOfView: angle }) {
    const session = this.#sessions.get(id);
    if (!session?.layer) return;
    const { drawingBufferWidth: width, drawingBufferHeight: height } = session.layer.context;
    const viewport = session.stage?.size ?? [width, height];
    const { eyes } = this.#setup;
    if (session.stage && eyes)
      return this.#look(session.stage, eyes, { near, far, viewport: [viewport[0] / 2, viewport[1]] });
    const pinhole = session.stage ? this.#shown(session.stage) : inline(viewport, angle ?? Math.PI / 2);
    const matrix = Float32Array.from(projectionMatrix(pinhole, { near, far, viewport, fit: "cover" }));
    for (const eye of session.immersive ? ["left", "right"] : ["none"]) this.#projections[eye] = matrix;
  }

  onFrameEnd() {}

  /** @param {number} id */
  async endSession(id) {
    const session = this.#sessions.get(id);
    if (!session) return;
    session.stage?.leave();
    session.over.abort();
    this.#sessions.delete(id);
    if (session.immersive) this.dispatchEvent("@@webxr-polyfill/vr-present-end", id);
  }

  /**
   * @param {number} id
   * @param {string} eye
   * @param {any} layer
   * @param {{x: number, y: number, width: number, height: number}} target
   */
  getViewport(id, eye, layer, target) {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = layer.context;
    if (this.#sessions.get(id)?.immersive && this.#setup.eyes) {
      const half = width >> 1;
      Object.assign(target, { x: eye === "right" ? half : 0, y: 0, width: half, height });
      return true;
    }
    if (eye === "right") return false; // a camera has one
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

  /** @param {string} eye */
  getBaseViewMatrix(eye) {
    return this.#inverses[eye] ?? inverse(this.getBasePoseMatrix());
  }

  getInputSources() {
    return [];
  }

  getInputPose() {
    return null;
  }

  onWindowResize() {}

  /**
   * Shows both cameras, and sees as they do.
   * @param {Stage} stage @param {Eyes} eyes @param {ViewOptions} frustum of each half
   */
  #look(stage, eyes, frustum) {
    stage.cover(eyes.element);
    eyes.draw();
    for (const { eye, projectionMatrix: matrix, transform } of eyes.views({
      ...frustum,
      fit: "cover",
      pose: this.getBasePoseMatrix(),
    })) {
      this.#projections[eye] = matrix;
      this.#inverses[eye] = transform.inverse.matrix;
    }
  }

  /**
   * Pinhole of the picture behind the layer, which is drawn to match it.
   * @param {Stage} stage
   * @returns {Pinhole}
   */
  #shown(stage) {
    const { video, pinhole, straight } = this.#setup;
    const straightened = straight?.();
    stage.cover(straightened?.canvas);
    if (!straightened) return pinhole() ?? this.#guess();
    if (video.readyState >= HTMLMediaElement.HAVE_CURRENT_DATA) straightened.draw(video);
    return straightened;
  }

  /** @returns {Pinhole} */
  #guess() {
    const { videoWidth: width, videoHeight: height } = this.#setup.video;
    const f = width / 2 / Math.tan((FIELD_OF_VIEW / 360) * Math.PI);
    return {
      img_size: [width, height],
      camera_matrix: [
        [f, 0, (width - 1) / 2],
        [0, f, (height - 1) / 2],
        [0, 0, 1],
      ],
    };
  }
}

/** @param {[number, number]} size @param {number} angle from top to bottom, radians @returns {Pinhole} */
function inline(size, angle) {
  const f = size[1] / 2 / Math.tan(angle / 2);
  return {
    img_size: size,
    camera_matrix: [
      [f, 0, (size[0] - 1) / 2],
      [0, f, (size[1] - 1) / 2],
      [0, 0, 1],
    ],
  };
}

/** Of a rigid motion. @param {ArrayLike<number>} m column-major 4x4 */
function inverse(m) {
  const moved = [0, 1, 2].map((row) => -(m[4 * row] * m[12] + m[4 * row + 1] * m[13] + m[4 * row + 2] * m[14]));
  return Float32Array.of(m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, ...moved, 1);
}
