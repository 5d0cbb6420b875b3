import assert from "node:assert/strict";
import { test } from "node:test";
import { latest } from "../../web/lib/latest.js";

test("only the latest run's result counts", async () => {
  const finish = [];
  const signals = [];
  const run = latest(
    (signal, value) =>
      new Promise((resolve) => {
        signals.push(signal);
        finish.push(() => resolve(value));
      }),
  );
  const [first, second] = [run("first"), run("second")];
  assert.deepEqual(
    signals.map(({ aborted }) => aborted),
    [true, false],
  );
  for (const each of finish) each();
  assert.deepEqual([await first, await second], [undefined, "second"]);
});

test("a stale run's error is dropped, the latest one's is not", async () => {
  const run = latest(async (signal, wait) => {
    await wait;
    signal.throwIfAborted();
    throw new RangeError("failed");
  });
  const [stale, current] = [run(Promise.resolve()), run(Promise.resolve())];
  assert.equal(await stale, undefined);
  await assert.rejects(current, RangeError);
});

test("a cancelled run is stale too", async () => {
  const run = latest(async () => "late");
  const cancelled = run();
  run.cancel();
  assert.equal(await cancelled, undefined);
  assert.equal(await run(), "late");
});
