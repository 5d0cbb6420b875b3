// Firefox for the tests of one process: pages one after the other, each by itself, and what they make of a function.
// Without a screen Firefox has no WebGL: DISPLAY names one.
//     DISPLAY=:99 node firefox_pages.mjs <executable>
// Reads a line of JSON for each page, {address, source}, and prints one, {result, complaints} or {error}, until its
// input ends.
import { createInterface } from "node:readline";
import { openFirefox, watch } from "./firefox_page.mjs";

const [, , executablePath] = process.argv;
const browser = await openFirefox(executablePath, false);
try {
  for await (const line of createInterface({ input: process.stdin })) {
    const { address, source } = JSON.parse(line);
    const visitor = await browser.createBrowserContext(); // storage and service workers of its own
    try {
      const outcome = await watch(await visitor.newPage(), async (page) => {
        await page.setViewport({ width: 1440, height: 900 });
        await page.goto(address);
        return { result: await page.evaluate(`(${source})()`) };
      });
      console.log(JSON.stringify(outcome));
    } catch (error) {
      console.log(JSON.stringify({ error: String(error?.stack ?? error) }));
    } finally {
      await visitor.close();
    }
  }
} finally {
  await browser.close();
}
