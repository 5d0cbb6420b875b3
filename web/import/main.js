// Calibration from another program's measurements. The file is read on this device; only corner positions are sent.
import { observedOutline } from "../lib/board-outline.js";
import { part, partsOf, liveRegion } from "../lib/dom.js";
import { explain as fault } from "../lib/faults.js";
import { takeFiles } from "../lib/files.js";
import { openPage } from "../lib/page.js";
import { onLanguage, formatSize, t } from "../lib/i18n.js";
import { rankByNovelty } from "../lib/rank.js";
import { AUTOMATIC, MAX_VIEWS, calibrateOnPage } from "../lib/series.js";
import { load } from "../lib/result/source.js";
import { LaterResultView } from "../lib/result/later.js";
import { platformHere } from "../sdk/calibdb.js";
import { COEFFICIENTS } from "../sdk/projection.js";
import { loadSettings } from "../lib/settings.js";
import { Converter } from "./converter.js";
import { MAX_CHARACTERS, sourceOf, unpackCorners } from "../lib/conversion.js";
import { MalformedError } from "./grid.js";
import { MIN_VIEW_CORNERS, MAX_BYTES, prepare, read } from "./read.js";
import { table } from "./table.js";
import { decode } from "./text.js";
import { card, guessView } from "./views.js";

/**
 * @import { Judgement } from "../lib/series.js"
 * @import { Guess, Numbered, View } from "./read.js"
 */

/**
 * @typedef {object} Measured
 * @property {import("../lib/board.js").SentBoard} board
 * @property {[number, number]} size of the pictures, px
 * @property {Numbered[]} views those that tell most, best first
 * @property {number} count of views in the file
 */

openPage();
const query = new URLSearchParams(location.search);
const parts = {
  ...partsOf(HTMLElement, ["drop", "status", "problem", "guess", "views", "camera-label", "focal-field"]),
  ...partsOf(HTMLInputElement, ["file", "camera", "focal"]),
  ...partsOf(HTMLFormElement, ["table", "form"]),
  ...partsOf(HTMLSelectElement, ["kind", "model"]),
  start: part("start", HTMLButtonElement),
};
const [columns, rows, width, height] = ["columns", "rows", "width", "height"].map((id) => part(id, HTMLInputElement));
const view = new LaterResultView(part("result", HTMLElement));
const tell = liveRegion(parts.status);
const converter = new Converter(part("converter", HTMLElement), (error) => explain(error));
/** @type {Measured | null} */
let measured = null;
/** @type {Guess | null} */
let guessed = null;
/** @type {string | null} id of a calibration of this service, whose own file it is */
let own = null;
/** A table whose board the visitor still has to enter. */
let text = "";
/** @type {unknown} what is wrong */
let wrong = null;
/** @type {Map<Numbered, Judgement>} */
const judgements = new Map();
/** Name of a camera in the name of its file: what stands before the size, as in my-cam-640x480-photonvision.json. */
const FILE_OF_CAMERA = /^(.+?)[-_ ]\d{3,5}x\d{3,5}\b/;
const BINARY = /[\u0000-\u0008\u000e-\u001f\ufffd]/; // characters that no text has
/** Files are read one after the other, and only the last one counts. */
let turn = 0;

/** @param {unknown} error */
function explain(error) {
  if (error instanceof MalformedError) return t(`import.wrong_${error.code}`, error.values);
  return fault(error);
}

/** @param {unknown} error null: nothing is wrong any more */
function complain(error) {
  wrong = error;
  parts.problem.hidden = error === null;
  parts.problem.textContent = error === null ? "" : explain(error);
}

/** Forgets what was read. */
function clear() {
  [measured, guessed, own, text] = [null, null, null, ""];
  converter.clear();
  judgements.clear();
  view.clear();
  complain(null);
  tell();
  parts.table.hidden = true;
  show();
}

function show() {
  parts.guess.hidden = guessed === null;
  parts.guess.replaceChildren(...(guessed ? guessView(guessed, own) : []));
  parts.form.hidden = measured === null;
  parts.views.replaceChildren(
    ...(measured?.views.map((each) => card(each, /** @type {Measured} */ (measured).size, judgements.get(each))) ?? []),
  );
}

/** @param {File | undefined} file */
async function take(file) {
  if (!file) return;
  const mine = ++turn;
  clear();
  try {
    if (file.size > MAX_BYTES) throw new MalformedError("large", { most: MAX_BYTES / 1e6 });
    tell(() => t("import.reading", { name: file.name }));
    const bytes = await bytesOf(file);
    if (mine !== turn) return;
    tell();
    const content = decode(bytes);
    const source = sourceOf(bytes, content);
    const isArchive = source?.encoding === "base64";
    const found = kindOf(
      content,
      source !== null && (isArchive || (content.trim() !== "" && !BINARY.test(content.slice(0, 1000)))),
    );
    if (found.kind === "guess") {
      guessed = found;
      own = ownId(content);
      tell(() => t("import.was_read", { name: file.name }));
      if (source)
        converter.offer(
          source,
          file.name,
          found.packed && content.length <= MAX_CHARACTERS ? () => unpack(content) : null,
        );
    }
    if (found.kind === "keypoints") accept(found.views, found.size);
    if (found.kind === "table") ask(found.text, found.squares);
    parts.camera.value ||= (FILE_OF_CAMERA.exec(file.name)?.[1] ?? "").replaceAll(/[-_]/g, " ");
    show();
  } catch (error) {
    if (mine !== turn) return;
    tell();
    complain(error);
  }
}

