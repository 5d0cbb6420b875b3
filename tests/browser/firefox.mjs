// One hands-free capture with the virtual camera in Firefox; prints what happened as JSON.
//     node firefox.mjs <executable> <address of the capture page>
import puppeteer from "puppeteer-core";

const [, , executablePath, address] = process.argv;
const browser = await puppeteer.launch({ browser: "firefox", executablePath, headless: true });
const complaints = [];
try {
  const page = await browser.newPage();
  page.on("console", (message) => {
    if (["error", "warn"].includes(message.type())) complaints.push(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`uncaught: ${error.message}`));
  const start = performance.now();
  await page.goto(address);
  await page.waitForSelector("#done:not([hidden]), #failed:not([hidden])", { timeout: 120_000 });
  const elapsed = (performance.now() - start) / 1000;
  const [failure, json, counts] = await page.evaluate(() =>
    ["failure", "json", "counts"].map((id) => document.getElementById(id).textContent));
  console.log(JSON.stringify({ elapsed, failure, counts, complaints, calibration: json ? JSON.parse(json) : null }));
} finally {
  await browser.close();
}
