// Return of the service to a capture: attempts to reconnect, and the views that were stored meanwhile.
import assert from "node:assert/strict";
import { test } from "node:test";
import { RequestQueue } from "../../web/calibrate/request-queue.js";
import { setGlobals } from "./globals.mjs";

const FIRST_PAUSE_MS = 1_000;

/**
 * A queue without the service; each attempt to reconnect stores as many views as are said for it, and may renew the
 * session.
 */
function away(t, storedMeanwhile, renewals = 0) {
  const browser = new EventTarget(); // what a page hears of its network
  setGlobals(t, { addEventListener: browser.addEventListener.bind(browser) });
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const [attempts, events] = [[], []];
  const session = {
    waiting: 1,
    renewals: 0,
    stored: () => session.waiting,
    async resume() {
      session.waiting = storedMeanwhile[attempts.length] ?? 0;
      attempts.push(session.waiting);
      session.renewals = renewals;
      return { state: { status: "capturing" }, taken: 1, refused: 0 };
    },
  };
  const state = { link: { busy: false, offline: true }, phase: "capturing", capture: {} };
  const page = { state: () => state, dispatch: (event) => events.push(event), fail: (error) => assert.fail(error) };
  const options = {
    dispatch: page.dispatch,
    signal: new AbortController().signal,
    onOffline() {},
    async onOnline() {},
  };
  new RequestQueue(page, session, options).goOffline();
  return { attempts, events, browser };
}

/** Lets all that waits for nothing but promises run. */
const settle = () => new Promise((resolve) => setImmediate(resolve));

test("views that are stored while earlier ones are sent follow at once", async (t) => {
  const { attempts, events } = away(t, [2, 1, 0]);
  await settle();
  assert.deepEqual(attempts, [], "the service was away a moment ago");
  t.mock.timers.tick(FIRST_PAUSE_MS);
  await settle();
  assert.deepEqual(attempts, [2, 1, 0]);
  assert.deepEqual(
    events.map(({ type, taken }) => [type, taken]),
    [["online", 3]],
  );
});

test("a network that is back is used at once", async (t) => {
  const { attempts, events, browser } = away(t, [0]);
  browser.dispatchEvent(new Event("online"));
  await settle();
  assert.deepEqual(attempts, [0]);
  assert.deepEqual(
    events.map(({ type }) => type),
    ["online"],
  );
});

test("a session that took the place of an expired one during an outage is told of", async (t) => {
  const { events, browser } = away(t, [0], 1);
  browser.dispatchEvent(new Event("online"));
  await settle();
  assert.deepEqual(
    events.map(({ type, notice }) => notice?.key ?? type),
    ["online", "capture.begun_anew"],
  );
});
