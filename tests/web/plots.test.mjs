import assert from "node:assert/strict";
import { test } from "node:test";
import { addMessages } from "../../web/lib/i18n.js";
import { displacements } from "../../web/lib/result/numbers.js";
import { distortionPlot, errorPlot } from "../../web/lib/result/plots.js";
import result from "../../web/messages/result.js";

/** As much of a document as plots are made with. */
class FakeElement {
  constructor(name) {
    Object.assign(this, { name, attributes: {}, children: [] });
  }
  setAttribute(name, value) {
    this.attributes[name] = value;
  }
  append(...children) {
    this.children.push(...children);
  }
  /** Of this name, at any depth. */
  all(name) {
    return this.children.filter((child) => child instanceof FakeElement)
      .flatMap((child) => [...(child.name === name ? [child] : []), ...child.all(name)]);
  }
}
globalThis.document = { createElementNS: (_, name) => new FakeElement(name) };
addMessages({ result });

const SIZE = [1280, 720];
const calibration = (f, distortion_model, distortion_coefficients) => ({
  img_size: SIZE, camera_matrix: [[f, 0, 639.5], [0, f, 359.5], [0, 0, 1]], distortion_model, distortion_coefficients,
});
const largest = (moves) => Math.max(...moves.map(({ from, to }) => Math.hypot(from[0] - to[0], from[1] - to[1])));

test("the caption of a lens without distortion says 0 px, for every model that can have none", () => {
  const lenses = [
    calibration(800, "rectilinear", [0, 0, 0, 0, 0]), calibration(800, "rational", [0, 0, 0, 0, 0, 0, 0, 0]),
    calibration(800, "omnidirectional", [0, 0, 0, 0, 0]),
  ];
  for (const lens of lenses) {
    const { caption } = distortionPlot(lens);
    assert.match(caption, /\b0\.0\spx/, `${lens.distortion_model}: ${caption}`);
    assert.doesNotMatch(caption, /[1-9]/, `${lens.distortion_model}: ${caption}`);
  }
  // Stereographic: its focal length at the axis is 800 px.
  const { caption } = distortionPlot(calibration(1600, "omnidirectional", [1, 0, 0, 0, 0]));
  assert.match(caption, /up to 154\.1\spx/, caption);
});

test("displacements of fisheye and omnidirectional lenses are from the pinhole of their focal length at the axis", () => {
  // Equidistant, r = f t, and stereographic, r = 2 f tan(t / 2), which is xi = 1: from f tan t.
  const grid = /** @type {[number, number]} */ ([17, 11]);
  const f = 800;
  const [u, v] = [639.5 - 1280 / 34 + 0.5, 359.5 - 720 / 22 + 0.5];
  const radius = Math.hypot(u, v);
  const equidistant = largest(displacements(calibration(f, "fisheye", [0, 0, 0, 0]), grid));
  assert.ok(Math.abs(equidistant - (f * Math.tan(radius / f) - radius)) < 1, `${equidistant}`);
  const stereographic = largest(displacements(calibration(2 * f, "omnidirectional", [1, 0, 0, 0, 0]), grid));
  const expected = f * Math.tan(2 * Math.atan(radius / (2 * f))) - radius;
  assert.ok(Math.abs(stereographic - expected) < 1, `${stereographic} instead of ${expected}`);
});

test("the error map's values lie on the centres of its cells, which cover the picture", () => {
  const [columns, rows] = [20, 12];
  const px = Array.from({ length: rows }, (_, row) => Array.from({ length: columns }, (_, column) => 0.1 + 0.01 * (row + column)));
  const { svg } = errorPlot(calibration(800, "rectilinear", [0, 0, 0, 0, 0]), { grid: [columns, rows], px });
  const [area] = svg.all("svg");
  const [left, top, width, height] = area.attributes.viewBox.split(" ").map(Number);
  const unit = width / SIZE[0]; // plot units a pixel
  const cells = area.all("rect").map(({ attributes }) => ["x", "y", "width", "height"].map((name) => Number(attributes[name])));
  assert.equal(cells.length, columns * rows);
  cells.forEach(([x, y, w, h], index) => {
    const [column, row] = [index % columns, Math.floor(index / columns)];
    const centre = [(x + w / 2 - left) / unit - 0.5, (y + h / 2 - top) / unit - 0.5];
    const expected = [((column + 0.5) * SIZE[0]) / columns - 0.5, ((row + 0.5) * SIZE[1]) / rows - 0.5];
    assert.ok(Math.abs(centre[0] - expected[0]) < 1.5 && Math.abs(centre[1] - expected[1]) < 1.5, `cell ${index} at ${centre}, not ${expected}`);
  });
  // Of 20 columns of 1280 px the first is centred at 31.5 px.
  const [[x, , w]] = cells;
  assert.ok(Math.abs((x + w / 2 - left) / unit - 0.5 - 31.5) < 1.5);
  const numbers = area.all("text");
  assert.equal(numbers.length, 20);
  for (const { attributes } of numbers) {
    const column = ((Number(attributes.x) - left) / unit / SIZE[0]) * columns - 0.5;
    assert.ok(Math.abs(column - Math.round(column)) < 0.02, `a number between two columns: ${column}`);
  }
});
