import assert from "node:assert/strict";
import { test } from "node:test";
import { readFileSync } from "node:fs";
import { DEFAULT_BOARD, corners } from "../../web/lib/board.js";
import { decide, holdProgress } from "../../web/calibrate/guidance.js";
import { initial, reduce } from "../../web/calibrate/reducer.js";
import { visibility } from "../../web/calibrate/overlay-layer.js";
import { isEnough, isFinishable, isRestless, isSharpestOffered, offlineGoal } from "../../web/calibrate/state.js";
import { HEALTHY } from "../../web/lib/capture/sight.js";
import { HOLD_MS, LONG_HOLD_MS, asMirrored, lenienceAfter } from "../../web/lib/capture/target.js";
import { observedOutline } from "../../web/lib/board-outline.js";
import { nextPlanned, plannedPose, trustedCalibration } from "../../web/calibrate/plan.js";
import { HANDS, Hand } from "../../web/lib/virtual/hand.js";
import { matchPose } from "../../web/lib/virtual/match.js";
import { motion } from "../../web/lib/capture/stillness.js";
import { seededRandom } from "../../web/lib/pose.js";
import { Announcer } from "../../web/lib/capture/feedback.js";
import { propose } from "../../web/lib/camera.js";
import * as statusText from "../../web/calibrate/status-text.js";
import { labelOf, setupFrom } from "../../web/lib/virtual/setup.js";
import { PINHOLE, calibrationOf, cornersSeen, distances, rms, see, targetOf } from "./scenes.mjs";
import "./messages.mjs";

const KEY = { camera: "Test", platform: "X11", img_size: [1280, 720], zoom: 0 };
const SESSION = {
  status: "capturing",
  views: [],
  progress: 0,
  uncertainty: null,
  calibration: null,
  calibration_id: null,
};
const CONVERGED = { ...SESSION, status: "converged", calibration: {}, progress: 1 };
const THERE = { rvec: [0.4, -0.5, 0.1], tvec: [-4, -3, 12] };
const ELSEWHERE = { rvec: [0.4, 0.6, 0], tvec: [-12, -6, 20] };
const FACING = { rvec: [0, 0, 0], tvec: [-8, -5, 22] };

const target = (pose, index = 0) => ({
  index,
  ...targetOf(DEFAULT_BOARD, PINHOLE, pose),
  purpose: "focal length",
  hint: "Tilt the board",
});
const NOTHING = { ids: [], points: [], markers: 0, size: [1280, 720], elapsed: 1, memory: 1 };
const frame = (pose) => ({ ...NOTHING, ...cornersSeen(DEFAULT_BOARD, PINHOLE, pose), markers: 27 });

/** Capturing, with a target, and so many frames at 20 a second of one thing. */
function capturing(events = []) {
  const wanted = { camera: null, img_size: null, distortion_model: "rectilinear" };
  return [
    { type: "open" },
    { type: "opened", key: KEY, mirrored: false, cropped: false },
    { type: "session", session: SESSION, time: 0 },
    { type: "pose", pose: target(THERE), picture: "blob:1", time: 0 },
    ...events,
  ].reduce(reduce, initial(DEFAULT_BOARD, wanted));
}
const mirrored = () => reduce(capturing(), { type: "opened", key: KEY, mirrored: true, cropped: false });
const VIEW = { index: 0, points: 40, rms: 0.1 };
const viewsOf = (count) => Array.from({ length: count }, (_, index) => ({ ...VIEW, index }));
/** The state after the service has judged a view, which it takes unless `answer` says otherwise. */
const answered = (state, answer, time = 1, corners = state.sight.corners) =>
  reduce(state, { type: "answer", answer: { ...SESSION, accepted: true, reason: null, ...answer }, corners, time });
const REFUSED = { accepted: false, reason: "no_information" };
const frames = (detection, ms, from = 0) =>
  Array.from({ length: ms / 50 + 1 }, (_, index) => ({ type: "frame", detection, time: from + 50 * index }));
/** Capturing with a board that is held so for so long, ms. */
const holding = (pose, ms) => capturing(frames(frame(pose), ms));
const holdOn = (state, pose, ms, from) => frames(frame(pose), ms, from).reduce(reduce, state);
const aimed = (state, pose, time) => reduce(state, { type: "pose", pose, picture: null, time });
const seeing = (state, pose, time) => reduce(state, { type: "frame", detection: frame(pose), time });
const sentFrom = (state) => reduce(state, { type: "sent", corners: state.sight.corners });

test("a board held still on the target is sent after the hold, not before", () => {
  const before = holding(THERE, HOLD_MS - 50);
  assert.ok(before.sight.overlap > 0.99);
  assert.equal(decide(before, HOLD_MS - 50), null);
  assert.ok(holdProgress(before) > 0.8 && holdProgress(before) < 1);
  assert.equal(decide(holding(THERE, HOLD_MS), HOLD_MS), "submit");
});

test("a tilted board held elsewhere is sent after a longer hold", () => {
  const tilted = (ms) => holding(ELSEWHERE, ms);
  assert.ok(tilted(100).sight.overlap < 0.3);
  assert.equal(decide(tilted(LONG_HOLD_MS - 50), LONG_HOLD_MS - 50), null);
  assert.equal(decide(tilted(LONG_HOLD_MS), LONG_HOLD_MS), "submit");
  assert.equal(decide(holding(FACING, 2 * LONG_HOLD_MS), 2 * LONG_HOLD_MS), null);
});

