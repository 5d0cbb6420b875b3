// Plots of a result: predicted error, distortion, coverage, residuals. Numbers in, SVG out.
import { number, rough, t } from "../i18n.js";
import { above, refined, valueAt } from "../contours.js";
import { gridLines } from "./grid-picture.js";
import { convexHull, hatching } from "./hull.js";
import { coverage, displacements, lensProfile, viewIssue } from "./numbers.js";
import { make } from "../dom.js";
import { arrow, imagePlot, short, ticks } from "../svg.js";

/**
 * @import { Values } from "../contours.js"
 * @import { Calibration, Report, ReportView } from "./numbers.js"
 */

const HEAT_LEVELS = 8; // of the colour scale, see style.css
const MIN_SCALE_PX = 1e-3; // px; of the largest amount on a scale
const MAX_SCALE_POWER = 3; // of a scale that shows what lies far below its largest amount
const FINE_COLUMNS = 80; // of a map as it is drawn
const ROUNDOFF_PX = 1e-6; // px; what is moved by less is not moved
const MOVES_GRID = /** @type {[number, number]} */ ([17, 11]); // where the distortion is measured
const NOTABLE_DISTORTION = 0.02; // of the width; smaller distortions are drawn larger than they are
const LABEL_WIDTH = 56; // units
const HATCH_LINES = 60; // across a picture's width
const PROFILE = { width: 440, height: 70, bottom: 18, pad: 8 }; // units
const PROFILE_STEPS = 60;

/** A round number not below. @param {number} value */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 1.2, 1.6, 2, 2.4, 3.2, 4, 5, 6, 8, 10].find((factor) => factor * power >= value * 0.999) ?? 10) * power;
}

/** Corners that the fit has used, px. @param {Report | null} report @returns {number[][]} */
const usedCorners = (report) => (report?.views ?? []).filter(({ reason }) => !reason).flatMap(cornersOf);

/** @param {ReportView} view @returns {number[][]} px */
const cornersOf = ({ points }) => /** @type {number[][]} */ (points.filter(([u, v]) => u !== null && v !== null));

/**
 * Hatching of the part of the picture that no board has shown: what a model says there is extrapolated.
 * @param {readonly [number, number]} size px @param {Report | null} report @param {(u: number) => number} x px → plot
 */
function extrapolated([width, height], report, x) {
  const hull = convexHull(usedCorners(report).map((point) => point.map((value) => value + 0.5)));
  const at = (/** @type {readonly number[]} */ point) => point.map((value) => short(x(value - 0.5))).join(" ");
  return make("path", {
    d: hatching(hull, [width, height], width / HATCH_LINES)
      .map(([from, to]) => `M${at(from)}L${at(to)}`)
      .join(""),
    class: "hatch",
  });
}

/**
 * Typical error over the picture: bands between levels, the corners measured, and a reading of the value at any place.
 * @param {Calibration} calibration
 * @param {Report | null} report null: not there yet; the empty frame has the same size
 */
export function errorPlot({ img_size, uncertainty }, report) {
  // The same two numbers as everywhere: rms and maximum of this very map.
  const found = { typical: rough(uncertainty.rms), max: rough(uncertainty.max) };
  const made = heatPlot(img_size, report?.error_map.px ?? null, uncertainty.max, t("result.error_label", found));
  if (report) {
    const d = dots(usedCorners(report).map((point) => point.map(made.x)));
    made.area.append(
      extrapolated(img_size, report, made.x),
      make("path", { d, class: "dot around" }),
      make("path", { d, class: "dot" }),
    );
  }
  return { ...made, caption: t("result.error_caption") };
}

/**
 * Amounts over the picture. The median is in the middle of the scale, as far as a power allows.
 * @param {[number, number]} size px
 * @param {Values | null} px null: an empty frame
 * @param {number} max px
 * @param {string} label
 */
