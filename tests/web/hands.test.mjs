import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { DEFAULT_BOARD, corners } from "../../web/lib/board.js";
import { decide } from "../../web/calibrate/guidance.js";
import { nextPlanned } from "../../web/calibrate/plan.js";
import { initial, reduce } from "../../web/calibrate/reducer.js";
import { isEnough } from "../../web/calibrate/state.js";
import { motion } from "../../web/lib/capture/stillness.js";
import { lenienceAfter } from "../../web/lib/capture/target.js";
import { Hand } from "../../web/lib/virtual/hand.js";
import { see } from "./scenes.mjs";
import { matchPose } from "../../web/lib/virtual/match.js";
import { seededRandom } from "../../web/lib/pose.js";

const PLAN = JSON.parse(readFileSync(new URL("../../web/calibrate/plan.json", import.meta.url), "utf8"));
const [WIDTH, HEIGHT] = [1280, 720];
const LENS = { fx: 1000, fy: 1000, cx: 664.5, cy: 359.5, k1: -0.25, k2: 0, p1: 0, p2: 0, k3: 0 };
const KEY = { camera: "Test", platform: "X11", img_size: [WIDTH, HEIGHT], zoom: 0 };
const FRAME = 1000 / 15; // ms
const LIMIT = 180_000; // ms
const NOISE = 0.1; // px

/** Corners that the detector would find in the picture; none where it is smeared. */
function seen(pose, blur, random) {
  const ids = [];
  const points = [];
  if (blur === 0) {
    see(LENS, pose, corners(DEFAULT_BOARD)).forEach(([u, v], id) => {
      if (u < 4 || v < 4 || u > WIDTH - 5 || v > HEIGHT - 5) return;
      ids.push(id);
      points.push([u + NOISE * (random() - 0.5), v + NOISE * (random() - 0.5)]);
    });
  }
  return { ids, points, markers: ids.length, size: [WIDTH, HEIGHT], elapsed: 15, memory: 1 };
}

/** A whole capture by the page's own targets, frame by frame, as the capture loop runs it. */
function capture(kind, seed) {
  const random = seededRandom(seed);
  const start = { rvec: [0, 0, 0], tvec: [-4.5, -3, 12] };
  const hand = new Hand(kind, { error: 1, seed, pivot: [4.5, 3, 0], focal: LENS.fx, start });
  let state = initial(DEFAULT_BOARD, { camera: null, img_size: null, distortion_model: "rectilinear" });
  const dispatch = (event) => (state = reduce(state, event));
  let [planned, skipped, time] = [0, 0, 0];
  const next = () => {
    const found = nextPlanned(PLAN, planned, DEFAULT_BOARD, KEY.img_size, null);
    planned = found.next;
    dispatch({ type: "pose", pose: found.pose, picture: null, time });
    hand.follow(matchPose(DEFAULT_BOARD, LENS, found.pose), time);
  };
  dispatch({ type: "open" });
  dispatch({ type: "opened", key: KEY, mirrored: false, cropped: false });
  dispatch({ type: "opened-offline", stored: 0, time });
  next();
  for (; time < LIMIT && !isEnough(state); time += FRAME) {
    const detection = seen(hand.pose(time), hand.blur(), random);
    dispatch({ type: "frame", detection, time });
    const action = decide(state, time);
    if (action === "skip") {
      skipped += 1;
      next();
    }
    if (action !== "submit") continue;
    const view = seen(hand.pose(time + FRAME), 0, random);
    if (motion(state.sight.corners, view) > 3 * lenienceAfter(time - state.capture.posedAt)) continue;
    dispatch({ type: "stored", corners: view, stored: state.link.stored + 1, time });
    if (!isEnough(state)) next();
  }
  return { views: state.link.stored, seconds: time / 1000, skipped };
}

// Eight views without the service, each a way to the target and a hold of 0.7 s.
const WITHIN = { still: 12, person: 20, shaky: 70, slow: 75, wrong: 30 }; // s

for (const [kind, limit] of Object.entries(WITHIN)) {
  test(`a ${kind} hand comes to the end by itself`, () => {
    const { views, seconds, skipped } = capture(kind, 1);
    assert.equal(views, 8, `${views} views in ${seconds} s`);
    assert.ok(seconds < limit, `${seconds.toFixed(1)} s, ${skipped} given up`);
  });
}
