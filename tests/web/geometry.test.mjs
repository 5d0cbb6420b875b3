// The board that is drawn is the board that OpenCV expects: pixel for pixel, against cv2 itself.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { TABLES } from "../../web/vendor/dictionaries.js";
import { blackRectangles, raster } from "../../web/lib/board-drawing.js";
import { say } from "../../web/lib/i18n.js";
import "./messages.mjs";
import { DEFAULT_BOARD, DICTIONARIES, boardFrom, corners, dictionaryOf } from "../../web/lib/board.js";

const python = fileURLToPath(new URL("../../.venv/bin/python", import.meta.url));

const MARGIN = 21; // px

/** ChArUco boards with their corners as cv2 draws them, and `others` as the solver does. */
function drawnByPython(boards, others) {
  const script = `
import base64, json, sys, cv2
sys.path.insert(0, "layers/solver")
from calibsolver import Board
from calibsolver.guidance.overlay import draw_board
found = []
charuco, others = json.loads(sys.argv[1])
for a in charuco:
    d = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, a["dictionary"]))
    b = cv2.aruco.CharucoBoard(tuple(a["squares"]), 1.0, a["marker_ratio"], d)
    b.setLegacyPattern(a["legacy"])
    w, h = (n * a["scale"] + 2 * a["margin"] for n in a["squares"])
    p = b.generateImage((w, h), marginSize=a["margin"])
    found.append([w, h, base64.b64encode(p.tobytes()).decode(), b.getChessboardCorners().tolist()])
pictures = [draw_board(Board.from_record(record), 120) for record in others]
print(json.dumps([found, [[*reversed(p.shape), base64.b64encode(p.tobytes()).decode()] for p in pictures]]))`;
  const request = boards.map(([, board, scale]) => ({ ...board, scale, margin: MARGIN }));
  const sent = JSON.stringify([request, others]);
  return JSON.parse(execFileSync(python, ["-c", script, sent], { maxBuffer: 1 << 28 }));
}

// Scales at which a marker's cells are whole pixels: elsewhere OpenCV rounds, and rounds each marker differently.
const cases = [
  ["the default board", DEFAULT_BOARD, 120],
  ["a legacy board with an even number of rows", { ...DEFAULT_BOARD, legacy: true }, 120],
  ["a legacy board with an odd number of rows", { ...DEFAULT_BOARD, squares: [6, 7], legacy: true }, 120],
  ["7x7 bits", { squares: [11, 8], marker_ratio: 0.6, dictionary: "DICT_7X7_1000", legacy: true }, 90],
  [
    "the original dictionary",
    { squares: [5, 4], marker_ratio: 0.7, dictionary: "DICT_ARUCO_ORIGINAL", legacy: false },
    100,
  ],
  ["AprilTag 16h5", { squares: [9, 6], marker_ratio: 0.75, dictionary: "DICT_APRILTAG_16h5", legacy: false }, 80],
  ["AprilTag 36h10", { squares: [30, 40], marker_ratio: 0.8, dictionary: "DICT_APRILTAG_36h10", legacy: false }, 50],
  ["AprilTag 36h11", { squares: [8, 11], marker_ratio: 0.8, dictionary: "DICT_APRILTAG_36h11", legacy: true }, 100],
];

const kinds = [
  {
    kind: "aprilgrid",
    squares: [3, 2],
    marker_ratio: 0.65,
    dictionary: "DICT_APRILTAG_36h11",
    legacy: false,
    tag_spacing: 0.25,
  },
  { kind: "chessboard", squares: [5, 4], marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false },
  { ...DEFAULT_BOARD, inverted: true },
];

const [drawings, drawingsOfKinds] = existsSync(python) ? drawnByPython(cases, kinds) : [[], []];

function expectDrawing({ width, height, data }, [expectedWidth, expectedHeight, pixels]) {
  assert.deepEqual([width, height], [expectedWidth, expectedHeight]);
  assert.equal(Buffer.from(pixels, "base64").compare(Buffer.from(data)), 0);
}

for (const [index, [name, board, scale]] of cases.entries()) {
  test(
    `${name} equals OpenCV's drawing in every pixel`,
    { skip: !existsSync(python) && "no Python environment" },
    () => {
      expectDrawing(raster(board, scale, MARGIN), drawings[index]);
      assert.deepEqual(
        corners(board),
        drawings[index][3].map(([x, y]) => [x, y]),
      );
    },
  );
}

test("an unknown or small dictionary is refused by name", () => {
  assert.throws(() => blackRectangles({ ...DEFAULT_BOARD, dictionary: "DICT_9X9_50" }), /DICT_9X9_50/);
  assert.throws(() => blackRectangles({ ...DEFAULT_BOARD, squares: [20, 20] }), /DICT_4X4_50 has 50 markers/);
});

test("a board that cannot be is named, and the default taken", () => {
  for (const [query, reason] of [
    ["squares=2x9", /3 to 50/],
    ["squares=9", /across and down/],
    ["squares=65x3", /3 to 50/],
    ["squares=3x3", /six corners/],
    ["marker_ratio=1", /0.3 to 0.95/],
    ["marker_ratio=wide", /0.3 to 0.95/],
    ["dictionary=DICT_9X9_50", /DICT_9X9_50/],
    ["squares=12x12", /DICT_4X4_50 has 50 markers, and the board needs 72/],
  ]) {
    const { board, problem } = boardFrom(new URLSearchParams(query));
    assert.equal(board, DEFAULT_BOARD, query);
    assert.match(say(`impossible.because_${problem.code}`, problem.values, "en"), reason);
  }
});

test("the dictionaries are the service's", () => {
  const { components } = JSON.parse(readFileSync(new URL("../../.build/openapi.json", import.meta.url), "utf8"));
  assert.deepEqual(DICTIONARIES, components.schemas.Board.properties.dictionary.enum);
  for (const name of DICTIONARIES) {
    const { size, side, count } = dictionaryOf(name);
    assert.equal(side, TABLES[size].side, name);
    assert.ok(count <= TABLES[size].count, name);
  }
});

test(
  "boards of other kinds equal the solver's drawings in every pixel",
  { skip: !existsSync(python) && "no Python environment" },
  () => {
    kinds.forEach((board, index) => {
      expectDrawing(raster(board, 120), drawingsOfKinds[index]);
    });
  },
);
