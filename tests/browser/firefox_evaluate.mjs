// What a page of the stack makes of an asynchronous function that is read from standard input; prints it as JSON.
// Without a screen Firefox has no WebGL: run under xvfb-run.
//     xvfb-run -a node firefox_evaluate.mjs <executable> <address of the page>
import { text } from "node:stream/consumers";
import puppeteer from "puppeteer-core";

const [, , executablePath, address] = process.argv;
const source = await text(process.stdin);
const browser = await puppeteer.launch({ browser: "firefox", executablePath, headless: false });
const complaints = [];
try {
  const page = await browser.newPage();
  page.on("console", (message) => {
    if (["error", "warn"].includes(message.type())) complaints.push(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`uncaught: ${error.message}`));
  await page.setViewport({ width: 1440, height: 900 });
  await page.goto(address);
  console.log(JSON.stringify({ result: await page.evaluate(`(${source})()`), complaints }));
} finally {
  await browser.close();
}
