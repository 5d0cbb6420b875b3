import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { KeptTokens, STORAGE_KEY, TokenFileError, fileOf, tokensInFile } from "../../web/developers/kept-tokens.js";
import { isLoopback, originsIn } from "../../web/developers/origins.js";
import { PLANS } from "../../web/developers/plans.js";
import { FULL, storageOf } from "./globals.mjs";

const API = "https://calibdb.example/v1";
const SECRET = "a".repeat(48);
const token = (id, more = {}) => ({
  id,
  token: `cdb_${id}_${SECRET}`,
  management_token: `cdbm_${id}_${SECRET}`,
  name: null,
  origins: ["http://localhost"],
  api: API,
  ...more,
});
test("an address of a page stands for its origin, as a browser writes it", () => {
  for (const [text, ...origins] of [
    ["http://localhost", "http://localhost"],
    ["localhost:5173", "http://localhost:5173"],
    ["http://127.0.0.1:80/page", "http://127.0.0.1"],
    ["http://[::1]:3000", "http://[::1]:3000"],
    ["Example.org", "https://example.org"],
    ["https://Example.ORG:443/app/?a#b,http://app.localhost", "https://example.org", "http://app.localhost"],
    ["https://bücher.example  https://bücher.example/", "https://xn--bcher-kva.example"],
    ["https://user:secret@example.org", "https://example.org"],
  ])
    assert.deepEqual(originsIn(text), { origins, wrong: null }, text);
});

test("what no token can name is told by its reason", () => {
  for (const [text, fault] of [
    ["", "none"],
    ["https://*.example.org", "wildcard"],
    ["http://example.org", "secure"],
    ["https://example.org:8443", "port"],
    ["https://192.0.2.7", "address"],
    ["https://[2001:db8::1]", "address"],
    ["https://3232235521", "address"],
    ["https://intranet", "name"],
    ["https://printer.local", "name"],
    ["https://example.org.", "name"],
    ["null", "name"],
    ["file:///tmp/page.html", "scheme"],
    ["https://exa mple", "name"],
    ["https://", "unreadable"],
    [Array.from({ length: 11 }, (_, n) => `https://n${n}.example`).join(" "), "too_many"],
  ])
    assert.equal(originsIn(text).wrong?.fault, fault, text);
  assert.deepEqual(
    [
      "http://localhost:3000",
      "https://app.localhost",
      "http://127.0.0.2",
      "https://example.org",
      "https://localhost.example.org",
    ].map(isLoopback),
    [true, true, true, false, false],
  );
});

test("tokens are kept at once, the newest first, and over the one with their id", () => {
  const content = new Map();
  const kept = new KeptTokens(storageOf(content));
  const again = token("one", { token: `cdb_one_${"b".repeat(48)}`, name: "Site" });
  for (const each of [token("one"), token("two"), again]) assert.ok(kept.keep(each));
  assert.deepEqual(new KeptTokens(storageOf(content)).all, [token("two"), again]);
  kept.forget("two");
  assert.deepEqual(
    JSON.parse(content.get(STORAGE_KEY)).map(({ id }) => id),
    ["one"],
  );
});

test("a browser without storage keeps tokens for the page", () => {
  for (const place of [null, FULL]) {
    const kept = new KeptTokens(place);
    assert.equal(kept.keep(token("one")), false);
    assert.deepEqual(kept.all, [token("one")]);
  }
});

test("a list that cannot be read is set aside, not lost", () => {
  const content = new Map([[STORAGE_KEY, "[{"]]);
  const kept = new KeptTokens(storageOf(content));
  assert.deepEqual(kept.all, []);
  assert.ok(kept.keep(token("one")));
  assert.equal(content.get(`${STORAGE_KEY}.damaged`), "[{");
  assert.deepEqual(kept.all, [token("one")]);
});

test("a file brings back what was saved, and nothing of other services", () => {
  const tokens = [token("one"), token("two", { name: "Site" })];
  assert.deepEqual(tokensInFile(fileOf(tokens), API), { tokens, elsewhere: 0 });
  const mixed = [token("one"), token("two", { api: "https://other.example/v1" }), { token: "no" }, null, 3];
  assert.deepEqual(tokensInFile(JSON.stringify(mixed), API), { tokens: [token("one")], elsewhere: 1 });
  // Of a management token of another token nothing is kept, and what belongs to neither stays out.
  const odd = {
    ...token("one"),
    management_token: `cdbm_two_${SECRET}`,
    evil: "<script>",
    origins: ["http://localhost", 3],
    name: {},
  };
  assert.deepEqual(tokensInFile(JSON.stringify(odd), API).tokens, [
    { id: "one", token: token("one").token, name: null, origins: ["http://localhost"], api: API },
  ]);
  for (const [text, code] of [
    ["", "unreadable"],
    ["{}", "empty"],
    ["null", "empty"],
    [JSON.stringify([token("one", { api: "https://other.example/v1" })]), "elsewhere"],
  ]) {
    assert.throws(
      () => tokensInFile(text, API),
      (error) => error instanceof TokenFileError && error.code === code,
      text,
    );
  }
});

test("the plans are those that the service has", () => {
  const source = readFileSync(new URL("../../layers/service/calibdb/access/plans.py", import.meta.url), "utf8");
  const allowance = (text) =>
    Object.fromEntries(
      [...text.matchAll(/(\w+)=([\d_]+)/g)].map(([, kind, limit]) => [kind, Number(limit.replaceAll("_", ""))]),
    );
  const each = allowance(/^_EACH = Allowance\((.*)\)/m.exec(source)[1]);
  assert.match(source, /"trial": Plan\(_EACH, _EACH/);
  const together = allowance(/"free": Plan\(Allowance\((.*?)\), _EACH\)/.exec(source)[1]);
  for (const [kind, limits] of Object.entries(PLANS))
    assert.deepEqual(limits, [each[kind], each[kind], together[kind]], kind);
});
