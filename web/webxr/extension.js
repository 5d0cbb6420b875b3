// WebXR views that know their camera: intrinsics, lens distortion, and which model the latter is of.
//
//     import { extend } from "https://<host>/webxr/extension.js";
//     extend((session, model) => lookup(track, { token, model }).then(({ calibration }) => calibration));
//     // later, in a frame:
//     view.cameraMatrix; // Float32Array(9), column-major, or null
//     view.distortionCoefficients; // Float32Array, or null
//     view.distortionModel; // "rectilinear", …, or null
//     session.updateRenderState({ distortionModel: "fisheye" }); // from a later frame on
//
// docs/webxr.md explains it as a proposal; camera.js does the lookup, too, and rig.js shows two cameras to two eyes.
import { COEFFICIENTS } from "../sdk/projection.js";
import { viewAttributes } from "../sdk/views.js";

/**
 * @typedef {object} Intrinsics
 * @property {readonly number[][]} camera_matrix row-major 3x3, px
 * @property {readonly number[]} distortion_coefficients
 * @property {string} distortion_model
 * @property {readonly [number, number]} [img_size] of the picture that these are of, px
 *
 * @typedef {object} Attributes what a view says, all of one calibration
 * @property {Float32Array | null} cameraMatrix column-major 3x3
 * @property {Float32Array | null} distortionCoefficients
 * @property {string | null} distortionModel
 *
 * @typedef {[number, number]} Size width, height, px
 *
 * @typedef {{left: Intrinsics | null, right: Intrinsics | null}} Eyes of two cameras; a view without an eye is the left
 *   one's
 *
 * @typedef {(session: object, model: string, size: Size | null) => Promise<Intrinsics | Eyes | null>} Provider asked
 * for the calibration of a session's camera, or of both its cameras, null where none is known; `size`: of the picture
 * that raw camera access gives, where it does
 *
 * @typedef {object} Options
 * @property {any} [global] where the WebXR classes are
 * @property {string} [model] of sessions that ask for none
 * @property {(known: Intrinsics) => boolean} [holds] called in each frame; true if the intrinsics are those of
 *   the picture shown
 * @property {(error: unknown) => void} [onError] called with a provider's error; the views stay as they were
 *
 * @typedef {object} State of a session
 * @property {string} model wanted
 * @property {Size | null} size
 * @property {number} asked how often
 * @property {boolean} failed the last time
 * @property {Eyes} known
 */

/** @type {Attributes} */
const UNKNOWN = { cameraMatrix: null, distortionCoefficients: null, distortionModel: null };
/** @type {Eyes} */
const NEITHER = { left: null, right: null };

/**
 * Adds the attributes to XRView, and `distortionModel` to XRRenderState. A second call changes the provider.
 * @param {Provider} provider @param {Options} [options]
 * @returns {(session?: object) => Promise<void>} asks the provider again, for all running sessions by default: the
 *   camera has changed
 */
export function extend(
  provider,
  { global = globalThis, model = "rectilinear", holds = () => true, onError = console.warn } = {},
) {
  const { XRView, XRFrame, XRSession, XRRenderState } = global;
  if (!XRView) throw new TypeError("there is no WebXR here: install() the polyfill first");
  const first = checked(model);
  /** @type {WeakMap<object, Attributes>} */
  const views = new WeakMap();
  /** @type {WeakMap<object, object>} */
  const owners = new WeakMap();
  /** @type {WeakMap<object, State>} */
  const states = new WeakMap();
  /** @type {Set<object>} */
  const running = new Set();

  const stateOf = (/** @type {any} */ session) => {
    const found = states.get(session);
    if (found) return found;
    /** @type {State} */
    const state = { model: first, size: null, asked: 0, failed: false, known: NEITHER };
    states.set(session, state);
    running.add(session);
    session.addEventListener("end", () => running.delete(session));
    return state;
  };
  const ask = async (/** @type {object} */ session) => {
    const state = stateOf(session);
    const own = ++state.asked;
    // An answer after a newer request, or after the end, is ignored.
    const late = () => own !== state.asked || !running.has(session);
    try {
      const known = await provider(session, state.model, state.size);
      if (late()) return;
      state.known = eyesOf(known);
      state.failed = false;
    } catch (error) {
      if (late()) return;
      state.failed = true;
      onError(error);
    }
  };

  const { getViewerPose } = original(XRFrame.prototype, "getViewerPose");
  XRFrame.prototype.getViewerPose = wrapping(getViewerPose, function (/** @type {any} */ ...space) {
    const pose = getViewerPose.apply(this, space);
    if (!pose) return pose;
    const state = stateOf(this.session);
    const camera = pose.views.find((/** @type {any} */ view) => view.camera)?.camera;
    const turned = camera && !sameSize(state.size, camera);
    if (turned) state.size = [camera.width, camera.height];
    if (turned || state.asked === 0) void ask(this.session);
    // As it is in this frame: a view does not change its camera while it is drawn.
    for (const view of pose.views) {
      const known = view.eye === "right" ? state.known.right : state.known.left;
      views.set(view, attributesOf(view, known && holds(known) ? known : null));
    }
    return pose;
  });
  for (const name of /** @type {(keyof Attributes)[]} */ (Object.keys(UNKNOWN))) {
    attribute(XRView.prototype, name, function () {
      return views.get(this)?.[name] ?? null;
    });
  }

  const { updateRenderState } = original(XRSession.prototype, "updateRenderState");
  XRSession.prototype.updateRenderState = wrapping(updateRenderState, function (/** @type {any} */ init = {}) {
    const wanted = init?.distortionModel === undefined ? undefined : checked(init.distortionModel);
    updateRenderState.call(this, init ?? {});
    const state = stateOf(this);
    if (wanted === undefined || (wanted === state.model && !state.failed)) return;
    state.model = wanted;
    if (state.asked > 0) void ask(this); // else with the first frame
  });
  const renderState = getter(XRSession.prototype, "renderState");
  attribute(
    XRSession.prototype,
    "renderState",
    wrapping(renderState, function () {
      const made = renderState.call(this);
      owners.set(made, this);
      return made;
    }),
  );
  attribute(XRRenderState.prototype, "distortionModel", function () {
    const session = owners.get(this);
    return session ? stateOf(session).model : null;
  });
  return async (session) => {
    const asked = session ? [session] : [...running];
    await Promise.all(asked.map(ask));
  };
}

