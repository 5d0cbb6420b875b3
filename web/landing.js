// Landing page: the figure, and a lookup of the visitor's own camera.
import { CameraError, open } from "./lib/camera.js";
import { DEFAULT_BOARD } from "./lib/board.js";
import { explain } from "./lib/faults.js";
import { drawLine, gridThrough } from "./lib/figure.js";
import { known, t } from "./lib/i18n.js";
import { openPage } from "./lib/page.js";
import { lookup } from "./sdk/calibdb.js";
import { loadSettings } from "./lib/settings.js";
import { liveRegion } from "./lib/live-region.js";
import landing from "./messages/landing.js";

/** @type {[number, number]} */
const SIZE = [640, 400];
/** @param {number} k1 */
const lens = (k1) => ({
  camera_matrix: [[500, 0, 320], [0, 500, 200], [0, 0, 1]], distortion_model: "rectilinear", distortion_coefficients: [k1, 0, 0, 0, 0],
});

function drawFigure() {
  const svg = document.getElementById("lens");
  if (!svg) return;
  for (const line of gridThrough(lens(0), SIZE, 40)) drawLine(svg, line, "ideal");
  for (const line of gridThrough(lens(-0.25), SIZE, 40)) drawLine(svg, line, "true");
  drawLine(svg, [[306, 200], [334, 200]], "axis");
  drawLine(svg, [[320, 186], [320, 214]], "axis");
}

/** @returns {Promise<() => Node[]>} what came of it */
async function lookUpMine() {
  const { api, token } = await loadSettings();
  const camera = await open("", {
    parameters: new URLSearchParams(), size: [1280, 720], place: document.body, board: DEFAULT_BOARD,
  });
  try {
    const options = { token, api: new URL(api, location.href) };
    const { calibration, guidanceUrl } = await lookup(camera.track, options);
    const name = camera.track.label;
    if (calibration) return () => [paragraph(t("landing.yes", { camera: name, count: calibration.calibrations })), json(calibration)];
    return () => [paragraph(t("landing.not_yet", { camera: name }), " ", link(t("landing.calibrate_it"), guidanceUrl ?? "./calibrate/"))];
  } finally {
    camera.close();
  }
}

/** Here there is no other camera to choose, and no virtual one. @param {unknown} error */
function errorText(error) {
  const made = paragraph();
  made.className = "problem";
  if (!(error instanceof CameraError)) made.append(explain(error));
  else {
    const keys = [`landing.fault_${error.code}`, `capture.fault_${error.code}`];
    made.append(t(keys.find(known) ?? "capture.fault_not_opened", { detail: error.detail }));
    if (error.code === "not_found") made.append(" ", link(t("landing.search_all"), "./cameras/"));
  }
  return made;
}

/** @param {(string | Node)[]} content */
function paragraph(...content) {
  const made = document.createElement("p");
  made.append(...content);
  return made;
}

/** @param {string} words @param {string} href */
function link(words, href) {
  const made = document.createElement("a");
  made.textContent = words;
  made.href = href;
  return made;
}

/** @param {object} value */
function json(value) {
  const made = document.createElement("pre");
  made.tabIndex = 0;
  // A list of numbers is one line: a number a line hides what it is about.
  made.textContent = JSON.stringify(value, null, 2).replace(/\[[\d\s.,e+-]+\]/g, (list) => list.replace(/\s+/g, " "));
  return made;
}

openPage({ landing });
drawFigure();
const origin = document.getElementById("origin");
if (origin) origin.textContent = location.origin;
const button = document.getElementById("look");
const outcome = document.getElementById("outcome");
if (button instanceof HTMLButtonElement && outcome) {
  const tell = liveRegion(outcome);
  button.addEventListener("click", async () => {
    button.disabled = true;
    tell(() => [paragraph(t("landing.asking"))]);
    try {
      tell(await lookUpMine());
    } catch (error) {
      tell(() => [errorText(error)]);
    } finally {
      button.disabled = false;
    }
  });
}
