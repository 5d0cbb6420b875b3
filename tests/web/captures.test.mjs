import assert from "node:assert/strict";
import { test } from "node:test";
import { Captures } from "../../web/calibrate/captures.js";
import { captureKey } from "../../web/calibrate/state.js";
import { json, keepHere } from "./globals.mjs";

const REQUEST = { camera: "c", platform: "p", img_size: [640, 480], zoom: 0, distortion_model: "rectilinear" };
const view = (id) => ({ ids: [id], points: [[id, id]] });
/** A service that takes every view; gives what it was sent, session by session. */
function serve(t) {
  const sent = [];
  const state = () => ({ status: "capturing", accepted: true, views: sent.at(-1).map((_, index) => ({ index })) });
  t.mock.method(globalThis, "fetch", async (address, { method = "GET", body } = {}) => {
    const call = `${method} ${new URL(address).pathname.split("/").slice(-2).join("/")}`;
    if (call.endsWith("config.json")) return json(200, { api: "https://calibdb.example/v1", token: "t" });
    if (call === "POST v1/auth") return json(201, { session_id: `s${sent.push([])}` });
    if (call === "GET session/pose") return json(200, { index: sent.at(-1).length });
    if (call === "POST session/views") sent.at(-1).push(JSON.parse(body).ids[0]);
    return json(200, state());
  });
  keepHere(t);
  return sent;
}

for (const room of [true, false]) {
  test(`a capture continues with the other views, ${room ? "saved here" : "also if nothing can be saved"}`, async (t) => {
    const sent = serve(t);
    const saved = new Map();
    const unsaved = [];
    const store = {
      load: async (about) => saved.get(about) ?? null,
      save: async (each) => room && Boolean(saved.set(each.about, each)),
      remove: async (about) => void saved.delete(about),
    };
    const captures = new Captures(store, { address: () => "?", onUnsaved: () => unsaved.push(1) });
    const run = { signal: new AbortController().signal, onRetry() {} };
    const { session } = await captures.open(REQUEST, run);
    for (const id of [1, 2, 3]) await session.submit(id - 1, view(id));
    const fisheye = { ...REQUEST, distortion_model: "fisheye" };
    await captures.move(session, fisheye, [1]);
    assert.deepEqual(
      [saved.has(captureKey(REQUEST)), saved.has(captureKey(fisheye)), unsaved.length > 0],
      [false, room, !room],
    );
    await captures.open(fisheye, run);
    assert.deepEqual(sent, [
      [1, 2, 3],
      [1, 3],
    ]);
    await captures.forget(captureKey(fisheye));
    await captures.open(fisheye, run);
    assert.deepEqual(sent, [[1, 2, 3], [1, 3], []], "what was taken up is not taken up twice");
  });
}