test("nothing is sent while a view is on its way, nor the same hold twice", () => {
  const held = holding(THERE, HOLD_MS);
  assert.equal(decide(reduce(held, { type: "busy" }), HOLD_MS), null);
  const refused = answered(held, REFUSED, 600);
  const again = holdOn(refused, THERE, HOLD_MS, 650);
  assert.equal(decide(again, 650 + HOLD_MS), null);
  assert.equal(refused.ui.notice.key, "capture.useless");
  assert.equal(refused.sight.target.index, 0);
  const moved = { rvec: [0.45, -0.5, 0.1], tvec: [-3.6, -2.6, 12] };
  const better = holdOn(again, moved, HOLD_MS, 2000);
  assert.equal(decide(better, 2000 + HOLD_MS), "submit");
});

test("a capture with four views ends after 30 s without a new one", () => {
  const answer = (count) => ({ views: viewsOf(count), calibration: {} });
  const after = (count) => {
    const taken = answered(capturing(), answer(count), 10_000, frame(THERE));
    return aimed(taken, target(THERE), 10_500);
  };
  assert.equal(decide(after(4), 40_000), null);
  assert.equal(decide(after(4), 40_001), "finish");
  assert.notEqual(decide(after(3), 60_000), "finish");
  const duplicate = { ...answer(4), accepted: false, reason: "duplicate" };
  const refused = answered(after(4), duplicate, 30_000, frame(THERE));
  assert.equal(refused.ui.notice.key, "capture.refused_duplicate");
  assert.equal(decide(refused, 40_001), "finish", "a refusal is nothing new");
  const ended = { ...duplicate, status: "converged", end: "nothing_new" };
  assert.equal(answered(after(4), ended, 30_000, frame(THERE)).phase, "done");
  const back = reduce(after(4), { type: "visible", time: 35_000 });
  assert.equal(decide(back, 40_001), null, "time in a hidden tab does not count");
});

test("a capture ends after four repeated holds in a row", () => {
  const answer = { views: viewsOf(4), calibration: {} };
  const places = [0, 1, 2].map((n) => frame({ rvec: [0.4, 0.6, 0], tvec: [-12 + 2 * n, -6, 20] }));
  let state = capturing();
  let time = 0;
  const hold = (detection, ms) => {
    state = frames(detection, ms, time).reduce(reduce, state);
    time += ms + 100;
  };
  for (const detection of places) {
    hold(detection, LONG_HOLD_MS + 200);
    assert.equal(decide(state, time), "submit");
    state = sentFrom(state);
    state = answered(state, answer, time);
    state = aimed(state, target(THERE), time);
    hold(detection, 2 * LONG_HOLD_MS); // the hold that was sent goes on
  }
  assert.equal(state.capture.repeats, 0);
  for (let n = 0; n < 4; n++) {
    assert.notEqual(decide(state, time), "finish", `after ${n}`);
    hold(places[n % 3], 2 * LONG_HOLD_MS);
    assert.equal(state.capture.repeats, n + 1);
    assert.equal(state.ui.notice.key, "capture.refused_duplicate");
  }
  assert.equal(decide(state, time), "finish");
  hold(frame(ELSEWHERE), 0);
  const fresh = answered(state, { ...answer, views: viewsOf(5) }, time);
  assert.equal(fresh.capture.repeats, 0);
});

test("only a refused pose is sent again", () => {
  const back = (reason) => {
    let state = holding(ELSEWHERE, 2 * LONG_HOLD_MS);
    state = answered(state, { accepted: reason === null, reason }, 3_000);
    state = aimed(state, target(THERE), 3_000);
    state = holdOn(state, { ...ELSEWHERE, tvec: [-9, -6, 20] }, 2 * LONG_HOLD_MS, 4_000);
    state = sentFrom(state);
    return holdOn(state, ELSEWHERE, 2 * LONG_HOLD_MS, 8_000);
  };
  assert.deepEqual([decide(back("outlier"), 11_000), back("outlier").capture.repeats], ["submit", 0]);
  assert.deepEqual([decide(back(null), 11_000), back(null).capture.repeats], [null, 1]);
});

test("a view off the target is reported", () => {
  const view = { ...VIEW, on_target: false };
  const taken = (views) => answered(capturing(), { views }).ui.notice.key;
  assert.equal(taken([view]), "capture.view_taken_aside");
  assert.equal(taken([view, { ...view, on_target: true }]), "capture.view_taken");
  assert.equal(taken([{ ...view, on_target: null }]), "capture.view_taken");
});

test("a refused target is skipped after 1 s, or 3 s with a reason to read", () => {
  const held = holding(THERE, HOLD_MS);
  const refused = answered(held, REFUSED, 600);
  assert.equal(decide(refused, 1_500), null);
  assert.equal(decide(refused, 1_700), "skip");
  const doubted = answered(held, { accepted: false, reason: "outlier", views: [VIEW] }, 600);
  assert.equal(doubted.ui.notice.key, "capture.refused_outlier");
  assert.equal(decide(doubted, 3_500), null);
  assert.equal(decide(doubted, 3_700), "skip");
  const elsewhere = answered(holding(ELSEWHERE, LONG_HOLD_MS), REFUSED, 1600);
  assert.equal(decide(elsewhere, 14_000), null);
});

