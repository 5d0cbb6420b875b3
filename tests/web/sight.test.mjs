import assert from "node:assert/strict";
import { test } from "node:test";
import { MOVING, motion, observe } from "../../web/lib/capture/stillness.js";
import { DEFAULT_BOARD, corners, markers, outline } from "../../web/lib/board.js";
import { advice, difference, jaccard } from "../../web/lib/capture/target.js";
import { perturbPose, seededRandom, transformPoint } from "../../web/lib/pose.js";
import { BoardWatch } from "../../web/lib/capture/board-watch.js";
import { BLIND, doubt, isSettled, observeFrame, troubleOf } from "../../web/lib/capture/sight.js";
import { foreshortening, observedOutline } from "../../web/lib/board-outline.js";
import { apply, homography } from "../../web/lib/homography.js";
import { CHESSBOARD, METRICS, PINHOLE, distances, rectangle, rms, see } from "./scenes.mjs";

const at = (x) => ({ ids: [0, 1, 2, 3, 4], points: [0, 1, 2, 3, 4].map((i) => [x + 50 * i, 100]) });

const watch = (positions, width = 1280) =>
  positions.reduce((state, x, index) => observe(state, at(x), 50 * index, width), MOVING);

test("a steady hand is held since its first frame", () => {
  const { held, frames } = watch([100, 101, 100, 99.5, 100.5, 100]);
  assert.deepEqual([held, frames], [250, 5]);
});

test("a jump begins a new hold, once it lasts", () => {
  const { held, frames } = watch([100, 100, 100, 104, 104, 104, 104]);
  assert.deepEqual([held, frames], [50, 1]);
});

test("slow movement is movement: 1.5 px a frame never makes a long hold", () => {
  let state = MOVING;
  for (let index = 0; index < 100; index++) {
    state = observe(state, at(100 + 1.5 * index), 50 * index, 1280);
    assert.ok(state.held <= 200, `held ${state.held} ms`);
  }
});

test("focus settles after a hold, a longer one where little of the board is seen, and not while it looks wrong", () => {
  const settled = (count, held, suspected = null) =>
    isSettled(
      {
        ...BLIND,
        corners: { ids: [...Array(count).keys()], points: [] },
        stillness: { ...MOVING, held },
        diagnosis: { ...BLIND.diagnosis, suspected },
      },
      DEFAULT_BOARD,
    );
  assert.deepEqual([settled(24, 299), settled(24, 300), settled(24, 300, "blurred")], [false, true, false]);
  assert.deepEqual([settled(23, 899), settled(23, 900), settled(23, 900, "blurred")], [false, true, false]);
});

test("the limit scales with the width of the image", () => {
  assert.equal(watch([100, 101.5, 100], 1280).frames, 2);
  assert.equal(watch([100, 101.5, 100], 640).frames, 0);
});

test("a smeared frame is passed over in a hold", () => {
  const held = watch([100, 100, 100]);
  const nothing = { ids: [], points: [] };
  const passed = observe(held, nothing, 150, 1280);
  assert.equal(passed, held);
  assert.equal(observe(passed, at(100), 200, 1280).held, 200);
  assert.equal(observe(passed, at(108), 200, 1280), held);
  assert.equal(observe(passed, at(108), 250, 1280).held, 0);
});

test("time that no frame shows does not count as held", () => {
  const every = (gap) => [0, 1, 2, 3].reduce((state, index) => observe(state, at(100), gap * index, 1280), MOVING);
  assert.equal(every(250).held, 750);
  assert.equal(every(600).held, 750);
});

test("too few common corners are no evidence of stillness", () => {
  const few = { ids: [0, 1, 7, 8], points: at(100).points.slice(1) };
  assert.equal(motion(at(0), few), Infinity);
  assert.equal(observe(watch([100, 100]), few, 200, 1280).held, 0);
});

const LENS = { ...PINHOLE, k1: -0.2 };
const CENTRE = [4.5, 3, 0];
const seen = (pose) => see(LENS, pose, outline(DEFAULT_BOARD));
/** The board turned so about its centre, which is there in the camera's frame. */
function held(rvec, centre) {
  const turned = transformPoint({ rvec, tvec: [0, 0, 0] }, CENTRE);
  return { rvec, tvec: centre.map((value, axis) => value - turned[axis]) };
}
const TILTED = held([0.5, 0.5, 0], [0.5, 0.5, 11]);

