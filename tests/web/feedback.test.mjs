import assert from "node:assert/strict";
import { test } from "node:test";
import { Feedback } from "../../web/lib/capture/feedback.js";
import { setGlobals } from "./globals.mjs";

test("the loudspeaker rests once the last note of a sign is over, and sounds again with the next", (t) => {
  const tones = [];
  const states = [];
  const part = () => ({ gain: { setValueAtTime() {}, exponentialRampToValueAtTime() {} }, connect: (next) => next });
  const AudioContext = class {
    currentTime = 0;
    destination = {};
    resume() {
      states.push("running");
    }
    suspend() {
      states.push("suspended");
    }
    createGain() {
      return part();
    }
    createOscillator() {
      const tone = { frequency: {}, start() {}, stop() {}, ...part() };
      tones.push(tone);
      return tone;
    }
  };
  const navigator = { userActivation: { hasBeenActive: true } };
  setGlobals(t, { AudioContext, navigator, localStorage: { getItem: () => null } });
  const feedback = new Feedback();
  feedback.give("taken");
  assert.deepEqual([tones.length, states], [2, ["running"]]);
  tones[0].onended();
  assert.deepEqual(states, ["running"], "the second note is still to come");
  tones[1].onended();
  assert.deepEqual(states, ["running", "suspended"]);
  feedback.give("hold");
  tones[2].onended();
  assert.deepEqual(states, ["running", "suspended", "running", "suspended"]);
});
