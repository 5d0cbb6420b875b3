import assert from "node:assert/strict";
import { test } from "node:test";
import { LICENCE_VERSION } from "../../web/lib/consent.js";
import { calibrate } from "../../web/lib/series.js";
import { CaptureSession } from "../../web/lib/session.js";
import { keepHere } from "./globals.mjs";

const REQUEST = { camera: "c", platform: "p", img_size: [640, 480], zoom: 0, distortion_model: "rectilinear" };
let fresh = 0;

/** Bodies of POST /session that both kinds of capture send, with the consent that is kept now. */
async function started() {
  // The choice is read once a page: another page is another module.
  const page = `?${fresh++}`;
  const sent = [];
  const json = async (method, path, _, { body } = {}) => {
    if (path === "/session" && method === "POST") sent.push(body);
    return { session_id: "s", views: [] };
  };
  const api = { json, send: async (...call) => new Response(JSON.stringify(await json(...call))) };
  return { sent, api, page };
}

test("no session says a licence unless the person agreed", async (t) => {
  keepHere(t);
  const { sent, api } = await started();
  await calibrate(api, "t", REQUEST, [], () => {});
  await new CaptureSession(api, "t", REQUEST).start();
  assert.deepEqual(
    sent.map((body) => [body.licence, body.licence_version]),
    [
      [undefined, undefined],
      [undefined, undefined],
    ],
  );
});

test("consent to an earlier text is none to this one", async (t) => {
  const kept = keepHere(t);
  kept.set("calibdb.consent", "2020-01-01");
  const { hasConsent } = await import("../../web/lib/consent.js?earlier");
  assert.equal(hasConsent(), false);
  kept.set("calibdb.consent", LICENCE_VERSION);
  const { consentFields } = await import("../../web/lib/consent.js?later");
  assert.deepEqual(consentFields(), { licence: "CC0-1.0", licence_version: LICENCE_VERSION });
});

test("a session that was started without a licence is given it under its own id, by another connection", async (t) => {
  const kept = keepHere(t);
  const { sent, api } = await started();
  kept.delete("calibdb.consent");
  const session = new CaptureSession({ ...api, json: api.json, send: api.send }, "t", REQUEST);
  await session.start();
  kept.set("calibdb.consent", LICENCE_VERSION);
  const calls = [];
  await session.license({ json: async (...call) => void calls.push(call) });
  assert.equal(sent.length, 1);
  assert.deepEqual(
    calls.map(([method, path]) => [method, path]),
    [["POST", "/session/licence"]],
  );
});
