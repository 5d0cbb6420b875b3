// Calibration from photographs or a video. Boards are looked for on this device; only where their corners are is sent.
import { boardFrom, boardQuery } from "../lib/board.js";
import { showProblem } from "../lib/board-problem.js";
import { Api } from "../lib/api.js";
import { observedOutline } from "../lib/board-outline.js";
import { Detector, DetectorError } from "../lib/detector.js";
import { blackSquares } from "../lib/target-preview.js";
import { el, part } from "../lib/dom.js";
import { explain as fault } from "../lib/faults.js";
import { sayChosen } from "../lib/file-input.js";
import { known, number, onLanguage, sized, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { load } from "../lib/result/source.js";
import { imagePlot, make, short } from "../lib/svg.js";
import { ResultView } from "../lib/result/view.js";
import { COEFFICIENTS } from "../sdk/projection.js";
import { loadSettings } from "../lib/settings.js";
import { liveRegion } from "../lib/live-region.js";
import capture from "../messages/capture.js";
import words from "../messages/photos.js";
import result from "../messages/result.js";
import { card, thumbnail } from "./card.js";
import { UnreadableError, shots } from "./files.js";
import { groups } from "./group.js";
import { sortByGain, rankByNovelty } from "../lib/rank.js";
import { MAX_VIEWS, calibrate } from "../lib/series.js";

/**
 * @typedef {import("./card.js").Picture} Picture
 * @typedef {import("../lib/series.js").Judgement} Judgement
 * @typedef {import("../lib/series.js").Outcome} Outcome
 */

const DETECTION_TIMEOUT_MS = 120_000; // ms for the board in one picture: they may have a hundred times the pixels of a frame

openPage({ photos: words, result, capture });
const query = new URLSearchParams(location.search);
const { board, problem } = boardFrom(query);
const parts = {
  drop: part("drop", HTMLElement), files: part("files", HTMLInputElement), status: part("status", HTMLElement),
  progress: part("progress", HTMLProgressElement), pictures: part("pictures", HTMLElement), form: part("form", HTMLFormElement),
  series: part("series", HTMLSelectElement), several: part("several", HTMLElement), camera: part("camera", HTMLInputElement),
  focal: part("focal", HTMLInputElement), model: part("model", HTMLSelectElement), start: part("start", HTMLButtonElement),
  wanted: part("wanted", HTMLElement), board: part("board", HTMLElement), problem: part("problem", HTMLElement),
};
const view = new ResultView(part("result", HTMLElement));
const [tell, want] = [liveRegion(parts.status), liveRegion(parts.wanted)];
/** @type {Picture[]} */
let pictures = [];
/** @type {Map<Picture, Judgement>} */
const judgements = new Map();
/** Is the last judgement in? */
let judged = false;
/** @type {Map<Picture, File>} to look at one again */
const origins = new Map();
/** @type {Promise<Detector> | null} */
let detector = null;
/** The search that is going on. */
let run = new AbortController();
/** Calibrations so far: what is computed for an earlier one, or for pictures chosen before, comes too late. */
let turn = 0;

/** @param {unknown} error */
function explain(error) {
  if (!(error instanceof DetectorError)) return fault(error);
  const key = `capture.fault_${error.code}`;
  return t(known(key) ? key : "capture.fault_detector", { detail: error.message });
}

const openDetector = () => (detector ??= Detector.open(board).catch((error) => {
  detector = null;
  throw error;
}));

/** Invalidate the results for the chosen pictures. @returns {number} the turn that begins */
function discard() {
  view.clear();
  want();
  judgements.clear();
  judged = false;
  return ++turn;
}

/** The series chosen. */
const chosen = () => groups(pictures).find(({ id }) => id === parts.series.value) ?? groups(pictures)[0] ?? null;

/** Those first that were used, by what they added; while they are judged each stays where it is. */
function showPictures() {
  const members = new Set((chosen()?.members ?? []).map((index) => pictures[index]));
  const shown = judged ? sortByGain(pictures, (picture) => judgements.get(picture)) : pictures;
  parts.pictures.replaceChildren(...shown.map((picture) => card(picture, members.has(picture), judgements.get(picture))));
}

function showSeries() {
  const found = groups(pictures);
  const before = parts.series.value;
  parts.series.replaceChildren(...found.map(({ id, camera, focal, size, members }) =>
    new Option([camera || t("photos.unnamed"), ...(focal ? [`${focal} mm`] : []), size.join(" × "), t("photos.count", { count: members.length })].join(" · "), id)));
  if (found.some(({ id }) => id === before)) parts.series.value = before;
  parts.several.hidden = found.length < 2;
  parts.form.hidden = found.length === 0;
}

/** Fill in the camera named in the files; typed text stays. */
function proposeKey() {
  const group = chosen();
  if (!group) return;
  parts.camera.value = group.camera || (query.get("camera") ?? parts.camera.value);
  parts.focal.value = group.focal ? String(group.focal) : "";
}

/** @param {File[]} files */
async function look(files) {
  run.abort();
  const { signal } = run = new AbortController();
  discard();
  parts.progress.hidden = false;
  /** @type {UnreadableError[]} */
  const unreadable = [];
  try {
    tell(() => t("photos.loading"));
    const finder = await openDetector();
    for (const [index, file] of files.entries()) {
      tell(() => t("photos.looking", { name: file.name }));
      parts.progress.value = index / files.length;
      try {
        for await (const shot of shots(file, signal)) {
          const picture = await find(finder, shot);
          if (signal.aborted) return;
          pictures.push(picture);
          origins.set(picture, file);
          showSeries();
          showPictures();
        }
      } catch (error) {
        if (!(error instanceof UnreadableError)) throw error;
        unreadable.push(error);
      }
      if (signal.aborted) return;
    }
    proposeKey();
    const views = groups(pictures).reduce((sum, { members }) => sum + members.length, 0);
    const values = { count: views, all: pictures.length };
    tell(() => [t("photos.found", values), ...(views === 0 ? [t("photos.which_board")] : []), ...reasons(unreadable)].join(" "));
  } catch (error) {
    if (!signal.aborted) tell(() => explain(error));
  } finally {
    parts.progress.hidden = true;
  }
}

/** Files that were not read: by name, and why. @param {UnreadableError[]} errors @returns {string[]} */
function reasons(errors) {
  const codes = [...new Set(errors.map(({ code }) => code))];
  return codes.map((code) => t(`photos.unreadable_${code}`, { names: errors.filter((each) => each.code === code).map(({ message }) => message).join(", ") }));
}

/** @param {Detector} finder @param {import("./files.js").Shot} shot @returns {Promise<Picture>} */
async function find(finder, { name, picture, camera, focal, kind }) {
  const kept = await createImageBitmap(picture, { resizeWidth: Math.min(picture.width, 480), resizeQuality: "high" });
  const { ids, points, size } = await finder.detect(picture, { full: true, timeout: DETECTION_TIMEOUT_MS });
  const scale = kept.width / size[0];
  const small = thumbnail(kept, points.map(([x, y]) => [(x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5]));
  kept.close();
  return { name, camera, focal, kind, size, ids, points, outline: observedOutline(board, { ids, points }), thumbnail: small };
}

/** @param {Set<Picture>} [without] pictures that are left out this time */
async function start(without = new Set()) {
  const group = chosen();
  if (!group) return;
  parts.start.disabled = true;
  const mine = discard();
  try {
    const { api: address, token, return_origins: returnOrigins } = await loadSettings();
    if (mine !== turn) return;
    const views = rankByNovelty(group.members.map((index) => pictures[index]).filter((picture) => !without.has(picture)), group.size, MAX_VIEWS);
    const request = {
      camera: parts.camera.value.trim(), platform: group.kind, img_size: group.size, zoom: Number(parts.focal.value) || 0,
      distortion_model: /** @type {import("../vendor/api.js").SessionRequest["distortion_model"]} */ (parts.model.value), board,
    };
    tell(() => t("photos.calibrating"));
    const onRetry = (/** @type {object | null} */ retry) => {
      if (mine === turn) tell(() => t(retry ? "faults.retry" : "photos.calibrating"));
    };
    const outcome = await calibrate(new Api(address, { onRetry }), token, request, views, (judgement) => {
      if (mine !== turn) return;
      judgements.set(views[judgement.view], judgement);
      showPictures();
    });
    if (mine === turn) await finish(outcome, views, returnOrigins, without);
  } catch (error) {
    if (mine === turn) tell(() => explain(error));
  } finally {
    parts.start.disabled = false;
  }
}

/** @param {Outcome} outcome @param {Picture[]} views @param {string[] | undefined} returnOrigins @param {Set<Picture>} without */
async function finish({ state, wanted, numbers }, views, returnOrigins, without) {
  const mine = turn;
  judged = true;
  showPictures();
  const taken = views.filter((each) => judgements.get(each)?.accepted);
  const id = state.calibration_id;
  if (!id) {
    const { uncertainty } = state;
    tell(() => (uncertainty ? t("photos.not_enough", { rms: number(uncertainty.rms, 1) }) : t("photos.nothing_taken")));
    if (wanted) want(() => [advice(wanted, state.img_size)]);
    return;
  }
  tell(() => t("photos.done", { count: taken.length }));
  const { calibration, report } = await load(id);
  const picture = await canvasOf(taken[0]);
  if (mine !== turn) return;
  const goOn = (/** @type {number[]} */ left) => void start(new Set([...without, ...left.map((index) => views[numbers.get(index) ?? -1])]));
  view.show({ calibration, report, picture, origin: "added", returnTo: query.get("return_to"), returnOrigins, goOn, explain });
  document.getElementById("verdict")?.focus();
}

/** A picture once more, as large as it is. @param {Picture | undefined} picture */
async function canvasOf(picture) {
  const file = picture && origins.get(picture);
  if (!file) return null;
  for await (const shot of shots(file, new AbortController().signal)) {
    const { width, height } = shot.picture;
    const canvas = el("canvas", { width, height });
    canvas.getContext("2d")?.drawImage(shot.picture, 0, 0);
    shot.picture.close();
    return canvas;
  }
  return null;
}

/** The photograph that would help most. @param {import("../vendor/api.js").Pose} pose @param {[number, number]} size */
function advice(pose, size) {
  const { svg, area, x, y } = imagePlot(size, t("photos.like_this"), { plain: true });
  const points = (/** @type {number[][]} */ list) => list.map(([u, v]) => `${short(x(u))},${short(y(v))}`).join(" ");
  for (const square of blackSquares(board, pose)) area.append(make("polygon", { points: points(square), class: "square" }));
  area.append(make("polygon", { points: points(pose.outline), class: "outline" }));
  return el("figure", { class: "figure measured" }, svg, el("figcaption", {}, t("photos.like_this")));
}

/** @param {FileList | null | undefined} list */
function take(list) {
  const files = [...(list ?? [])];
  if (files.length) void look(files);
}

parts.model.append(...Object.keys(COEFFICIENTS).map((model) => new Option("", model)));
function speak() {
  for (const option of parts.model.options) option.textContent = t(`photos.model_${option.value}`);
  const { squares, dictionary } = board;
  parts.board.textContent = t("photos.board", { size: sized(squares), dictionary });
  showSeries();
  showPictures();
}
speak();
onLanguage(speak);
showProblem(parts.problem, problem);
for (const link of /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('a[href^="../board/"]'))) {
  const there = new URL(link.href);
  there.search = boardQuery(board).toString();
  link.href = there.href;
}
sayChosen(parts.files);
parts.files.addEventListener("change", () => {
  take(parts.files.files);
  parts.files.value = "";
});
for (const name of ["dragenter", "dragover", "dragleave", "drop"]) {
  parts.drop.addEventListener(name, (event) => {
    event.preventDefault();
    parts.drop.classList.toggle("over", name === "dragenter" || name === "dragover");
    if (name === "drop") take(/** @type {DragEvent} */ (event).dataTransfer?.files);
  });
}
parts.series.addEventListener("change", () => {
  discard();
  tell();
  proposeKey();
  showPictures();
});
parts.form.addEventListener("submit", (event) => {
  event.preventDefault();
  void start();
});
part("clear", HTMLButtonElement).addEventListener("click", () => {
  run.abort();
  discard();
  pictures = [];
  origins.clear();
  tell();
  showSeries();
  showPictures();
  parts.files.focus();
});
