import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { parseHTML } from "linkedom";
import { returnAddress, withResult } from "../../web/lib/result/return-address.js";
import {
  coverage,
  digitsFor,
  digitsOf,
  displacements,
  fieldOfView,
  fileName,
  intrinsics,
  lensProfile,
  levelOf,
  viewIssue,
} from "../../web/lib/result/numbers.js";
import { boardSentence, errorInScene, errorInWords } from "../../web/lib/result/meaning.js";
import { convexHull, hatching } from "../../web/lib/result/hull.js";
import { reasonTexts } from "../../web/lib/result/reasons.js";
import { ticks } from "../../web/lib/svg.js";
import { refined, valueAt } from "../../web/lib/contours.js";
import { gridLines } from "../../web/lib/result/grid-picture.js";
import { viewsPart } from "../../web/lib/result/views.js";
import { distortionPlot, errorPlot, profilePlot } from "../../web/lib/result/plots.js";
import "./messages.mjs";
import { calibrationOf, isInside, rectangle } from "./scenes.mjs";
import { setGlobals } from "./globals.mjs";

const { report, ...calibration } = JSON.parse(readFileSync(new URL("./result.json", import.meta.url), "utf8"));

test("values have the digits of their standard deviations", () => {
  assert.deepEqual([1.04, 0.749, 0.0023, 12, 0].map(digitsFor), [1, 2, 4, 0, 2]);
  const rows = intrinsics(calibration, report);
  assert.deepEqual(
    rows.map(({ name }) => name),
    ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
  );
  assert.equal(rows[0].std, report.std.fx);
  assert.ok(rows[4].value === calibration.distortion_coefficients[0] && rows[4].std === report.std.distortion[0]);
  assert.ok(intrinsics(calibration, null).every(({ std }) => std === null));
});

test("a coefficient is never written as nought that is none", () => {
  assert.deepEqual([-0.28, 0.00066, -0.0000021, 3e-12, 0].map(digitsOf), [5, 5, 7, 8, 5]);
});

test("the field of view includes distortion", () => {
  const wide = calibrationOf([230], [639.5, 359.5], {
    distortion_model: "fisheye",
    distortion_coefficients: [0, 0, 0, 0],
  });
  const { horizontal, vertical } = fieldOfView(wide);
  assert.ok(Math.abs(horizontal - (1280 / 230) * (180 / Math.PI)) < 1e-6, `${horizontal}`);
  assert.ok(Math.abs(vertical - (720 / 230) * (180 / Math.PI)) < 1e-6, `${vertical}`);
  assert.equal(fieldOfView(wide).diagonal, null);
});

test("the views to take again are named, and only those", () => {
  const found = report.views.map((view) => viewIssue(view, report.views));
  assert.deepEqual(
    found.map((what, index) => [index, what]).filter(([, what]) => what),
    [
      [1, "some_cut"],
      [4, "stands_out"],
      [5, "left_out"],
    ],
  );
  const even = [0.2, 0.22, 0.25].map((rms) => ({ ...report.views[0], rms }));
  assert.ok(even.every((view) => viewIssue(view, even) === null));
});

test("coverage counts cells of the picture", () => {
  assert.equal(
    coverage(
      [
        [10, 10],
        [12, 12],
      ],
      [1200, 700],
    ),
    1 / 84,
  );
  assert.equal(coverage([], [1200, 700]), 0);
});

test("without a report the predicted error decides", () => {
  const at = (rms, width, more = {}) => levelOf({ uncertainty: { rms, max: rms, ...more }, img_size: [width, 720] });
  assert.deepEqual([at(1, 1280), at(0.3, 320), at(3.1, 1280)], ["good", "fair", "poor"]);
  assert.equal(at(9, 1280, { inside: 1, covered: 0.4 }), "fair");
  assert.equal(at(9, 1280, { inside: 1.1, covered: 0.4 }), "poor");
  assert.equal(at(9, 1280, { inside: 0.3, covered: 0.05 }), "poor");
});

test("an error is a part of a pixel, a length and an angle", () => {
  assert.deepEqual(
    [0.05, 0.23, 0.9, 2.6, 0.001].map((px) => errorInWords(px)),
    [
      "About a twentieth of a pixel.",
      "About a quarter of a pixel.",
      "About a pixel.",
      "About 3 pixels.",
      "A hundredth of a pixel or less.",
    ],
  );
  const camera = calibrationOf([1000], [0, 0]);
  const { mm, degrees } = errorInScene(0.5, camera, 10);
  assert.ok(Math.abs(mm - 5) < 1e-9 && Math.abs(degrees - 0.02864789) < 1e-6);
  const omnidirectional = { distortion_model: "omnidirectional", distortion_coefficients: [1, 0, 0, 0, 0] };
  const wide = errorInScene(0.5, { ...camera, ...omnidirectional }, 10);
  assert.ok(Math.abs(wide.mm - 10) < 1e-9, "by the focal length at the axis");
});

