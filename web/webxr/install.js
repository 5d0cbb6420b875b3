// WebXR on a webcam, where the browser has none of its own or none for augmented reality.
//
//     import { install, isNeeded } from "https://<host>/webxr/install.js";
//     if (await isNeeded()) install({ video, pinhole: () => calibration });
//     const session = await navigator.xr.requestSession("immersive-ar");
import { SESSION, classes } from "../vendor/webxr/polyfill.js";
import { WebcamDevice } from "./device.js";

export { isNeeded } from "./extension.js";

/**
 * Puts the webcam in the place of `navigator.xr`, the polyfill's classes in that of the browser's. What is installed
 * later serves the sessions that begin later.
 * @param {import("./device.js").Setup} setup
 * @returns {WebcamDevice}
 */
export function install(setup) {
  const device = new WebcamDevice(setup);
  const system = new Webcams(device);
  // The browser's other classes do not know these: a page that finds XRWebGLBinding would hand our session to it.
  for (const name of Object.getOwnPropertyNames(globalThis))
    if (/^XR[A-Z]/.test(name)) Reflect.deleteProperty(globalThis, name);
  Object.assign(globalThis, classes);
  // Every context will do. Browsers that have the function would look for a headset, some without end.
  for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
    Object.defineProperty(prototype, "makeXRCompatible", { value: async () => {}, configurable: true, writable: true });
  }
  Object.defineProperty(navigator, "xr", { value: system, configurable: true });
  return device;
}

class Webcams extends classes.XRSystem {
  #device;

  /** @param {WebcamDevice} device */
  constructor(device) {
    super(Promise.resolve(device));
    this.#device = device;
  }

  /** @param {string} mode @param {{domOverlay?: {root: HTMLElement}}} [init] @returns {Promise<object>} */
  async requestSession(mode, init) {
    await this.isSessionSupported(mode); // the polyfill insists on having been asked
    const session = await super.requestSession(mode, init);
    const { id, viewSpaces } = session[SESSION];
    // The polyfill gives everything immersive two eyes; a phone in augmented reality has one, and so has a webcam.
    if (mode !== "inline") viewSpaces.length = this.#device.count;
    const enabledFeatures = this.#device.featuresOf(id);
    Object.assign(session, { enabledFeatures });
    const root = init?.domOverlay?.root;
    if (root && enabledFeatures.includes("dom-overlay")) {
      this.#device.setOverlay(id, root);
      Object.assign(session, { domOverlayState: { type: "screen" } });
    }
    return session;
  }
}
