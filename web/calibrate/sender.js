// The application that sent the visitor: its request, what is known of the camera, the way back, and what it gets of a
// practice run.
import { Api } from "../lib/api.js";
import { onLanguage, formatSize, t } from "../lib/i18n.js";
import { returnAddress } from "../lib/result/return-address.js";
import { loadSettings } from "../lib/settings.js";
import { isVirtual } from "../lib/camera-name.js";
import { isPracticeReturned } from "./history.js";

/**
 * @import { ReturnAddress } from "../lib/result/return-address.js"
 * @import { CameraSize } from "../vendor/api.js"
 * @import { Parts } from "./parts.js"
 * @import { State, Wanted } from "./state.js"
 */

/**
 * @typedef {object} Known calibrations of the camera that was asked for
 * @property {number} calibrations at the size that was asked for
 * @property {number} missing calibrations that must still agree
 * @property {boolean} reliable
 */

const MAX_FOUND = 20;

/** Name of the place that the visitor returns to. @param {ReturnAddress} sender */
const senderName = ({ host, isHere }) => (isHere ? t("capture.sender_here") : host);

/**
 * Sentence about the requested camera.
 * @param {Known | null} known null: not known yet, or the lookup failed
 */
export function knownText(known) {
  if (!known) return "";
  if (known.reliable) return t("capture.camera_known");
  if (known.calibrations === 0) return t("capture.camera_new");
  return known.missing > 0 ? t("capture.camera_more", { count: known.missing }) : t("capture.camera_unsettled");
}

/**
 * Facts of one camera at one size, out of a search's answer.
 * @param {{cameras: {camera: string, sizes: readonly CameraSize[]}[]}} answer
 * @param {string} label
 * @param {[number, number] | null} size px
 * @returns {Known}
 */
export function knownOf({ cameras }, label, size) {
  const name = withoutId(label);
  const modes = cameras
    .filter(({ camera }) => withoutId(camera) === name)
    .flatMap(({ sizes }) => sizes)
    .filter(({ img_size }) => !size || img_size.join() === size.join());
  return {
    calibrations: modes.reduce((most, { calibrations }) => Math.max(most, calibrations), 0),
    missing: modes.reduce((least, { agreeing, required }) => Math.min(least, required - agreeing), Infinity),
    reliable: modes.some(({ reliable }) => reliable),
  };
}

/** Some browsers add a camera's USB id to its label, and some do not. @param {string} label */
const withoutId = (label) => label.replace(/\s*\([0-9a-f]{4}:[0-9a-f]{4}\)\s*$/i, "").toLowerCase();

/**
 * Shows which page sent the visitor, and how to return; nothing if no page did.
 * @param {Parts} parts @param {string | null} returnTo @param {Wanted} wanted
 */
export async function showSender(
  { sender, senderHost, senderNeeds, senderReturns, senderKnown, goBack },
  returnTo,
  wanted,
) {
  /** @type {Known | null} */
  let known = null;
  /** @type {readonly string[]} */
  let allowed = [];
  let isSettled = false;
  const isAsked = wanted.camera !== null && !isVirtual(wanted.camera);
  const write = () => {
    const from = returnAddress(returnTo, location.origin, allowed);
    sender.hidden = !from;
    senderHost.textContent = from ? senderName(from) : "";
    const camera =
      wanted.camera && [wanted.camera, wanted.img_size && formatSize(wanted.img_size)].filter(Boolean).join(", ");
    senderNeeds.textContent = from ? (camera ? t("capture.needs_named", { camera }) : t("capture.needs")) : "";
    senderReturns.textContent = from ? returnText(from, isSettled) : "";
    goBack.hidden = !from?.allowed;
    if (from?.allowed) goBack.href = from.url.href;
    senderKnown.textContent = knownText(known);
    senderKnown.hidden = !isAsked; // its line stays free for this sentence
  };
  write();
  onLanguage(write);
  if (sender.hidden) return;
  try {
    const { api, token, return_origins = [] } = await loadSettings();
    [allowed, isSettled] = [return_origins, true];
    write();
    if (!wanted.camera || !isAsked) return;
    const parameters = new URLSearchParams({ query: withoutId(wanted.camera), limit: String(MAX_FOUND) });
    known = knownOf(await new Api(api).json("GET", `/cameras?${parameters}`, token), wanted.camera, wanted.img_size);
    write();
  } catch (error) {
    // This is only information. If the service fails, the capture reports it.
    console.info("nothing is known of the sender or the camera:", error instanceof Error ? error.message : error);
  }
}

/**
 * @param {ReturnAddress} sender
 * @param {boolean} isSettled it is known which origins get results
 */
function returnText({ host, isHere, allowed }, isSettled) {
  if (isHere) return t("capture.returns_here");
  return allowed || !isSettled ? t("capture.returns", { host }) : t("capture.no_return", { host });
}

/**
 * Says that a practice result is not handed over, and offers the ways on.
 * @param {Parts} parts
 * @param {State} state of a capture that is done
 * @param {string | null} returnTo
 */
export async function showPracticeEnd(
  { practiceKept, practiceKeptText, backWithout },
  { capture: { key }, wanted },
  returnTo,
) {
  practiceKept.hidden = true;
  if (!returnTo || !isVirtual(key?.camera ?? "") || isPracticeReturned(returnTo, wanted.camera)) return;
  const { return_origins = [] } = await loadSettings().catch(() => ({ return_origins: [] }));
  const sender = returnAddress(returnTo, location.origin, return_origins);
  if (!sender) return;
  const { host, url, allowed, isHere } = sender;
  practiceKeptText.textContent = t("capture.practice_kept", { host: senderName(sender) });
  practiceKept.hidden = false;
  backWithout.textContent = isHere ? t("capture.go_back") : t("capture.back_without", { host });
  backWithout.hidden = !allowed;
  if (allowed) backWithout.href = url.href;
}
