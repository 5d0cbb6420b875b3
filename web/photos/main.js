// Calibration from photos or a video. Boards are detected on this device; only corner positions are sent.
import { DEFAULT_BOARD, boardFrom, boardQuery, isSameBoard } from "../lib/board.js";
import { showProblem } from "../lib/board-text.js";
import { Detector, DetectorError } from "../lib/detector.js";
import { el, part, partsOf, liveRegion } from "../lib/dom.js";
import { explain as fault } from "../lib/faults.js";
import { takeFiles } from "../lib/files.js";
import { openPage } from "../lib/page.js";
import { hasMessage, onLanguage, t } from "../lib/i18n.js";
import { load } from "../lib/result/source.js";
import { levelOf } from "../lib/result/numbers.js";
import { LaterResultView } from "../lib/result/later.js";
import { COEFFICIENTS } from "../sdk/projection.js";
import { loadSettings } from "../lib/settings.js";
import { card, sizeOf } from "./card.js";
import { WhichBoard } from "../lib/board-form.js";
import { cameraOfNames, shots } from "./files.js";
import { showLikely } from "./likely.js";
import { groups } from "./group.js";
import { BoardQuestion, recogniseIn } from "./recognition.js";
import { search, unreadableTexts } from "./search.js";
import { wantedFigure } from "./wanted.js";
import { distinct, sortByGain, rankByNovelty } from "../lib/rank.js";
import { AUTOMATIC, MAX_VIEWS, calibrateOnPage } from "../lib/series.js";

/**
 * @import { Judgement, Outcome } from "../lib/series.js"
 * @import { Picture } from "./card.js"
 */

const MIN_SUFFICIENT_PHOTOS = 10; // that agree: with as many, the page asks for no more

openPage();
const query = new URLSearchParams(location.search);
const asked = boardFrom(query);
let { board } = asked;
let mirrored = false; // the pictures; then they are turned back
let isChosen =
  asked.problem === null &&
  ["kind", "squares", "marker_ratio", "dictionary", "legacy", "inverted"].some((name) => query.has(name));
const parts = {
  ...partsOf(HTMLElement, ["drop", "status", "pictures", "several", "wanted", "problem"]),
  ...partsOf(HTMLInputElement, ["files", "camera", "focal"]),
  progress: part("progress", HTMLProgressElement),
  form: part("form", HTMLFormElement),
  ...partsOf(HTMLSelectElement, ["series", "model"]),
  ...partsOf(HTMLButtonElement, ["start", "clear"]),
};
const view = new LaterResultView(part("result", HTMLElement));
const [tell, want] = [liveRegion(parts.status), liveRegion(parts.wanted)];
const whichBoard = new WhichBoard(board, (chosen) => changeBoard(chosen), isChosen);
const question = new BoardQuestion();
/** @type {File[]} all that were chosen; they stay when the board changes */
let files = [];
/** @type {Picture[]} */
let pictures = [];
/** @type {Map<Picture, Judgement>} */
const judgements = new Map();
/** True if the last judgement has arrived. */
let judged = false;
/** @type {Map<Picture, File>} to look at one again */
const origins = new Map();
/** @type {Promise<Detector> | null} */
let detector = null;
/** The search in progress. */
let run = new AbortController();
/** Number of calibrations: results of an earlier one, or of pictures chosen before, are ignored. */
let turn = 0;

/** @param {unknown} error */
function explain(error) {
  if (!(error instanceof DetectorError)) return fault(error);
  const key = `capture.fault_${error.code}`;
  return t(hasMessage(key) ? key : "capture.fault_detector", { detail: error.message });
}

