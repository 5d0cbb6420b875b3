// Rig page: several cameras calibrated together. It begins or joins a rig, resumes an interrupted one, and shows
// results.
import { Api } from "../lib/api.js";
import { boardFrom, boardQuery } from "../lib/board.js";
import { showProblem } from "../lib/board-text.js";
import { CameraError, deviceFaultText } from "../lib/camera.js";
import { Announcer, Feedback } from "../lib/capture/feedback.js";
import { acquireLock, heldLocks, openCaptureStore } from "../lib/capture/capture-store.js";
import { PageDetector } from "../lib/detector.js";
import { pressByKeys, sayFailure } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { onLanguage, pageUrl, t } from "../lib/i18n.js";
import { latest } from "../lib/latest.js";
import { openPage } from "../lib/page.js";
import { showRigPicture } from "../lib/rig-picture.js";
import { lastSettings } from "../lib/settings.js";
import { keepAwake, openCameras, openDetector } from "./opening.js";
import { ResizeError, RigCapture } from "./capture.js";
import { JoinError, enter, invite, requestOf } from "./membership.js";
import { findParts } from "./parts.js";
import { NOTHING_SHOWN, render } from "./render.js";
import { RigService } from "./service.js";
import { MIN_CAMERAS, Setup } from "./setup.js";
import { HALVES } from "../lib/capture/streams.js";

/**
 * @import { Choice } from "../lib/capture/streams.js"
 * @import { RigRecord } from "./membership.js"
 * @import { RigState } from "./service.js"
 */

/**
 * @typedef {{record: RigRecord, code?: string}} Beginning code: of the rig to join
 */

openPage();
const parameters = new URLSearchParams(location.search);
const parts = findParts();
const { board, problem } = boardFrom(parameters);
const joins = parameters.has("code") || parameters.has("join");
const store = /** @type {import("../lib/capture/capture-store.js").CaptureStore<RigRecord>} */ (
  openCaptureStore("calibdb.rigs")
);
const feedback = new Feedback();
const announcer = new Announcer(parts.said);
const setup = new Setup(parts, parameters, joins);
/**
 * Pictures of the views taken last, by position: the result shows them straightened.
 * @type {Map<number, ImageBitmap>}
 */
const pictures = new Map();
/**
 * Views that this page took, by moment: the result draws the boards.
 * @type {Map<string, {position: number, corners: import("../lib/board-outline.js").Corners}>}
 */
const taken = new Map();
/** @type {Beginning | null} */
let last = null;
/** @type {RigRecord | null} */
let interrupted = null;
/** @type {import("./render.js").Invitation} */
let invitation = null;
/** @type {RigCapture | null} */
let capture = null;
/** True if the visitor has asked for a stop that loses moments. */
let isStopAsked = false;
/** Draws the capture again. */
let redraw = () => {};

/** @param {keyof typeof parts.phases} phase */
function show(phase) {
  for (const [name, section] of Object.entries(parts.phases)) section.hidden = name !== phase;
  document.documentElement.classList.remove("arrives");
  document.body.classList.toggle("viewfinder", phase === "capturing");
  document.body.classList.toggle("wide", phase === "capturing");
  parts.phases[phase].querySelector("h1")?.focus();
}

/** @param {Record<string, string>} query besides the board's */
function address(query) {
  const kept = new URLSearchParams([...boardQuery(board), ...Object.entries(query)]);
  return pageUrl(`rig/?${kept}`).href;
}

