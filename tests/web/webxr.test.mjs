// The extension of WebXR on classes that behave as a browser's; real browsers: tests/browser/test_webxr.py.
import assert from "node:assert/strict";
import test from "node:test";
import { projectionMatrix } from "../../web/sdk/pinhole.js";
import { extend, matrixOf } from "../../web/webxr/extension.js";
import { calibrationOf, cameraMatrix } from "./scenes.mjs";

const PLAIN = calibrationOf([500, 505], [325, 238], {
  img_size: [640, 480],
  distortion_coefficients: [-0.25, 0.0625, 0, 0, 0],
});
const FISHEYE = { ...PLAIN, distortion_model: "fisheye", distortion_coefficients: [-0.125, 0.5, 0, 0.25] };
const MATRIX = [500, 0, 0, 0, 505, 0, 325, 238, 1];
const NOTHING = [null, null, null];

/** A browser's classes, anew for every test: they are changed. */
function browser() {
  class XRView {}
  class XRRenderState {}
  class XRFrame {
    constructor(session) {
      this.session = session;
    }
    getViewerPose() {
      if (!this.session.tracked) return null;
      return { views: this.session.seen.map((own) => Object.assign(new XRView(), own)) };
    }
  }
  class XRSession extends EventTarget {
    #state = new XRRenderState();
    applied = [];
    tracked = true;
    ended = false;
    seen = [{}];
    get renderState() {
      return this.#state;
    }
    updateRenderState(init) {
      if (this.ended) throw new DOMException("ended", "InvalidStateError");
      this.applied.push(init);
    }
    end() {
      this.ended = true;
      this.dispatchEvent(new Event("end"));
    }
  }
  return { XRView, XRFrame, XRSession, XRRenderState };
}

const say = ({ cameraMatrix, distortionCoefficients, distortionModel }) => [
  cameraMatrix && [...cameraMatrix],
  distortionCoefficients && [...distortionCoefficients],
  distortionModel,
];
const views = ({ XRFrame }, session) => new XRFrame(session).getViewerPose().views;
const look = (global, session) => say(views(global, session)[0]);
const settled = () => new Promise(setImmediate);

function running(options = {}) {
  const global = browser();
  const calls = [];
  const again = extend(
    (session, model, size) =>
      new Promise((resolve, reject) => {
        calls.push({ session, model, size, resolve, reject });
      }),
    { global, ...options },
  );
  const answer = async (call, calibration) => {
    calls[call].resolve(calibration);
    await settled();
  };
  return { global, session: new global.XRSession(), calls, again, answer };
}

test("views are empty until the calibration arrives", async () => {
  const { global, session, calls, answer } = running();
  assert.deepEqual(look(global, session), NOTHING);
  assert.deepEqual(
    calls.map(({ model, size }) => [model, size]),
    [["rectilinear", null]],
  );
  await answer(0, PLAIN);
  const [view] = views(global, session);
  assert.deepEqual(say(view), [MATRIX, PLAIN.distortion_coefficients, "rectilinear"]);
  assert.ok(view.cameraMatrix instanceof Float32Array && view.distortionCoefficients instanceof Float32Array);
  assert.equal(calls.length, 1);
  for (const name of ["cameraMatrix", "distortionCoefficients", "distortionModel"]) {
    assert.ok(Object.hasOwn(global.XRView.prototype, name) && name in view);
    assert.equal(global.XRView.prototype[name], null);
  }
});

test("views are independent", async () => {
  const { global, session, answer } = running();
  const [early] = views(global, session);
  await answer(0, PLAIN);
  const [view] = views(global, session);
  view.cameraMatrix.fill(0);
  session.end();
  assert.deepEqual(say(early), NOTHING);
  assert.deepEqual([...view.cameraMatrix], Array(9).fill(0));
  assert.deepEqual(look(global, session)[0], MATRIX);
});

