import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { Announcer } from "../../web/lib/capture/feedback.js";
import { propose } from "../../web/lib/camera.js";
import "./messages.mjs";
import { initial } from "../../web/calibrate/reducer.js";
import { requestFacts, requestText } from "../../web/calibrate/status-text.js";
import * as statusText from "../../web/calibrate/status-text.js";
import { labelOf, setupFrom } from "../../web/lib/virtual/setup.js";

const VIRTUAL = { id: "virtual", label: labelOf(setupFrom(new URLSearchParams())) };
const BUILT_IN = { id: "a", label: "Integrated Camera", named: true };
const C920 = { id: "b", label: "C920", named: true };
const wanted = { camera: "C920", img_size: [1280, 720], distortion_model: "rectilinear" };
const fresh = initial(DEFAULT_BOARD, wanted);
const having = (changes, state = fresh) => ({
  ...state,
  ...Object.fromEntries(Object.entries(changes).map(([part, change]) => [part, { ...state[part], ...change }])),
});
const state = having({ ui: { cameras: [BUILT_IN, VIRTUAL] } });
const key = { camera: "C920", platform: "X11", img_size: [1280, 720], zoom: 0 };

test("the requested camera is proposed, never the virtual one", () => {
  assert.equal(propose([BUILT_IN, C920, VIRTUAL], "C920", ""), "b");
  assert.equal(propose([BUILT_IN, C920, VIRTUAL], "C920", "a"), "a");
  assert.equal(propose([BUILT_IN, VIRTUAL], "C920", ""), "a");
  assert.equal(propose([VIRTUAL], "C920", ""), "");
  assert.equal(propose([VIRTUAL], VIRTUAL.label, ""), "virtual");
  assert.equal(propose([VIRTUAL], null, ""), "");
  assert.equal(propose([VIRTUAL], null, "virtual"), "virtual");
});

test("a missing camera is reported once names are known", () => {
  assert.equal(
    statusText.wanted(state),
    "This page was opened for C920 at 1280\u00a0×\u00a0720. That camera is not connected here.",
  );
  assert.equal(
    statusText.wanted(having({ ui: { cameras: [C920, VIRTUAL] } })),
    "This page was opened for C920 at 1280\u00a0×\u00a0720.",
  );
  const nameless = { id: "", label: "Camera 1", named: false };
  assert.equal(
    statusText.wanted(having({ ui: { cameras: [nameless, VIRTUAL] } })),
    "This page was opened for C920 at 1280\u00a0×\u00a0720.",
  );
  assert.match(statusText.wanted(having({ ui: { cameras: [VIRTUAL] } })), /No camera was found here/);
});

test("another camera or size than requested is reported", () => {
  assert.equal(statusText.cameraMismatch(having({ capture: { key } })), "");
  assert.match(
    statusText.cameraMismatch(having({ capture: { key: { ...key, camera: "Integrated Camera" } } })),
    /C920 at 1280\u00a0×\u00a0720. Open now: Integrated Camera/,
  );
  assert.match(
    statusText.cameraMismatch(having({ capture: { key: { ...key, img_size: [640, 480] } } })),
    /Open now: C920 at 640\u00a0×\u00a0480/,
  );
  assert.equal(statusText.cameraMismatch(having({ capture: { key }, wanted: { camera: null } })), "");
});

test("all that is sent is shown, as it is sent", () => {
  const request = {
    ...key,
    board: DEFAULT_BOARD,
    distortion_model: "fisheye",
    target_error: 0.1,
    track: { focusMode: "manual" },
  };
  assert.deepEqual(JSON.parse(requestText(request)), request);
  const facts = Object.fromEntries(requestFacts(request));
  assert.equal(Object.keys(facts).length, Object.keys(request).length - 1 + Object.keys(request.track).length);
  assert.equal(facts["Lens model"], "Fisheye");
  assert.equal(facts.Resolution, "1280\u00a0×\u00a0720");
  assert.match(facts.Board, /^9 × 6 squares, DICT_4X4_50/);
});

test("news are announced once, instructions on change", async () => {
  const place = { textContent: "" };
  const announcer = new Announcer(place, 5);
  announcer.say("Closer", "View 1 taken.");
  assert.equal(place.textContent, "View 1 taken. Closer");
  announcer.say("Move left", "View 1 taken.");
  announcer.say("Hold still", "View 2 taken.");
  announcer.say("Move up", "");
  await new Promise((done) => setTimeout(done, 20));
  assert.equal(place.textContent, "View 2 taken. Move up", "news are not lost to what comes after them");
  announcer.say("Turn it", "", "");
  announcer.say("Turn it", "", "Another camera.");
  announcer.say("Turn it", "View 3 taken.", "Another camera.");
  announcer.say("Closer", "View 3 taken.", "Another camera.");
  await new Promise((done) => setTimeout(done, 20));
  assert.equal(place.textContent, "View 3 taken. Another camera. Closer", "nor to what is new of another kind");
});

