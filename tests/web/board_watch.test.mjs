import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD, markers } from "../../web/lib/board.js";
import { BoardWatch } from "../../web/lib/capture/board-watch.js";
import { troubleOf } from "../../web/lib/capture/sight.js";

const CHESSBOARD = { ...DEFAULT_BOARD, kind: "chessboard", squares: [10, 7] };
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
      return {
        id,
        corners: [
          [left, top],
          [left + side, top],
          [left + side, top + side],
          [left, top + side],
        ],
      };
    }),
});
const after = (expected, ...sightings) => {
  const watch = new BoardWatch();
  return sightings.map((sighting, n) => watch.add(sighting, expected, 1000 * n)).at(-1);
};

test("another board is suggested once two looks agree, and the expected one is not", () => {
  assert.equal(after(DEFAULT_BOARD, chessboard([10, 7])), null);
  const found = after(DEFAULT_BOARD, chessboard([10, 7]), chessboard([10, 7]));
  assert.deepEqual([found.board.kind, found.board.squares, found.isCut], ["chessboard", [10, 7], false]);
  assert.equal(after(CHESSBOARD, chessboard([10, 7]), chessboard([10, 7])), null);
  assert.equal(after(DEFAULT_BOARD, nothing, nothing, nothing), null);
});

test("a board that may go on beyond the picture's edge is said to be cut off", () => {
  assert.equal(after(DEFAULT_BOARD, chessboard([10, 7], [20, 200]), chessboard([10, 7], [20, 200])).isCut, true);
  assert.equal(
    after(DEFAULT_BOARD, chessboard([10, 7]), chessboard([10, 7]), chessboard([10, 6])).isCut,
    true,
    "the looks differ",
  );
});

test("the upper rows of the expected board are no other board, and what is not plain is no chessboard", () => {
  assert.equal(after(DEFAULT_BOARD, charuco(DEFAULT_BOARD, {}, 4), charuco(DEFAULT_BOARD, {}, 4)), null);
  const marked = { ...nothing, chessboard: { ...lattice([6, 4]), isPlain: false } };
  assert.equal(after(DEFAULT_BOARD, marked, marked), null);
});

test("a mirrored picture is trouble of its own, be the board the expected one", () => {
  const found = after(
    DEFAULT_BOARD,
    charuco(DEFAULT_BOARD, { mirrored: true }),
    charuco(DEFAULT_BOARD, { mirrored: true }),
  );
  assert.equal(found.mirrored, true);
  assert.equal(troubleOf(found, DEFAULT_BOARD), "mirrored");
  assert.equal(
    troubleOf({ ...found, mirrored: false, board: { ...DEFAULT_BOARD, legacy: true } }, DEFAULT_BOARD),
    "legacy",
  );
  assert.equal(troubleOf({ ...found, mirrored: false, board: CHESSBOARD }, DEFAULT_BOARD), "wrong_board");
});

test("looks are due where the board has not been seen for a while, and not one after the other", () => {
  const watch = new BoardWatch();
  assert.equal(watch.isDue(Infinity, 5000), false);
  assert.equal(watch.isDue(4800, 5000), false);
  assert.equal(watch.isDue(4500, 5000), true);
  watch.add(nothing, DEFAULT_BOARD, 5000);
  assert.equal(watch.isDue(4500, 5200), false);
  assert.equal(watch.isDue(4500, 5500), true);
});
