// WebXR views that know their camera: intrinsics, lens distortion, and which model the latter is of.
//
//     import { extend } from "https://<host>/webxr/extension.js";
//     extend((session, model) => lookup(track, { token, model }).then(({ calibration }) => calibration));
//     // later, in a frame:
//     view.cameraMatrix; // Float32Array(9), column-major, or null
//     view.distortionCoefficients; // Float32Array, or null
//     view.distortionModel; // "rectilinear", …, or null
//     session.updateRenderState({ distortionModel: "fisheye" }); // from a later frame on
import { COEFFICIENTS } from "../sdk/projection.js";

/**
 * @typedef {object} Intrinsics
 * @property {readonly number[][]} camera_matrix row-major 3x3
 * @property {readonly number[]} distortion_coefficients
 * @property {string} distortion_model
 *
 * @typedef {object} Snapshot what a view says, all of one calibration
 * @property {Float32Array | null} cameraMatrix
 * @property {Float32Array | null} distortionCoefficients
 * @property {string | null} distortionModel
 *
 * @typedef {(session: object, model: string) => Promise<Intrinsics | null>} Provider asked for the calibration of a session's camera;
 *   null where none is known
 *
 * @typedef {object} Options
 * @property {any} [global] where the WebXR classes are
 * @property {string} [model] of sessions that ask for none
 * @property {(error: unknown) => void} [onError] told what a provider rejected with; the views stay as they were
 */

/** @type {Snapshot} */
const UNKNOWN = { cameraMatrix: null, distortionCoefficients: null, distortionModel: null };

/**
 * Adds the attributes to XRView, and `distortionModel` to XRRenderState. A second call changes the provider.
 * @param {Provider} provider @param {Options} [options]
 * @returns {(session: object) => Promise<void>} asks the provider again: the camera's picture has changed
 */
export function extend(provider, { global = globalThis, model = "rectilinear", onError = console.warn } = {}) {
  const { XRView, XRFrame, XRSession, XRRenderState } = global;
  if (!XRView) throw new TypeError("there is no WebXR here: install() the polyfill first");
  /** @type {WeakMap<object, Snapshot>} */
  const views = new WeakMap();
  /** @type {WeakMap<object, object>} */
  const sessions = new WeakMap();
  /** @type {WeakMap<object, {model: string, asked: number, known: Snapshot}>} */
  const states = new WeakMap();

  const stateOf = (/** @type {object} */ session) => {
    const found = states.get(session);
    if (found) return found;
    const state = { model, asked: 0, known: UNKNOWN };
    states.set(session, state);
    void ask(session);
    return state;
  };
  const ask = async (/** @type {object} */ session) => {
    const state = stateOf(session);
    const own = ++state.asked;
    try {
      const known = await provider(session, state.model);
      // What was asked for before something else comes too late.
      if (own === state.asked) state.known = known ? snapshot(known) : UNKNOWN;
    } catch (error) {
      onError(error);
    }
  };

  const { getViewerPose } = original(XRFrame.prototype, "getViewerPose");
  XRFrame.prototype.getViewerPose = wrapping(getViewerPose, function (/** @type {any} */ ...space) {
    const pose = getViewerPose.apply(this, space);
    const { known } = stateOf(this.session);
    // As it is in this frame: a view does not change its camera while it is drawn.
    for (const view of pose?.views ?? []) views.set(view, known === UNKNOWN ? ofRawCamera(view) : known);
    return pose;
  });
  for (const name of /** @type {(keyof Snapshot)[]} */ (Object.keys(UNKNOWN))) {
    attribute(XRView.prototype, name, function () {
      return views.get(this)?.[name] ?? null;
    });
  }

  const { updateRenderState } = original(XRSession.prototype, "updateRenderState");
  XRSession.prototype.updateRenderState = wrapping(updateRenderState, function ({ distortionModel, ...init } = {}) {
    if (distortionModel !== undefined && !(distortionModel in COEFFICIENTS)) {
      throw new TypeError(`'${distortionModel}' is not a distortion model`);
    }
    updateRenderState.call(this, init);
    const state = stateOf(this);
    if (distortionModel === undefined || distortionModel === state.model) return;
    state.model = distortionModel;
    void ask(this);
  });
  const renderState = getter(XRSession.prototype, "renderState");
  attribute(XRSession.prototype, "renderState", wrapping(renderState, function () {
    const made = renderState.call(this);
    sessions.set(made, this);
    return made;
  }));
  attribute(XRRenderState.prototype, "distortionModel", function () {
    const session = sessions.get(this);
    return session ? stateOf(session).model : null;
  });
  return ask;
}

/**
 * The intrinsics behind a projection matrix, of a picture that fills its view: what raw camera access tells.
 * @param {ArrayLike<number>} p column-major 4x4 @param {number} width px @param {number} height
 * @returns {number[]} column-major 3x3; the centre of the top-left pixel is (0, 0)
 */
export function matrixOf(p, width, height) {
  return [(p[0] * width) / 2, 0, 0, 0, (p[5] * height) / 2, 0, ((1 - p[8]) * width - 1) / 2, ((1 + p[9]) * height - 1) / 2, 1];
}

/** Nothing is known but what the browser itself knows; of distortion it says nothing. @param {any} view @returns {Snapshot} */
function ofRawCamera({ camera, projectionMatrix }) {
  if (!camera) return UNKNOWN;
  return { ...UNKNOWN, cameraMatrix: Float32Array.from(matrixOf(projectionMatrix, camera.width, camera.height)) };
}

/** @param {Intrinsics} intrinsics @returns {Snapshot} */
function snapshot({ camera_matrix: k, distortion_coefficients, distortion_model }) {
  return {
    cameraMatrix: Float32Array.from([0, 1, 2].flatMap((column) => k.map((row) => row[column]))),
    distortionCoefficients: Float32Array.from(distortion_coefficients),
    distortionModel: distortion_model,
  };
}

const WRAPPED = Symbol("what stood here before calibDB");

/** Remembers what it stands for, so that a second call does not wrap it twice. @param {any} before @param {(this: any, ...parameters: any[]) => any} after */
function wrapping(before, after) {
  return Object.assign(after, { [WRAPPED]: before });
}

/** @param {any} prototype @param {string} name @returns {Record<string, (this: any, ...parameters: any[]) => any>} */
function original(prototype, name) {
  return { [name]: prototype[name][WRAPPED] ?? prototype[name] };
}

/** @param {any} prototype @param {string} name @returns {(this: any) => any} */
function getter(prototype, name) {
  const get = /** @type {any} */ (Object.getOwnPropertyDescriptor(prototype, name)?.get);
  return get[WRAPPED] ?? get;
}

/** @param {any} prototype @param {string} name @param {(this: any) => any} get */
function attribute(prototype, name, get) {
  Object.defineProperty(prototype, name, { get, configurable: true, enumerable: true });
}
