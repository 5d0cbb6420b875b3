// Elements of the capture page that are drawn into and listened to.
import { part } from "../lib/dom.js";

/** Elements of the page, found once; throws if the page lacks one. */
export function findParts() {
  const html = (/** @type {string} */ id) => part(id, HTMLElement);
  const svg = (/** @type {string} */ id) => part(id, SVGElement);
  return {
    sheets: { welcome: html("welcome"), opening: html("opening"), failed: html("failed"), done: html("done") },
    stage: html("stage"),
    video: part("video", HTMLVideoElement),
    overlay: part("overlay", HTMLImageElement),
    marks: svg("marks"),
    pictureEdge: svg("picture-edge"),
    corners: svg("corners"),
    seenOutline: svg("seen-outline"),
    target: svg("target"),
    targetBack: svg("target-back"),
    targetCorner: svg("target-corner"),
    ghost: svg("ghost"),
    held: svg("held"),
    ring: svg("ring"),
    arrows: svg("arrows"),
    reticle: html("reticle"),
    instruction: html("instruction"),
    notice: html("notice"),
    remedy: html("remedy"),
    statusLine: html("away"),
    said: html("said"),
    facts: html("facts"),
    sent: html("sent"),
    sentJson: html("sent-json"),
    sentTable: html("sent-table"),
    accuracy: html("accuracy"),
    sender: html("sender"),
    senderHost: html("sender-host"),
    senderNeeds: html("sender-needs"),
    senderReturns: html("sender-returns"),
    senderKnown: html("sender-known"),
    goBack: part("go-back", HTMLAnchorElement),
    paper: part("paper", HTMLButtonElement),
    paperFile: html("paper-file"),
    setup: html("setup"),
    modeName: part("mode-name", HTMLInputElement),
    noBoard: html("no-board"),
    codes: /** @type {NodeListOf<SVGElement>} */ (document.querySelectorAll("svg.qr")),
    addresses: document.querySelectorAll(".board-address"),
    boardChoice: html("board-choice"),
    useBoard: part("use-board", HTMLButtonElement),
    sharpest: part("sharpest", HTMLButtonElement),
    rightBoard: part("right-board", HTMLButtonElement),
    wanted: html("wanted"),
    problem: html("problem"),
    interrupted: html("interrupted"),
    interruptedText: html("interrupted-text"),
    forget: part("forget", HTMLButtonElement),
    goOn: part("go-on", HTMLButtonElement),
    senses: {
      sound: part("sound", HTMLInputElement),
      vibration: part("vibration", HTMLInputElement),
      voice: part("voice", HTMLInputElement),
    },
    resolution: part("resolution", HTMLSelectElement),
    resolutions: html("resolutions"),
    lens: part("lens", HTMLSelectElement),
    practice: html("practice"),
    practiceKept: html("practice-kept"),
    practiceKeptText: html("practice-kept-text"),
    goOnReally: part("go-on-really", HTMLButtonElement),
    backWithout: part("back-without", HTMLAnchorElement),
    models: [part("model", HTMLButtonElement), part("model-done", HTMLButtonElement)],
    another: html("another"),
    mismatches: /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".another")),
    boardLinks: /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('a[href^="../board/"]')),
    camera: part("camera", HTMLSelectElement),
    start: part("start", HTMLButtonElement),
    startVirtual: part("start-virtual", HTMLButtonElement),
    cancel: part("cancel", HTMLButtonElement),
    again: part("again", HTMLButtonElement),
    other: part("other", HTMLButtonElement),
    failedVirtual: part("failed-virtual", HTMLButtonElement),
    openingText: html("opening-text"),
    failure: html("failure"),
    kept: html("kept"),
    controls: html("controls"),
    film: html("film"),
    counts: html("counts"),
    count: html("count"),
    countMore: html("count-more"),
    undo: part("undo", HTMLButtonElement),
    skip: part("skip", HTMLButtonElement),
    stop: part("stop", HTMLButtonElement),
    finish: part("finish", HTMLButtonElement),
    result: html("result"),
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
