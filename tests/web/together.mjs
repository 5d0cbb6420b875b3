// Runs the test files that it is given in one process. `node --test` would start one for each, which takes longer than
// most of their tests.
import { resolve } from "node:path";
import { test } from "node:test";
import { pathToFileURL } from "node:url";

/** @type {(value?: unknown) => void} */
let start = () => {};
// No test runs while others are loaded: modules look for the globals that a test may have set.
test("the test files are loaded", () => new Promise((loaded) => (start = loaded)));
try {
  for (const file of process.argv.slice(2)) await import(pathToFileURL(resolve(file)).href);
} finally {
  start(); // also after a file that cannot be loaded, so that its error is reported
}