test("a followed target overlaps, a board that faces the camera does not", () => {
  const random = seededRandom(3);
  const missed = Array.from({ length: 400 }, () => perturbPose(TILTED, 1, random, CENTRE));
  const apart = missed.map((pose) => difference(seen(pose), seen(TILTED)));
  assert.ok(Math.max(...apart) < 0.08 && rms(apart) > 0.02, `${rms(apart)}`);
  const centres = [TILTED, ...missed].map((pose) => transformPoint(pose, CENTRE));
  const shift = rms(distances(centres.slice(1), Array(400).fill(centres[0]))) / Math.hypot(...centres[0]);
  assert.ok(shift > 0.025 && shift < 0.035, `${shift}`);
  let inPlace = 0;
  for (let z = 9; z < 16; z += 0.25) {
    const facing = seen(held([0, 0, 0], [0.5, 0.5, z]));
    if (jaccard(facing, seen(TILTED), SIZE) <= 0.6) continue;
    inPlace += 1;
    assert.ok(difference(facing, seen(TILTED)) > 0.08, `at ${z}`);
  }
  assert.ok(inPlace > 5, "overlap alone takes it for there");
});

test("the other way up is as good", () => {
  const [a, b, c, d] = seen(TILTED);
  assert.ok(difference([c, d, a, b], seen(TILTED)) < 1e-12);
  assert.equal(advice([c, d, a, b], seen(TILTED)), "");
});

test("the largest difference is named first", () => {
  const target = seen(held([0, 0.5, 0], [0, 0, 11]));
  const said = (rvec, centre) => advice(seen(held(rvec, centre)), target);
  assert.equal(said([0, 0.5, 0], [3, 2.5, 11]), "up_left");
  assert.equal(said([0, 0.4, 0], [-4, 0, 11]), "right");
  assert.equal(said([0, 0.5, 0], [0, 0, 17]), "closer");
  assert.equal(said([0, 0.5, 0], [0, 0, 7]), "farther");
  assert.equal(said([0, 0.45, -0.8], [0, 0, 11]), "turn_clockwise");
  assert.equal(said([0, 0, 0], [0, 0, 11]), "tilt_right");
});

test("the edge named is the one that is nearer in the target", () => {
  const facing = seen(held([0, 0, 0], [0, 0, 11]));
  for (const [rvec, name] of [
    [[0, 0.5, 0], "right"],
    [[0, -0.5, 0], "left"],
    [[0.5, 0, 0], "top"],
    [[-0.5, 0, 0], "bottom"],
  ]) {
    const target = held(rvec, [0, 0, 11]);
    assert.equal(advice(facing, seen(target)), `tilt_${name}`);
  }
});

const SIZE = [1280, 720];

test("areas overlap within the picture, in either winding", () => {
  const board = rectangle(300, 200, 300, 200);
  const diamond = [
    [640, 160],
    [840, 360],
    [640, 560],
    [440, 360],
  ];
  const shifted = (299 * 225) / (2 * 400 * 300 - 299 * 225);
  for (const [one, other, share, error] of [
    [board, board, 1, 0],
    [board, [...board].reverse(), 1, 0],
    [rectangle(100, 100, 200, 200), rectangle(700, 100, 200, 200), 0, 0],
    [[], [], 0, 0],
    [rectangle(-900, -500, 1540, 860), rectangle(0, 0, 640, 360), 1, 0],
    [rectangle(101, 99, 400, 300), rectangle(202, 174, 400, 300), shifted, 0.01],
    [diamond, rectangle(440, 160, 400, 400), 0.5, 0.01],
  ]) {
    const found = jaccard(one, other, SIZE);
    assert.ok(Math.abs(found - share) <= error, `${found}, not ${share}`);
  }
});

const lattice = ([columns, rows], [left, top] = [300, 200]) => ({
  squares: [columns, rows],
  isPlain: true,
  points: Array.from({ length: (columns - 1) * (rows - 1) }, (_, n) => [
    left + 40 * (n % (columns - 1)),
    top + 40 * Math.floor(n / (columns - 1)),
  ]),
});
const nothing = { family: null, markers: [], inverted: false, mirrored: false, size: [1280, 720], chessboard: null };
const chessboard = (squares, place) => ({ ...nothing, chessboard: lattice(squares, place) });
const charuco = (board, more = {}, rows = Infinity) => ({
  ...nothing,
  family: "DICT_4X4_1000",
  ...more,
  markers: markers(board)
    .filter(({ y }) => y < rows)
    .map(({ id, x, y }) => {
      const [left, top, side] = [200 + 60 * x + 10, 100 + 60 * y + 10, 40];
      return { id, corners: rectangle(left, top, side) };
    }),
});
const after = (expected, ...sightings) => {
  const watch = new BoardWatch();
  return sightings.map((sighting, n) => watch.add(sighting, expected, 1000 * n)).at(-1);
};

/** Two looks at the same. */
const twice = (expected, sighting) => after(expected, sighting, sighting);

