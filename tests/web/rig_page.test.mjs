import assert from "node:assert/strict";
import { test } from "node:test";
import { ApiError, OfflineError } from "../../web/lib/api.js";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { composePoses } from "../../web/lib/pose.js";
import { BLIND, observeFrame } from "../../web/lib/capture/sight.js";
import { MOVING } from "../../web/lib/capture/stillness.js";
import { intrinsicsOf } from "../../web/lib/virtual/lens.js";
import { RigLink } from "../../web/rig/link.js";
import { JoinError, enter } from "../../web/rig/membership.js";
import { answer, isReady, remoteHold, requiredHold } from "../../web/rig/moments.js";
import { Outbox } from "../../web/rig/outbox.js";
import { hasPlateau, isAlone, isComplete, isFinishable, silentPositions } from "../../web/rig/progress.js";
import { boardInRig, relationOf } from "../../web/rig/relations.js";
import { boardPose, cameraPose, setupAt } from "../../web/rig/scene.js";
import { inTurn } from "./globals.mjs";
import { cornersSeen, distances, targetOf } from "./scenes.mjs";
import { labelOfHalf, placeOf } from "../../web/lib/capture/streams.js";

const POINTS = [0, 1, 2, 3, 4, 5].map((i) => [100 + 50 * i, 100 + 20 * (i % 2)]);
const detection = (shift = 0) => ({
  ids: [0, 1, 2, 3, 4, 5],
  points: POINTS.map(([x, y]) => [x + shift, y]),
  markers: 6,
  size: [1280, 720],
});

/** Sight of a board that jumped at `since` and is looked at every 50 ms until `until`. */
function sightOf(since, until) {
  let sight = observeFrame(BLIND, detection(200), since - 50, DEFAULT_BOARD);
  for (let time = since; time <= until; time += 50) sight = observeFrame(sight, detection(), time, DEFAULT_BOARD);
  return sight;
}

test("a view needs a board that was still before its moment was opened", () => {
  const sight = sightOf(1_000, 3_000);
  assert.equal(answer(sight, { unopenedAt: 1_500, seenAt: 2_800 }, 3_000), "take");
  assert.equal(answer(sight, { unopenedAt: 999, seenAt: 2_800 }, 3_000), "miss");
  assert.equal(answer(sight, { unopenedAt: 1_500, seenAt: 3_010 }, 3_020), "wait");
  const moved = observeFrame(sight, detection(40), 3_200, DEFAULT_BOARD);
  assert.equal(answer(moved, { unopenedAt: 1_500, seenAt: 3_100 }, 3_200), "miss");
  assert.equal(answer(BLIND, { unopenedAt: 1_500, seenAt: 2_000 }, 2_000), "miss");
});

test("a hand at 5 cm/s is not still after 200 ms", () => {
  // 60 cm before a camera of 1,000 px: 83 px/s, which is 4 px from one frame to the next.
  let sight = sightOf(0, 1_000);
  for (let time = 1_050, x = 0; time < 2_000; time += 50)
    sight = observeFrame(sight, detection((x += 4.2)), time, DEFAULT_BOARD);
  assert.equal(answer(sight, { unopenedAt: 1_900, seenAt: 1_910 }, 2_000), "miss");
  assert.ok(!isReady([sight], 0));
});

test("other devices need a longer hold, and longer after a miss", () => {
  const still = (hold) => sightOf(0, hold);
  assert.ok(!isReady([still(1_400)], 0) && isReady([still(1_500)], 0));
  assert.ok(!isReady([still(1_500)], remoteHold(0)) && isReady([still(1_900)], remoteHold(0)));
  assert.ok(remoteHold(0) < remoteHold(1) && remoteHold(99) === 5_000);
  const taken = still(3_000);
  assert.equal(requiredHold([{ ...taken, lastTaken: taken.corners }], 0), null);
  assert.equal(requiredHold([{ ...taken, stillness: MOVING, corners: { ids: [], points: [] } }], 0), null);
});

const LETTERS = [
  { kind: "open", moment: "a" },
  ...[0, 1].map((position) => ({ kind: "view", position, session: "s", moment: "a", ids: [1], points: [[1, 1]] })),
];

/** An outbox over a service that gives what `answers` has; what it did is in `log`. */
function boxOf(answers, letters = []) {
  const log = [];
  const saved = [];
  const box = new Outbox(
    {
      send: async (letter) => {
        log.push(`${letter.kind} ${letter.position ?? letter.moment}`);
        return inTurn(answers) ?? {};
      },
      save: () => saved.push(box.letters.length),
      onSent() {},
      onRefused: (_, error) => log.push(`refused ${error.status}`),
      onLink: (offline) => log.push(offline ? "offline" : "online"),
    },
    letters,
  );
  return { box, log, saved };
}

