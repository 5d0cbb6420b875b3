import assert from "node:assert/strict";
import { test } from "node:test";
import { readFileSync } from "node:fs";
import { parseHTML } from "linkedom";
import "./messages.mjs";
import { setGlobals } from "./globals.mjs";
import { calibrationOf, isInside } from "./scenes.mjs";
import { displacements, lensProfile } from "../../web/lib/result/numbers.js";
import { refined, valueAt } from "../../web/lib/contours.js";
import { gridLines } from "../../web/lib/result/grid-picture.js";
import { viewsPart } from "../../web/lib/result/views.js";
import { distortionPlot, errorPlot, profilePlot } from "../../web/lib/result/plots.js";

const { document } = parseHTML("<!doctype html>");
const { report, ...measured } = JSON.parse(readFileSync(new URL("./result.json", import.meta.url), "utf8"));

const SIZE = [1280, 720];
const calibration = (f, distortion_model, distortion_coefficients) =>
  calibrationOf([f], [639.5, 359.5], { distortion_model, distortion_coefficients });
const largest = (moves) => Math.max(...moves.map(({ from, to }) => Math.hypot(from[0] - to[0], from[1] - to[1])));

test("the advice names the views to retake", (t) => {
  setGlobals(t, { document });
  // View 5 stands out, view 6 was left out; of view 2 only some corners were.
  assert.match(viewsPart({ calibration: measured, report }, null, null).textContent, /\b5 and 6\b/);
});

test("a lens without distortion has 0 px in its caption", (t) => {
  setGlobals(t, { document });
  const lenses = [
    calibration(800, "rectilinear", [0, 0, 0, 0, 0]),
    calibration(800, "rational", [0, 0, 0, 0, 0, 0, 0, 0]),
    calibration(800, "omnidirectional", [0, 0, 0, 0, 0]),
  ];
  for (const lens of lenses) {
    const { caption } = distortionPlot(lens);
    assert.match(caption, /\b0\.0\spx/, `${lens.distortion_model}: ${caption}`);
    assert.doesNotMatch(caption, /[1-9]/, `${lens.distortion_model}: ${caption}`);
  }
});

test("the lens profile is dashed beyond the measured corners", (t) => {
  setGlobals(t, { document });
  const lens = calibration(800, "rectilinear", [-0.1, 0, 0, 0, 0]);
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
  const equidistant = largest(displacements(calibration(f, "fisheye", [0, 0, 0, 0]), grid));
  assert.ok(Math.abs(equidistant - (f * Math.tan(radius / f) - radius)) < 1, `${equidistant}`);
  const stereographic = largest(displacements(calibration(2 * f, "omnidirectional", [1, 0, 0, 0, 0]), grid));
  const expected = f * Math.tan(2 * Math.atan(radius / (2 * f))) - radius;
  assert.ok(Math.abs(stereographic - expected) < 1, `${stereographic} instead of ${expected}`);
});

test("the error map's bands and numbers are at their values", (t) => {
  setGlobals(t, { document });
  const [columns, rows] = [20, 12];
  const px = Array.from({ length: rows }, (_, row) =>
    Array.from({ length: columns }, (_, column) => 0.1 + 0.01 * (row + column)),
  );
  const lens = { ...calibration(800, "rectilinear", [0, 0, 0, 0, 0]), uncertainty: { rms: 0.26, max: 0.4 } };
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
    assert.ok(levels.some((level) => Math.abs(level - Number(number.textContent)) < 0.005));
  }
  const bands = [...area.querySelectorAll("path[class^='heat-']")].map((path) =>
    path
      .getAttribute("d")
      .split("Z")
      .filter(Boolean)
      .map((part) =>
        part
          .slice(1)
          .split("L")
          .map((pair) => pair.split(" ").map(Number)),
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
  assert.equal(
    valueAt(
      [
        [1, null],
        [3, 4],
      ],
      size,
      [99, 40],
    ),
    null,
  );
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
  assert.ok(
    refined(coarse, 4)
      .flat()
      .filter((each) => each === null).length > 16,
  );
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
  assert.ok(bend(calibration(800, "rectilinear", [0, 0, 0, 0, 0])) < 1e-6);
  assert.ok(bend(calibration(800, "rectilinear", [-0.2, 0.03, 0, 0, 0])) > 20);
  assert.ok(gridLines(calibration(300, "fisheye", [0, 0, 0, 0])).length > 20);
});
