// What a page of the stack makes of an asynchronous function that is read from standard input; prints it as JSON.
// Without a screen Firefox has no WebGL: DISPLAY names one.
//     DISPLAY=:99 node firefox_evaluate.mjs <executable> <address of the page>
import { text } from "node:stream/consumers";
import { inFirefox } from "./firefox_page.mjs";

const [, , executablePath, address] = process.argv;
const source = await text(process.stdin);
await inFirefox(executablePath, false, async (page) => {
  await page.setViewport({ width: 1440, height: 900 });
  await page.goto(address);
  return { result: await page.evaluate(`(${source})()`) };
});
