// Landing page: the pictures, counts of the database, and a lookup of the visitor's own camera.
import { DEFAULT_BOARD } from "../lib/board.js";
import { el, liveRegion, make, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { hasMessage, number, onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { lookup } from "../sdk/lookup.js";
import { sdkOptions } from "../lib/settings.js";
import { phoneModel } from "../lib/phone-model.js";
import { showRigPicture } from "../lib/rig-picture.js";
import { gridLines } from "../lib/result/grid-picture.js";
import { short } from "../lib/svg.js";
import { knownCard, unknownCard } from "./answer-card.js";
import { captureLoop } from "./capture-loop.js";
import { countCameras } from "./counts.js";

/** @type {[number, number]} */
const SIZE = [640, 400];
/** @param {number} k1 */
const lens = (k1) => ({
  camera_matrix: [
    [500, 0, 320],
    [0, 500, 200],
    [0, 0, 1],
  ],
  distortion_model: "rectilinear",
  distortion_coefficients: [k1, 0, 0, 0, 0],
});

/** A regular grid, and the same through a lens. @param {number} k1 */
function drawFigure(k1) {
  const path = (/** @type {number[][][]} */ lines, /** @type {string} */ name) =>
    make("path", {
      d: lines.map((line) => `M${line.map((point) => point.map(short).join(" ")).join("L")}`).join(""),
      class: name,
    });
  const lines = gridLines({ ...lens(k1), img_size: SIZE });
  part("lens", SVGElement).replaceChildren(
    path(
      lines.map(({ ideal }) => ideal),
      "ideal",
    ),
    path(
      lines.map(({ seen }) => seen),
      "true",
    ),
    path(
      [
        [
          [306, 200],
          [334, 200],
        ],
        [
          [320, 186],
          [320, 214],
        ],
      ],
      "axis",
    ),
  );
}

/** Access to cameras, loaded when the visitor looks up theirs. @type {typeof import("../lib/camera.js") | null} */
let cameras = null;

/** @returns {Promise<() => Node[]>} what came of it */
async function lookUpMine() {
  cameras ??= await import("../lib/camera.js");
  const options = await sdkOptions();
  const camera = await cameras.open("", {
    parameters: new URLSearchParams(),
    size: [1280, 720],
    place: document.body,
    board: DEFAULT_BOARD,
  });
  try {
    const { calibration, guidanceUrl, estimate } = await lookup(camera.track, { ...options, device: phoneModel() });
    const name = camera.track.label;
    return () => [
      calibration ? knownCard(name, calibration) : unknownCard(name, guidanceUrl ?? "./calibrate/", estimate),
    ];
  } finally {
    camera.close();
  }
}

/** Here there is no other camera to choose, and no virtual one. @param {unknown} error */
function errorText(error) {
  const made = el("p", { class: "problem" });
  if (!cameras || !(error instanceof cameras.CameraError)) made.append(explain(error));
  else {
    const keys = [`landing.fault_${error.code}`, `capture.fault_${error.code}`];
    made.append(t(keys.find(hasMessage) ?? "capture.fault_not_opened", { detail: error.detail }));
    if (error.code === "not_found") made.append(" ", el("a", { href: "./cameras/" }, t("landing.search_all")));
  }
  return made;
}

/** Shows how much the database contains; nothing if it is empty or unavailable. */
async function showCounts() {
  const counts = await countCameras().catch((error) => console.info("not counted:", error.message));
  if (!counts?.cameras) return;
  const more = counts.more ? "+" : "";
  const show = () =>
    part("counts", HTMLElement).replaceChildren(
      ...[
        [t("landing.count_cameras", { count: counts.cameras }), counts.cameras],
        [t("landing.count_ready", { count: counts.ready }), counts.ready],
        [t("landing.count_calibrations", { count: counts.calibrations }), counts.calibrations],
      ].map(([words, count]) => el("li", {}, el("strong", {}, `${number(Number(count), 0)}${more}`), ` ${words}`)),
    );
  onLanguage(show);
  show();
}

openPage();
const redraw = captureLoop(
  /** @type {SVGElement} */ (/** @type {unknown} */ (part("loop", SVGElement))),
  part("loop-words", HTMLElement),
  part("loop-toggle", HTMLButtonElement),
);
onLanguage(redraw);
showRigPicture(part("rig", HTMLElement));
const slide = part("lens-slide", HTMLInputElement);
drawFigure(slide.valueAsNumber);
slide.addEventListener("input", () => drawFigure(slide.valueAsNumber));
const overlay = part("overlay-slide", HTMLInputElement);
overlay.addEventListener("input", () =>
  part("before-after", HTMLElement).style.setProperty("--cut", `${overlay.value}%`),
);
part("origin", HTMLElement).textContent = location.origin;
const button = part("look", HTMLButtonElement);
const tell = liveRegion(part("outcome", HTMLElement));
button.addEventListener("click", async () => {
  button.disabled = true;
  tell(() => t("landing.asking"));
  try {
    tell(await lookUpMine());
  } catch (error) {
    tell(() => [errorText(error)]);
  } finally {
    button.disabled = false;
  }
});
new IntersectionObserver(
  (entries, watcher) => {
    // Loaded once the visitor scrolls near: most visitors leave the page before.
    if (!entries.some(({ isIntersecting }) => isIntersecting)) return;
    watcher.disconnect();
    void showCounts();
  },
  { rootMargin: "200px" },
).observe(part("counts", HTMLElement));
