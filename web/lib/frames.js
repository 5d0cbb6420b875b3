// The frames of a video: the next one, and how long each of them takes.

const PACE_FRAMES = 24; // frames
const SLOW_FRAME_MS = 60; // ms for a frame, median of the last ones: with more, a hand cannot be followed

export class Pace {
  /** @type {number[]} ms, of the last frames */
  #taken = [];

  /** @param {number} taken ms, for one more frame */
  isSlow(taken) {
    this.#taken = [...this.#taken, taken].slice(-PACE_FRAMES);
    return (
      this.#taken.length === PACE_FRAMES && [...this.#taken].sort((a, b) => a - b)[PACE_FRAMES / 2] > SLOW_FRAME_MS
    );
  }
}

/** The next frame that the video shows. @param {HTMLVideoElement} video @returns {Promise<void>} */
export function nextFrame(video) {
  return new Promise((resolve) => {
    // A camera that stalls, or a hidden tab, must not stop the loop for good.
    const timer = setTimeout(resolve, 500);
    const done = () => {
      clearTimeout(timer);
      resolve();
    };
    if (video.requestVideoFrameCallback) video.requestVideoFrameCallback(done);
    else requestAnimationFrame(done);
  });
}