test("progress only falls by undo", () => {
  const views = [VIEW];
  const taken = answered(holding(THERE, HOLD_MS), { views, progress: 0.5 }, 600);
  assert.deepEqual(
    [taken.sight.target, taken.ui.picture, taken.capture.progress, taken.link.busy],
    [null, null, 0.5, false],
  );
  assert.equal(reduce(taken, { type: "session", session: { ...SESSION, views, progress: 0.4 } }).capture.progress, 0.5);
  const undone = reduce(taken, { type: "undone", session: SESSION, time: 700 });
  assert.deepEqual([undone.capture.progress, undone.sight.lastTaken, undone.capture.taken], [0, null, []]);
});

test("convergence ends the capture", () => {
  const done = reduce(capturing(), { type: "session", session: CONVERGED });
  assert.deepEqual([done.phase, done.capture.progress, done.sight.target], ["done", 1, null]);
  assert.equal(decide(done, 1e9), null);
  assert.equal(seeing(done, THERE, 1), done);
});

test("a target not reached for 15 s is skipped", () => {
  const state = holding(FACING, 200);
  assert.equal(decide(state, 14_999), null);
  assert.equal(decide(state, 15_001), "skip");
  assert.equal(decide(capturing(frames(NOTHING, 200)), 60_000), null);
});

const missed = (until) =>
  frames(NOTHING, until).flatMap((event) =>
    event.time % 500 === 0 ? [event, { type: "looked", suggestion: null, time: event.time }] : [event],
  );

test("a board is asked for after three looks without it", () => {
  const code = (events) => capturing(events).ui.instruction.code;
  assert.deepEqual(
    [400, 1400, 1900].map((until) => code(missed(until))),
    ["looking", "looking", "show"],
  );
  const seen = frames(frame(THERE), 600);
  const lost = frames(NOTHING, 500, 700);
  assert.equal(capturing([...missed(1500), ...seen, ...lost]).ui.instruction.code, "looking");
  const blind = capturing(frames(NOTHING, 500));
  const taken = { ...blind, capture: { ...blind.capture, session: { ...blind.capture.session, views: [{}] } } };
  const after = frames(NOTHING, 500, 700).reduce(reduce, taken);
  assert.equal(after.ui.instruction.code, "show", "no other board is looked for after the first view");
});

test("instructions say what is missing, and stand for 400 ms", () => {
  const blind = capturing(missed(1500));
  assert.equal(blind.ui.instruction.code, "show");
  const first = seeing(blind, ELSEWHERE, 1550);
  assert.equal(first.ui.instruction.code, "show");
  const later = holdOn(first, ELSEWHERE, 400, 1600);
  assert.equal(later.ui.instruction.code, "tilt_left");
  const there = holdOn(later, THERE, 450, 2100);
  assert.equal(there.ui.instruction.code, "hold");
  const sent = sentFrom(there);
  assert.equal(sent.ui.instruction.code, "wait");
  const slid = { ids: there.sight.corners.ids, points: there.sight.corners.points.map(([x, y]) => [x + 4, y]) };
  assert.equal(reduce(there, { type: "sent", corners: slid }).capture.unsteady, true);
});

test("an unsteady board is reported after 12 s, its sharpest frames are offered after 60", () => {
  const swaying = (time) =>
    frame({ ...ELSEWHERE, tvec: [ELSEWHERE.tvec[0] + 0.4 * Math.sin(time / 300), ...ELSEWHERE.tvec.slice(1)] });
  const states = [capturing([])];
  for (let time = 200; time <= 62_000; time += 200)
    states.push(reduce(states.at(-1), { type: "frame", detection: swaying(time), time }));
  const [early, later, late] = [11_000, 14_000, 62_000].map((time) => states[time / 200]);
  assert.deepEqual([early, later, late].map(isRestless), [false, true, true]);
  assert.deepEqual([later, late].map(isSharpestOffered), [false, true]);
  assert.equal(isSharpestOffered(sentFrom(late)), false);
  assert.equal(isRestless(frames(NOTHING, 20_000).reduce(reduce, capturing([]))), false);
});

test("what was said of one target does not stand for the next", () => {
  const held = holding(THERE, 600);
  assert.equal(held.ui.instruction.code, "hold");
  const next = aimed(held, target(ELSEWHERE, 1), 650);
  assert.equal(next.ui.instruction.code, "tilt_right");
});

test("in a mirrored preview left is right", () => {
  const codes = ["up_right", "tilt_left", "turn_clockwise", "closer"];
  assert.deepEqual(codes.map(asMirrored), ["up_left", "tilt_right", "turn_counterclockwise", "closer"]);
  const shown = (state, pose) => [pose, ...frames(frame(ELSEWHERE), 450)].reduce(reduce, state).ui.instruction.code;
  const known = { type: "pose", pose: target(THERE), picture: "blob:2", time: 0 };
  assert.equal(shown(capturing(), known), "tilt_left");
  assert.equal(shown(mirrored(), known), "tilt_right");
  // Where the target is hardly in the picture, the service's own hint is all there is; one that is not known is not
  // said.
  const hinted = (hint_code) => ({ ...known, pose: { ...target(THERE), ids: [], corners: [], hint_code } });
  assert.equal(shown(capturing(), hinted("left")), "left");
  assert.equal(shown(mirrored(), hinted("left")), "right");
  assert.equal(shown(capturing(), hinted("dance")), "match");
});

test("a hand that is not steady is asked for less, the longer it tries", () => {
  assert.deepEqual([0, 3000, 4500, 59_000].map(lenienceAfter), [1, 1, 1.5, 4]);
  const trembling = (from, ms) =>
    frames(frame(THERE), ms, from).map((event, index) => {
      const points = event.detection.points.map(([x, y]) => [x + (index % 2 ? 3 : 0), y]);
      return { ...event, detection: { ...event.detection, points } };
    });
  assert.equal(decide(capturing(trembling(0, 2000)), 2000), null);
  assert.equal(decide(capturing(trembling(0, 12_000)), 12_000), "submit");
});

