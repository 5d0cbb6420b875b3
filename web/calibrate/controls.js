// Buttons of the capture page, and what they do.
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

const OPEN = ".rim details[open]";

/**
 * Closes the popovers at the rim of the viewfinder with Escape, and with a press anywhere else.
 * @param {() => void} onEscape called when no popover was open
 */
function watchPopovers(onEscape) {
  document.addEventListener("keydown", ({ key }) => {
    if (key !== "Escape") return;
    const popovers = document.querySelectorAll(OPEN);
    for (const popover of popovers) {
      if (popover.contains(document.activeElement)) popover.querySelector("summary")?.focus();
      popover.removeAttribute("open");
    }
    if (popovers.length === 0) onEscape();
  });
  document.addEventListener("pointerdown", ({ target }) => {
    for (const popover of document.querySelectorAll(OPEN)) {
      if (target instanceof Node && !popover.contains(target)) popover.removeAttribute("open");
    }
  });
}