const openDetector = () =>
  (detector ??= Detector.open(board).catch((error) => {
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
const chosenSeries = () => groups(pictures).find(({ id }) => id === parts.series.value) ?? groups(pictures)[0] ?? null;

/** Pictures, first those used, by what they added; of a video, only the frames used, in their order. */
function showPictures() {
  const members = new Set((chosenSeries()?.members ?? []).map((index) => pictures[index]));
  const isUsed = (/** @type {Picture} */ picture) => judgements.get(picture)?.accepted === true;
  const shown = (judged ? sortByGain(pictures, (picture) => judgements.get(picture)) : pictures).filter(
    (picture) => picture.kind !== "video",
  );
  const frames = pictures.filter((picture) => picture.kind === "video" && isUsed(picture));
  const cards = [...shown, ...frames].map((picture) => {
    const judgement = judgements.get(picture);
    // Once the result exists, errors of earlier steps say nothing about a picture.
    return card(
      picture,
      members.has(picture),
      judged && judgement?.accepted ? { ...judgement, after: null } : judgement,
    );
  });
  parts.pictures.classList.toggle("filmstrip", frames.length > 0 && shown.length === 0);
  parts.pictures.replaceChildren(...cards);
}

function showSeries() {
  void showLikely(part("likely", HTMLElement), pictures);
  const found = groups(pictures);
  const before = parts.series.value;
  parts.series.replaceChildren(
    ...found.map(
      ({ id, camera, focal, size, members }) =>
        new Option(
          [
            camera || t("photos.unnamed"),
            ...(focal ? [`${focal} mm`] : []),
            size.join(" × "),
            t("photos.count", { count: members.length }),
          ].join(" · "),
          id,
        ),
    ),
  );
  if (found.some(({ id }) => id === before)) parts.series.value = before;
  parts.several.hidden = found.length < 2;
  parts.form.hidden = found.length === 0;
  parts.clear.hidden = files.length === 0;
}

/** Fill in the camera named in the files, or by them; typed text stays. */
function proposeKey() {
  const group = chosenSeries();
  if (!group) return;
  const names = group.members.map((index) => origins.get(pictures[index])?.name ?? "");
  parts.camera.value = group.camera || (query.get("camera") ?? (parts.camera.value || cameraOfNames(names)));
  parts.focal.value = group.focal ? String(group.focal) : "";
}

/** Looks for another board in the same files. @param {typeof board} other */
function changeBoard(other) {
  board = other;
  isChosen = true;
  linkBoard();
  if (files.length) void lookAgain();
}

/** Looks at all files from the beginning. */
function lookAgain() {
  pictures = [];
  origins.clear();
  return look(files);
}

/** @param {File[]} added */
function take(added) {
  if (added.length === 0) return;
  files = [...files, ...added];
  void look(added);
}

/** @param {File[]} list */
async function look(list) {
  run.abort();
  const { signal } = (run = new AbortController());
  discard();
  parts.progress.hidden = false;
  parts.progress.removeAttribute("value");
  try {
    tell(() => t("photos.loading"));
    const finder = await openDetector();
    // If the visitor has not chosen a board, a few pictures show which one it is.
    const recognised = isChosen || pictures.length ? null : await recognise(finder, list, signal);
    if (signal.aborted) return;
    if (recognised && !isChosen) return;
    await finder.change(board);
    const unreadable = await search(finder, board, list, signal, {
      mirrored,
      onFile: (file, share) => {
        parts.progress.value = share;
        tell(() => t("photos.looking", { name: file.name, percent: Math.round(100 * share) }));
      },
      onPicture: (picture, file) => {
        pictures.push(picture);
        origins.set(picture, file);
        if (picture.kind === "video") return;
        showSeries();
        showPictures();
      },
    });
    if (signal.aborted) return;
    proposeKey();
    showSeries();
    const views = groups(pictures).reduce((sum, { members }) => sum + members.length, 0);
    if (views === 0 && pictures.length && !recognised && (await recognise(finder, list, signal))) return;
    if (signal.aborted) return;
    const values = { count: views, all: pictures.length };
    const isFilm = pictures.every(({ kind }) => kind === "video");
    const found = () => {
      if (pictures.length === 0) return [];
      return [
        views
          ? t(`photos.found_${isFilm ? "frames" : "photos"}`, values)
          : t("photos.not_found", { count: pictures.length }),
      ];
    };
    tell(() => [...found(), ...unreadableTexts(unreadable)].join(" "));
    if (views === 0 && pictures.length) whichBoard.open();
  } catch (error) {
    if (!signal.aborted) tell(() => explain(error));
  } finally {
    if (!signal.aborted) parts.progress.hidden = true;
  }
}

/**
 * Recognises the board, and asks whether it is the one.
 * @param {Detector} finder @param {File[]} list @param {AbortSignal} signal
 * @returns {Promise<boolean>} whether a board was recognised that is not the one looked for; then the answer has been
 *   acted on
 */
async function recognise(finder, list, signal) {
  tell(() => t("photos.recognising"));
  const found = await recogniseIn(finder, list, signal);
  if (signal.aborted || !found) return false;
  if (isSameBoard(found.board, board) && !found.mirrored) return false;
  tell();
  parts.progress.hidden = true;
  const isRight = await question.ask(found, signal);
  if (signal.aborted) return true;
  if (isRight) {
    whichBoard.show(found.board);
    mirrored = found.mirrored;
    changeBoard(found.board);
  } else {
    tell(() => t("photos.which_board_then"));
    whichBoard.open();
  }
  return true;
}

/** @param {Set<Picture>} [without] pictures that are left out this time */
async function start(without = new Set()) {
  const group = chosenSeries();
  if (!group) return;
  parts.start.disabled = true;
  const mine = discard();
  try {
    const settings = await loadSettings();
    if (mine !== turn) return;
    const members = group.members.map((index) => pictures[index]).filter((picture) => !without.has(picture));
    const views = rankByNovelty(
      group.kind === "video" ? distinct(members, group.size[0]) : members,
      group.size,
      MAX_VIEWS,
    );
    const request = {
      camera: parts.camera.value.trim(),
      platform: group.kind,
      img_size: group.size,
      zoom: Number(parts.focal.value) || 0,
      board,
    };
    const outcome = await calibrateOnPage(settings, request, parts.model.value, views, {
      judgements,
      tell,
      isCurrent: () => mine === turn,
      onJudgement: showPictures,
    });
    if (mine === turn) await finish(outcome, views, settings.return_origins, without);
  } catch (error) {
    if (mine === turn) tell(() => explain(error));
  } finally {
    parts.start.disabled = false;
  }
}

/**
 * @param {Outcome} outcome
 * @param {Picture[]} views
 * @param {string[] | undefined} returnOrigins
 * @param {Set<Picture>} without
 */
async function finish({ state, wanted, numbers }, views, returnOrigins, without) {
  const mine = turn;
  judged = true;
  showPictures();
  const taken = views.filter((each) => judgements.get(each)?.accepted);
  const id = state.calibration_id;
  const isFolded = taken.length >= MIN_SUFFICIENT_PHOTOS && Boolean(id);
  const helpful = () =>
    wanted ? [wantedFigure(board, wanted, state.img_size, { addMore: () => parts.files.click(), isFolded })] : [];
  if (!id) {
    const { uncertainty } = state;
    tell(() => (uncertainty ? t("photos.not_enough") : t("photos.nothing_taken")));
    want(helpful);
    return;
  }
  tell(() => t("photos.done", { count: taken.length, all: views.length }));
  const { calibration, report } = await load(id);
  const picture = await canvasOf(taken[0]);
  if (mine !== turn) return;
  const aside = el("div", { class: "wanted" });
  if (levelOf(calibration) !== "good" || (report?.verdict && report.verdict.level !== "good"))
    liveRegion(aside)(helpful);
  const pictureOf = (/** @type {number} */ index) => views[numbers.get(index) ?? -1];
  const goOn = (/** @type {number[]} */ left) => void start(new Set([...without, ...left.map(pictureOf)]));
  const names = (/** @type {number} */ index) => pictureOf(index)?.name ?? "";
  const photo = (/** @type {number} */ index) => pictureOf(index)?.thumbnail.toDataURL("image/jpeg") ?? null;
  await view.show({
    calibration,
    report,
    picture,
    origin: "added",
    returnTo: query.get("return_to"),
    returnOrigins,
    goOn,
    names,
    photo,
    aside,
    explain,
  });
  document.getElementById("verdict")?.focus();
}

/** A picture at its full size. @param {Picture | undefined} picture */
async function canvasOf(picture) {
  const file = picture && origins.get(picture);
  if (!file) return null;
  for await (const shot of shots(file, new AbortController().signal, { samples: 1, mirrored })) {
    const [width, height] = sizeOf(shot.picture);
    const canvas = el("canvas", { width, height });
    canvas.getContext("2d")?.drawImage(shot.picture, 0, 0);
    shot.picture.close();
    return canvas;
  }
  return null;
}

/** Makes the links to the board lead to the current one. */
function linkBoard() {
  for (const link of /** @type {NodeListOf<HTMLAnchorElement>} */ (
    document.querySelectorAll("main a[href*='/board/']")
  )) {
    const there = new URL(link.href);
    there.search = boardQuery(board).toString();
    link.href = there.href;
  }
}

parts.model.append(...[AUTOMATIC, ...Object.keys(COEFFICIENTS)].map((model) => new Option("", model)));
function speak() {
  for (const option of parts.model.options) option.textContent = t(`photos.model_${option.value}`);
  parts.camera.placeholder = t("photos.camera_example");
  showSeries();
  showPictures();
}
speak();
onLanguage(speak);
showProblem(parts.problem, asked.problem);
linkBoard();
takeFiles(parts.files, parts.drop, take);
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
parts.clear.addEventListener("click", () => {
  run.abort();
  discard();
  [files, pictures, mirrored] = [[], [], false];
  origins.clear();
  if (isSameBoard(board, DEFAULT_BOARD)) whichBoard.show(board, (isChosen = false));
  parts.progress.hidden = true;
  tell();
  showSeries();
  showPictures();
  parts.files.focus();
});
