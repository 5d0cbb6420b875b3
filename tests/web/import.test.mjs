import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { corners } from "../../web/lib/board.js";
import { grid, MalformedError } from "../../web/import/grid.js";
import { prepare, read } from "../../web/import/read.js";
import { isTable, squaresIn, table } from "../../web/import/table.js";
import { decode } from "../../web/import/text.js";
import { messages } from "./messages.mjs";
import { cameraMatrix } from "./scenes.mjs";

const SIZE = [1280, 720];
const BOARD = { squares: [9, 6] };
const place = ([x, y], index) => [100 + 60 * x + 3 * index * y, 80 + 55 * y - 2 * x];
/** Views of a board whose points are given in any unit, from any corner, rows counted downwards or upwards. */
const seen = ({ unit = 1, origin = [0, 0], upwards = false, board = BOARD } = {}) =>
  [0, 1, 2].map((index) => ({
    name: `view${index}`,
    object: corners(board).map(([x, y]) => [unit * x + origin[0], (upwards ? -unit : unit) * y + origin[1], 0]),
    image: corners(board).map((corner) => place(corner, index)),
  }));
const ALL = corners(BOARD).map((_, id) => id);
const point = (values) => Object.fromEntries(values.map((value, index) => ["xyz"[index], value]));
const photonVision = (views, more = {}) =>
  JSON.stringify({
    resolution: { width: 1280.0, height: 720.0 },
    cameraIntrinsics: { rows: 3, cols: 3, type: 6, data: [900, 0, 640, 0, 901, 360, 0, 0, 1] },
    distCoeffs: { rows: 1, cols: 5, type: 6, data: [0, 0, 0, 0, 0] },
    observations: views.map(({ object, image, used }) => ({
      locationInObjectSpace: object.map(point),
      locationInImageSpace: image.map(point),
      ...(used ? { cornersUsed: used } : {}),
    })),
    ...more,
  });
