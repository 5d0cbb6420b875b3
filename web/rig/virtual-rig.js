// Simulated rig: several virtual cameras that look at one board, whose hand follows the rig's targets.
import { facts } from "../lib/camera.js";
import { composePoses } from "../lib/pose.js";
import { Hand } from "../lib/virtual/hand.js";
import { VirtualCamera, streamOf } from "../lib/virtual/camera.js";
import { boardPose, cameraPose, firstPose, setupAt } from "./scene.js";
import { Stream } from "../lib/capture/streams.js";

/**
 * @import { Choice } from "../lib/capture/streams.js"
 * @import { Pose } from "../lib/pose.js"
 */

const MIN_TICK_MS = 50;

export class VirtualRig {
  #parameters;
  #board;
  #place;
  /** @type {{camera: VirtualCamera, pose: Pose}[]} pose: camera 0 → camera */
  #cameras = [];
  #hand;
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  #target = "";

  /**
   * @param {URLSearchParams} parameters of the address
   * @param {import("../lib/board.js").Board} board
   * @param {HTMLElement} place of the canvases
   */
  constructor(parameters, board, place) {
    this.#parameters = parameters;
    this.#board = board;
    this.#place = place;
    // Its targets are those of the scene, which are the same in every browser: it adds nothing to them.
    const start = firstPose(board, setupAt(parameters, 0));
    this.#hand = new Hand("still", { error: 0, seed: 0, pivot: [0, 0, 0], focal: 1, start });
  }

  /**
   * Opens one stream: of one camera, or of two that share it as a stereo camera does.
   * @param {Choice} choice @param {number} position of its first camera @returns {Promise<Stream>}
   */
  async open(choice, position) {
    const positions = choice.layout === "one" ? [position] : [position, position + 1];
    const made = positions.map((each) => ({
      camera: new VirtualCamera(setupAt(this.#parameters, each), this.#place, this.#board),
      pose: cameraPose(each),
    }));
    const streams = [];
    for (const { camera } of made) streams.push(await camera.open());
    this.#cameras.push(...made);
    this.#show();
    const cameras = made.map(({ camera }) => camera);
    const { rate } = setupAt(this.#parameters, position);
    const stream =
      choice.layout === "one" ? streams[0] : joined(cameras, choice.layout === "side_by_side", rate, this.#place);
    const [track] = stream.getVideoTracks();
    const opened = {
      stream,
      track,
      virtual: cameras[0],
      mirrored: false,
      cropped: facts(track).resizeMode === "crop-and-scale",
      close() {
        for (const camera of cameras) camera.close();
        track.stop();
      },
    };
    return new Stream(opened, choice.layout);
  }

  /** Moves the board to a target. @param {readonly import("./service.js").Target[]} targets of the rig's cameras */
  follow(targets) {
    const target = JSON.stringify(targets.map(({ position, rvec, tvec }) => [position, rvec, tvec]));
    const pose = target === this.#target ? null : boardPose(targets, this.#board, this.#parameters);
    if (!pose) return;
    this.#target = target;
    this.#hand.follow(pose, performance.now());
    clearInterval(this.#timer);
    this.#timer = setInterval(() => this.#show(), tick(setupAt(this.#parameters, 0).rate));
  }

  close() {
    clearInterval(this.#timer);
    for (const { camera } of this.#cameras) camera.close();
  }

  #show() {
    const now = performance.now();
    const pose = this.#hand.pose(now);
    for (const { camera, pose: there } of this.#cameras) camera.hold(composePoses(there, pose));
    if (!this.#hand.moves(now)) clearInterval(this.#timer);
  }
}

/** Time from one picture to the next, ms. @param {number} rate pictures a second */
const tick = (rate) => Math.max(MIN_TICK_MS, 1000 / rate);

/**
 * One stream with the pictures of two cameras, as stereo cameras deliver it.
 * @param {VirtualCamera[]} cameras @param {boolean} sideBySide @param {number} rate Hz @param {HTMLElement} place
 */
function joined(cameras, sideBySide, rate, place) {
  const canvas = place.ownerDocument.createElement("canvas");
  const [
    {
      canvas: { width, height },
    },
  ] = cameras;
  canvas.width = sideBySide ? 2 * width : width;
  canvas.height = sideBySide ? height : 2 * height;
  canvas.className = "virtual-camera";
  canvas.setAttribute("aria-hidden", "true");
  place.append(canvas);
  const context = canvas.getContext("2d", { alpha: false });
  const draw = () =>
    cameras.forEach((camera, index) =>
      context?.drawImage(camera.canvas, sideBySide ? index * width : 0, sideBySide ? 0 : index * height),
    );
  draw();
  const timer = setInterval(draw, tick(rate));
  const stream = streamOf(canvas, rate, cameras[0].label);
  const [track] = stream.getVideoTracks();
  const stop = track.stop.bind(track);
  track.stop = () => {
    clearInterval(timer);
    canvas.remove();
    stop();
  };
  return stream;
}
