// Frames of a video file, each once: the browser plays it, and says of each picture which frame it is.
import { grab } from "../lib/detector.js";
import { sizeOf } from "./card.js";

/**
 * @typedef {{time: number, picture: ImageBitmap | VideoFrame}} VideoPicture time: s, of the frame in the video
 */

// that are played at first, as many as any detector manages; a video of fewer is played faster
const MIN_FRAMES_PER_S = 10;
const MAX_FRAMES_PER_S = 30; // that are played as long as no frame is missed and all are looked at
const ACCELERATION = 1.06; // for each frame that came in time
const MISSED_INTERVALS = 1.6; // between frames, from which one between them was missed
const RETREAT = 0.7; // of the speed at which a frame was missed: it is played no faster for a while
const RECOVERY = 1.01; // of that limit, for each frame
const MAX_RATE = 4; // of playing: beyond, browsers leave out frames
const MAX_WAITING = 4; // pictures that have not been looked at; with more the video waits
const UNKNOWN_STRIDE_S = 0.1; // between frames, of a video that does not say how long it is
const TOLERANCE_S = 0.001; // s, of the times of frames
const STALLED_MS = 15_000; // ms without another frame

/**
 * Frames one after the other, all or as many as wanted, spread evenly.
 * @param {HTMLVideoElement} video that has data @param {number} most frames @param {AbortSignal} signal
 * @returns {AsyncGenerator<VideoPicture>}
 */
export async function* playedFrames(video, most, signal) {
  const stride = Number.isFinite(video.duration) ? video.duration / most : UNKNOWN_STRIDE_S;
  /** @type {{time: number, picture: Promise<ImageBitmap | VideoFrame>}[]} */
  const waiting = [];
  let [last, due, previous, isOver] = [-Infinity, 0, NaN, false];
  // frames/s; s, the shortest between frames so far
  let [speed, top, interval] = [MIN_FRAMES_PER_S, MAX_FRAMES_PER_S, Infinity];
  let wake = () => {};
  const over = () => {
    isOver = true;
    wake();
  };
  /** @param {number} _ @param {{mediaTime: number}} frame */
  const take = (_, { mediaTime }) => {
    if (isOver) return;
    if (mediaTime > previous) {
      const gap = mediaTime - previous;
      interval = Math.min(interval, gap);
      if (gap > MISSED_INTERVALS * interval && mediaTime > due + Math.max(stride, interval) - TOLERANCE_S)
        top = Math.max(MIN_FRAMES_PER_S, RETREAT * speed);
      else top = Math.min(MAX_FRAMES_PER_S, RECOVERY * top);
      speed = Math.min(top, waiting.length < 2 ? speed * ACCELERATION : speed);
      video.playbackRate = Math.min(MAX_RATE, Math.max(1, speed * Math.max(stride, interval)));
    }
    previous = mediaTime;
    if (mediaTime > last && mediaTime >= due) {
      last = mediaTime;
      due = stride * (Math.floor((mediaTime + TOLERANCE_S) / stride) + 1) - TOLERANCE_S;
      waiting.push({ time: mediaTime, picture: pictureOf(video) });
      wake();
    }
    if (waiting.length >= MAX_WAITING) video.pause();
    video.requestVideoFrameCallback(take);
  };
  const end = new AbortController();
  for (const name of ["ended", "error"]) video.addEventListener(name, over, { signal: end.signal });
  document.addEventListener("visibilitychange", () => void (document.hidden ? video.pause() : play(video)), {
    signal: end.signal,
  });
  signal.addEventListener("abort", over, { signal: end.signal });
  try {
    take(0, { mediaTime: video.currentTime });
    await play(video);
    while (!signal.aborted && (waiting.length || !isOver)) {
      const next = waiting.shift();
      if (next) yield { time: next.time, picture: await next.picture };
      else {
        if (!document.hidden) void play(video);
        const timer = setTimeout(() => !document.hidden && over(), STALLED_MS);
        await new Promise((resolve) => (wake = () => resolve(undefined)));
        clearTimeout(timer);
      }
    }
  } finally {
    isOver = true;
    end.abort();
    for (const { picture } of waiting) void picture.then((each) => each.close());
  }
}

/**
 * The frame as it is shown: some browsers do not turn the frames of a video that was taken upright.
 * @param {HTMLVideoElement} video
 */
async function pictureOf(video) {
  const frame = await grab(video);
  const [width, height] = sizeOf(frame);
  if (width === video.videoWidth && height === video.videoHeight) return frame;
  frame.close();
  return createImageBitmap(video);
}

/** A video that is let go of meanwhile rejects. @param {HTMLVideoElement} video */
const play = (video) => video.play().catch(() => {});
