// WebXR on a webcam, where the browser has none of its own or none for augmented reality.
//
//     import { install, isNeeded } from "https://<host>/webxr/install.js";
//     if (await isNeeded()) install({ video, pinhole: () => calibration });
//     const session = await navigator.xr.requestSession("immersive-ar");
import { SESSION, classes } from "../vendor/webxr/polyfill.js";
import { WebcamDevice } from "./device.js";

/** Is there nothing that can show augmented reality? */
export async function isNeeded() {
  const { xr } = /** @type {any} */ (navigator);
  try {
    return !(await xr?.isSessionSupported("immersive-ar"));
  } catch (error) {
    if (error instanceof DOMException) return true; // forbidden by a policy
    throw error;
  }
}

/**
 * Puts the webcam in the place of `navigator.xr`, the polyfill's classes in that of the browser's. Once a page.
 * @param {import("./device.js").Setup} setup
 * @returns {WebcamDevice}
 */
export function install(setup) {
  const device = new WebcamDevice(setup);
  const system = new Webcams(Promise.resolve(device));
  Object.assign(globalThis, classes);
  // Every context will do. Browsers that have the function would look for a headset, some without end.
  for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
    Object.defineProperty(prototype, "makeXRCompatible", { value: async () => {}, configurable: true, writable: true });
  }
  Object.defineProperty(navigator, "xr", { value: system, configurable: true });
  return device;
}

class Webcams extends classes.XRSystem {
  /** @param {string} mode @param {object} [init] @returns {Promise<object>} */
  async requestSession(mode, init) {
    await this.isSessionSupported(mode); // the polyfill insists on having been asked
    const session = await super.requestSession(mode, init);
    // The polyfill gives everything immersive two eyes; a phone in augmented reality has one, and so has a webcam.
    if (mode !== "inline") session[SESSION].viewSpaces.length = 1;
    return session;
  }
}
