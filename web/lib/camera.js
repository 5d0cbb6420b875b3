// Cameras of the device: the list, opening one at its native resolution, and errors that a person can act on.
import { DetectorError } from "./detector.js";
import { t } from "./i18n.js";
import { isVirtual } from "./camera-name.js";
import { labelOf, setupFrom } from "./virtual/setup.js";

/**
 * @typedef {object} Choice
 * @property {string} id device id, "" for the browser's own choice, "virtual"; "environment" and "user" by where a
 *   phone's cameras face
 * @property {string} label
 * @property {boolean} [named] the browser reports its name, which it does once camera access is granted
 *
 * @typedef {object} OpenCamera
 * @property {MediaStream} stream
 * @property {MediaStreamTrack} track
 * @property {boolean} mirrored shown as a mirror: it faces the user
 * @property {boolean} cropped the browser cut or scaled the sensor's picture
 * @property {import("./virtual/camera.js").VirtualCamera | null} virtual
 * @property {() => void} close
 */

/** Codes name texts: `capture.fault_<code>`. */
export class CameraError extends Error {
  /** @param {string} code @param {string} [detail] */
  constructor(code, detail = "") {
    super(`${code}: ${detail}`);
    this.code = code;
    this.detail = detail;
  }
}

const FIRST_FRAME_TIMEOUT_MS = 15_000; // ms: five times as long as a slow camera takes

/** Meaning of getUserMedia's refusals. @type {Record<string, string>} */
const ERROR_CODES = {
  NotAllowedError: "not_allowed",
  SecurityError: "not_allowed",
  NotFoundError: "not_found",
  NotReadableError: "in_use",
  OverconstrainedError: "too_strict",
  AbortError: "interrupted", // Firefox's word for a camera that is in use
};

/** @param {URLSearchParams} parameters @returns {Promise<Choice[]>} */
export async function cameras(parameters) {
  const devices = (await navigator.mediaDevices?.enumerateDevices()) ?? [];
  const real = devices.filter(({ kind }) => kind === "videoinput");
  // Before permission is given labels are empty and there is at most one entry: the browser's own choice.
  const listed = real.map(({ deviceId, label }, index) => ({
    id: deviceId,
    label: label || t("capture.camera_number", { number: index + 1 }),
    named: label !== "",
  }));
  // Labels of a phone's cameras say little, and are empty before permission: the direction they face identifies them.
  const faces = real.length > 0 && !parameters.has("camera") && (parameters.has("facing") || isHandheld());
  const choices = faces ? [...facing(parameters.get("facing")), ...listed.filter(({ named }) => named)] : listed;
  return [...choices, { id: "virtual", label: labelOf(setupFrom(parameters)) }];
}

const isHandheld = () => globalThis.matchMedia?.("(pointer: coarse) and (hover: none)").matches ?? false;

/**
 * The cameras of a phone, the one that was asked for first.
 * @param {string | null} asked "user", or the rear one
 * @returns {Choice[]}
 */
function facing(asked) {
  const rear = { id: "environment", label: t("capture.rear_camera"), named: false };
  const front = { id: "user", label: t("capture.front_camera"), named: false };
  return asked === "user" ? [front, rear] : [rear, front];
}

/**
 * The camera to propose: the chosen one, else the requested one, else a real one. The virtual camera never replaces a
 * real one.
 * @param {readonly Choice[]} choices @param {string | null} asked label @param {string} chosen id, "" for none yet
 * @returns {string} id; "" for none
 */
export function propose(choices, asked, chosen) {
  const found =
    choices.find(({ id }) => id === chosen && chosen !== "") ?? choices.find(({ label }) => label === asked);
  const real = choices.find(({ id }) => id !== "virtual");
  return (found ?? real)?.id ?? (isVirtual(asked ?? "") ? "virtual" : "");
}

/**
 * Lists cameras in a select element, and proposes one. Until the browser has listed its cameras, nothing is said about
 * them.
 * @param {HTMLSelectElement} select
 * @param {readonly Choice[]} choices
 * @param {string | null} asked label of the camera that the page was opened for
 * @returns {boolean} true if it proposes none
 */
export function offerCameras(select, choices, asked) {
  const proposed = propose(choices, asked, select.value);
  select.replaceChildren(
    ...choices.map(({ id, label }) => new Option(id === "virtual" ? t("capture.virtual_name") : label, id)),
  );
  const isListed = choices.length > 0 && choices.every(({ id }) => id !== "");
  const none = proposed === "" && isListed;
  if (none) select.prepend(new Option(t("capture.no_camera"), ""));
  select.value = proposed;
  return none;
}

/**
 * @param {string} id of a choice
 * @param {{parameters: URLSearchParams, size: [number, number], place: HTMLElement, board:
 *   import("./board.js").Board}} options size: what to ask for, px; place: where the virtual camera may put its
 *   canvas
 * @returns {Promise<OpenCamera>}
 */
