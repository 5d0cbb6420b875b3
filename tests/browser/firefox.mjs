// One hands-free capture with the virtual camera in Firefox; prints what happened as JSON.
//     node firefox.mjs <executable> <address of the capture page>
import { inFirefox } from "./firefox_page.mjs";

const [, , executablePath, address] = process.argv;
await inFirefox(executablePath, true, async (page) => {
  const start = performance.now();
  await page.goto(address);
  await page.waitForSelector("#done:not([hidden]), #failed:not([hidden])", { timeout: 120_000 });
  const elapsed = (performance.now() - start) / 1000;
  const [failure, json, counts] = await page.evaluate(() =>
    ["failure", "json", "counts"].map((id) => document.getElementById(id).textContent));
  return { elapsed, failure, counts, calibration: json ? JSON.parse(json) : null };
});