test("who comes nearer, slowly, keeps the target", () => {
  const far = (time) => ({
    rvec: THERE.rvec,
    tvec: [THERE.tvec[0] - (8 * (20_000 - time)) / 20_000, THERE.tvec[1], THERE.tvec[2]],
  });
  let slow = capturing();
  for (let time = 0; time <= 16_000; time += 1000) slow = seeing(slow, far(time), time);
  assert.equal(decide(slow, 16_001), null);
  assert.equal(decide(slow, slow.capture.nearest.time + 15_001), "skip");
  const nearer = { ...slow, capture: { ...slow.capture, nearest: { ...slow.capture.nearest, time: 45_000 } } };
  assert.equal(decide(nearer, 45_001), "skip");
});

test("offline views are kept and counted", () => {
  const held = holding(THERE, HOLD_MS);
  const away = reduce(held, { type: "offline", stored: 1 });
  assert.deepEqual([away.link.offline, away.link.stored, away.sight.target, away.ui.notice], [true, 1, null, null]);
  const planned = aimed(away, { ...target(ELSEWHERE), index: -1 }, 900);
  assert.equal(decide(holdOn(planned, ELSEWHERE, HOLD_MS, 1000), 1000 + HOLD_MS), "submit");
  const stored = reduce(planned, { type: "stored", corners: frame(ELSEWHERE), stored: 2, time: 2000 });
  assert.deepEqual([stored.link.stored, stored.sight.target, stored.ui.notice.key], [2, null, "capture.view_stored"]);
  const far = { ...stored, capture: { ...stored.capture, session: { ...SESSION, progress: 0.6 }, progress: 0.6 } };
  const keep = (state, count) =>
    reduce(state, { type: "stored", corners: frame(ELSEWHERE), stored: count, time: 2000 });
  let grown = far;
  for (const count of [3, 4, 5, 6, 7, 8]) {
    const before = grown.capture.progress;
    grown = keep(grown, count);
    assert.ok(grown.capture.progress > before, "progress only grows");
  }
  assert.ok(Math.abs(grown.capture.progress - 0.95) < 1e-9, "the service alone says that it is the end");
  const trying = reduce(stored, { type: "retrying", attempts: 2 });
  const back = reduce(trying, {
    type: "online",
    session: { ...SESSION, views: viewsOf(2), progress: 0.5 },
    taken: 2,
    refused: 0,
    time: 3000,
  });
  assert.deepEqual(
    [back.link.offline, back.link.stored, back.link.attempts, back.capture.progress],
    [false, 0, 0, 0.5],
  );
});

test("an offline capture ends at eight views, or after three more", () => {
  const offline = (stored) => reduce(capturing(), { type: "opened-offline", stored, time: 0 });
  assert.deepEqual([offline(0).ui.notice, offline(3).link.offline, offline(3).phase], [null, true, "capturing"]);
  assert.deepEqual([offlineGoal(offline(0)), isEnough(offline(7)), isEnough(offline(8))], [8, false, true]);
  const views = viewsOf(7);
  const late = reduce(reduce(capturing(), { type: "session", session: { ...SESSION, views } }), {
    type: "offline",
    stored: 2,
  });
  assert.deepEqual(
    [offlineGoal(late), isEnough(late), isEnough({ ...late, link: { ...late.link, stored: 3 } })],
    [3, false, true],
  );
  const told = frames(NOTHING, 500).reduce(reduce, offline(8));
  assert.equal(told.ui.instruction.code, "enough");
  assert.equal(reduce(late, { type: "sending", sending: true }).link.sending, true);
  const back = (taken, refused) =>
    reduce(late, { type: "online", session: SESSION, taken, refused, time: 2 }).ui.notice.key;
  assert.deepEqual(
    [back(2, 0), back(1, 1), back(0, 0)],
    ["capture.came_back", "capture.came_back_less", "capture.came_back_only"],
  );
});

test("a refusal says what would help, as the preview shows it", () => {
  const left = { code: "left", text: "Move left" };
  const refuse = (state, hint) => answered(state, { accepted: false, reason: "too_few_points", hint }).ui.notice;
  const { key, hint } = refuse(capturing(), left);
  assert.deepEqual([key, hint], ["capture.refused_too_few_points", "left"]);
  assert.equal(refuse(mirrored(), left).hint, "right");
  assert.equal(refuse(capturing(), { code: "dance", text: "" }).hint, undefined);
});

test("a view that is set aside later is said to be, once", () => {
  const views = [
    { ...VIEW, set_aside: { reason: "outlier", detail: "" } },
    { ...VIEW, index: 1 },
  ];
  const first = answered(capturing(), { views });
  assert.deepEqual([first.ui.notice.key, first.ui.notice.values.number], ["capture.view_set_aside", 1]);
  const second = answered(first, { views }, 2);
  assert.equal(second.ui.notice.key, "capture.view_taken");
});

test("a board of the other layout is accepted before the first view", () => {
  const { sight, link, ...rest } = capturing();
  const seen = { ...sight, diagnosis: { ...HEALTHY, trouble: "legacy" } };
  const legacy = (stored) => ({ ...rest, sight: seen, link: { ...link, stored } });
  assert.equal(decide(legacy(0), 1), "relayout");
  assert.equal(decide(legacy(1), 1), null);
});

