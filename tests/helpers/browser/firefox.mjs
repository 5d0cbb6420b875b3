// One hands-free capture with the virtual camera in Firefox; prints what happened as JSON.
//     node firefox.mjs <executable> <address of the capture page>
import { inFirefox } from "./firefox_page.mjs";

const [, , executablePath, address] = process.argv;
await inFirefox(executablePath, true, async (page) => {
  await page.evaluateOnNewDocument(() => {
    window.looks = 0;
    const post = Worker.prototype.postMessage;
    Worker.prototype.postMessage = function (message, ...more) {
      if (message.frame) window.looks += 1;
      return post.call(this, message, ...more);
    };
  });
  await page.goto(address);
  await page.waitForSelector("#done:not([hidden]), #failed:not([hidden])");
  const taken = await page.evaluate(() => [performance.now() / 1000, window.looks]);
  const [failure, json, counts] = await page.evaluate(() =>
    ["failure", "json"]
      .map((id) => document.getElementById(id).textContent.trim())
      .concat(document.getElementById("counts").dataset.taken),
  );
  return { taken, failure, counts, calibration: json ? JSON.parse(json) : null };
});
