// Elements of the capture page that are drawn into and listened to.
import { part, partsOf } from "../lib/dom.js";

/** Elements of the page, found once; throws if the page lacks one. */
export function findParts() {
  return {
    ...partsOf(HTMLElement, [
      "stage",
      "reticle",
      "instruction",
      "notice",
      "remedy",
      "said",
      "facts",
      "sent",
      "sent-json",
      "sent-table",
      "accuracy",
      "sender",
      "sender-host",
      "sender-needs",
      "sender-returns",
      "sender-known",
      "paper-file",
      "setup",
      "no-board",
      "board-choice",
      "wanted",
      "problem",
      "interrupted",
      "interrupted-text",
      "resolutions",
      "practice",
      "practice-kept",
      "practice-kept-text",
      "another",
      "opening-text",
      "failure",
      "kept",
      "controls",
      "film",
      "counts",
      "count",
      "count-more",
      "result",
    ]),
    video: part("video", HTMLVideoElement),
    overlay: part("overlay", HTMLImageElement),
    ...partsOf(SVGElement, [
      "marks",
      "picture-edge",
      "corners",
      "seen-outline",
      "target",
      "target-back",
      "target-corner",
      "ghost",
      "held",
      "ring",
      "arrows",
    ]),
    ...partsOf(HTMLAnchorElement, ["go-back", "back-without"]),
    ...partsOf(HTMLButtonElement, [
      "paper",
      "use-board",
      "sharpest",
      "right-board",
      "forget",
      "go-on",
      "go-on-really",
      "start",
      "start-virtual",
      "cancel",
      "again",
      "other",
      "failed-virtual",
      "undo",
      "skip",
      "stop",
      "finish",
    ]),
    modeName: part("mode-name", HTMLInputElement),
    ...partsOf(HTMLSelectElement, ["resolution", "lens", "camera"]),
    sheets: partsOf(HTMLElement, ["welcome", "opening", "failed", "done"]),
    statusLine: part("away", HTMLElement),
    codes: /** @type {NodeListOf<SVGElement>} */ (document.querySelectorAll("svg.qr")),
    addresses: document.querySelectorAll(".board-address"),
    senses: partsOf(HTMLInputElement, ["sound", "vibration", "voice"]),
    models: [part("model", HTMLButtonElement), part("model-done", HTMLButtonElement)],
    mismatches: /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".another")),
    boardLinks: /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('a[href^="../board/"]')),
  };
}

/** @typedef {ReturnType<typeof findParts>} Parts */

/**
 * @typedef {"resume" | "changeModel" | "restart" | "stop" | "forget" | "useBoard" | "wantBoard" | "practise" |
 *   "leavePractice" | "again" | "escape" | "listCameras" | "showChoice"} Action
 */

/** Gives the buttons what they do. @param {Parts} parts @param {Record<Action, () => unknown>} actions */
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
    select.addEventListener("change", () => void actions.showChoice());
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