test("the time in a hidden tab does not count", () => {
  const state = reduce(holding(FACING, 200), { type: "visible", time: 60_000 });
  assert.equal(decide(state, 60_001), null);
  assert.equal(state.sight.stillness.held, 0);
});

test("a picture of another size ends the capture", () => {
  const turned = { ...frame(THERE), size: [720, 1280] };
  const held = holding(THERE, HOLD_MS);
  assert.equal(decide(held, HOLD_MS), "submit");
  const state = reduce(held, { type: "frame", detection: turned, time: HOLD_MS + 50 });
  assert.deepEqual([state.phase, state.failure.code], ["failed", "resized"]);
  assert.equal(decide(state, HOLD_MS + 50), null);
});

test("starting over keeps the cameras and forgets the rest", () => {
  const state = reduce(holding(THERE, 200), { type: "cameras", cameras: [{ id: "a", label: "A" }] });
  const fresh = reduce(state, { type: "restart" });
  assert.deepEqual(
    [fresh.phase, fresh.sight.target, fresh.capture.session, fresh.ui.cameras.length],
    ["welcome", null, null, 1],
  );
});

test("a slow device stays slow", () => {
  const slow = reduce(capturing(), { type: "slow" });
  assert.equal(slow.ui.plain, true);
  assert.equal(reduce(slow, { type: "open" }).ui.plain, true);
});

test("an opening notice is shown once the capture runs", () => {
  const notice = { key: "capture.resized", kind: "plain" };
  const opening = reduce(capturing(), { type: "open", notice });
  for (const type of ["session", "opened-offline"]) {
    const { phase, ui } = reduce(opening, { type, session: SESSION, stored: 0, time: 7_000 });
    assert.deepEqual([phase, ui.notice, ui.noticedAt, ui.openingNotice], ["capturing", notice, 7_000, null]);
  }
  assert.equal(reduce(opening, { type: "session", session: CONVERGED, time: 7_000 }).ui.notice, null);
  const failed = reduce(opening, { type: "failed", code: "not_found" });
  assert.equal(reduce(failed, { type: "open" }).ui.openingNotice, null);
});

test("a board is offered after eight seconds without one", () => {
  const blind = (ms, seen = NOTHING) => frames(seen, ms).reduce(reduce, capturing());
  assert.equal(blind(7_900).detector.boardless, false);
  assert.equal(blind(8_100).detector.boardless, true);
  assert.equal(blind(8_100, { ...NOTHING, markers: 2 }).detector.boardless, false);
  const wanted = reduce(capturing(), { type: "want-board" });
  assert.equal(reduce(wanted, { type: "frame", detection: NOTHING, time: 10 }).ui.boardWanted, true);
  assert.equal(seeing(wanted, THERE, 10).ui.boardWanted, false);
});

test("the target's squares are gone before the board lies on them", () => {
  const at = (overlap, count = 0) =>
    visibility({
      ...capturing(),
      capture: { session: { views: Array(count).fill({}) } },
      link: { stored: 0 },
      sight: { overlap },
    });
  assert.deepEqual([at(0), at(0.25), at(0.5), at(0.9)], [1, 0.5, 0, 0]);
  assert.ok(at(0, 1) < at(0), "who has taken a view knows what a target is");
});

test("a capture can be ended by hand from four views", () => {
  const having = (count, rms, more = {}) =>
    isFinishable({
      capture: {
        session: { views: Array(count).fill({}), calibration: {}, uncertainty: { rms }, img_size: [640, 480] },
      },
      link: { offline: false, stored: 0, ...more },
    });
  assert.deepEqual([having(3, 0.5), having(4, 0.5), having(4, 16)], [false, true, true]);
  assert.equal(having(4, 0.5, { offline: true }), false);
  assert.equal(having(4, 0.5, { stored: 1 }), false);
});

const PLAN = JSON.parse(readFileSync(new URL("../../web/calibrate/plan.json", import.meta.url), "utf8"));
const camera = ([width, height], k1, k2 = 0) =>
  calibrationOf([0.8 * Math.max(width, height)], [(width - 1) / 2 + 12, (height - 1) / 2], {
    distortion_coefficients: [k1, k2, 0, 0, 0],
  });

function isConvex(vertices) {
  const turns = vertices.map(([x, y], index) => {
    const [[a, b], [c, d]] = [vertices[(index + 1) % 4], vertices[(index + 2) % 4]];
    return (a - x) * (d - b) - (b - y) * (c - a);
  });
  return turns.every((turn) => turn > 0) || turns.every((turn) => turn < 0);
}

for (const size of [
  [1280, 720],
  [640, 360],
  [720, 1280],
  [640, 480],
]) {
  for (const [k1, k2] of [
    [0, 0],
    [-0.25, 0],
    [-0.3, 0],
    [-0.35, 0.05],
    [-0.4, 0],
    [-0.45, 0],
    [-0.25, -0.1],
    [-3, 2],
  ]) {
    test(`every target without the service is a whole board, ${size.join("x")}, k1 ${k1}, k2 ${k2}`, () => {
      let from = 0;
      for (let step = 0; step < PLAN.length; step++) {
        const { pose, next } = nextPlanned(PLAN, from, DEFAULT_BOARD, size, camera(size, k1, k2));
        assert.equal(pose.outline.length, 4);
        assert.ok(isConvex(pose.outline), JSON.stringify(pose.outline));
        assert.ok(pose.ids.length >= 24, `${pose.ids.length} corners`);
        assert.ok(observedOutline(DEFAULT_BOARD, { ids: pose.ids, points: pose.corners }));
        from = next;
      }
    });
  }
}