test("a model that would fit better is offered, unless it is the one", () => {
  const session = { suggested_model: "fisheye" };
  assert.equal(statusText.suggestedModel(having({ capture: { session } })), "Start again with lens model “Fisheye”");
  assert.equal(
    statusText.suggestedModel(having({ capture: { session }, wanted: { distortion_model: "fisheye" } })),
    "",
  );
  assert.equal(statusText.suggestedModel(state), "");
});

test("what is waited for is named", () => {
  assert.match(statusText.opening(having({ ui: { waiting: "camera" } })), /If your browser asks, allow it/);
  assert.match(statusText.opening(having({ ui: { waiting: "service" } })), /Opening a session at calibDB/);
  assert.match(statusText.opening(having({ ui: { waiting: "service" }, link: { attempts: 2 } })), /lost. Trying again/);
});

test("the status line says that the detector is loading", () => {
  assert.match(statusText.statusLine(having({ detector: { loading: 0.5 } })), /Loading the board detector/);
  assert.doesNotMatch(statusText.statusLine(having({ detector: { loading: 1 } })), /Loading/);
});

test("the cause of what is systematic is told while the capture runs", () => {
  const told = (codes, { count = 4, unsteady = false } = {}) => {
    const advice = codes.map((code) => ({ code, text: "" }));
    const session = { advice, suggested_model: "fisheye", views: Array(count).fill({}) };
    return statusText.statusLine(having({ capture: { unsteady, session }, ui: { saved: true } }));
  };
  assert.match(told(["board_bent", "limit_reached"]), /Glue it to something rigid/);
  assert.equal(told(["board_bent"], { count: 3 }), "");
  assert.equal(told(["motion"]), "", "the corners did not move while the views were held");
  assert.match(told(["motion"], { unsteady: true }), /Hold it still for longer/);
  assert.match(told(["focus_changed"]), /Switch autofocus off/);
  assert.match(told(["model_too_simple"]), /“Fisheye” would fit better/);
});

test("the views taken are counted, and four are said to be the least", () => {
  const counted = (count, rms) => {
    const session = { views: Array(count).fill({}), uncertainty: { rms, max: 1 }, target_error: 0.3 };
    return statusText.counts(having({ capture: { session } })).join(" · ");
  };
  assert.equal(counted(1, 19), "1 of about 5 views · at least 4");
  assert.equal(counted(2, 0.2), "2 of about 4 views · accurate enough; 2 more to confirm");
  assert.equal(counted(4, 0.5), "4 of about 5 views");
  assert.equal(counted(6, 0.5), "6 of about 7 views");
});

test("pixels are for who opens the details", () => {
  const session = { views: [], uncertainty: { rms: 0.2, max: 1 }, target_error: 0.3 };
  assert.equal(statusText.accuracy(having({ capture: { session } })), "Accuracy so far: ± 0.20, goal 0.30\u00a0px");
  assert.equal(statusText.accuracy(fresh), "");
});

test("the button that ends the capture says what is lost by it", () => {
  const after = (count, more = {}) => having({ capture: { session: { views: Array(count).fill({}) } }, ...more });
  assert.equal(statusText.stopLabel(after(0)), "Cancel");
  assert.equal(statusText.stopLabel(after(2)), "Stop");
  assert.equal(statusText.stopLabel(after(2, { ui: { stopAskedAt: 1 } })), "Stop?");
});

test("there is one instruction at a time", () => {
  const code = (more) =>
    having({ capture: { skipAfter: 1_000 }, ui: { instruction: { code: "tilt_left", next: "", since: 0 }, ...more } });
  const useless = code({ notice: { key: "capture.useless", kind: "plain" } });
  assert.equal(statusText.instruction(useless), "Looking for a better pose");
  assert.equal(statusText.notice(useless.ui.notice), "");
  const hinted = code({ notice: { key: "capture.refused_too_few_points", kind: "bad", hint: "closer" } });
  assert.equal(statusText.instruction(hinted), "Bring the board closer");
  assert.equal(statusText.notice(hinted.ui.notice), "Too little of the board was visible.");
});
