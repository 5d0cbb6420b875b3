import assert from "node:assert/strict";
import { test } from "node:test";
import { RequestQueue } from "../../web/calibrate/request-queue.js";
import { OfflineError } from "../../web/lib/api.js";
import { setGlobals } from "./globals.mjs";

test("a silent service is away after two seconds, one that has to start after five", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const [events, delivered] = [[], []];
  const session = { renewals: 0, stored: () => 1 };
  const state = { link: { busy: false, offline: false }, phase: "capturing", capture: {} };
  const page = { state: () => state, dispatch: ({ type }) => events.push(type), fail: (error) => assert.fail(error) };
  const { signal } = new AbortController();
  const queue = new RequestQueue(page, session, {
    dispatch: page.dispatch,
    signal,
    onOffline: () => events.push("plan"),
  });
  for (const [isFirst, limit] of [
    [true, 5_000],
    [false, 2_000],
  ]) {
    let respond = () => {};
    const request = () => {
      session.onRequest(isFirst);
      return new Promise((resolve) => (respond = resolve));
    };
    const sent = queue.send(request, (response) => delivered.push(response));
    t.mock.timers.tick(limit - 1);
    assert.deepEqual(events.splice(0), ["busy"]);
    t.mock.timers.tick(1);
    assert.deepEqual([events.splice(0), queue.isOverdue], [["offline", "plan"], true]);
    respond("too late");
    await sent;
    assert.deepEqual([events.splice(0), queue.isOverdue, delivered], [["idle"], false, []]);
  }
});

test("an outage by silence ends at once with a late answer, and after a pause with a late failure", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const browser = new EventTarget();
  setGlobals(t, { addEventListener: browser.addEventListener.bind(browser) });
  const settle = () => new Promise((done) => setImmediate(done));
  for (const isAnswered of [true, false]) {
    const events = [];
    const state = { link: { busy: false, offline: false }, phase: "capturing", capture: {} };
    const session = {
      renewals: 0,
      waiting: 0,
      stored: () => 1,
      resume: async () => ({ state: { status: "capturing" }, taken: 1, refused: 0 }),
    };
    const page = { state: () => state, fail: (error) => assert.fail(error) };
    const queue = new RequestQueue(page, session, {
      dispatch: ({ type, taken }) => {
        if (type === "offline") state.link.offline = true;
        events.push(taken === undefined ? type : `${type} ${taken}`);
      },
      signal: new AbortController().signal,
      onOffline: () => {},
      onOnline: async () => void events.push("service's targets"),
    });
    let end = () => {};
    const request = () =>
      new Promise((resolve, reject) => (end = () => (isAnswered ? resolve() : reject(new OfflineError()))));
    const sent = queue.send(request, () => assert.fail("delivered too late"));
    t.mock.timers.tick(2_000);
    assert.deepEqual(events.splice(0), ["busy", "offline"]);
    end();
    await sent;
    await settle();
    const back = ["online 1", "service's targets"];
    assert.deepEqual(events.splice(0), isAnswered ? back : []);
    t.mock.timers.tick(1_000);
    await settle();
    assert.deepEqual(events, isAnswered ? [] : back);
  }
});