test("the plan's own camera can draw all of it", () => {
  for (const step of PLAN) assert.ok(plannedPose(step, DEFAULT_BOARD, [1280, 720], null));
  assert.equal(nextPlanned([], 0, DEFAULT_BOARD, [1280, 720], null), null);
});

test("an estimate of fewer than three views draws nothing", () => {
  const calibration = camera([1280, 720], -0.2);
  const views = (count, aside = 0) =>
    Array.from({ length: count }, (_, index) => ({ set_aside: index < aside ? {} : null }));
  assert.equal(trustedCalibration(null), null);
  assert.equal(trustedCalibration({ calibration, views: views(2) }), null);
  assert.equal(trustedCalibration({ calibration, views: views(3, 1) }), null);
  assert.equal(trustedCalibration({ calibration, views: views(3) }), calibration);
});

test("an offline target has one size for every model", () => {
  const size = [1280, 720];
  const plain = calibrationOf([1024], [639.5, 359.5]);
  const generalised = calibrationOf([2048], [639.5, 359.5], {
    distortion_model: "omnidirectional",
    distortion_coefficients: [1, 0, 0, 0, 0],
  });
  for (const step of PLAN) {
    const poses = [plain, generalised].map((known) => plannedPose(step, DEFAULT_BOARD, size, known));
    const [expected, actual] = poses.map((pose) => pose.tvec[2]);
    assert.ok(Math.abs(actual / expected - 1) < 1e-12, `${actual} squares away instead of ${expected}`);
  }
});

test("an unknown model is drawn by the plan's own camera", () => {
  const unknown = { ...camera([1280, 720], 0), distortion_model: "double-sphere" };
  assert.deepEqual(
    nextPlanned(PLAN, 0, DEFAULT_BOARD, [1280, 720], unknown),
    nextPlanned(PLAN, 0, DEFAULT_BOARD, [1280, 720], null),
  );
});

const [WIDTH, HEIGHT] = KEY.img_size;
test("an address sets the truth, and another truth is another camera", () => {
  const [one, same, other] = ["k1=-0.25&error=0.5", "k1=-0.25&seed=9", "k1=-0.26&error=0.5"].map((more) =>
    setupFrom(new URLSearchParams(`virtual=1&fx=1000&cx=664.5&k2=0&${more}`)),
  );
  const { fx, fy, cx, k1, k2 } = one.lens;
  assert.deepEqual([fx, fy, cx, k1, k2, one.error], [1000, 1000, 664.5, -0.25, 0, 0.5]);
  assert.notEqual(labelOf(one), labelOf(other));
  assert.equal(labelOf(one), labelOf(same));
});

test("an address sets the frame rate within limits", () => {
  const rate = (address) => setupFrom(new URLSearchParams(address)).rate;
  assert.deepEqual(["", "rate=10", "rate=0", "rate=1e9", "rate=x"].map(rate), [30, 10, 2, 60, 30]);
});

const NARROW = { ...PINHOLE, fx: 640, fy: 640, cx: 664.5, cy: 345, k1: -0.25, k2: 0.05 };
const AIM = { rvec: [0.5, -0.4, 0.1], tvec: [-3, -2, 9] };
/** Distance, px rms, of a board that a lens sees from places. */
const apart = (lens, pose, places) => rms(distances(cornersSeen(DEFAULT_BOARD, lens, pose).points, places));
const hand = (kind, error = 0, seed = 3, focal = NARROW.fx) =>
  new Hand(kind, { error, seed, pivot: [4.5, 3, 0], focal, start: { rvec: [0, 0, 0], tvec: [-4.5, -3, 12] } });

test("the board covers an outline drawn for another lens", () => {
  const drawn = { ...PINHOLE, cx: 639.5, cy: 359.5 };
  const target = targetOf(DEFAULT_BOARD, drawn, AIM);
  assert.ok(apart(NARROW, AIM, target.corners) > 60, "the numbers alone lead far away");
  assert.ok(apart(NARROW, matchPose(DEFAULT_BOARD, NARROW, target), target.corners) < 12);
  assert.ok(apart(drawn, matchPose(DEFAULT_BOARD, drawn, target), target.corners) < 1e-6);
  assert.deepEqual(matchPose(DEFAULT_BOARD, NARROW, AIM), { rvec: AIM.rvec, tvec: AIM.tvec });
});

test("a hand arrives on time and trembles as specified", () => {
  for (const [kind, { travel, tremor, sway }] of Object.entries(HANDS)) {
    const one = hand(kind);
    one.follow(AIM, 1000);
    const settled = 1000 + travel + 10;
    const away = Array.from({ length: 12 }, (_, i) =>
      apart(NARROW, one.pose(settled + 110 * i), see(NARROW, AIM, corners(DEFAULT_BOARD))),
    );
    const limit = 2.5 * (tremor + sway);
    assert.ok(Math.max(...away) <= limit + 1e-9, `${kind}: ${Math.max(...away)} px`);
    assert.ok(tremor === 0 || Math.max(...away) > tremor, kind);
    assert.equal(one.moves(settled), tremor > 0);
  }
});

test("a hand's way does not depend on painted frames", () => {
  const [seldom, often] = ["person", "person"].map((kind) => hand(kind, 1));
  for (let i = 0; i < 50; i++) often.blur();
  for (const each of [seldom, often]) each.follow(AIM, 1000);
  assert.deepEqual(often.pose(3000), seldom.pose(3000));
  assert.ok(Array.from({ length: 100 }, () => often.blur()).some((px) => px > 0));
});

