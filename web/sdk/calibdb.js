// calibDB for web applications: the calibration of the camera that a page has open, and of several cameras together.
//
//     import { lookup } from "https://<host>/sdk/calibdb.js";
//     const { calibration, guidanceUrl } = await lookup(track, { token });
//
// Modules without dependencies; what is imported from here alone is all that is loaded, but for what works on the GPU,
// which
// `calibration.rectifier()` and `rectifyPair()` load.

/**
 * @typedef {import("./key.js").CameraKey} CameraKey
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 * @typedef {import("./calibration.js").Adapted} Adapted
 * @typedef {import("./calibration.js").CameraData} CameraData
 * @typedef {import("./calibration.js").EstimateData} EstimateData
 * @typedef {import("./pinhole.js").Frustum} Frustum
 * @typedef {import("./lookup.js").Answer} Answer
 * @typedef {import("./lookup.js").Options} Options
 * @typedef {import("./rig.js").RigData} RigData
 * @typedef {import("./rig.js").Pose} Pose
 * @typedef {import("./stereo.js").TwoCameras} TwoCameras
 * @typedef {import("./pair-rectifier.js").PairRectifier} PairRectifier
 * @typedef {import("./views.js").View} View
 */
export { Calibration, Estimate } from "./calibration.js";
export { calibrate, returned } from "./guidance.js";
export { cameraKey, platformHere, platformOf } from "./key.js";
export { lookup, watch } from "./lookup.js";
export { projectionMatrix } from "./pinhole.js";
export { UnknownModelError, lensOf } from "./projection.js";
export { LookupError } from "./request.js";
export { Rig, rectifyPair, rig } from "./rig.js";