test("the convex hull is hatched around, not inside", () => {
  const square = rectangle(20, 20, 60, 40);
  const hull = convexHull([...square, [50, 40], [20, 30], [70, 20]]);
  assert.deepEqual(new Set(hull.map(String)), new Set(square.map(String)));
  for (const [[a, b], [c, d]] of hatching(hull, [100, 80], 7)) assert.ok(!isInside([(a + c) / 2, (b + d) / 2], square));
  const length = (all) => all.reduce((sum, [from, to]) => sum + Math.hypot(to[0] - from[0], to[1] - from[1]), 0);
  const whole = length(hatching([], [100, 80], 1));
  assert.ok(
    Math.abs(length(hatching(hull, [100, 80], 1)) / whole - (1 - (60 * 40) / (100 * 80))) < 0.02,
    "as much as lies outside",
  );
});

test("axes are numbered roundly", () => {
  assert.deepEqual(ticks(1280, 5), [0, 400, 800, 1200]);
});

test("a file of a camera without a name is named", () => {
  assert.equal(fileName({ ...calibration, camera: "…" }, "yaml"), "camera-1280x720.yaml");
});

test("results return over HTTPS, to localhost and to allowed origins", () => {
  const here = "https://calibdb.example";
  const allowed = ["http://robot.example"];
  const to = (address) => returnAddress(address, here, allowed)?.allowed ?? null;
  assert.equal(to("https://app.example/ar?x=1#y"), true);
  assert.equal(to("/elsewhere"), true);
  const isHere = (address) => returnAddress(address, here, []).isHere;
  assert.deepEqual(["/elsewhere", "https://app.example/"].map(isHere), [true, false]);
  assert.equal(to("http://app.example/"), false);
  assert.equal(to("http://localhost.evil.example/"), false);
  assert.equal(to("http://robot.example/arm"), true);
  assert.equal(to("http://localhost:5173/"), true, "the service is tried on the same machine");
  for (const address of [null, "", "javascript:alert(1)", "data:text/html,x", "https://user:pw@app.example/"])
    assert.equal(to(address), null, address);
  assert.equal(
    withResult(new URL("https://app.example/ar?x=1#y=2"), "a/b"),
    "https://app.example/ar?x=1#y=2&calibration=a%2Fb",
  );
});

test("systematic errors are reported with a remedy", () => {
  const verdict = { level: "fair", reasons: [{ code: "uncertain", text: "" }] };
  const textOf = (cause, model = null) =>
    reasonTexts({ verdict, systematic: { inflation: 5, cause, text: "", model } }, [], calibration).at(-1);
  assert.match(textOf("board_bent"), /^The board bends differently from view to view. Glue it to something rigid/);
  assert.match(textOf("model_too_simple", "fisheye"), /Choose the fisheye model/);
});

test("a cause is named once", () => {
  const bent = { code: "board_bent", text: "The board is not flat." };
  const systematic = { inflation: 1.7, cause: "board_bent", text: bent.text, model: null };
  const named = { verdict: { level: "fair", reasons: [bent] }, systematic };
  const notes = [bent, { code: "limit_reached", text: "" }];
  assert.equal(reasonTexts(named, notes, calibration).length, 2);
  assert.equal(reasonTexts({ verdict: { level: "good", reasons: [] }, systematic }, [], calibration).length, 1);
  assert.match(
    reasonTexts(null, [{ code: "motion", text: "" }], { ...calibration, platform: "photographs" })[0],
    /Exclude the worst photos/,
  );
  const later = { code: "of_tomorrow", text: "As the service says." };
  assert.deepEqual(reasonTexts(null, [later], calibration), [later.text]);
  const simple = { verdict: { level: "fair", reasons: [{ code: "model_too_simple", text: "" }] } };
  assert.match(
    reasonTexts(simple, [], { ...calibration, distortion_model: "fisheye" })[0],
    /Choose the rational or omnidirectional model/,
  );
});

