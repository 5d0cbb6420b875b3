// Meaning of a result: of an error in the picture, in words, and as a length and an angle at a distance that one
// chooses; of the board's shape that a fit has found.
import { el } from "../dom.js";
import { language, rough, t } from "../i18n.js";
import { focalLengths } from "../../sdk/pinhole.js";

/** @import { BoardShape, Calibration } from "./numbers.js" */

const PARTS = [1, 2, 3, 4, 5, 10, 20, 50, 100]; // of a pixel that have a name
const MAX_NAMED_PX = 1.4; // px; more is several pixels
const DISTANCES_M = [0.1, 0.3, 1, 3, 10, 30, 100]; // m
let distance = 1; // m; chosen once for all results on this page

/** "About a twentieth of a pixel." @param {number} px */
export function errorInWords(px) {
  if (px > MAX_NAMED_PX) return t("result.about_pixels", { count: Math.round(px) });
  const part = PARTS.reduce((best, each) =>
    Math.abs(Math.log(each * px)) < Math.abs(Math.log(best * px)) ? each : best,
  );
  return t(`result.about_${part}`);
}

/**
 * Length and angle that an error in the picture covers, in the middle of the picture.
 * @param {number} px
 * @param {Pick<Calibration, "camera_matrix" | "distortion_model" | "distortion_coefficients">} calibration
 * @param {number} metres away
 * @returns {{mm: number, degrees: number}}
 */
export function errorInScene(px, calibration, metres) {
  const tangent = px / Math.sqrt(focalLengths(calibration).reduce((product, f) => product * f));
  return { mm: 1000 * metres * tangent, degrees: (Math.atan(tangent) * 180) / Math.PI };
}

/** A distance as it is written: in cm below 1 m. @param {number} metres */
const distanceText = (metres) =>
  new Intl.NumberFormat(language(), { style: "unit", unit: metres < 1 ? "centimeter" : "meter" }).format(
    metres < 1 ? 100 * metres : metres,
  );

/** @param {Calibration} calibration @returns {HTMLElement} */
export function meaning(calibration) {
  const { rms } = calibration.uncertainty;
  const select = el(
    "select",
    { id: "distance" },
    ...DISTANCES_M.map((metres) => new Option(distanceText(metres), String(metres))),
  );
  select.value = String(distance);
  const output = el("output", { for: "distance", class: "number" });
  const show = () => {
    distance = Number(select.value);
    const { mm, degrees } = errorInScene(rms, calibration, distance);
    output.textContent = t("result.in_scene", {
      size: mm < 1000 ? `${rough(mm)} mm` : `${rough(mm / 1000)} m`,
      angle: rough(degrees),
    });
  };
  select.addEventListener("change", show);
  show();
  return el(
    "div",
    { class: "meaning" },
    el("span", {}, errorInWords(rms)),
    el("span", { class: "at" }, el("label", { for: "distance" }, t("result.at_distance")), select, output),
  );
}

const MIN_SIGMAS = 2; // of a shape that is certain
const MAX_STRETCH = 0.01; // share of the length by which a printer may stretch a board

/**
 * Sentence about the board's shape, if it is certain and a printer may have made it.
 * @param {BoardShape | null} [board]
 * @param {number | null} [length] mm, longer extent of the corners; null: the bend is a share of it
 * @returns {string[]}
 */
export function boardSentence(board, length = null) {
  if (!board || !(board.stretch < MAX_STRETCH)) return [];
  const deviations = [];
  if (board.sag > MIN_SIGMAS * board.sag_std)
    deviations.push(
      length === null
        ? t("result.board_bent", { sag: rough(100 * board.sag) })
        : t("result.board_bent_mm", { sag: rough(length * board.sag) }),
    );
  if (board.stretch > MIN_SIGMAS * board.stretch_std)
    deviations.push(t(`result.board_${board.stretch_kind ?? "stretched"}`, { stretch: rough(100 * board.stretch) }));
  if (!deviations.length) return [];
  return [t("result.board", { deviations: new Intl.ListFormat(language()).format(deviations) })];
}