/**
 * The intrinsics behind a projection matrix, of a picture that fills its view: those of raw camera access.
 * @param {ArrayLike<number>} p column-major 4x4 @param {number} width px @param {number} height
 * @returns {number[]} column-major 3x3; the centre of the top-left pixel is (0, 0)
 */
export function matrixOf(p, width, height) {
  return [
    (p[0] * width) / 2,
    0,
    0,
    0,
    (p[5] * height) / 2,
    0,
    ((1 - p[8]) * width - 1) / 2,
    ((1 + p[9]) * height - 1) / 2,
    1,
  ];
}

/**
 * The provider's intrinsics come first, but not of another picture; then the browser's own, which say nothing of
 * distortion.
 */
function attributesOf(/** @type {any} */ view, /** @type {Intrinsics | null} */ known) {
  const { camera } = view;
  if (known && (!camera || !known.img_size || sameSize(known.img_size, camera))) return viewAttributes(known);
  if (!camera) return UNKNOWN;
  return { ...UNKNOWN, cameraMatrix: Float32Array.from(matrixOf(view.projectionMatrix, camera.width, camera.height)) };
}

/** @param {Intrinsics | Eyes | null} known @returns {Eyes} throws a TypeError for what no view could say */
function eyesOf(known) {
  if (!known) return NEITHER;
  if (!("left" in known)) return { left: usable(known), right: known };
  return { left: known.left && usable(known.left), right: known.right && usable(known.right) };
}

/** @param {Intrinsics} intrinsics @returns {Intrinsics} itself; throws a TypeError for what no view could say */
function usable(intrinsics) {
  const { camera_matrix: k, distortion_coefficients: d, distortion_model } = intrinsics;
  const numbers = [...k.flat(), ...d];
  const complete = numbers.length === 9 + COEFFICIENTS[checked(distortion_model)].length && k.length === 3;
  if (!complete || !numbers.every(Number.isFinite)) throw new TypeError("the provider's calibration is incomplete");
  return intrinsics;
}

/** As an enumeration of IDL does. @param {unknown} model @returns {string} */
function checked(model) {
  const name = `${model}`;
  if (!Object.hasOwn(COEFFICIENTS, name)) throw new TypeError(`'${name}' is not a distortion model`);
  return name;
}

/** @param {readonly [number, number] | null} size @param {{width: number, height: number}} camera */
function sameSize(size, { width, height }) {
  return size?.[0] === width && size[1] === height;
}

const WRAPPED = Symbol("what stood here before calibDB");

/**
 * Remembers what it stands for, so that a second call does not wrap it twice.
 * @param {any} before @param {(this: any, ...parameters: any[]) => any} after
 */
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

/** True if the browser has nothing of its own that can show augmented reality. */
export async function isNeeded() {
  const { xr } = /** @type {any} */ (navigator);
  try {
    return !(await xr?.isSessionSupported("immersive-ar"));
  } catch (error) {
    if (error instanceof DOMException) return true; // forbidden by a policy
    throw error;
  }
}
