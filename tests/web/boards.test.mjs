import assert from "node:assert/strict";
import { test } from "node:test";
import {
  DEFAULT_BOARD,
  boardFrom,
  boardQuery,
  circlesCommand,
  corners,
  impossible,
  isSameBoard,
  markers,
  outline,
} from "../../web/lib/board.js";
import { blackRectangles, exactScale, markerBits } from "../../web/lib/board-drawing.js";
import { PRESETS } from "../../web/lib/board-form.js";
import { recognise } from "../../web/lib/board-recognition.js";
import { findChessboard, recogniseChessboard, shrunk } from "../../web/lib/chessboard.js";
import { apply } from "../../web/lib/homography.js";
import { fitGrid } from "../../web/lib/marker-grid.js";
import { cameraOfNames } from "../../web/photos/files.js";
import { boardPdf } from "../../web/lib/board-pdf.js";
import { PAPERS, squareSide } from "../../web/lib/papers.js";
import { refine, refineCorner, squareSizes } from "../../web/lib/subpixel.js";
import { readMarkers } from "../../web/lib/marker-reader.js";
import { CHESSBOARD, PINHOLE, cornersSeen, distances, photograph, rectangle, rms } from "./scenes.mjs";

const VIEW = [40, 6, 90, -4, 38, 320, 0.008, 0.011, 1]; // board to picture
const APRILGRID = {
  kind: "aprilgrid",
  squares: [6, 5],
  marker_ratio: 0.65,
  dictionary: "DICT_APRILTAG_36h11",
  legacy: false,
  tag_spacing: 0.25,
};

/** Markers of a board as a picture shows them; turned: quarter turns of the tags on an AprilGrid. */
function seen(board, { turned = 0, keep = () => true } = {}) {
  const isGrid = board.kind === "aprilgrid";
  return markers(board)
    .filter(keep)
    .map(({ id, x, y }) => {
      const pitch = 1 + (board.tag_spacing ?? 0.3);
      const margin = isGrid ? 0 : (1 - board.marker_ratio) / 2;
      const side = isGrid ? 1 : board.marker_ratio;
      const [left, top] = isGrid ? [x * pitch, -y * pitch - 1] : [x + margin, y + margin];
      const clockwise = rectangle(left, top, side);
      return { id, corners: [0, 1, 2, 3].map((n) => apply(VIEW, clockwise[(n + turned) % 4])) };
    });
}
const sighting = (family, found, more = {}) => ({
  family,
  markers: found,
  inverted: false,
  chessboard: null,
  size: [1280, 720],
  ...more,
});

test("boards of all kinds go through an address and back", () => {
  const legacy = { squares: [8, 11], marker_ratio: 0.75, dictionary: "DICT_5X5_100", legacy: true };
  const inverted = { ...DEFAULT_BOARD, inverted: true };
  const shown = { ...DEFAULT_BOARD, surface: "screen" };
  for (const board of [...PRESETS.map((preset) => preset.board), legacy, inverted, shown])
    assert.deepEqual(boardFrom(boardQuery(board)), { board, problem: null });
  assert.equal(boardQuery(DEFAULT_BOARD).toString(), "");
  assert.ok(isSameBoard({ ...DEFAULT_BOARD, kind: "charuco" }, DEFAULT_BOARD));
  assert.ok(isSameBoard(shown, DEFAULT_BOARD), "a camera cannot see what shows the board");
  assert.deepEqual(boardFrom(new URLSearchParams("surface=paper")).board, DEFAULT_BOARD);
  assert.equal(new Set(PRESETS.map(({ board }) => boardQuery(board).toString())).size, PRESETS.length);
});