test("another model is requested once, stale answers are dropped", async () => {
  const { global, session, calls, answer } = running();
  look(global, session);
  session.updateRenderState({ distortionModel: "fisheye", depthNear: 2 });
  session.updateRenderState({ distortionModel: "fisheye" });
  assert.deepEqual(session.applied[0].depthNear, 2);
  assert.equal(session.renderState.distortionModel, "fisheye");
  assert.deepEqual(
    calls.map(({ model }) => model),
    ["rectilinear", "fisheye"],
  );
  await answer(1, FISHEYE);
  await answer(0, PLAIN);
  assert.deepEqual(look(global, session), [MATRIX, FISHEYE.distortion_coefficients, "fisheye"]);
});

test("unknown models are a TypeError and change nothing", () => {
  const { global, session, calls } = running();
  for (const distortionModel of ["Fisheye", "", "toString", "constructor", null, 7, Symbol("fisheye")]) {
    assert.throws(() => session.updateRenderState({ depthNear: 2, distortionModel }), TypeError);
  }
  assert.deepEqual(session.applied, []);
  assert.throws(() => extend(async () => null, { global, model: "brown" }), TypeError);
  for (const init of [
    undefined,
    null,
    {},
    { distortionModel: undefined },
    Object.create({ distortionModel: "rational" }),
  ]) {
    session.updateRenderState(init);
  }
  assert.equal(session.applied.length, 5);
  look(global, session);
  assert.deepEqual(
    calls.map(({ model }) => model),
    ["rational"],
    "a member may be inherited, and the first frame asks",
  );
});

test("an error leaves the views as they were until a retry", async () => {
  const messages = [];
  const { global, session, calls, again, answer } = running({ onError: (error) => messages.push(error.message) });
  look(global, session);
  calls[0].reject(new Error("no network"));
  await settled();
  assert.deepEqual(look(global, session), NOTHING);
  session.updateRenderState({ distortionModel: "rectilinear" });
  await answer(1, PLAIN);
  void again(session);
  await answer(2, { ...PLAIN, distortion_coefficients: [0.1] });
  void again(session);
  await answer(3, { ...PLAIN, camera_matrix: cameraMatrix([NaN], [1, 1]) });
  assert.deepEqual(messages, [
    "no network",
    "the provider's calibration is incomplete",
    "the provider's calibration is incomplete",
  ]);
  assert.deepEqual(look(global, session)[0], MATRIX);
});

test("a provider that throws at once is like one that rejects", async () => {
  const global = browser();
  const messages = [];
  extend(
    () => {
      throw new Error("at once");
    },
    { global, onError: (error) => messages.push(error.message) },
  );
  assert.deepEqual(look(global, new global.XRSession()), NOTHING);
  await settled();
  assert.deepEqual(messages, ["at once"]);
});

test("two sessions have a model each", async () => {
  const { global, session, calls, again, answer } = running();
  const other = new global.XRSession();
  other.updateRenderState({ distortionModel: "fisheye" });
  look(global, session);
  look(global, other);
  await answer(0, PLAIN);
  await answer(1, FISHEYE);
  assert.deepEqual([look(global, session)[2], look(global, other)[2]], ["rectilinear", "fisheye"]);
  other.end();
  assert.throws(() => other.updateRenderState({ distortionModel: "rational" }), { name: "InvalidStateError" });
  void again();
  assert.deepEqual(
    calls.slice(2).map((call) => call.session),
    [session],
  );
  session.end();
  await answer(2, FISHEYE);
  assert.deepEqual(look(global, session)[2], "rectilinear");
});

test("a camera that is no longer known loses its calibration", async () => {
  const { global, session, again, answer } = running();
  look(global, session);
  await answer(0, PLAIN);
  const asked = again();
  await answer(1, null);
  await asked;
  assert.deepEqual(look(global, session), NOTHING);
});