test("the board's shape is described if it is certain", () => {
  const board = { sag: 0.0071, sag_std: 0.0004, stretch: 0.0021, stretch_std: 0.0005, stretch_kind: "wider" };
  const said = (shape) => boardSentence(shape).map((text) => text.replaceAll("\u00a0", " "));
  const whole = (what) => [`Your board is ${what}. That was taken into account.`];
  assert.deepEqual(said(board), whole("bent by 0.71 % of its length and 0.21 % wider than drawn"));
  assert.deepEqual(said({ ...board, stretch_std: 0.002 }), whole("bent by 0.71 % of its length"));
  for (const [kind, what] of [
    ["narrower", "0.21 % narrower than drawn"],
    ["skewed", "skewed by 0.21 %"],
    [undefined, "0.21 % out of shape"],
  ])
    assert.deepEqual(said({ ...board, sag_std: 0.005, stretch_kind: kind }), whole(what));
  for (const none of [undefined, null, { ...board, stretch: 0.02 }, { ...board, sag_std: 0.01, stretch_std: 0.01 }]) {
    assert.deepEqual(said(none), []);
  }
});

const { document } = parseHTML("<!doctype html>");
const SIZE = [1280, 720];
const camera = (f, distortion_model = "rectilinear", distortion_coefficients = [0, 0, 0, 0, 0]) =>
  calibrationOf([f], [639.5, 359.5], { distortion_model, distortion_coefficients });
const largest = (moves) => Math.max(...moves.map(({ from, to }) => Math.hypot(from[0] - to[0], from[1] - to[1])));

test("the advice names the views to retake", (t) => {
  setGlobals(t, { document });
  // View 5 stands out, view 6 was left out; of view 2 only some corners were.
  assert.match(viewsPart({ calibration, report }, null, null).textContent, /\b5 and 6\b/);
});

test("a lens without distortion has 0 px in its caption", (t) => {
  setGlobals(t, { document });
  const lenses = [
    camera(800),
    camera(800, "rational", [0, 0, 0, 0, 0, 0, 0, 0]),
    camera(800, "omnidirectional", [0, 0, 0, 0, 0]),
  ];
  for (const lens of lenses) {
    const { caption } = distortionPlot(lens);
    assert.match(caption, /\b0\.0\spx/, `${lens.distortion_model}: ${caption}`);
    assert.doesNotMatch(caption, /[1-9]/, `${lens.distortion_model}: ${caption}`);
  }
});

test("the lens profile is dashed beyond the measured corners", (t) => {
  setGlobals(t, { document });
  const lens = camera(800, "rectilinear", [-0.1, 0, 0, 0, 0]);
  const profile = lensProfile(lens, 10);
  assert.ok(profile.length === 11 && Math.abs(profile[10].radius - Math.hypot(640, 360)) < 1e-9);
  for (const { radius, shift } of profile) {
    const straight = (radius - shift) / 800;
    assert.ok(Math.abs(shift + 0.1 * 800 * straight ** 3) < 1e-3, `${radius}: ${shift}`);
  }
  const view = { index: 0, reason: null, points: [[639.5 + 300, 359.5]], residuals: [[0, 0]], cut: [] };
  const curves = (report) => [...profilePlot(lens, report).svg.querySelectorAll("path")];
  const [, inside, beyond] = curves({ views: [view] });
  const end = Number(inside.getAttribute("d").split("L").at(-1).split(" ")[0]);
  assert.ok(Math.abs(end - (438 * 300) / Math.hypot(640, 360)) < 8, `${end}`);
  assert.match(beyond.getAttribute("class"), /beyond/);
  assert.notEqual(beyond.getAttribute("d"), "");
  assert.equal(curves(null)[2].getAttribute("d"), "", "nothing is dashed where it is not known what was measured");
});

test("displacements start at the pinhole of the focal length", () => {
  // Equidistant, r = f t, and stereographic, r = 2 f tan(t / 2), which is xi = 1: from f tan t.
  const grid = [17, 11];
  const f = 800;
  const [u, v] = [639.5 - 1280 / 34 + 0.5, 359.5 - 720 / 22 + 0.5];
  const radius = Math.hypot(u, v);
  const equidistant = largest(displacements(camera(f, "fisheye", [0, 0, 0, 0]), grid));
  assert.ok(Math.abs(equidistant - (f * Math.tan(radius / f) - radius)) < 1, `${equidistant}`);
  const stereographic = largest(displacements(camera(2 * f, "omnidirectional", [1, 0, 0, 0, 0]), grid));
  const expected = f * Math.tan(2 * Math.atan(radius / (2 * f))) - radius;
  assert.ok(Math.abs(stereographic - expected) < 1, `${stereographic} instead of ${expected}`);
});