test("boards of other kinds have limits of their own", () => {
  const code = (more) => impossible({ ...APRILGRID, ...more })?.code ?? null;
  assert.equal(code({}), null);
  assert.deepEqual(
    [
      code({ dictionary: "DICT_4X4_50" }),
      code({ tag_spacing: 0 }),
      code({ squares: [1, 1] }),
      code({ squares: [50, 50] }),
      code({ kind: "dots" }),
    ],
    ["family", "spacing", "few_corners", "many_corners", "kind"],
  );
  assert.equal(impossible({ ...DEFAULT_BOARD, kind: "chessboard", squares: [40, 40] }), null);
});

test("an AprilGrid is numbered as Kalibr numbers it", () => {
  const points = corners(APRILGRID);
  assert.deepEqual(points.slice(0, 5), [
    [0, 0],
    [1, 0],
    [1, -1],
    [0, -1],
    [1.25, 0],
  ]);
  assert.deepEqual(points[4 * 6 + 2], [1, -2.25]);
  assert.deepEqual(outline(APRILGRID), [
    [0, -6],
    [7.25, -6],
    [7.25, 0],
    [0, 0],
  ]);
});

test("an AprilGrid is drawn with every corner on a whole pixel", () => {
  const spaced = (tag_spacing) => ({ ...APRILGRID, tag_spacing });
  assert.deepEqual(
    [exactScale(spaced(0.25), 64), exactScale(spaced(0.3), 64), exactScale(DEFAULT_BOARD, 61)],
    [64, 60, 61],
  );
});

test("markers tell squares, layout and ratio of their board", () => {
  for (const [squares, legacy, ratio] of [
    [[9, 6], false, 0.65],
    [[8, 6], true, 0.6],
    [[7, 4], true, 0.7],
    [[14, 9], false, 0.75],
  ]) {
    const board = { squares, legacy, marker_ratio: ratio, dictionary: "DICT_5X5_1000" };
    const found = recognise([sighting("DICT_5X5_1000", seen(board))]);
    assert.deepEqual({ ...found.board, dictionary: "" }, { ...board, dictionary: "" }, `${squares} ${legacy}`);
    assert.equal(found.board.dictionary, squares[0] === 14 ? "DICT_5X5_100" : "DICT_5X5_50");
  }
});

test("tags of an AprilGrid may be turned on it", () => {
  for (const turned of [0, 2]) {
    const found = recognise([sighting("DICT_APRILTAG_36h11", seen(APRILGRID, { turned }))]);
    assert.deepEqual(found.board, APRILGRID);
  }
});

test("parts of a board identify it, false markers do not", () => {
  const parts = [({ y }) => y < 3, ({ y }) => y > 1].map((keep) => seen(DEFAULT_BOARD, { keep }));
  parts[0].push({ id: 26, corners: rectangle(10, 10, 30) });
  const found = recognise(parts.map((part) => sighting("DICT_4X4_1000", part)));
  assert.deepEqual(found.board.squares, [9, 6]);
  assert.equal(fitGrid(seen(DEFAULT_BOARD, { keep: ({ y }) => y === 0 }), false), null);
  const random = Array.from({ length: 12 }, (_, n) => ({
    id: (n * 37) % 50,
    corners: rectangle((n * 311) % 900, (n * 173) % 600, 20),
  }));
  assert.equal(fitGrid(random, true), null);
  assert.equal(recognise([sighting(null, [])]), null);
});

const LENS = { ...PINHOLE, fx: 600, fy: 600, cx: 320, cy: 240 };

