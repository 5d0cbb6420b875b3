import assert from "node:assert/strict";
import { test } from "node:test";
import { askPhoneModel, modelsOf, phoneModel } from "../../web/lib/phone-model.js";
import { keepHere } from "./globals.mjs";

const SAFARI = "Mozilla/5.0 (iPhone; CPU iPhone OS 17_5 like Mac OS X) AppleWebKit/605.1.15";
const MAC = "Mozilla/5.0 (Macintosh; Intel Mac OS X 10_15_7) AppleWebKit/605.1.15";
const air = { width: 420, height: 912, ratio: 3 };
const signal = new AbortController().signal;

test("the screen leaves few models, upright or turned", () => {
  const upright = modelsOf({ width: 390, height: 844, ratio: 3 });
  assert.deepEqual(upright, modelsOf({ width: 844, height: 390, ratio: 3 }));
  assert.ok(upright.some(([, id]) => id === "iPhone14,5"));
  assert.ok(upright.length <= 6);
  assert.deepEqual(modelsOf({ width: 391, height: 844, ratio: 3 }), []);
});

test("identifiers are Apple's, and none stands for two models", () => {
  const screens = [
    [320, 568, 2],
    [375, 667, 2],
    [414, 736, 3],
    [375, 812, 3],
    [414, 896, 2],
    [414, 896, 3],
    [390, 844, 3],
    [428, 926, 3],
    [393, 852, 3],
    [430, 932, 3],
    [402, 874, 3],
    [440, 956, 3],
    [420, 912, 3],
  ];
  const ids = screens.flatMap(([width, height, ratio]) => modelsOf({ width, height, ratio }).map(([, id]) => id));
  assert.equal(new Set(ids).size, ids.length);
  for (const id of ids) assert.match(id, /^iPhone[0-9]{1,2},[0-9]$/);
  assert.ok(ids.length > 35);
});

test("nothing is asked of other devices, and what the screen says alone is taken", async (t) => {
  const kept = keepHere(t);
  assert.equal(await askPhoneModel(signal, { userAgent: MAC, screen: air }), "");
  assert.equal(await askPhoneModel(signal, { userAgent: SAFARI, screen: { width: 1, height: 2, ratio: 3 } }), "");
  assert.equal(kept.size, 0);
  assert.equal(await askPhoneModel(signal, { userAgent: SAFARI, screen: air }), "iPhone18,4");
  assert.equal(phoneModel(), "iPhone18,4");
  kept.set("calibdb.phone-model", "-");
  assert.equal(
    await askPhoneModel(signal, { userAgent: SAFARI, screen: air }),
    "",
    "who does not know is not asked again",
  );
});
