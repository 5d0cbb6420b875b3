import assert from "node:assert/strict";
import { test } from "node:test";
import { isPracticeReturned } from "../../web/calibrate/history.js";
import { knownOf, knownText } from "../../web/calibrate/sender.js";
import { setGlobals } from "./globals.mjs";
import "./messages.mjs";

const location = new URL("https://calibdb.example/calibrate/");
const VIRTUAL = "calibDB virtual camera 42e1b240";

test("an application under development gets a practice result, any other only if it asked for one", (t) => {
  setGlobals(t, { location });
  assert.equal(isPracticeReturned("http://localhost:9000/app", "HD Pro Webcam C920"), true);
  assert.equal(isPracticeReturned("http://127.0.0.1:9000/", null), true);
  assert.equal(isPracticeReturned("https://app.example/", "HD Pro Webcam C920"), false);
  assert.equal(isPracticeReturned("https://localhost.app.example/", null), false);
  assert.equal(isPracticeReturned("https://app.example/", VIRTUAL), true);
  assert.equal(isPracticeReturned(null, null), false);
  assert.equal(isPracticeReturned("/ar/", null), false, "a page of this site is no application under development");
});

test("what a camera still needs is told for the size that was asked for", () => {
  const size = (img_size, agreeing, reliable = false) => ({
    img_size,
    calibrations: agreeing,
    agreeing,
    required: 5,
    reliable,
  });
  const answer = {
    cameras: [
      { camera: "HD Pro Webcam C920", sizes: [size([640, 480], 3), size([1280, 720], 9, true)] },
      { camera: "HD Pro Webcam C920 Plus", sizes: [size([640, 480], 4)] },
    ],
  };
  const said = (label, img_size) => knownText(knownOf(answer, label, img_size));
  assert.match(said("HD Pro Webcam C920 (046d:082d)", [640, 480]), /^2 more calibrations are needed/);
  assert.match(said("hd pro webcam c920", [1280, 720]), /knows this camera already/);
  assert.match(said("HD Pro Webcam C920", [1920, 1080]), /new here/);
  assert.match(said("Another", null), /new here/);
  const apart = { cameras: [{ camera: "C920", sizes: [size([640, 480], 6)] }] };
  assert.match(knownText(knownOf(apart, "C920", [640, 480])), /do not agree yet/);
  assert.equal(knownText(null), "");
});