test("captured views are delivered in order", async () => {
  const { box, log, saved } = boxOf([{}, new OfflineError(), new ApiError(503, {}), {}, {}]);
  box.post(...LETTERS);
  const sending = box.flush();
  for (let turn = 0; turn < 40; turn++) {
    await new Promise(setImmediate);
    box.retry();
  }
  await sending;
  assert.deepEqual(log, ["open a", "view 0", "offline", "view 0", "view 0", "online", "view 1"]);
  assert.deepEqual([saved[0], saved.at(-1), box.views], [3, 0, 0], "kept before it is sent, forgotten after it was");
});

test("a refused letter does not hold up the rest", async () => {
  const { box, log } = boxOf([{}, new ApiError(409, { type: "x#moment-undone" }), {}], LETTERS);
  await box.flush();
  assert.deepEqual(log, ["open a", "view 0", "refused 409", "view 1"]);
});

test("a moment is withdrawn until its opening is on its way", () => {
  const { box } = boxOf([]);
  box.post(...LETTERS);
  assert.equal(box.withdraw("a"), false);
  assert.equal(boxOf([], LETTERS).box.withdraw("a"), true);
  assert.deepEqual(box.letters, []);
});

test("the link tells since when what is new was not there", async () => {
  const states = [{ status: "capturing", moments: [] }, null, { status: "finished", moments: [1] }];
  const told = [];
  const service = {
    async state() {
      const state = inTurn(states);
      return state && { state, etag: "e" };
    },
  };
  const link = new RigLink({
    service,
    id: "r",
    session: "s",
    signal: new AbortController().signal,
    onState: (state, unopenedAt) => told.push([state.moments.length, unopenedAt]),
    onLink() {},
    onFailure: assert.fail,
  });
  const running = link.run();
  for (let turn = 0; turn < 20; turn++) {
    await new Promise(setImmediate);
    link.hurry();
  }
  await running;
  assert.deepEqual(told[0], [0, -Infinity], "of what was there at first nobody knows");
  assert.ok(Number.isFinite(told[1][1]));
});

const REQUEST = { camera: "c", platform: "p", img_size: [640, 480], board: DEFAULT_BOARD };
const memberAt = (position) => ({ position, session: "", opened: false, request: null });
const recordOf = (leads, ...members) => ({ about: "", leads, cameras: 3, square_size: 0.03, members });

test("a reloaded page joins a rig with the same sessions", async () => {
  const calls = [];
  let isLost = true;
  let sessions = 0;
  const service = {
    authenticate: async () => `s${sessions++}`,
    openSession: async (session, { rig }) => {
      calls.push([session, rig]);
      if (rig && isLost) throw new OfflineError();
      return { rig: rig && { id: "r", position: rig.position ?? 1 } };
    },
    create: async (session, body) => calls.push([session, body]) && { rig_id: "r", join_code: "ABC234", expires_at: 9 },
  };
  const record = recordOf(true, memberAt(0), memberAt(1));
  const saves = [];
  const save = async () => saves.push(record.about);
  await assert.rejects(enter(service, record, [REQUEST, REQUEST], { save }), OfflineError);
  isLost = false;
  assert.equal(await enter(service, record, [REQUEST, REQUEST], { save }), null);
  assert.deepEqual(calls, [
    ["s0", undefined],
    ["s0", { cameras: 3, square_size: 0.03 }],
    ["s1", { id: "r", position: 1 }],
    ["s1", { id: "r", position: 1 }],
  ]);
  assert.ok(saves.every((id) => id === "r") && record.members.every(({ opened }) => opened));
});

test("a refused code is told apart from another board", async () => {
  for (const [field, code] of [
    ["rig.code", "code"],
    ["rig.position", "position"],
    ["board", "board"],
  ]) {
    const service = {
      authenticate: async () => "s",
      openSession: async () => {
        throw new ApiError(422, { detail: "Not valid.", errors: [{ field, detail: "no" }] });
      },
    };
    await assert.rejects(
      enter(service, recordOf(false, memberAt(0)), [REQUEST], { code: "ABC234", save: async () => {} }),
      (error) => error instanceof JoinError && error.code === code,
    );
  }
});

test("the simulated board covers the target in the first camera", () => {
  const parameters = new URLSearchParams("error=0");
  const { lens, size } = setupAt(parameters, 0);
  const pose = { rvec: [0.3, -0.2, 0.1], tvec: [-4, -3, 14] };
  const target = { position: 0, ...targetOf(DEFAULT_BOARD, lens, pose), rvec: [0.32, -0.2, 0.1] };
  const found = boardPose([{ ...target, position: 3 }, target].reverse(), DEFAULT_BOARD, parameters);
  const off = distances(cornersSeen(DEFAULT_BOARD, lens, found).points, target.corners);
  assert.ok(Math.max(...off) < 0.1, `${Math.max(...off)} px of ${size[0]}`);
  assert.equal(boardPose([], DEFAULT_BOARD, parameters), null);
});