test("a whole chessboard is found to 0.05 px rms", () => {
  const pose = { rvec: [-0.3, 0.2, 0.13], tvec: [-4.7, -3.5, 13.5] };
  const picture = photograph(CHESSBOARD, LENS, [640, 480], pose);
  const { points: truth } = cornersSeen(CHESSBOARD, LENS, pose);
  const { ids, points } = findChessboard(picture, [10, 7]);
  assert.equal(ids.length, 54);
  const errors = distances(
    points,
    ids.map((id) => truth[id]),
  );
  assert.ok(rms(errors) < 0.05 && Math.max(...errors) < 0.2, `${errors} px`);
  assert.deepEqual(findChessboard(picture, [9, 7]).ids, []);
  assert.equal(findChessboard(picture, [10, 7], { full: false }).ids.length, 54);
  const seenBoard = recogniseChessboard(picture);
  assert.deepEqual([seenBoard.squares, seenBoard.isPlain], [[10, 7], true]);
  const cut = photograph(CHESSBOARD, LENS, [640, 480], { ...pose, tvec: [0, -3.5, 13.5] });
  assert.equal(findChessboard(cut, [10, 7]).ids.length, 0);
  assert.equal(recogniseChessboard({ width: 200, height: 150, data: new Uint8Array(30000).fill(99) }), null);
});

test("a small copy of a picture has the means of its pixels", () => {
  const small = shrunk({ width: 4, height: 2, data: Uint8Array.from([0, 2, 10, 10, 2, 4, 10, 10]) }, 2);
  assert.deepEqual([small.width, small.height, ...small.data], [2, 1, 2, 10]);
});

test("files name their camera where they begin with its name", () => {
  const lifecam = [
    "Microsoft_LifeCam_HD-3000_output_2024-05-07T072708807.jpg",
    "Microsoft_LifeCam_HD-3000_output_2024-05-07T072715764.jpg",
  ];
  assert.equal(cameraOfNames(lifecam), "Microsoft LifeCam HD-3000");
  assert.equal(cameraOfNames(lifecam.map((name) => name.replace("3000_", "3000-1280_"))), "Microsoft LifeCam HD-3000");
  assert.equal(cameraOfNames(["IMG_0231.jpg", "IMG_0232.jpg"]), "");
  assert.equal(cameraOfNames(["GoPro Hero9 001.mp4"]), "GoPro Hero9");
  assert.equal(cameraOfNames(["20240507_1.jpg"]), "");
  assert.equal(cameraOfNames([]), "");
});

const CIRCLES = {
  kind: "asymmetric_circles",
  squares: [4, 11],
  marker_ratio: 0.5,
  dictionary: "DICT_4X4_50",
  legacy: false,
};

test("circles are where OpenCV has them, at true size", () => {
  const places = corners(CIRCLES);
  assert.equal(places.length, 44);
  assert.deepEqual(
    [places[0], places[1], places[4], places[43]],
    [
      [1, 1],
      [3, 1],
      [2, 2],
      [7, 11],
    ],
  );
  assert.deepEqual(corners({ ...CIRCLES, kind: "circles", squares: [3, 2] }).at(-1), [3, 2]);
  assert.deepEqual(outline(CIRCLES).at(2), [9, 12]);
  const area = blackRectangles(CIRCLES).reduce((sum, [, , width, height]) => sum + width * height, 0);
  assert.ok(Math.abs(area / (44 * Math.PI * 0.25 ** 2) - 1) < 1e-3, String(area));
});

test("pages that detect boards name the command for circles", () => {
  const query = boardQuery(CIRCLES);
  assert.deepEqual(boardFrom(query, { circles: true }).board, CIRCLES);
  const { board, problem } = boardFrom(query);
  assert.equal(isSameBoard(board, DEFAULT_BOARD), true);
  assert.deepEqual([problem.code, problem.values.command], ["circles", circlesCommand(CIRCLES)]);
  assert.equal(
    circlesCommand({ ...CIRCLES, inverted: true }),
    "calibdb calibrate photos/ --offline --kind asymmetric_circles --squares 4x11 --marker-ratio 0.5 --inverted",
  );
  assert.equal(impossible({ ...CIRCLES, squares: [1, 9] }).code, "squares");
  assert.equal(impossible({ ...CIRCLES, squares: [2, 2] }).code, "few_corners");
});

const FOOT = { bar: "100 mm", lines: ["9 × 6 Felder (28 mm)", "Eben muß sie sein."] };
const PDF = Buffer.from(boardPdf(DEFAULT_BOARD, PAPERS.A4, FOOT, () => null)).toString("latin1");