test("the error map's bands and numbers are at their values", (t) => {
  setGlobals(t, { document });
  const [columns, rows] = [20, 12];
  const px = Array.from({ length: rows }, (_, row) =>
    Array.from({ length: columns }, (_, column) => 0.1 + 0.01 * (row + column)),
  );
  const lens = { ...camera(800), uncertainty: { rms: 0.26, max: 0.4 } };
  const { svg, levels } = errorPlot(lens, { error_map: { grid: [columns, rows], px }, views: [] });
  const area = svg.querySelector("svg");
  assert.match(svg.getAttribute("aria-label"), /0\.26\spx.*0\.40\spx/);
  const [left, top, width] = area.getAttribute("viewBox").split(" ").map(Number);
  const unit = width / SIZE[0]; // plot units a pixel
  const numbers = [...area.querySelectorAll("text")];
  assert.ok(numbers.length === 1 || numbers.length === 2, "anywhere else a number would contradict the band below it");
  for (const number of numbers) {
    const place = ["x", "y"].map((name, axis) => (number.getAttribute(name) - [left, top][axis]) / unit - 0.5);
    const value = valueAt(px, SIZE, place);
    assert.ok(Math.abs(value - Number(number.textContent)) < 0.005, `${number.textContent} stands at ${value}`);
  }
  const bands = [...area.querySelectorAll("path[class^='heat-']")].map((path) =>
    Array.from(path.getAttribute("d").matchAll(/[^MZ]+/g), ([polygon]) =>
      polygon.split("L").map((pair) => pair.split(" ").map(Number)),
    ),
  );
  assert.equal(bands.length, 8);
  for (const [u, v] of [
    [3, 3],
    [640, 360],
    [1270, 715],
    [200, 600],
  ]) {
    const value = valueAt(px, SIZE, [u, v]);
    const place = [left + (u + 0.5) * unit, top + (v + 0.5) * unit];
    const highest = bands.findLastIndex((polygons) => polygons.some((polygon) => isInside(place, polygon)));
    const slack = 0.1 * (levels[highest + 1] - levels[highest]);
    assert.ok(
      value > levels[highest] - slack && value < levels[highest + 1] + slack,
      `${value} px at ${u}, ${v} is drawn as band ${highest}`,
    );
  }
});

test("values are linear between centres, constant at the edge", () => {
  const px = [
    [1, 2],
    [3, 4],
  ];
  const size = [200, 100];
  const around = [
    [49.5, 24.5, 1],
    [99.5, 24.5, 1.5],
    [99.5, 49.5, 2.5],
    [0, 0, 1],
    [199, 99, 4],
  ];
  for (const [u, v, value] of around) assert.ok(Math.abs(valueAt(px, size, [u, v]) - value) < 1e-9, `${u}, ${v}`);
  px[0][1] = null;
  assert.equal(valueAt(px, size, [99, 40]), null);
});

test("a finer map goes smoothly through the values that there are", () => {
  const value = (u, v) => 0.1 + 0.002 * u * u + 0.001 * v;
  const coarse = Array.from({ length: 15 }, (_, row) =>
    Array.from({ length: 20 }, (_, column) => value(column - 10, row)),
  );
  const fine = refined(coarse, 4);
  assert.deepEqual([fine.length, fine[0].length], [60, 80]);
  for (let row = 8; row < 52; row++) {
    for (let column = 8; column < 72; column++) {
      const error = fine[row][column] - value((column + 0.5) / 4 - 10.5, (row + 0.5) / 4 - 0.5);
      assert.ok(Math.abs(error) < 1e-3, `${row}, ${column}: ${error}`);
    }
  }
  coarse[3][4] = null;
  const unknown = refined(coarse, 4).flat();
  assert.ok(unknown.filter((each) => each === null).length > 16);
});

test("the grid has straight lines for a pinhole only", () => {
  const bend = (lens) =>
    Math.max(
      ...gridLines(lens).map(({ seen: line }) => {
        const [[x, y], [p, q]] = [line[0], line[line.length - 1]];
        const length = Math.hypot(p - x, q - y);
        return Math.max(...line.map(([u, v]) => Math.abs((p - x) * (v - y) - (q - y) * (u - x)) / length));
      }),
    );
  assert.ok(bend(camera(800)) < 1e-6);
  assert.ok(bend(camera(800, "rectilinear", [-0.2, 0.03, 0, 0, 0])) > 20);
  assert.ok(gridLines(camera(300, "fisheye", [0, 0, 0, 0])).length > 20);
});
