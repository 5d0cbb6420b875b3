// Elements of the rig page that are drawn into and listened to.
import { part } from "../lib/dom.js";

/** Elements of the page, found once; throws if the page lacks one. */
export function findParts() {
  const html = (/** @type {string} */ id) => part(id, HTMLElement);
  const button = (/** @type {string} */ id) => part(id, HTMLButtonElement);
  const input = (/** @type {string} */ id) => part(id, HTMLInputElement);
  const svg = (/** @type {string} */ id) => part(id, SVGElement);
  return {
    phases: {
      welcome: html("welcome"),
      opening: html("opening"),
      failed: html("failed"),
      capturing: html("capturing"),
      done: html("done"),
    },
    problem: html("problem"),
    picture: html("picture"),
    interrupted: html("interrupted"),
    interruptedText: html("interrupted-text"),
    goOn: button("go-on"),
    forget: button("forget"),
    setup: part("setup", HTMLFormElement),
    cameras: html("cameras"),
    camerasNote: html("cameras-note"),
    allow: button("allow"),
    others: part("others", HTMLSelectElement),
    square: input("square"),
    code: input("code"),
    setupProblem: html("setup-problem"),
    start: button("start"),
    practise: button("practise"),
    boardLinks: /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('main a[href^="../board/"]')),
    openingText: html("opening-text"),
    loadingMeter: html("loading-meter"),
    loading: part("loading", HTMLProgressElement),
    cancel: button("cancel"),
    failure: html("failure"),
    again: button("again"),
    back: button("back"),
    ring: svg("ring"),
    held: svg("held"),
    instruction: html("instruction"),
    detail: html("detail"),
    said: html("said"),
    pictures: html("pictures"),
    progress: part("progress", HTMLProgressElement),
    counts: html("counts"),
    finish: button("finish"),
    undo: button("undo"),
    skip: button("skip"),
    take: button("take"),
    stop: button("stop"),
    leads: /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll("button.leads")),
    senses: { sound: input("sound"), vibration: input("vibration"), voice: input("voice") },
    joining: html("joining"),
    qr: svg("qr"),
    joinAddress: html("join-address"),
    joinCode: html("join-code"),
    joinUntil: html("join-until"),
    newCode: button("new-code"),
    members: html("members"),
    advice: html("advice"),
    moments: html("moments"),
    momentList: html("moment-list"),
    result: html("result"),
  };
}

/** @typedef {ReturnType<typeof findParts>} Parts */