test("squares are whole millimetres, as large as the paper allows", () => {
  assert.equal(squareSide(DEFAULT_BOARD, PAPERS.A4), 28);
  assert.ok(squareSide(DEFAULT_BOARD, PAPERS.A3) > 40);
});

test("the cross-reference table points at the objects", () => {
  const start = Number(/startxref\n(\d+)/.exec(PDF)[1]);
  assert.equal(PDF.slice(start, start + 4), "xref");
  const offsets = [...PDF.slice(start).matchAll(/^(\d{10}) 00000 n /gm)].map(([, offset]) => Number(offset));
  assert.equal(offsets.length, 5);
  offsets.forEach((offset, index) => assert.ok(PDF.startsWith(`${index + 1} 0 obj`, offset)));
  const stream = /stream\n(.*)\nendstream/s.exec(PDF)[1];
  assert.equal(Number(/Length (\d+)/.exec(PDF)[1]), stream.length);
});

test("the page is A4 and the board on it true to scale", () => {
  const [, , width, height] = /MediaBox \[(.*?)\]/.exec(PDF)[1].split(" ").map(Number);
  assert.ok(Math.abs(width - (297 * 72) / 25.4) < 0.01 && Math.abs(height - (210 * 72) / 25.4) < 0.01);
  const rectangles = [...PDF.matchAll(/^(.+) re$/gm)].map(([, numbers]) => numbers.split(" ").map(Number));
  const expected = blackRectangles(DEFAULT_BOARD);
  const side = (28 * 72) / 25.4;
  const left = Math.min(...rectangles.slice(0, expected.length).map(([x]) => x));
  const top = Math.max(...rectangles.slice(0, expected.length).map(([, y, , h]) => y + h));
  expected.forEach(([x, y, w, h], index) => {
    const [u, v, a, b] = rectangles[index];
    const off = [u - left - x * side, v + b - top + y * side, a - w * side, b - h * side];
    assert.ok(Math.max(...off.map(Math.abs)) < 2e-3, `rectangle ${index} is ${off} points off`);
  });
  assert.ok(rectangles.slice(expected.length).some(([, , w]) => Math.abs(w - (100 * 72) / 25.4) < 1e-3));
});

test("captions are escaped", () => {
  assert.ok(PDF.includes("(9 × 6 Felder \\(28 mm\\)) Tj"));
});

const SIZE = [640, 360];
const BARREL = { fx: 500, fy: 505, cx: 327.3, cy: 172.8, k1: -0.25, k2: 0.05, p1: 0.001, p2: -0.002, k3: 0 };

function scene(pose) {
  return { image: photograph(DEFAULT_BOARD, BARREL, SIZE, pose), ...cornersSeen(DEFAULT_BOARD, BARREL, pose) };
}

const POSE = { rvec: [0.3, -0.4, 0.1], tvec: [-4.2, -2.9, 9] };

test("corners that start up to 0.8 px away come back to 0.1 px rms", () => {
  const { image, points, ids } = scene(POSE);
  const started = points.map(([x, y], index) => [x + 0.8 * Math.cos(index), y + 0.8 * Math.sin(index)]);
  const { ids: kept, points: refined } = refine(image, { ids, points: started }, 8);
  assert.equal(kept.length, 40);
  const errors = distances(refined, points);
  assert.ok(rms(errors) < 0.1 && Math.max(...errors) < 0.2, `${errors} px`);
});

test("a corner that is not there is dropped", () => {
  const { image, points, ids } = scene(POSE);
  const wrong = points.map((point) => [...point]);
  wrong[11][0] += 3; // more than the 1 px that a detector may be wrong by
  assert.ok(!refine(image, { ids, points: wrong }, 8).ids.includes(11));
});

