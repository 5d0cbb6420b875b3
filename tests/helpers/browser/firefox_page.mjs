// A page in Firefox, for as long as something is done with it; prints what comes of that, and what the page complains of.
import puppeteer from "puppeteer-core";

const TIMEOUT_S = 120_000; // ms; only what fails is waited for so long

/**
 * @param {string} executablePath @param {boolean} headless without a screen Firefox has no WebGL
 * @param {(page: import("puppeteer-core").Page) => Promise<object>} use
 */
export async function inFirefox(executablePath, headless, use) {
  const browser = await puppeteer.launch({ browser: "firefox", executablePath, headless, timeout: TIMEOUT_S, protocolTimeout: 2 * TIMEOUT_S });
  const complaints = [];
  try {
    const page = await browser.newPage();
    page.setDefaultTimeout(TIMEOUT_S);
    page.on("console", (message) => {
      if (["error", "warn"].includes(message.type())) complaints.push(`${message.type()}: ${message.text()}`);
    });
    page.on("pageerror", (error) => complaints.push(`uncaught: ${error.message}`));
    console.log(JSON.stringify({ ...await use(page), complaints }));
  } finally {
    await browser.close();
  }
}