export function heatPlot(size, px, max, label) {
  const top = roundUp(Math.max(max, MIN_SCALE_PX));
  const known = /** @type {number[]} */ (px?.flat().filter((value) => value !== null) ?? []).sort((a, b) => a - b);
  const median = known[Math.floor(known.length / 2)] ?? top / 2;
  const power = Math.min(MAX_SCALE_POWER, Math.max(1, Math.log(Math.max(median, ROUNDOFF_PX) / top) / Math.log(0.5)));
  const levels = Array.from({ length: HEAT_LEVELS + 1 }, (_, step) => top * (step / HEAT_LEVELS) ** power);
  const { svg, area, x, y } = imagePlot(size, label, "heat");
  if (px) {
    const fine = refined(px, Math.ceil(FINE_COLUMNS / px[0].length));
    area.append(
      ...levels.slice(0, -1).map((level, step) => {
        const polygons = above(fine, size, step === 0 ? -Infinity : level);
        return make("path", {
          d: polygons
            .map((points) => `M${points.map(([u, v]) => `${short(x(u))} ${short(y(v))}`).join("L")}Z`)
            .join(""),
          class: `heat-${step}`,
        });
      }),
    );
  }
  if (px) area.append(...lineLabels(px, size, levels, x));
  const at = (/** @type {MouseEvent} */ event) => {
    const box = area.getBoundingClientRect();
    const shares = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    const place = /** @type {[number, number]} */ (shares.map((share, axis) => share * size[axis] - 0.5));
    return px && shares.every((share) => share >= 0 && share <= 1) ? { place, value: valueAt(px, size, place) } : null;
  };
  return { svg, area, x, levels, at };
}

/**
 * Numbers at the innermost and the outermost line between bands, to the right of the middle.
 * @param {Values} px @param {[number, number]} size px @param {number[]} levels px
 * @param {(u: number) => number} x px → plot
 */
function lineLabels(px, [width, height], levels, x) {
  const places = Array.from({ length: FINE_COLUMNS }, (_, step) => (width / 2) * (1 + step / FINE_COLUMNS));
  const values = places.map((u) => valueAt(px, [width, height], [u, height / 2]) ?? NaN);
  const crossings = levels.flatMap((level) => {
    const step = values.findIndex((value, index) => value >= level && values[index - 1] < level);
    return step > 0 && x(places[step]) < x(width) - LABEL_WIDTH / 2 ? [{ level, at: x(places[step]) }] : [];
  });
  const [inner, outer] = [crossings[0], crossings[crossings.length - 1]];
  return (crossings.length > 1 && outer.at - inner.at > LABEL_WIDTH ? [inner, outer] : crossings.slice(0, 1)).map(
    ({ level, at }) => make("text", { x: short(at), y: short(x(height / 2)), class: "said" }, [rough(level)]),
  );
}

/**
 * Rows of the map's values for a table, at the centres and the corners.
 * @param {Calibration} calibration
 * @param {Report | null} report null: not there yet
 */
export function errorTable({ img_size }, report) {
  const along = (/** @type {number} */ side) => [0, 0.25, 0.5, 0.75, 1].map((share) => Math.round(share * (side - 1)));
  const columns = along(img_size[0]);
  return {
    columns,
    rows: along(img_size[1]).map((v) => ({
      v,
      values: columns.map((u) => (report ? valueAt(report.error_map.px, img_size, [u, v]) : null)),
    })),
  };
}

/**
 * Distortion over the image: a regular grid of the scene, as a pinhole would show it and as the lens does.
 * @param {Calibration} calibration of a model that is known here
 * @param {Report | null} [report] of the corners measured
 */