test("corners of squares below 16 px are dropped", () => {
  const { image, points, ids } = scene({ rvec: [0, 0, 0], tvec: [-4.5, -3, 36] });
  assert.deepEqual(refine(image, { ids, points }, 8).ids, []);
});

test("a flat patch and the image's edge hold no corner", () => {
  const image = { width: 64, height: 64, data: new Uint8Array(64 * 64).fill(90) };
  assert.equal(refineCorner(image, 30, 30, 4), null);
  assert.equal(refineCorner(image, 2, 30, 4), null);
});

test("squares are measured between neighbours", () => {
  // Corners 7 and 8 of a board of 8 a row follow each other by number and lie at opposite ends.
  assert.deepEqual(
    squareSizes(
      [7, 8, 15],
      [
        [400, 100],
        [50, 140],
        [400, 140],
      ],
      8,
    ),
    [40, 40, 40],
  );
});

const CELL = 12; // px

/** A marker drawn on white, turned by quarters and mirrored, and the quadrilateral of its outermost black pixels. */
function drawn(family, id, { border = 1, quarters = 0, mirrored = false } = {}) {
  let cells = markerBits(family, id);
  for (let n = 0; n < quarters; n++) cells = cells[0].map((_, column) => cells.map((row) => row[column]).reverse());
  if (mirrored) cells = cells.map((row) => [...row].reverse());
  const count = cells.length + 2 * border;
  const [width, from] = [CELL * (count + 4), 2 * CELL];
  const data = new Uint8Array(width * width).fill(220);
  for (let y = 0; y < count * CELL; y++) {
    for (let x = 0; x < count * CELL; x++) {
      const white = cells[Math.floor(y / CELL) - border]?.[Math.floor(x / CELL) - border] ?? false;
      data[(from + y) * width + from + x] = white ? 220 : 30;
    }
  }
  return {
    image: { width, height: width, data },
    quad: rectangle(from, from, count * CELL - 1),
  };
}

test("a marker is read turned, mirrored and with Kalibr's border", () => {
  for (const [family, id, border] of [
    ["DICT_4X4_1000", 7, 1],
    ["DICT_6X6_1000", 123, 1],
    ["DICT_APRILTAG_36h11", 31, 2],
    ["DICT_7X7_1000", 900, 1],
  ]) {
    for (const quarters of [0, 1, 2, 3]) {
      for (const mirrored of [false, true]) {
        const { image, quad } = drawn(family, id, { border, quarters, mirrored });
        const own = readMarkers(image, [quad]).filter((each) => each.family === family && each.mirrored === mirrored);
        assert.deepEqual(
          own.flatMap(({ markers }) => markers.map((marker) => marker.id)),
          [id],
          `${family} ${quarters} ${mirrored}`,
        );
        assert.equal(own[0].border, border);
      }
    }
  }
});

test("the first corner is the marker's own upper left", () => {
  const { image, quad } = drawn("DICT_5X5_1000", 3, { quarters: 1 });
  const [reading] = readMarkers(image, [quad]);
  const [[x, y]] = reading.markers[0].corners;
  assert.ok(Math.hypot(x - quad[1][0] - 0.5, y - quad[1][1] + 0.5) < 0.5, "a quarter clockwise: at the upper right");
  const other = drawn("DICT_5X5_1000", 3, { mirrored: true });
  const back = readMarkers(other.image, [other.quad]).find(({ mirrored }) => mirrored);
  const [[u, v]] = back.markers[0].corners;
  assert.ok(Math.hypot(u - quad[0][0] + 0.5, v - quad[0][1] + 0.5) < 0.5);
});

test("what has no dark frame, or no contrast, is not a marker", () => {
  const { image, quad } = drawn("DICT_4X4_1000", 7);
  assert.deepEqual(readMarkers({ ...image, data: image.data.map((value) => 255 - value) }, [quad]), []);
  assert.deepEqual(readMarkers({ ...image, data: image.data.map((value) => 100 + value / 20) }, [quad]), []);
});
