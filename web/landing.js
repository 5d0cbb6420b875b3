// The landing page: the figure, and a lookup of the visitor's own camera.
import { CameraError, open } from "./calibrate/camera.js";
import { DEFAULT_BOARD } from "./board/geometry.js";
import { LookupError, lookup } from "./sdk/calibdb.js";
import { drawLine, gridThrough } from "./figure.js";
import { OfflineError, reach } from "./network.js";
import { SettingsError, loadSettings } from "./settings.js";

/** @type {[number, number]} */
const SIZE = [640, 400];
const PINHOLE = { fx: 500, fy: 500, cx: 320, cy: 200, k1: 0, k2: 0, p1: 0, p2: 0, k3: 0 };

function drawFigure() {
  const svg = document.getElementById("lens");
  if (!svg) return;
  for (const line of gridThrough(PINHOLE, SIZE, 40)) drawLine(svg, line, "ideal");
  for (const line of gridThrough({ ...PINHOLE, k1: -0.25 }, SIZE, 40)) drawLine(svg, line, "true");
  drawLine(svg, [[306, 200], [334, 200]], "axis");
  drawLine(svg, [[320, 186], [320, 214]], "axis");
}

/** @param {HTMLElement} outcome */
async function lookUpMine(outcome) {
  const { api, token } = await loadSettings();
  const camera = await open("", {
    parameters: new URLSearchParams(), size: [1280, 720], place: document.body, board: DEFAULT_BOARD,
  });
  try {
    const options = { token, api: new URL(api, location.href), fetch: reach };
    const { calibration, guidanceUrl } = await lookup(camera.track, options);
    const name = camera.track.label;
    if (calibration) outcome.replaceChildren(paragraph(`Yes: ${name}. ${calibration.calibrations} calibrations agree.`), json(calibration));
    else outcome.replaceChildren(paragraph(`Not yet: ${name}. `, link("Calibrate it", guidanceUrl ?? "./calibrate/")));
  } finally {
    camera.close();
  }
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
  made.textContent = JSON.stringify(value, null, 2);
  return made;
}

drawFigure();
const origin = document.getElementById("origin");
if (origin) origin.textContent = location.origin;
const button = document.getElementById("look");
const outcome = document.getElementById("outcome");
if (button instanceof HTMLButtonElement && outcome) {
  button.addEventListener("click", async () => {
    button.disabled = true;
    outcome.replaceChildren(paragraph("Asking for the camera."));
    try {
      await lookUpMine(outcome);
    } catch (error) {
      const known = [CameraError, LookupError, OfflineError, SettingsError].some((type) => error instanceof type);
      if (!known) console.error(error);
      outcome.replaceChildren(paragraph(error instanceof Error ? error.message : String(error)));
    } finally {
      button.disabled = false;
    }
  });
}