const WEBCAM = { ...PINHOLE, cx: 664.5, cy: 359.5, k1: -0.25 };
const FRAME = 1000 / 15; // ms
const NOISE = 0.1; // px

/** Corners that the detector would find in the picture; none where it is smeared. */
function seen(pose, blur, random) {
  const ids = [];
  const points = [];
  if (blur === 0) {
    see(WEBCAM, pose, corners(DEFAULT_BOARD)).forEach(([u, v], id) => {
      if (u < 4 || v < 4 || u > WIDTH - 5 || v > HEIGHT - 5) return;
      ids.push(id);
      points.push([u + NOISE * (random() - 0.5), v + NOISE * (random() - 0.5)]);
    });
  }
  return { ...NOTHING, ids, points, markers: ids.length };
}

/** A whole capture by the page's own targets, frame by frame, as the capture loop runs it. */
function capture(kind, seed) {
  const random = seededRandom(seed);
  const held = hand(kind, 1, seed, WEBCAM.fx);
  let [planned, skipped, time] = [0, 0, 0];
  let state = reduce(capturing(), { type: "opened-offline", stored: 0, time });
  const dispatch = (event) => (state = reduce(state, event));
  const next = () => {
    const found = nextPlanned(PLAN, planned, DEFAULT_BOARD, KEY.img_size, null);
    planned = found.next;
    dispatch({ type: "pose", pose: found.pose, picture: null, time });
    held.follow(matchPose(DEFAULT_BOARD, WEBCAM, found.pose), time);
  };
  next();
  for (; time < 180_000 && !isEnough(state); time += FRAME) {
    const detection = seen(held.pose(time), held.blur(), random);
    dispatch({ type: "frame", detection, time });
    const action = decide(state, time);
    if (action === "skip") {
      skipped += 1;
      next();
    }
    if (action !== "submit") continue;
    const view = seen(held.pose(time + FRAME), 0, random);
    if (motion(state.sight.corners, view) > 3 * lenienceAfter(time - state.capture.posedAt)) continue;
    dispatch({ type: "stored", corners: view, stored: state.link.stored + 1, time });
    if (!isEnough(state)) next();
  }
  return { views: state.link.stored, seconds: time / 1000, skipped };
}

// Eight views without the service, each a way to the target and a hold of 0.7 s.
const WITHIN = { still: 12, person: 20, shaky: 70, slow: 75 }; // s

for (const [kind, limit] of Object.entries(WITHIN)) {
  test(`a ${kind} hand comes to the end by itself`, () => {
    const { views, seconds, skipped } = capture(kind, 1);
    assert.equal(views, 8, `${views} views in ${seconds} s`);
    assert.ok(seconds < limit, `${seconds.toFixed(1)} s, ${skipped} given up`);
  });
}

const VIRTUAL = { id: "virtual", label: labelOf(setupFrom(new URLSearchParams())) };
const BUILT_IN = { id: "a", label: "Integrated Camera", named: true };
const C920 = { id: "b", label: "C920", named: true };
const wanted = { camera: "C920", img_size: [1280, 720], distortion_model: "rectilinear" };
const fresh = initial(DEFAULT_BOARD, wanted);
const having = (changes, state = fresh) => ({
  ...state,
  ...Object.fromEntries(Object.entries(changes).map(([part, change]) => [part, { ...state[part], ...change }])),
});
const key = { camera: "C920", platform: "X11", img_size: [1280, 720], zoom: 0 };

test("the requested camera is proposed, never the virtual one", () => {
  assert.equal(propose([BUILT_IN, C920, VIRTUAL], "C920", ""), "b");
  assert.equal(propose([BUILT_IN, C920, VIRTUAL], "C920", "a"), "a");
  assert.equal(propose([BUILT_IN, VIRTUAL], "C920", ""), "a");
  assert.equal(propose([VIRTUAL], "C920", ""), "");
  assert.equal(propose([VIRTUAL], VIRTUAL.label, ""), "virtual");
  assert.equal(propose([VIRTUAL], null, ""), "");
  assert.equal(propose([VIRTUAL], null, "virtual"), "virtual");
});

test("a missing camera is reported once names are known", () => {
  const said = (...cameras) => statusText.wanted(having({ ui: { cameras } }));
  const opened = "This page was opened for C920 at 1280\u00a0×\u00a0720.";
  assert.equal(said(BUILT_IN, VIRTUAL), `${opened} That camera is not connected here.`);
  assert.equal(said(C920, VIRTUAL), opened);
  assert.equal(said({ id: "", label: "Camera 1", named: false }, VIRTUAL), opened);
  assert.match(said(VIRTUAL), /No camera was found here/);
});

test("another camera or size than requested is reported", () => {
  const said = (more, wanted = {}) =>
    statusText.cameraMismatch(having({ capture: { key: { ...key, ...more } }, wanted }));
  assert.equal(said({}), "");
  assert.match(said({ camera: "Integrated Camera" }), /C920 at 1280\u00a0×\u00a0720. Open now: Integrated Camera/);
  assert.match(said({ img_size: [640, 480] }), /Open now: C920 at 640\u00a0×\u00a0480/);
  assert.equal(said({}, { camera: null }), "");
});