test("a board seen by any camera of the rig is found where it is", () => {
  const board = { rvec: [0.2, 0.3, -0.1], tvec: [-4, -2, 15] };
  const extrinsics = [0, 1].map((position) => ({
    position,
    ...cameraPose(position),
    std: [0.001, 0.001, 0.001, 0.01, 0.02, 0.03],
  }));
  const lenses = [0, 1].map((position) => setupAt(new URLSearchParams(), position));
  const calibrations = lenses.map(({ lens, size }) => ({ ...intrinsicsOf(lens), img_size: size }));
  const there = composePoses(cameraPose(1), board);
  const seen = cornersSeen(DEFAULT_BOARD, lenses[1].lens, there);
  const found = boardInRig({ calibrations, extrinsics }, 1, seen, DEFAULT_BOARD, 1);
  for (const name of ["rvec", "tvec"])
    found[name].forEach((value, axis) => assert.ok(Math.abs(value - board[name][axis]) < 1e-3));
  const { distance, distanceStd, angle } = relationOf(extrinsics[1]);
  assert.ok(Math.abs(distance - Math.hypot(...cameraPose(1).tvec)) < 1e-12 && distanceStd > 0.01 && distanceStd < 0.03);
  assert.ok(angle > 9 && angle < 11);
});

test("the halves of a stereo picture are named cameras", () => {
  assert.deepEqual(placeOf("right", [2560, 720]), { size: [1280, 720], offset: [1280, 0] });
  assert.deepEqual(placeOf("bottom", [641, 961]), { size: [641, 480], offset: [0, 481] });
  assert.deepEqual(placeOf(null, [640, 480]), { size: [640, 480], offset: [0, 0] });
  assert.equal(labelOfHalf("ZED 2 (2b03:f780)", "left"), "ZED 2 left (2b03:f780)");
  assert.equal(labelOfHalf("ZED 2", null), "ZED 2");
});

test("a rig ends when it is accurate or nothing more comes", () => {
  const cameras = [0, 1].map((position) => ({ position, status: "capturing", views: 4 }));
  const moment = (id, ...positions) => ({ id, positions });
  const state = {
    status: "capturing",
    cameras,
    unlinked: [],
    rms: 0.1,
    target_error: 0.3,
    uncertainty: { rms: 0.2 },
    moments: [moment("a", 0, 1), moment("b", 0, 1)],
  };
  assert.ok(isComplete(state, 0, []) && !isAlone(state));
  assert.deepEqual(silentPositions(state, [0]), []);
  assert.deepEqual(
    silentPositions({ ...state, moments: [moment("a", 0, 1), moment("b", 0), moment("c", 0)] }, [0]),
    [1],
  );
  const inaccurate = { ...state, uncertainty: { rms: 0.31 } };
  assert.ok(!isComplete(inaccurate, 30_000, []));
  assert.ok(isComplete(inaccurate, 30_001, []));
  assert.ok(isComplete({ ...inaccurate, moments: Array(20).fill(moment("a", 0, 1)) }, 0, []));
  assert.ok(!isComplete({ ...state, unlinked: [1] }, 60_000, []));
  assert.ok(!isFinishable({ ...state, unlinked: [1] }));
  assert.ok(!isFinishable({ ...state, cameras: [cameras[0], { ...cameras[1], views: 3 }] }));
  assert.ok(isAlone({ ...state, cameras: [cameras[0], { ...cameras[1], status: "waiting" }] }));
  const course = [9, 8, 7, 6, 5, 4, 2.1, 2, 2, 1.9].map((rms) => ({ rms, atTarget: true }));
  assert.ok(isComplete(inaccurate, 0, course));
});

test("a rig's error has a plateau after ten moments", () => {
  const of = (errors, missed = -1) => errors.map((rms, n) => ({ rms, atTarget: n !== missed }));
  const still = [null, null, null, 6, 5, 4, 2, 2, 2, 1.8];
  assert.ok(hasPlateau(of(still)));
  assert.ok(!hasPlateau(of(still.slice(1))));
  assert.ok(!hasPlateau(of([...still.slice(0, 9), 1.6])));
  assert.ok(!hasPlateau(of([...still.slice(0, 9), 2.7])));
  assert.ok(!hasPlateau(of(still, 8)));
  assert.ok(hasPlateau(of(still, 5)));
  assert.ok(!hasPlateau(of([...still.slice(0, 9), null])));
});