test("another board is suggested once two looks agree", () => {
  assert.equal(after(DEFAULT_BOARD, chessboard([10, 7])), null);
  const found = twice(DEFAULT_BOARD, chessboard([10, 7]));
  assert.deepEqual([found.board.kind, found.board.squares, found.isCut], ["chessboard", [10, 7], false]);
  assert.equal(twice(CHESSBOARD, chessboard([10, 7])), null);
  assert.equal(twice(DEFAULT_BOARD, nothing), null);
});

test("a board at the picture's edge is cut off", () => {
  assert.equal(twice(DEFAULT_BOARD, chessboard([10, 7], [20, 200])).isCut, true);
  assert.equal(after(DEFAULT_BOARD, chessboard([10, 7]), chessboard([10, 7]), chessboard([10, 6])).isCut, true);
});

test("parts of the expected board are not another board", () => {
  assert.equal(twice(DEFAULT_BOARD, charuco(DEFAULT_BOARD, {}, 4)), null);
  const marked = { ...nothing, chessboard: { ...lattice([6, 4]), isPlain: false } };
  assert.equal(twice(DEFAULT_BOARD, marked), null);
});

test("a mirrored picture is trouble of its own", () => {
  const found = twice(DEFAULT_BOARD, charuco(DEFAULT_BOARD, { mirrored: true }));
  assert.equal(found.mirrored, true);
  assert.equal(troubleOf(found, DEFAULT_BOARD), "mirrored");
  assert.equal(
    troubleOf({ ...found, mirrored: false, board: { ...DEFAULT_BOARD, legacy: true } }, DEFAULT_BOARD),
    "legacy",
  );
  assert.equal(troubleOf({ ...found, mirrored: false, board: CHESSBOARD }, DEFAULT_BOARD), "wrong_board");
});

test("a board that is blurred or far away is not taken for another one", () => {
  const other = twice(DEFAULT_BOARD, chessboard([10, 7]));
  const trouble = (markers, metrics) => {
    const frame = { ids: [], points: [], markers, size: [640, 360], metrics: { ...METRICS, ...metrics } };
    return doubt(observeFrame(BLIND, frame, 1000, DEFAULT_BOARD), other, DEFAULT_BOARD, 1000).diagnosis.trouble;
  };
  assert.equal(trouble(0, {}), "wrong_board");
  assert.equal(trouble(0, { sharpness: 0.061 }), null);
  assert.equal(trouble(4, { square: 12 }), null);
});

test("looks are due while no board is seen, with pauses", () => {
  const watch = new BoardWatch();
  assert.equal(watch.isDue(Infinity, 5000), false);
  assert.equal(watch.isDue(4800, 5000), false);
  assert.equal(watch.isDue(4500, 5000), true);
  watch.add(nothing, DEFAULT_BOARD, 5000);
  assert.equal(watch.isDue(4500, 5200), false);
  assert.equal(watch.isDue(4500, 5500), true);
});

const BARREL = { ...PINHOLE, k1: -0.25 };
const POSE = { rvec: [0.5, -0.6, 0.2], tvec: [-4, -3, 11] };
test("a plane seen by a pinhole is a homography, to 1e-8 px", () => {
  const board = corners(DEFAULT_BOARD);
  const h = homography(board, see(PINHOLE, POSE, board));
  const corner = apply(h, [0, 0]);
  const [truth] = see(PINHOLE, POSE, [[0, 0]]);
  assert.ok(Math.hypot(corner[0] - truth[0], corner[1] - truth[1]) < 1e-8);
});

test("points on a line, or fewer than four, determine none", () => {
  const three = rectangle(0, 0, 1).slice(1);
  assert.equal(homography(three, three), null);
  const line = [0, 1, 2, 3, 4].map((n) => [n, n]);
  assert.equal(homography(line, line), null);
});

test("the outline is found from a quarter of the corners to 2 % of the width", () => {
  const ids = [9, 10, 11, 17, 18, 19, 25, 26, 27, 28];
  const all = see(BARREL, POSE, corners(DEFAULT_BOARD));
  const seen = observedOutline(DEFAULT_BOARD, { ids, points: ids.map((id) => all[id]) });
  const truth = see(BARREL, POSE, outline(DEFAULT_BOARD));
  assert.ok(Math.max(...distances(seen, truth)) < 0.02 * 1280);
  assert.equal(observedOutline(DEFAULT_BOARD, { ids: [0, 1], points: all.slice(0, 2) }), null);
});

test("foreshortening distinguishes a facing board from a tilted one", () => {
  const edge = outline(DEFAULT_BOARD);
  assert.ok(foreshortening(see(PINHOLE, { rvec: [0, 0, 0.3], tvec: [-4, -3, 12] }, edge)) < 1e-9);
  assert.ok(foreshortening(see(PINHOLE, { rvec: [0, 0.5, 0], tvec: [-4, -3, 12] }, edge)) > 0.2);
});