export function distortionPlot(calibration, report = null) {
  const {
    img_size,
    camera_matrix: [[, , cx], [, , cy]],
  } = calibration;
  const [width] = img_size;
  const moves = displacements(calibration, MOVES_GRID);
  const largest = Math.max(0, ...moves.map(({ from, to }) => Math.hypot(from[0] - to[0], from[1] - to[1])));
  const scale =
    largest > NOTABLE_DISTORTION * width || largest < ROUNDOFF_PX
      ? 1
      : 10 ** Math.ceil(Math.log10((NOTABLE_DISTORTION * width) / largest));
  const found = { max: number(largest, 1) };
  const { svg, area, x, y } = imagePlot(img_size, t("result.distortion_label", found), "distortion");
  const lines = gridLines(calibration);
  const path = (/** @type {number[][][]} */ all) =>
    all.map((line) => `M${line.map(([u, v]) => `${short(x(u))} ${short(y(v))}`).join("L")}`).join("");
  const bent = lines.map(({ seen, ideal }) =>
    seen.map((point, index) => point.map((value, axis) => ideal[index][axis] + scale * (value - ideal[index][axis]))),
  );
  if (report) area.append(extrapolated(img_size, report, x));
  area.append(
    make("path", { d: path(lines.map(({ ideal }) => ideal)), class: "ideal" }),
    make("path", { d: path(bent), class: "mark" }),
    make("path", {
      d: `M${short(x(cx) - 7)} ${short(y(cy))}h14M${short(x(cx))} ${short(y(cy) - 7)}v14`,
      class: "axis",
    }),
  );
  const more = [
    ...(scale === 1 ? [] : [t("result.magnified", { factor: scale })]),
    ...(report ? [t("result.extrapolated")] : []),
  ];
  return { svg, caption: [t("result.distortion_caption", found), ...more].join(" ") };
}

/**
 * Profile of the lens: the shift by distortion from the principal point to the farthest corner of the picture.
 * @param {Calibration} calibration of a model that is known here
 * @param {Report | null} [report] of the corners measured: beyond the farthest the curve is dashed
 */
export function profilePlot(calibration, report = null) {
  const {
    camera_matrix: [[, , cx], [, , cy]],
  } = calibration;
  const profile = lensProfile(calibration, PROFILE_STEPS);
  const end = profile[profile.length - 1].radius;
  const largest = profile.reduce((best, each) => (Math.abs(each.shift) > Math.abs(best.shift) ? each : best));
  const found = { shift: number(largest.shift, 1), radius: number(largest.radius, 0) };
  const reach = report ? Math.max(0, ...usedCorners(report).map(([u, v]) => Math.hypot(u - cx, v - cy))) : Infinity;
  const { width, height, bottom, pad } = PROFILE;
  const shifts = profile.map(({ shift }) => shift);
  const [low, high] = [Math.min(0, ...shifts), Math.max(0, ...shifts)];
  const span = Math.max(high - low, ROUNDOFF_PX);
  const x = (/** @type {number} */ radius) => 1 + ((width - 2) * radius) / end;
  const y = (/** @type {number} */ shift) => pad + ((high - shift) / span) * (height - bottom - 2 * pad);
  const line = (/** @type {typeof profile} */ points) =>
    points.length > 1
      ? `M${points.map(({ radius, shift }) => `${short(x(radius))} ${short(y(shift))}`).join("L")}`
      : "";
  const beyond = profile.findIndex(({ radius }) => radius > reach);
  const inside = beyond < 0 ? profile : profile.slice(0, beyond);
  const svg = make(
    "svg",
    {
      viewBox: `0 0 ${width} ${height}`,
      role: "img",
      "aria-label": t("result.profile_label", found),
      class: "plot profile",
    },
    [
      make("rect", { x: 1, y: 1, width: width - 2, height: height - bottom - 1, class: "ground" }),
      make("path", { d: `M1 ${short(y(0))}H${width - 1}`, class: "ideal" }),
      make("path", { d: line(inside), class: "mark" }),
      make("path", { d: beyond < 0 ? "" : line(profile.slice(Math.max(0, beyond - 1))), class: "mark beyond" }),
      make("rect", { x: 1, y: 1, width: width - 2, height: height - bottom - 1, class: "edge" }),
      ...ticks(end, 5).map((radius) =>
        make("text", { x: short(x(radius)), y: height - 4, class: radius ? "" : "start" }, [number(radius, 0)]),
      ),
    ],
  );
  const more = beyond < 0 ? [] : [t("result.profile_beyond")];
  return { svg, caption: [t("result.profile_caption", found), ...more].join(" ") };
}

/**
 * All corners measured, in the outline of each view's.
 * @param {Calibration} calibration
 * @param {Report | null} report null: not there yet
 */
