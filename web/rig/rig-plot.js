// 3D view of a rig, drawn as SVG: the cameras' frusta and the boards, turned by dragging, by the arrow keys, or by sliders.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { make, short } from "../lib/svg.js";
import { drawnPoint } from "./relations.js";

/** @typedef {ReturnType<typeof import("./relations.js").sceneOf>} Scene */

const HALF = 200; // units: half of the drawing's width
const ASPECT = 0.72;
const FIRST = { yaw: -0.6, pitch: -0.45 }; // rad: from above, and from the side
const DRAG = 0.01; // rad a CSS pixel
const MAX_PITCH = 1.5; // rad

/** @param {Scene} scene @param {string} label for those who cannot see it */
export function rigPlot(scene, label) {
  const svg = make("svg", { viewBox: `${-HALF} ${-HALF * ASPECT} ${2 * HALF} ${2 * HALF * ASPECT}`, role: "img", "aria-label": label, class: "rig-plot" });
  const view = { ...FIRST };
  const yaw = slider(t("rig.turn"), -Math.PI, Math.PI, view.yaw);
  const pitch = slider(t("rig.tilt"), -MAX_PITCH, MAX_PITCH, view.pitch);
  const draw = () => svg.replaceChildren(...bodies(scene, view.yaw, view.pitch));
  const set = (/** @type {number} */ turn, /** @type {number} */ tilt) => {
    view.yaw = Math.atan2(Math.sin(turn), Math.cos(turn));
    view.pitch = Math.min(MAX_PITCH, Math.max(-MAX_PITCH, tilt));
    yaw.value = String(view.yaw);
    pitch.value = String(view.pitch);
    draw();
  };
  for (const each of [yaw, pitch]) each.addEventListener("input", () => set(Number(yaw.value), Number(pitch.value)));
  svg.addEventListener("pointerdown", (event) => svg.setPointerCapture(event.pointerId));
  svg.addEventListener("pointermove", (event) => {
    if (event.buttons) set(view.yaw + DRAG * event.movementX, view.pitch - DRAG * event.movementY);
  });
  draw();
  return el("div", { class: "rig-view" }, svg, el("div", { class: "fields" },
    ...[yaw, pitch].map((input) => el("label", { class: "field" }, el("span", { class: "label" }, input.title), input))));
}

/** @param {string} title @param {number} min @param {number} max @param {number} value */
function slider(title, min, max, value) {
  const input = el("input", { type: "range", min, max, step: 0.01, title });
  input.value = String(value);
  return input;
}

/** @param {Scene} scene @param {number} yaw rad @param {number} pitch rad @returns {SVGElement[]} the farthest first */
function bodies(scene, yaw, pitch) {
  const scale = HALF * ASPECT * 0.96;
  const place = (/** @type {readonly number[]} */ point) => drawnPoint(point, scene, yaw, pitch);
  return scene.bodies.map(({ kind, position, lines, label }) => {
    const depth = Math.max(...lines.flat().map((point) => place(point)[2]));
    const paths = lines.map((line) => `M${line.map((point) => place(point).slice(0, 2).map((value) => short(value * scale)).join(" ")).join("L")}`);
    const parts = [make("path", { d: paths.join("") })];
    if (label) {
      const [x, y] = place(label);
      parts.push(make("circle", { cx: short(x * scale), cy: short(y * scale), r: 3 }),
        make("text", { x: short(x * scale), y: short(y * scale - 8), "text-anchor": "middle" }, [String(position + 1)]));
    }
    return { depth, group: make("g", { class: `${kind}${position === 0 && kind === "camera" ? " first" : ""}` }, parts) };
  }).sort((a, b) => b.depth - a.depth).map(({ group }) => group);
}