test("without a pose nothing is asked for", () => {
  const { global, session, calls } = running();
  session.tracked = false;
  assert.equal(new global.XRFrame(session).getViewerPose(), null);
  assert.equal(calls.length, 0);
});

test("a second call changes the provider and wraps nothing twice", async () => {
  const { global, session, calls } = running();
  look(global, session);
  extend(async () => FISHEYE, { global });
  look(global, session);
  await settled();
  session.updateRenderState({ depthNear: 3 });
  assert.equal(look(global, session)[2], "fisheye");
  assert.equal(session.applied.length, 1);
  assert.equal(calls.length, 1);
});

test("two eyes are two cameras", async () => {
  const holds = ({ img_size: [width] }) => width === 640;
  const { global, session, answer } = running({ holds });
  session.seen = [{ eye: "left" }, { eye: "right" }, { eye: "none" }];
  look(global, session);
  await answer(0, { left: PLAIN, right: FISHEYE });
  const models = (of) => views(global, of).map((view) => view.distortionModel);
  assert.deepEqual(models(session), ["rectilinear", "fisheye", "rectilinear"]);
  const errors = [];
  for (const answer of [
    { left: PLAIN, right: null },
    { left: PLAIN, right: { ...FISHEYE, img_size: [1280, 960] } },
  ]) {
    extend(async () => answer, { global, holds, onError: (error) => errors.push(error) });
    const next = new global.XRSession();
    next.seen = session.seen;
    look(global, next);
    await settled();
    assert.deepEqual(models(next), ["rectilinear", null, "rectilinear"]);
  }
  assert.deepEqual(errors, []);
});

test("the formula of raw camera access takes projection matrices back", () => {
  // Half of a field of view of 90° is one width away from the pinhole: numbers that need no code of ours.
  assert.deepEqual(
    matrixOf([1, 0, 0, 0, 0, 3, 0, 0, 0.5, 0.25, -1, -1, 0, 0, -0.2, 0], 400, 200),
    [200, 0, 0, 0, 300, 0, 99.5, 124.5, 1],
  );
});

test("raw camera access gives the matrix that the service lacks", async () => {
  const { global, session, calls, answer } = running();
  const shown = (pinhole) => [
    {
      camera: { width: pinhole.img_size[0], height: pinhole.img_size[1] },
      projectionMatrix: new Float32Array(projectionMatrix(pinhole)),
    },
    {},
  ];
  const near = (found, wanted) =>
    found.forEach((value, n) => assert.ok(Math.abs(value - wanted[n]) < 1e-4, `${found} is not ${wanted}`));
  session.seen = shown(calibrationOf([498], [321, 241], { img_size: [640, 480] }));
  const [k, ...distortion] = look(global, session);
  near(k, [498, 0, 0, 0, 498, 0, 321, 241, 1]);
  assert.deepEqual(distortion, [null, null]);
  assert.deepEqual(say(views(global, session)[1]), NOTHING);
  assert.deepEqual(
    calls.map(({ size }) => size),
    [[640, 480]],
  );
  await answer(0, PLAIN);
  assert.deepEqual(
    look(global, session),
    [MATRIX, PLAIN.distortion_coefficients, "rectilinear"],
    "the service's comes first",
  );
  // The phone is turned: what is known is of another picture.
  session.seen = shown(calibrationOf([498], [238, 321], { img_size: [480, 640] }));
  near(look(global, session)[0], [498, 0, 0, 0, 498, 0, 238, 321, 1]);
  assert.deepEqual(
    calls.map(({ size }) => size),
    [
      [640, 480],
      [480, 640],
    ],
  );
  await answer(1, null);
  near(look(global, session)[0], [498, 0, 0, 0, 498, 0, 238, 321, 1]);
  assert.equal(calls.length, 2);
});

test("where there is no WebXR at all it says what to do", () => {
  assert.throws(() => extend(async () => null, { global: {} }), /install\(\)/);
});
