// Firefox as tests run it: waits, and what a page complains of.
import puppeteer from "puppeteer-core";

const TIMEOUT_MS = 120_000; // only what fails is waited for so long

/** @param {string} executablePath @param {object} options of Puppeteer */
export const launch = (executablePath, options) =>
  puppeteer.launch({
    browser: "firefox",
    executablePath,
    timeout: TIMEOUT_MS,
    protocolTimeout: 2 * TIMEOUT_MS,
    ...options,
  });

/** Adds errors and warnings of a page to `complaints`. */
export function watch(page, complaints) {
  page.setDefaultTimeout(TIMEOUT_MS);
  page.on("console", (message) => {
    if (["error", "warn"].includes(message.type())) complaints.push(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => complaints.push(`uncaught: ${error.message}`));
}
