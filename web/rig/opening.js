// Opening of a capture: the cameras of this device with their pictures on the page, and the board detector.
import { Detector } from "../lib/detector.js";
import { t } from "../lib/i18n.js";
import { Figure } from "./figure.js";
import { HALVES, openStream } from "../lib/capture/streams.js";

/**
 * @import { Choice, Picture, Stream } from "../lib/capture/streams.js"
 * @import { Parts } from "./parts.js"
 */

/**
 * @typedef {import("../lib/board.js").SentBoard} Board
 * @typedef {{stream: Stream, choice: Choice, figure: Figure, half: number, picture:
 *   Picture}} Shown half: index of the picture in the stream
 */

/**
 * Opens the cameras of a record, and shows all of them. They are closed when the capture ends.
 * @param {Parts} parts @param {import("./membership.js").RigRecord} record
 * @param {{parameters: URLSearchParams, board: Board, signal: AbortSignal, onUnplugged: (error: Error) => void}}
 *   options onUnplugged: called when a camera is unplugged
 * @returns {Promise<{virtual: import("./virtual-rig.js").VirtualRig | null, shown: Shown[]}>} virtual: the simulated
 *   rig, if it is one
 */
export async function openCameras(parts, { choices, members }, { parameters, board, signal, onUnplugged }) {
  const virtual = choices.some(({ id }) => id.startsWith("virtual")) ? await simulate(parameters, board) : null;
  /** @type {Shown[]} */
  const shown = [];
  parts.pictures.replaceChildren();
  for (const choice of choices) {
    const stream = virtual
      ? await virtual.open(choice, members[shown.length].position)
      : await openStream(choice, { parameters, place: document.body, board });
    stream.closeWith(signal, onUnplugged);
    const figures = HALVES[choice.layout].map((half, index) => new Figure(shown.length + index, half));
    parts.pictures.append(...figures.map(({ root }) => root));
    const pictures = await stream.play(figures.map(({ video }) => video));
    pictures.forEach((picture, half) => {
      figures[half].shape(picture.size, stream.mirrored);
      shown.push({ stream, choice, figure: figures[half], half, picture });
    });
  }
  return { virtual, shown };
}

/** @param {URLSearchParams} parameters @param {Board} board */
async function simulate(parameters, board) {
  const { VirtualRig } = await import("./virtual-rig.js");
  return new VirtualRig(parameters, board, document.body);
}

/** @param {Parts} parts @param {Board} board @param {AbortSignal} signal closes the detector */
export async function openDetector({ openingText, loadingMeter, loading }, board, signal) {
  openingText.textContent = t("capture.opening_loading");
  loadingMeter.hidden = false;
  const detector = await Detector.open(board, (fraction) => {
    loading.value = fraction;
  });
  loadingMeter.hidden = true;
  if (signal.aborted) detector.close();
  signal.throwIfAborted();
  signal.addEventListener("abort", () => detector.close());
  return detector;
}

/**
 * Keeps the screen on while a device takes part, because it is not touched meanwhile.
 * @param {AbortSignal} signal lets it go off again
 */
export async function keepAwake(signal) {
  /** @type {WakeLockSentinel | null} */
  let lock = null;
  const ask = async () => {
    if (document.hidden || signal.aborted || !navigator.wakeLock) return;
    try {
      lock = await navigator.wakeLock.request("screen");
      if (signal.aborted) await lock.release();
    } catch (error) {
      if (!(error instanceof DOMException)) throw error; // refused, as with a low battery
    }
  };
  // A hidden page loses it.
  document.addEventListener("visibilitychange", ask, { signal });
  signal.addEventListener("abort", () => void lock?.release());
  await ask();
}
