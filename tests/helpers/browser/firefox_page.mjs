// A page in Firefox, for as long as something is done with it; prints what comes of that, and what the page complains
// of.
import puppeteer from "puppeteer-core";

const TIMEOUT_MS = 120_000; // only what fails is waited for so long

/** @param {string} executablePath @param {boolean} headless without a screen Firefox has no WebGL */
export const openFirefox = (executablePath, headless) =>
  puppeteer.launch({
    browser: "firefox",
    executablePath,
    headless,
    timeout: TIMEOUT_MS,
    protocolTimeout: 2 * TIMEOUT_MS,
  });

/**
 * What is done with a page, and what the page complains of meanwhile.
 * @param {import("puppeteer-core").Page} page @param {(page: import("puppeteer-core").Page) => Promise<object>} use
 */
export async function watch(page, use) {
  const complaints = [];
  page.setDefaultTimeout(TIMEOUT_MS);
  page.on("console", (message) => {
    if (["error", "warn"].includes(message.type())) complaints.push(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`uncaught: ${error.message}`));
  return { ...(await use(page)), complaints };
}

/**
 * @param {string} executablePath @param {boolean} headless
 * @param {(page: import("puppeteer-core").Page) => Promise<object>} use
 */
export async function inFirefox(executablePath, headless, use) {
  const browser = await openFirefox(executablePath, headless);
  try {
    console.log(JSON.stringify(await watch(await browser.newPage(), use)));
  } finally {
    await browser.close();
  }
}
