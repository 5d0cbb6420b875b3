// Firefox for the tests of one process: pages one after the other, each by itself, and what they make of a function.
// Without a screen Firefox has no WebGL: DISPLAY names one.
//     DISPLAY=:99 node firefox_pages.mjs <executable>
// Reads a line of JSON for each page, {address, source, before, size}, and prints one, {result, complaints} or {error},
// until its input ends.
import { createInterface } from "node:readline";
import { launch, watch } from "./firefox.mjs";

const [, , executablePath] = process.argv;
// Without a GPU the processor draws each frame. A process for a page that is never opened takes a second.
const extraPrefsFirefox = { "layout.frame_rate": 20, "dom.ipc.processPrelaunch.enabled": false };
const browser = await launch(executablePath, { headless: false, extraPrefsFirefox });

/** Result of a function in a page, and what the page complains of meanwhile. */
async function evaluate(page, { address, source, before, size: [width, height] }) {
  const complaints = [];
  watch(page, complaints);
  await page.setViewport({ width, height });
  if (before) await page.evaluateOnNewDocument(before);
  await page.goto(address);
  return { result: await page.evaluate(`(${source})()`), complaints };
}

try {
  for await (const line of createInterface({ input: process.stdin })) {
    const visitor = await browser.createBrowserContext(); // storage and service workers of its own
    try {
      console.log(JSON.stringify(await evaluate(await visitor.newPage(), JSON.parse(line))));
    } catch (error) {
      console.log(JSON.stringify({ error: String(error?.stack ?? error) }));
    } finally {
      await visitor.close();
    }
  }
} finally {
  await browser.close();
}
