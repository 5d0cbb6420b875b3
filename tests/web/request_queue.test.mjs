import assert from "node:assert/strict";
import { test } from "node:test";
import { RequestQueue } from "../../web/calibrate/request-queue.js";

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
