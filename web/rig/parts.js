// Elements of the rig page that are drawn into and listened to.
import { part, partsOf } from "../lib/dom.js";

/** Elements of the page, found once; throws if the page lacks one. */
export function findParts() {
  return {
    ...partsOf(HTMLElement, [
      "problem",
      "picture",
      "interrupted",
      "interrupted-text",
      "cameras",
      "cameras-note",
      "setup-problem",
      "opening-text",
      "loading-meter",
      "failure",
      "instruction",
      "detail",
      "said",
      "pictures",
      "counts",
      "joining",
      "join-address",
      "join-code",
      "join-until",
      "members",
      "advice",
      "moments",
      "moment-list",
      "result",
    ]),
    ...partsOf(HTMLButtonElement, [
      "go-on",
      "forget",
      "allow",
      "start",
      "practise",
      "cancel",
      "again",
      "back",
      "finish",
      "undo",
      "skip",
      "take",
      "stop",
      "new-code",
    ]),
    setup: part("setup", HTMLFormElement),
    others: part("others", HTMLSelectElement),
    ...partsOf(HTMLInputElement, ["square", "code"]),
    ...partsOf(HTMLProgressElement, ["loading", "progress"]),
    ...partsOf(SVGElement, ["ring", "held", "qr"]),
    phases: partsOf(HTMLElement, ["welcome", "opening", "failed", "capturing", "done"]),
    boardLinks: /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('main a[href^="../board/"]')),
    leads: /** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll("button.leads")),
    senses: partsOf(HTMLInputElement, ["sound", "vibration", "voice"]),
  };
}

/** @typedef {ReturnType<typeof findParts>} Parts */