export async function open(id, { parameters, size: [width, height], place, board }) {
  if (id === "virtual") {
    const { VirtualCamera } = await import("./virtual/camera.js");
    const virtual = new VirtualCamera(setupFrom(parameters), place, board);
    return opened(await virtual.open(), virtual);
  }
  /** @type {MediaTrackConstraints & {resizeMode: string}} */
  const video = { width: { ideal: width }, height: { ideal: height }, resizeMode: "none" };
  if (id === "environment" || id === "user") video.facingMode = { ideal: id };
  else if (id) video.deviceId = { exact: id };
  return opened(await requestStream(video), null);
}

/**
 * A camera's stream, after the browser has asked for permission. Without permission cameras have no names.
 * @param {MediaTrackConstraints | true} video
 * @returns {Promise<MediaStream>} rejects with CameraError
 */
export async function requestStream(video) {
  if (!navigator.mediaDevices?.getUserMedia) throw new CameraError("insecure");
  try {
    return await navigator.mediaDevices.getUserMedia({ video, audio: false });
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    if (error instanceof OverconstrainedError && error.constraint === "deviceId") throw new CameraError("gone");
    throw new CameraError(ERROR_CODES[error.name] ?? "not_opened", error.message);
  }
}

/**
 * Shows what the camera sees.
 * @param {HTMLVideoElement} video @param {MediaStream} stream @param {number} [timeout] ms until its first picture
 */
export async function play(video, stream, timeout = FIRST_FRAME_TIMEOUT_MS) {
  video.srcObject = stream;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new CameraError("no_picture")), timeout);
  });
  await Promise.race([video.play(), late]).finally(() => clearTimeout(timer));
}

/**
 * @param {MediaStream} stream @param {import("./virtual/camera.js").VirtualCamera | null} virtual
 * @returns {OpenCamera}
 */
function opened(stream, virtual) {
  const [track] = stream.getVideoTracks();
  const { facingMode, resizeMode } = facts(track);
  return {
    stream,
    track,
    virtual,
    // Laptops and desktops report no facing: their cameras look at the user. The virtual one looks at a board.
    mirrored: !virtual && (facingMode === "user" || !facingMode),
    cropped: resizeMode === "crop-and-scale",
    close() {
      virtual?.close();
      for (const each of stream.getTracks()) each.stop();
    },
  };
}

/**
 * Locks focus and zoom, if the camera allows it: a hunting autofocus changes the focal length.
 * @param {MediaStreamTrack} track one that shows the board, so that the board is what it is focused on
 */
export async function lockFocus(track) {
  const { focusMode, zoom } = /** @type {{focusMode?: string[], zoom?: object}} */ (track.getCapabilities?.() ?? {});
  const { focusDistance, zoom: now } = /** @type {{focusDistance?: number, zoom?: number}} */ (track.getSettings());
  /** @type {Record<string, string | number>} */
  const wanted = {};
  if (focusMode?.includes("manual")) {
    wanted.focusMode = "manual";
    if (focusDistance !== undefined) wanted.focusDistance = focusDistance;
  }
  // Some cameras zoom to follow a face. Requesting the current zoom keeps it fixed.
  if (zoom && now !== undefined) wanted.zoom = now;
  if (Object.keys(wanted).length === 0) return;
  const constraints = /** @type {MediaTrackConstraints} */ (/** @type {unknown} */ ({ advanced: [wanted] }));
  // A camera that offers this and then refuses stays as it was. Its actual settings are recorded either way.
  await track.applyConstraints(constraints).catch((error) => console.info("focus not locked:", error.message));
}

/**
 * Further settings of the camera: recorded with the session, never part of the key.
 * @param {MediaStreamTrack} track
 */
export function facts(track) {
  const settings = /** @type {Record<string, string | number | undefined>} */ (track.getSettings());
  /** @type {Record<string, string | number>} */
  const known = {};
  for (const name of ["focusMode", "focusDistance", "facingMode", "resizeMode", "frameRate"]) {
    const value = settings[name];
    if (value !== undefined && value !== "") known[name] = value;
  }
  return known;
}

/**
 * Type of a lens, as the pages name it: a model of the service.
 * @typedef {"rectilinear" | "rational" | "fisheye" | "omnidirectional"} LensType
 */

/** The simplest first. @type {readonly LensType[]} */
export const LENS_TYPES = ["rectilinear", "rational", "fisheye", "omnidirectional"];

/** @param {string | null} name @returns {name is LensType} */
export const isLensType = (name) => LENS_TYPES.some((type) => type === name);

/**
 * Code of a message `capture.fault_<code>` about a camera or a board detector, and what the browser says.
 * @param {unknown} error @returns {{code: string, detail: string} | null} null: another error
 */
export function deviceFault(error) {
  if (error instanceof CameraError) return { code: error.code, detail: error.detail };
  if (error instanceof DetectorError) return { code: error.code, detail: error.message };
  return null;
}

/** @param {unknown} error @returns {string} "" for another error */
export function deviceFaultText(error) {
  const fault = deviceFault(error);
  return fault ? t(`capture.fault_${fault.code}`, { detail: fault.detail }) : "";
}
