import assert from "node:assert/strict";
import { test } from "node:test";
import { playedFrames } from "../../web/photos/video-frames.js";
import { setGlobals } from "./globals.mjs";

const SCREEN_HZ = 60;

/** A video of `count` frames; rate and what the browser decodes (capacity) in frames/s. */
function film({ rate, count, capacity }) {
  const listeners = {};
  const video = {
    duration: count / rate,
    playbackRate: 1,
    currentTime: 0,
    paused: true,
    shown: 0,
    played: 0,
    addEventListener: (name, call) => (listeners[name] = call),
    requestVideoFrameCallback: (call) => (video.callback = call),
    pause: () => (video.paused = true),
    play: async () => {
      video.paused = false;
    },
  };
  let [at, lastFrame, budget] = [0, 0, 0];
  const tick = () => {
    if (video.paused) return;
    video.played += 1 / SCREEN_HZ;
    at += video.playbackRate / SCREEN_HZ;
    budget = Math.min(1, budget + capacity / SCREEN_HZ);
    const frame = Math.floor(at * rate);
    if (frame >= count) return listeners.ended?.();
    if (frame === lastFrame || budget < 1) return;
    [lastFrame, budget] = [frame, budget - 1];
    video.shown++;
    const call = video.callback;
    video.callback = null;
    call?.(0, { mediaTime: frame / rate });
  };
  return { video, tick };
}

/** `refreshes` of the screen are needed to look at a picture. */
async function watch(t, options, refreshes = 1) {
  const { video, tick } = film(options);
  const document = { hidden: false, addEventListener() {} };
  setGlobals(t, { document, createImageBitmap: async () => ({ close() {} }) });
  const times = [];
  const timer = setInterval(tick, 0);
  for await (const { time } of playedFrames(video, 120, new AbortController().signal)) {
    times.push(time);
    const until = video.played + refreshes / SCREEN_HZ;
    while (video.played < until && !video.paused) await new Promise(setImmediate);
  }
  clearInterval(timer);
  return { times, played: video.played };
}

test("a long video is played faster without losing frames", async (t) => {
  const { times, played } = await watch(t, { rate: 24, count: 260, capacity: 60 });
  assert.ok(times.length >= 116, `${times.length} frames`);
  assert.ok(played < 0.6 * (260 / 24), `${played} s`);
});

test("a browser that misses frames is given the time that it needs", async (t) => {
  const { times } = await watch(t, { rate: 6, count: 57, capacity: 14 });
  assert.ok(times.length >= 54, `${times.length} frames of 57`);
  assert.equal(new Set(times).size, times.length);
});