/** Parameters of the simulated cameras: all devices of the rig see the same scene. */
const simulation = () =>
  Object.fromEntries(
    [...parameters].filter(([name]) =>
      ["virtual", "img_size", "error", "seed", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"].includes(name),
    ),
  );

/** The service, without a network by the settings of the last visit. @param {AbortSignal} signal */
async function openService(signal) {
  const { api, token } = await lastSettings();
  return new RigService(new Api(api, { signal, timeout: 15_000 }), token);
}

/** One capture, from opening the cameras to its end; a new one ends the one before. */
const begin = latest(async (signal, /** @type {Beginning} */ beginning) => {
  last = beginning;
  parts.loadingMeter.hidden = true;
  parts.openingText.textContent = t("capture.opening_camera");
  show("opening");
  try {
    const state = await run(beginning, signal);
    if (state && !signal.aborted) await finished(state, beginning.record);
  } catch (error) {
    fail(error, signal);
  }
});

/** @param {Beginning} beginning @param {AbortSignal} signal */
async function run({ record, code }, signal) {
  const { virtual, shown } = await openCameras(parts, record, {
    parameters,
    board,
    signal,
    onUnplugged: (error) => fail(error, signal),
  });
  const detector = new PageDetector(() => openDetector(parts, board, signal));
  await detector.open();
  parts.openingText.textContent = t("capture.opening_service");
  const service = await openService(signal);
  const save = () => store.save(record);
  const requests = shown.map(({ picture, choice }) => requestOf(picture, board, choice));
  invitation = null;
  isStopAsked = false;
  parts.stop.textContent = t("rig.stop");
  const invited = await enter(service, record, requests, { code, save });
  if (!(await acquireLock(record.about, signal))) throw new CameraError("elsewhere");
  await save();
  // A rig whose code has expired, or that a reload has forgotten, has a new one.
  if (record.leads) setInvitation(invited ?? (await freshCode(service, record)));
  history.replaceState(null, "", address({ ...simulation(), id: record.about }));
  const members = shown.map(({ stream, figure, picture, half }, index) => ({
    ...record.members[index],
    stream,
    half,
    figure,
    size: picture.size,
    camera: picture.camera,
  }));
  const { leads } = record;
  let before = /** @type {import("./render.js").Shown} */ (NOTHING_SHOWN);
  capture = new RigCapture({
    service,
    record,
    save,
    board,
    openDetector: () => detector.open(),
    members,
    virtual,
    signal,
    onChange: () => redraw(),
    onSign: (sign) => feedback.give(sign),
    onFailure: (error) => fail(error, signal),
    onTaken: (moment, position, corners, picture) => {
      if (!taken.has(moment)) taken.set(moment, { position, corners });
      pictures.get(position)?.close();
      pictures.set(position, picture);
    },
  });
  const { model } = capture;
  redraw = () => {
    const drawn = render(
      parts,
      model,
      { members, leads, board, invitation, time: performance.now(), undo: (id) => capture?.undo(id) },
      before,
    );
    before = drawn;
    announcer.say(drawn.said, drawn.line);
    feedback.say(drawn.said);
  };
  parts.newCode.onclick = async () => setInvitation(await freshCode(service, record));
  redraw();
  show("capturing");
  pressByKeys({ u: parts.undo, n: parts.skip, t: parts.take }, signal);
  void keepAwake(signal);
  return capture.run();
}

/** @param {RigService} service @param {RigRecord} record */
async function freshCode(service, record) {
  try {
    return await invite(service, record);
  } catch (error) {
    console.info("no code:", String(error)); // all cameras have joined, or there is no network: the capture continues
    return null;
  }
}

/** @param {{code: string, expires: number} | null} invited */
function setInvitation(invited) {
  const own = last?.record.members.length ?? 0;
  invitation = invited && {
    ...invited,
    address: address({
      ...simulation(),
      ...(parameters.get("virtual") === "1" && { position: String(own) }),
      code: invited.code,
    }),
  };
  redraw();
}

/** @param {RigState} state @param {RigRecord | null} record */
async function finished(state, record) {
  begin.cancel();
  feedback.give("done");
  history.replaceState(null, "", pageUrl(`rig/?id=${encodeURIComponent(state.rig_id)}`));
  await showResult(state, record);
  // The rig has everything now.
  if (record) await store.remove(record.about);
}

/** @param {RigState} state @param {RigRecord | null} record of this device's part in it */
async function showResult(state, record) {
  const { RigView, titleOf } = await import("./result.js");
  const { keepReceipt } = await import("../lib/receipts.js");
  for (const { position, session, request } of record?.members ?? []) {
    keepReceipt(session, { calibration_id: state.result?.cameras[position], camera: request?.camera });
  }
  const service = await openService(new AbortController().signal);
  new RigView(parts.result, state, { service, pictures, views: [...taken.values()] }).draw();
  document.title = titleOf(state);
  show("done");
}

/** @param {unknown} error @param {AbortSignal} [signal] of the capture that failed */
function fail(error, signal) {
  if (signal?.aborted) return;
  begin.cancel();
  sayFailure(parts.failure, failureText(error));
  show("failed");
  void listInterrupted();
}

/** @param {unknown} error */
function failureText(error) {
  if (error instanceof JoinError) return t(`rig.join_${error.code}`);
  if (error instanceof ResizeError) return t("rig.resized");
  return deviceFaultText(error) || explain(error);
}

/**
 * @param {readonly Choice[]} choices
 * @param {boolean} leads
 * @param {number} first position of simulated cameras
 * @returns {RigRecord}
 */
function newRecord(choices, leads, first = 0) {
  const members = choices
    .flatMap(({ layout }) => HALVES[layout])
    .map((_, index) => ({
      position: leads || first > 0 ? first + index : 0,
      session: "",
      opened: false,
      request: null,
    }));
  return {
    about: "",
    leads,
    query: new URLSearchParams([...boardQuery(board), ...Object.entries(simulation())]).toString(),
    cameras: Math.max(MIN_CAMERAS, setup.count),
    square_size: setup.squareSize,
    choices: [...choices],
    members,
    letters: [],
  };
}

/** Simulated cameras: two of this device unless the address says otherwise. @returns {Beginning} */
function practice() {
  parameters.set("virtual", "1");
  const layout = /** @type {Choice["layout"]} */ (parameters.get("layout") ?? "one");
  const number = (/** @type {string} */ name, /** @type {number} */ otherwise) =>
    Number(parameters.get(name) ?? otherwise);
  const choice = (/** @type {number} */ index) => ({
    id: `virtual-${index}`,
    label: "",
    layout,
    distortion_model: /** @type {const} */ ("rectilinear"),
  });
  const own = number(
    "cameras",
    joins ? 1 : layout === "one" && !Number(parts.others.value) && !parameters.has("others") ? 2 : 1,
  );
  const choices = Array.from({ length: own }, (_, index) => choice(index));
  const record = newRecord(choices, !joins, joins ? number("position", 1) : 0);
  record.cameras = Math.max(MIN_CAMERAS, record.members.length + number("others", Number(parts.others.value)));
  return { record, code: setup.code };
}

/** @param {boolean} virtual */
function start(virtual) {
  const wrong = setup.problem(virtual);
  parts.setupProblem.textContent = wrong;
  if (wrong) return;
  void begin(virtual ? practice() : { record: newRecord(setup.choices, !joins), code: setup.code });
}

/** @param {RigRecord} record */
function resume(record) {
  if (
    new URLSearchParams(record.query).toString() !==
    new URLSearchParams([...boardQuery(board), ...Object.entries(simulation())]).toString()
  ) {
    return location.assign(
      `${location.pathname}?${record.query}${record.query ? "&" : ""}id=${encodeURIComponent(record.about)}`,
    );
  }
  void begin({ record });
}

async function listInterrupted() {
  interrupted = await store.last(await heldLocks());
  parts.interrupted.hidden = !interrupted;
  parts.interruptedText.textContent = interrupted
    ? t("rig.interrupted", { count: interrupted.letters.filter(({ kind }) => kind === "view").length })
    : "";
}

/** Ends this device's part. If moments would be lost, the visitor has to confirm. */
async function stop() {
  const record = last?.record;
  const { state = null, waiting = 0 } = capture?.model ?? {};
  const lost = Math.max(state?.moments.length ?? 0, waiting);
  if (lost > 0 && !isStopAsked) {
    isStopAsked = true;
    parts.stop.textContent = t(record?.leads ? "rig.stop_really" : "rig.leave_really", { count: lost });
    return;
  }
  begin.cancel();
  if (record?.about) {
    await store.remove(record.about);
    // The rig expires at the service in any case.
    await giveUp(record).catch((error) => console.info("not given up at the service:", String(error)));
  }
  location.assign(pageUrl("rig/"));
}

/** Reports to the service that this device's cameras have stopped. @param {RigRecord} record */
async function giveUp({ about, leads, members }) {
  const service = await openService(new AbortController().signal);
  if (leads) await service.forget(about, members[0].session);
  else for (const { session } of members) await service.leave(session);
}

/** Shows a rig that an address names: its result, or the capture that this browser takes part in. @param {string} id */
async function open(id) {
  const record = await store.load(id);
  parts.openingText.textContent = t("rig.loading");
  show("opening");
  try {
    const service = await openService(new AbortController().signal);
    const found = await service.state(id, record?.members[0]?.session || undefined);
    if (found?.state.status === "finished") return await finishedElsewhere(found.state, record);
    if (!record) throw new Error(t("rig.not_here"));
    resume(record);
  } catch (error) {
    if (record) return resume(record); // without the network, too
    const isElsewhere = error instanceof Error && !("status" in error) && error.message === t("rig.not_here");
    sayFailure(parts.failure, isElsewhere ? error.message : failureText(error));
    show("failed");
  }
}

/** @param {RigState} state @param {RigRecord | null} record */
async function finishedElsewhere(state, record) {
  await showResult(state, record);
  if (record) await store.remove(record.about);
}

parts.setup.addEventListener("submit", (event) => {
  event.preventDefault();
  start(false);
});
parts.practise.addEventListener("click", () => start(true));
parts.goOn.addEventListener("click", () => interrupted && resume(interrupted));
parts.forget.addEventListener("click", async () => {
  if (interrupted) await store.remove(interrupted.about);
  await listInterrupted();
  parts.start.focus();
});
for (const button of [parts.cancel, parts.back])
  button.addEventListener("click", () => {
    begin.cancel();
    show("welcome");
  });
parts.again.addEventListener("click", () => (last ? void begin(last) : location.reload()));
parts.stop.addEventListener("click", ({ detail }) => void (detail < 2 && stop()));
parts.undo.addEventListener("click", () => capture?.undo());
parts.skip.addEventListener("click", () => void capture?.skip());
parts.take.addEventListener("click", () => void capture?.open());
parts.finish.addEventListener("click", () => void capture?.finish());
feedback.bind(parts.senses);
showRigPicture(parts.picture);
for (const link of parts.boardLinks) link.search = boardQuery(board).toString();
showProblem(parts.problem, problem);
onLanguage(() => {
  void setup.list(true);
  redraw();
});
await Promise.all([setup.list(), listInterrupted()]);
const id = parameters.get("id");
if (id) void open(id);
else if (parameters.get("virtual") === "1") start(true);
