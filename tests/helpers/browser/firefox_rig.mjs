// Leader of a rig in Firefox, killed in the middle and started again with the same profile.
//     node firefox_rig.mjs <executable> <address of the page> <folder of the profile>
// Prints a line of JSON once the rig can be joined, {code, address}, and one when it is finished, {id, moments,
// complaints}.
import { launch, watch } from "./firefox.mjs";

const MOMENTS_BEFORE = 2; // with all cameras, before it is killed

const [, , executablePath, address, userDataDir] = process.argv;
const complaints = [];

async function start(there) {
  const browser = await launch(executablePath, { headless: true, userDataDir });
  const page = await browser.newPage();
  watch(page, complaints);
  await page.goto(there);
  return { browser, page };
}

const first = await start(address);
await first.page.waitForSelector("#joining:not([hidden])");
const invitation = await first.page.evaluate(() => ({
  code: document.getElementById("join-code").textContent,
  address: document.getElementById("join-address").textContent,
}));
console.log(JSON.stringify(invitation));
// Both cameras' numbers in the line of a moment.
const shared = (least) =>
  [...document.querySelectorAll("#moment-list li")].filter(({ textContent }) =>
    /1\D+2/.test(textContent.replace(/^\d+:/, "")),
  ).length >= least;
await first.page.waitForFunction(shared, {}, MOMENTS_BEFORE);
const before = await first.page.$$eval("#moment-list li", (items) => items.length);
const again = await first.page.evaluate(() => `${location.origin}/rig/`);
first.browser.process().kill("SIGKILL");

const second = await start(again);
await second.page.waitForSelector("#interrupted:not([hidden])");
await second.page.click("#go-on");
await second.page.waitForSelector("#moment-list li", { visible: true });
const kept = await second.page.$$eval("#moment-list li", (items) => items.length);
await second.page.waitForSelector("#done:not([hidden])");
const id = await second.page.evaluate(() => new URLSearchParams(location.search).get("id"));
console.log(JSON.stringify({ id, before, kept, complaints }));
await second.browser.close();