/**
 * Content of a file, by its kind. The service may read kinds that the page does not know.
 * @param {string} content @param {boolean} isSendable whether the service takes it
 */
function kindOf(content, isSendable) {
  try {
    return read(content);
  } catch (error) {
    if (!(error instanceof MalformedError) || error.code !== "unknown" || !isSendable) throw error;
    return /** @type {Guess} */ ({ kind: "guess", matrix: null, packed: false });
  }
}

/** Id of a calibration of this service, null where it is another program's file. @param {string} content */
const ownId = (content) => /"id":\s*"(c\d+-[\w-]{8,120})"/.exec(content)?.[1] ?? null;

/** @param {File} file */
async function bytesOf(file) {
  try {
    return await file.arrayBuffer();
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    throw new MalformedError("unreadable"); // moved or changed since it was chosen, or not permitted
  }
}

/** Calibrates from the corners that a file has packed. @param {string} content */
async function unpack(content) {
  const mine = turn;
  const found = read(await unpackCorners(content));
  if (mine !== turn) return;
  if (found.kind !== "keypoints") throw new MalformedError("empty");
  guessed = null;
  converter.clear();
  accept(found.views, found.size);
  show();
}

/** Board of a table of corners. @param {string} content @param {[number, number] | null} squares */
function ask(content, squares) {
  text = content;
  [columns.value, rows.value] = squares?.map(String) ?? ["", ""];
  parts.table.hidden = false;
  tell(() => t("import.which_board"));
  (squares ? width : columns).focus();
}

/** @param {View[]} views @param {[number, number]} size */
function accept(views, size) {
  const { board, views: numbered } = prepare(views, size);
  const candidates = numbered.map((each) => ({ ...each, outline: observedOutline(board, each) }));
  measured = { board, size, views: rankByNovelty(candidates, size, MAX_VIEWS), count: views.length };
  summarise();
}

function summarise() {
  if (!measured) return;
  const { board, size, views, count } = measured;
  tell(() =>
    [
      t("import.found", { count, squares: formatSize(board.squares), size: formatSize(size) }),
      ...(count > views.length ? [t("import.best", { most: views.length })] : []),
    ].join(" "),
  );
}

/** @param {Set<unknown>} [without] views that are left out this time */
async function start(without = new Set()) {
  if (!measured) return;
  const { board, size, views } = measured;
  const mine = turn;
  parts.start.disabled = true;
  view.clear();
  complain(null);
  judgements.clear();
  show();
  try {
    const settings = await loadSettings();
    const webcam = parts.kind.value === "webcam";
    const request = {
      camera: parts.camera.value.trim(),
      platform: webcam ? await platformHere() : parts.kind.value,
      img_size: size,
      zoom: webcam ? 0 : Number(parts.focal.value) || 0,
      board,
    };
    const usable = views.filter((each) => each.points.length >= MIN_VIEW_CORNERS && !without.has(each));
    const { state, numbers } = await calibrateOnPage(settings, request, parts.model.value, usable, {
      judgements,
      tell,
      isCurrent: () => mine === turn,
      onJudgement: show,
    });
    if (mine !== turn) return;
    const id = state.calibration_id;
    if (!id) {
      const { uncertainty } = state;
      tell(() => (uncertainty ? t("import.not_enough") : t("import.nothing_taken")));
      return;
    }
    const taken = [...judgements.values()].filter(({ accepted }) => accepted);
    tell(() => t("photos.done", { count: taken.length, all: usable.length }));
    const { calibration, report } = await load(id);
    const goOn = (/** @type {number[]} */ left) =>
      void start(new Set([...without, ...left.map((index) => usable[numbers.get(index) ?? -1])]));
    await view.show({
      calibration,
      report,
      origin: "imported",
      returnTo: query.get("return_to"),
      returnOrigins: settings.return_origins,
      goOn,
      explain,
    });
    document.getElementById("verdict")?.focus();
  } catch (error) {
    if (mine !== turn) return;
    tell();
    complain(error);
  } finally {
    parts.start.disabled = false;
  }
}

function showKind() {
  const webcam = parts.kind.value === "webcam";
  parts.focalField.hidden = webcam;
  parts.cameraLabel.textContent = t(webcam ? "import.webcam" : "photos.camera");
}

function speak() {
  for (const option of parts.model.options) option.textContent = t(`photos.model_${option.value}`);
  showKind();
  if (wrong !== null) complain(wrong);
  show();
}

parts.camera.value = query.get("camera") ?? "";
parts.kind.value = query.has("camera") ? "webcam" : "photographs";
parts.model.append(...[AUTOMATIC, ...Object.keys(COEFFICIENTS)].map((model) => new Option("", model)));
speak();
onLanguage(speak);
takeFiles(parts.file, parts.drop, ([file]) => void take(file));
parts.kind.addEventListener("change", showKind);
parts.table.addEventListener("submit", (event) => {
  event.preventDefault();
  turn++; // invalidates the results of an earlier reading
  complain(null);
  view.clear();
  judgements.clear();
  measured = null;
  try {
    accept(table(text, [columns.valueAsNumber, rows.valueAsNumber]), [width.valueAsNumber, height.valueAsNumber]);
  } catch (error) {
    tell();
    complain(error);
  }
  show();
});
parts.form.addEventListener("submit", (event) => {
  event.preventDefault();
  void start();
});