export function coveragePlot({ img_size }, report) {
  const views = (report?.views ?? []).map((view) => ({ index: view.index, points: cornersOf(view) }));
  const points = views.flatMap((view) => view.points);
  const share = number(100 * coverage(points, img_size), 0);
  const { svg, area, x, y } = imagePlot(img_size, t("result.coverage_label", { share }), "coverage");
  const at = (/** @type {readonly number[]} */ [u, v]) => `${short(x(u))} ${short(y(v))}`;
  area.append(
    ...views.map((view) =>
      make("path", { d: `M${convexHull(view.points).map(at).join("L")}Z`, class: "view", "data-view": view.index }),
    ),
    make("path", { d: dots(points.map(([u, v]) => [x(u), y(v)])), class: "dot" }),
  );
  return { svg, caption: t("result.coverage_caption", { share, count: points.length }) };
}

/** @param {number[][]} points in plot units */
const dots = (points) => points.map(([u, v]) => `M${short(u)} ${short(v)}h.01`).join("");

/**
 * The residuals of one view, drawn larger than they are.
 * @param {Calibration} calibration @param {ReportView} view @param {ReportView[]} views @param {number} factor
 * @param {string | null} photo address of the picture that the view comes from
 */
export function residualPlot({ img_size }, view, views, factor, photo) {
  const what = viewIssue(view, views);
  const label = t("result.view_label", { index: view.index + 1, rms: number(view.rms, 2) });
  const { svg, area, x, y } = imagePlot(img_size, label, `residuals ${what ? "bad" : ""}`);
  if (photo)
    area.append(make("image", { href: photo, x: 1, y: 1, width: "100%", height: "100%", preserveAspectRatio: "none" }));
  const cut = new Set(view.cut);
  const lines = view.points
    .map((point, number) => {
      const [[u, v], [du, dv]] = /** @type {number[][]} */ ([point, view.residuals[number]]);
      return u === null || du === null
        ? null
        : {
            cut: view.reason !== null || cut.has(number),
            at: [x(u), y(v)],
            d: arrow(x(u), y(v), x(u + du * factor), y(v + dv * factor)),
          };
    })
    .filter((line) => line !== null);
  const path = (/** @type {boolean} */ which) =>
    lines
      .filter((line) => line.cut === which)
      .map(({ d }) => d)
      .join("");
  area.append(
    make("path", { d: path(false), class: "mark" }),
    make("path", { d: dots(lines.map(({ at }) => at)), class: "dot" }),
  );
  // Excluded points also get a cross, so that they differ by more than colour.
  const crosses = lines
    .filter((line) => line.cut)
    .map(({ at: [u, v] }) => `M${short(u - 3)} ${short(v - 3)}l6 6m0-6l-6 6`)
    .join("");
  area.append(make("path", { d: path(true) + crosses, class: "cut" }), ...scaleBar(img_size, factor, x));
  return svg;
}

/**
 * Bar of a round length in the picture's lower left corner.
 * @param {readonly [number, number]} size px @param {number} factor by which lengths are drawn larger
 * @param {(u: number) => number} x px → plot
 */
function scaleBar([width, height], factor, x) {
  const longest = width / 6 / factor;
  const power = 10 ** Math.floor(Math.log10(longest));
  const length = ([5, 2].find((digit) => digit * power <= longest) ?? 1) * power;
  const [left, bottom] = [x(0.03 * width), x(height - 0.04 * width)];
  return [
    make("path", { d: `M${short(left)} ${short(bottom)}h${short(x(length * factor) - x(0))}`, class: "bar" }),
    make("text", { x: short(left), y: short(bottom - 6), class: "said start" }, [`${rough(length)}\u00a0px`]),
  ];
}

/**
 * Scale of drawn residuals, the same for all views: a typical one is a 40th of the width.
 * @param {Calibration} calibration
 * @param {Report} report
 */
export function magnification({ img_size: [width] }, { views }) {
  const sorted = views.map(({ rms }) => rms).sort((a, b) => a - b);
  const typical = Math.max(sorted[Math.floor(sorted.length / 2)] ?? 0, 1e-3);
  return Math.max(1, Number((width / 40 / typical).toPrecision(1)));
}
