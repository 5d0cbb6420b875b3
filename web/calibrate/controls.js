// Buttons of the capture page, and what they do.
import { watchPopovers } from "./popovers.js";
import { renderChoice } from "./render.js";

/**
 * @typedef {"resume" | "changeModel" | "restart" | "stop" | "forget" | "useBoard" | "wantBoard" | "practise" |
 *   "leavePractice" | "again"
 *   | "escape" | "listCameras"} Action
 */

/** @param {import("./parts.js").Parts} parts @param {Record<Action, () => unknown>} actions */
export function connectControls(parts, actions) {
  const on = (/** @type {HTMLElement[]} */ buttons, /** @type {() => unknown} */ action) => {
    for (const button of buttons) button.addEventListener("click", () => void action());
  };
  on([parts.goOn], actions.resume);
  on(parts.models, actions.changeModel);
  on([parts.startVirtual, parts.failedVirtual], actions.practise);
  on([parts.cancel, parts.other], actions.restart);
  on([parts.again], actions.again);
  on([parts.goOnReally], actions.leavePractice);
  on([parts.useBoard], actions.useBoard);
  on([parts.rightBoard], actions.wantBoard);
  for (const select of [parts.camera, parts.resolution, parts.lens])
    select.addEventListener("change", () => renderChoice(parts));
  navigator.mediaDevices?.addEventListener("devicechange", actions.listCameras);
  // A phone may have taken the camera away meanwhile.
  document.addEventListener("visibilitychange", () => void (document.hidden || actions.listCameras()));
  watchPopovers(() => void actions.escape());
  // A double click counts once where what is lost does not come back.
  for (const [button, action] of /** @type {const} */ ([
    [parts.stop, actions.stop],
    [parts.forget, actions.forget],
  ])) {
    button.addEventListener("click", ({ detail }) => void (detail < 2 && action()));
  }
}