const guess = (matrix) => ({ kind: "guess", matrix, packed: false });
const refused = (code, action) =>
  assert.throws(action, (error) => {
    assert.ok(error instanceof MalformedError, `${error}`);
    assert.equal(error.code, code);
    assert.ok(`import.wrong_${code}` in messages.en);
    for (const name of messages.en[`import.wrong_${code}`].match(/(?<=\{)\w+/g) ?? [])
      assert.ok(name in error.values, `${code} says ${name}`);
    return true;
  });

test("a board is recognised in any unit, origin and order of rows", () => {
  for (const options of [{}, { unit: 25.4 }, { unit: 0.0254, origin: [-3, 7] }, { unit: 30, upwards: true }]) {
    const { squares, views } = grid(seen(options));
    assert.deepEqual(squares, [9, 6]);
    for (const { ids } of views) assert.deepEqual(ids, ALL, JSON.stringify(options));
  }
});

test("corners keep their numbers if some are missing", () => {
  const [first, second] = seen({ unit: Math.fround(25.4) });
  const some = {
    ...second,
    object: second.object.filter((_, i) => i % 3).map((p) => p.map(Math.fround)),
    image: second.image.filter((_, i) => i % 3),
  };
  const { views } = grid([first, some]);
  assert.deepEqual(
    views[1].ids,
    ALL.filter((id) => id % 3),
  );
  assert.deepEqual(views[1].points, some.image);
});

test("what is no flat board of squares is refused", () => {
  const [view] = seen();
  const changed = (change) => [{ ...view, object: view.object.map(change) }];
  refused("flat", () => grid(changed(([x, y], i) => [x, y, i % 2])));
  refused("line", () => grid(changed(([x]) => [x, 1, 0])));
  refused("rows", () => grid(changed(([x, y]) => [x, y * 1.5, 0])));
  refused("twice", () => grid(changed(([x, y], i) => (i === 7 ? [1, 1, 0] : [x, y, 0]))));
  refused("board", () => grid(changed(([x, y], i) => [i === 0 ? 200 : x, y, 0])));
  const four = corners({ squares: [3, 3] }).map(([x, y]) => [x, y, 0]);
  refused("board", () => grid([{ ...view, object: four, image: view.image.slice(0, 4) }]));
});

test("PhotonVision's file is read without unused corners", () => {
  const [first, second] = seen({ unit: 25.4 });
  const hidden = { ...first, image: first.image.map((q, i) => (i < 4 ? [-1, -1] : q)) };
  const unused = { ...second, used: second.image.map((_, i) => i !== 5) };
  const found = read(photonVision([hidden, unused, { object: [], image: [] }]));
  assert.equal(found.kind, "keypoints");
  assert.deepEqual(found.size, SIZE);
  const { board, views } = prepare(found.views, found.size);
  assert.deepEqual([board.squares, board.dictionary], [[9, 6], "DICT_4X4_50"]);
  assert.deepEqual(
    views.map(({ ids }) => ids.length),
    [36, 39],
  );
  assert.ok(!views[0].ids.includes(0) && !views[1].ids.includes(5));
});

test("large boards have a dictionary that is large enough", () => {
  const views = seen({ board: { squares: [14, 9] } });
  assert.equal(prepare(views, SIZE).board.dictionary, "DICT_4X4_1000");
});

test("a damaged file is refused with what is wrong in it", () => {
  const views = seen();
  const odd = (change) => () => read(photonVision(views.map(change)));
  refused("json", () => read(photonVision(views).slice(0, 500)));
  refused(
    "number",
    odd((view) => ({ ...view, image: view.image.map(([x, y], i) => (i === 3 ? [x, "9"] : [x, y])) })),
  );
  refused("number", () => read(photonVision(views).replace(/"x":\d+/, '"x":1e999')));
  refused("number", () => read(photonVision(views, { resolution: { width: 1280.5, height: 720 } })));
  refused(
    "count",
    odd((view) => ({ ...view, image: view.image.slice(1) })),
  );
  refused("many", () => read(photonVision([], { observations: Array(1001).fill({}) })));
  refused("outside", () => prepare(read(photonVision(views)).views, [320, 240]));
  refused("empty", () => prepare([], SIZE));
  for (const text of [
    "",
    "hello",
    "{}",
    '{"__proto__": {"cameraIntrinsics": 1}}',
    "\u0000\u0001",
    "[1, 2]",
    '{"a": 1}',
  ])
    refused("unknown", () => read(text));
});

test("no file makes the page think for long", () => {
  for (const text of ["\n", " ", "#", "\r\n", "a ", "{", "[", "# 1 x "].map((piece) =>
    piece.repeat(1_000_000 / piece.length),
  )) {
    const start = process.cpuUsage();
    assert.throws(() => read(text), MalformedError);
    assert.ok(process.cpuUsage(start).user < 2_000_000, JSON.stringify(text.slice(0, 8)));
  }
});

test("a file without corners is a first guess", () => {
  assert.deepEqual(read(photonVision([])), guess(cameraMatrix([900, 901], [640, 360])));
  assert.deepEqual(read("%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n   rows: 3\n"), guess(null));
  assert.equal(
    read("# a camera\n{\n    'lensmodel':  'LENSMODEL_OPENCV5',\n    'optimization_inputs': b'abc',\n}\n").packed,
    true,
  );
  assert.equal(read("{\n    'lensmodel':  'LENSMODEL_OPENCV5',\n}\n").packed, false);
});

test("other tools' texts are first guesses", () => {
  const expected = guess(cameraMatrix([900, 905], [630, 350]));
  const folder = new URL("../data/imports/", import.meta.url);
  const content = (name) => readFileSync(new URL(name, folder), "utf8");
  const kinds = [
    "sample.yml",
    "aruco.yml",
    "camera.yml",
    "out_camera_data.xml",
    "interactive.xml",
    "size.xml",
    "ost.txt",
    "camera_info.yaml",
    "rows.yaml",
    "keys.json",
    "nested.json",
    "beside.json",
    "realsense.json",
  ];
  for (const name of kinds) assert.deepEqual(read(content(`rectilinear/${name}`)), expected, name);
  for (const name of [
    "several/chain.yaml",
    "fisheye/kannala.yaml",
    "omnidirectional/mei.yaml",
    "rectilinear/orb.yaml",
    "rectilinear/zed.conf",
  ]) {
    assert.equal(read(content(name)).kind, "guess", name);
  }
  const text = content("rectilinear/out_camera_data.xml");
  assert.equal(decode(new TextEncoder().encode(text).buffer), text);
  assert.equal(decode(Uint8Array.from(Buffer.from(text, "utf16le")).buffer), text);
  assert.equal(decode(Uint8Array.from(Buffer.from(text, "utf16le").swap16()).buffer), text);
});

test("a table of corners is read once its board is known", () => {
  const lines = ["# 8 x 5 corners, one square apart", "# filename x y level"];
  for (const name of ["a.png", "b.png"])
    corners(BOARD).forEach((corner, i) =>
      lines.push(i === 2 ? `${name} - - -` : `${name} ${place(corner, 0).join(" ")} 0`),
    );
  lines.push("c.png - - -"); // a picture without a board
  const text = `${lines.join("\n")}\n`;
  assert.deepEqual(read(text), { kind: "table", text, squares: [9, 6] });
  const { board, views } = prepare(table(text, [9, 6]), SIZE);
  assert.deepEqual(board.squares, [9, 6]);
  assert.deepEqual(
    views.map(({ name, ids }) => [name, ids.length, ids.includes(2)]),
    [
      ["a.png", 39, false],
      ["b.png", 39, false],
    ],
  );
  refused("lines", () => table(text, [8, 6]));
  refused("lines", () => table(text.replace("c.png - - -", "c.png 1 2 0"), [9, 6]));
  refused("fields", () => table("a.png 1\n", [3, 4]));
  refused("fields", () => table("a.png one two\n", [3, 4]));
  assert.equal(squaresIn("a.png 1 2\n"), null);
  assert.ok(isTable("# c\n\na.png - -\n") && !isTable("a: 1\n") && !isTable("%YAML:1.0\n---\n"));
});

test("measurements of a practice run are refused", () => {
  const views = seen();
  const named = {
    observations: JSON.parse(photonVision(views)).observations.map((each, n) => ({
      ...each,
      snapshotName: `calibDB virtual camera, view ${n}`,
    })),
  };
  refused("practice", () => read(photonVision(views, named)));
  refused("practice", () => read("# calibDB virtual camera\n# filename x y\na.png 1.0 2.0 1.0\n"));
  refused("practice", () =>
    read("# calibDB virtual camera\n{ 'lensmodel': 'LENSMODEL_OPENCV5', 'optimization_inputs': b'abc' }"),
  );
  assert.equal(
    read('{"name": "calibDB virtual camera", "K": [[900, 0, 640], [0, 900, 360], [0, 0, 1]]}').kind,
    "guess",
  );
});