test("all that is sent is shown, as it is sent", () => {
  const request = {
    ...key,
    board: DEFAULT_BOARD,
    distortion_model: "fisheye",
    target_error: 0.1,
    track: { focusMode: "manual" },
  };
  assert.deepEqual(JSON.parse(statusText.requestText(request)), request);
  const facts = Object.fromEntries(statusText.requestFacts(request));
  assert.equal(Object.keys(facts).length, Object.keys(request).length - 1 + Object.keys(request.track).length);
  assert.equal(facts["Lens model"], "Fisheye");
  assert.equal(facts.Resolution, "1280\u00a0×\u00a0720");
  assert.match(facts.Board, /^9 × 6 squares, DICT_4X4_50/);
});

test("news are announced once, instructions on change", async () => {
  const place = { textContent: "" };
  const announcer = new Announcer(place, 5);
  announcer.say("Closer", "View 1 taken.");
  assert.equal(place.textContent, "View 1 taken. Closer");
  announcer.say("Move left", "View 1 taken.");
  announcer.say("Hold still", "View 2 taken.");
  announcer.say("Move up", "");
  await new Promise((done) => setTimeout(done, 20));
  assert.equal(place.textContent, "View 2 taken. Move up", "news are not lost to what comes after them");
  announcer.say("Turn it", "", "");
  announcer.say("Turn it", "", "Another camera.");
  announcer.say("Turn it", "View 3 taken.", "Another camera.");
  announcer.say("Closer", "View 3 taken.", "Another camera.");
  await new Promise((done) => setTimeout(done, 20));
  assert.equal(place.textContent, "View 3 taken. Another camera. Closer", "nor to what is new of another kind");
});

test("a model that would fit better is offered, unless it is the one", () => {
  const offered = having({ capture: { session: { suggested_model: "fisheye" } } });
  assert.equal(statusText.suggestedModel(offered), "Start again with lens model “Fisheye”");
  assert.equal(statusText.suggestedModel(having({ wanted: { distortion_model: "fisheye" } }, offered)), "");
  assert.equal(statusText.suggestedModel(fresh), "");
});

test("what is waited for is named", () => {
  const said = (waiting, attempts = 0) => statusText.opening(having({ ui: { waiting }, link: { attempts } }));
  assert.match(said("camera"), /If your browser asks, allow it/);
  assert.match(said("service"), /Opening a session at calibDB/);
  assert.match(said("service", 2), /lost. Trying again/);
});

test("the status line says that the detector is loading", () => {
  assert.match(statusText.statusLine(having({ detector: { loading: 0.5 } })), /Loading the board detector/);
  assert.doesNotMatch(statusText.statusLine(having({ detector: { loading: 1 } })), /Loading/);
});

test("the cause of systematic residuals is shown while the capture runs", () => {
  const causeText = (codes, { count = 4, unsteady = false } = {}) => {
    const advice = codes.map((code) => ({ code, text: "" }));
    const session = { advice, suggested_model: "fisheye", views: Array(count).fill({}) };
    return statusText.statusLine(having({ capture: { unsteady, session }, ui: { saved: true } }));
  };
  assert.match(causeText(["board_bent", "limit_reached"]), /Glue it to something rigid/);
  assert.equal(causeText(["board_bent"], { count: 3 }), "");
  assert.equal(causeText(["motion"]), "", "the corners did not move while the views were held");
  assert.match(causeText(["motion"], { unsteady: true }), /Hold it still for longer/);
  assert.match(causeText(["focus_changed"]), /Switch autofocus off/);
  assert.match(causeText(["model_too_simple"]), /“Fisheye” would fit better/);
});

test("the views taken are counted, and four are said to be the least", () => {
  const counted = (count, rms) => {
    const session = { views: Array(count).fill({}), uncertainty: { rms, max: 1 }, target_error: 0.3 };
    return statusText.counts(having({ capture: { session } })).join(" · ");
  };
  assert.equal(counted(1, 19), "1 of about 5 views · at least 4");
  assert.equal(counted(2, 0.2), "2 of about 4 views · accurate enough; 2 more to confirm");
  assert.equal(counted(4, 0.5), "4 of about 5 views");
  assert.equal(counted(6, 0.5), "6 of about 7 views");
});

test("pixels are for who opens the details", () => {
  const session = { views: [], uncertainty: { rms: 0.2, max: 1 }, target_error: 0.3 };
  assert.equal(statusText.accuracy(having({ capture: { session } })), "Accuracy so far: ± 0.20, goal 0.30\u00a0px");
  assert.equal(statusText.accuracy(fresh), "");
});

test("the button that ends the capture says what is lost by it", () => {
  const after = (count, more = {}) => having({ capture: { session: { views: Array(count).fill({}) } }, ...more });
  assert.equal(statusText.stopLabel(after(0)), "Cancel");
  assert.equal(statusText.stopLabel(after(2)), "Stop");
  assert.equal(statusText.stopLabel(after(2, { ui: { stopAskedAt: 1 } })), "Stop?");
});

test("there is one instruction at a time", () => {
  const code = (more) =>
    having({ capture: { skipAfter: 1_000 }, ui: { instruction: { code: "tilt_left", next: "", since: 0 }, ...more } });
  const useless = code({ notice: { key: "capture.useless", kind: "plain" } });
  assert.equal(statusText.instruction(useless), "Looking for a better pose");
  assert.equal(statusText.notice(useless.ui.notice), "");
  const hinted = code({ notice: { key: "capture.refused_too_few_points", kind: "bad", hint: "closer" } });
  assert.equal(statusText.instruction(hinted), "Bring the board closer");
  assert.equal(statusText.notice(hinted.ui.notice), "Too little of the board was visible.");
});
