import assert from "node:assert/strict";
import { test } from "node:test";
import { hear, stateOf } from "../../web/status/health.js";
import { inTurn } from "./globals.mjs";

const NOW = 1_795_000_000;
const SETTINGS = { ok: true, status: 200, ms: 12, body: { api: "/v1" } };
const heard = (failed = [], canary = null) => ({
  ok: failed.length === 0,
  status: failed.length ? 503 : 200,
  ms: 40,
  body: {
    canary,
    parts: ["table", "bucket", "edge", "solver"].map((part) => ({
      part,
      ok: !failed.includes(part),
      latency_ms: failed.includes(part) ? null : 3.2,
      limit_ms: 2000,
    })),
  },
});
const ALL_WELL = { pages: "ok", functions: "ok", table: "ok", bucket: "ok", solver: "ok", edge: "ok" };
const states = ({ rows }) => Object.fromEntries(rows.map(({ name, state }) => [name, state]));

test("every part is told for itself, whatever the status of the answer", () => {
  assert.equal(stateOf(heard(), SETTINGS, NOW).verdict, "all");
  const failed = stateOf(heard(["bucket"]), SETTINGS, NOW);
  assert.equal(failed.verdict, "some");
  assert.deepEqual(states(failed), { ...ALL_WELL, bucket: "failed" });
  assert.equal(stateOf(heard(["edge"]), SETTINGS, NOW).verdict, "edge");
});

test("functions that are down are said to be down, with what still works", () => {
  const gateway = { ok: false, status: 503, ms: 9, body: { message: "Service Unavailable" } };
  for (const health of [gateway, { ...gateway, body: null }, { ...gateway, status: 0, body: null }]) {
    const found = stateOf(health, SETTINGS, NOW);
    assert.equal(found.verdict, "functions");
    const { pages, functions, ...parts } = states(found);
    assert.deepEqual([pages, functions, ...new Set(Object.values(parts))], ["ok", "failed", "unknown"]);
  }
  assert.equal(stateOf(gateway, { ok: false, status: 0, ms: 5, body: null }, NOW).verdict, "nothing");
});

test("the canary is shown where there is one: well, failed, or late", () => {
  const run = (more) => ({ ok: true, at: NOW - 60, took_ms: 1800, failed_at: null, ...more });
  const row = (canary) => stateOf(heard([], canary), SETTINGS, NOW).rows.at(-1);
  assert.equal(row(run({})).state, "ok");
  const failed = run({ ok: false, failed_at: "view" });
  assert.deepEqual([row(failed).state, row(failed).words], ["failed", "view"]);
  assert.equal(stateOf(heard([], failed), SETTINGS, NOW).verdict, "canary");
  const late = row(run({ at: NOW - 1600 }));
  assert.deepEqual([late.state, late.words], ["unknown", "late"]);
});

test("whatever answers is heard, and silence too", async (context) => {
  const answers = [new Response("<html>", { status: 502 }), new TypeError("Failed to fetch")];
  context.mock.method(globalThis, "fetch", async () => inTurn(answers));
  for (const status of [502, 0]) {
    const said = await hear(new URL("https://calibdb.example/healthz"), () => 0);
    assert.deepEqual(said, { ok: false, status, ms: 0, body: null });
  }
});
