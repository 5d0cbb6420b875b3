// Model of an iPhone, which Safari does not say: asked once, among the few that the screen leaves, and kept in this
// browser.
import { el } from "./dom.js";
import { t } from "./i18n.js";
import { keepItem, readItem } from "./storage.js";

/**
 * @typedef {{width: number, height: number, ratio: number}} Screen in CSS pixels, upright or not, and pixels per CSS
 *   pixel
 */
/** @typedef {[name: string, identifier: string]} Model identifier as native shells know it */

const MODEL_KEY = "calibdb.phone-model";
const NONE = "-"; // the visitor does not know
const IPHONE = /\biPhone\b/;

/**
 * Models by the screen's short side, long side and ratio; of a model with several identifiers the first.
 * @type {Record<string, Model[]>}
 */
const MODELS = {
  "320x568@2": [
    ["iPhone 5s", "iPhone6,1"],
    ["iPhone SE (1st generation)", "iPhone8,4"],
  ],
  "375x667@2": [
    ["iPhone 6s", "iPhone8,1"],
    ["iPhone 7", "iPhone9,1"],
    ["iPhone 8", "iPhone10,1"],
    ["iPhone SE (2nd generation)", "iPhone12,8"],
    ["iPhone SE (3rd generation)", "iPhone14,6"],
  ],
  "414x736@3": [
    ["iPhone 6s Plus", "iPhone8,2"],
    ["iPhone 7 Plus", "iPhone9,2"],
    ["iPhone 8 Plus", "iPhone10,2"],
  ],
  "375x812@3": [
    ["iPhone X", "iPhone10,3"],
    ["iPhone XS", "iPhone11,2"],
    ["iPhone 11 Pro", "iPhone12,3"],
    ["iPhone 12 mini", "iPhone13,1"],
    ["iPhone 13 mini", "iPhone14,4"],
  ],
  "414x896@2": [
    ["iPhone XR", "iPhone11,8"],
    ["iPhone 11", "iPhone12,1"],
  ],
  "414x896@3": [
    ["iPhone XS Max", "iPhone11,6"],
    ["iPhone 11 Pro Max", "iPhone12,5"],
  ],
  "390x844@3": [
    ["iPhone 12", "iPhone13,2"],
    ["iPhone 12 Pro", "iPhone13,3"],
    ["iPhone 13", "iPhone14,5"],
    ["iPhone 13 Pro", "iPhone14,2"],
    ["iPhone 14", "iPhone14,7"],
    ["iPhone 16e", "iPhone17,5"],
  ],
  "428x926@3": [
    ["iPhone 12 Pro Max", "iPhone13,4"],
    ["iPhone 13 Pro Max", "iPhone14,3"],
    ["iPhone 14 Plus", "iPhone14,8"],
  ],
  "393x852@3": [
    ["iPhone 14 Pro", "iPhone15,2"],
    ["iPhone 15", "iPhone15,4"],
    ["iPhone 15 Pro", "iPhone16,1"],
    ["iPhone 16", "iPhone17,3"],
  ],
  "430x932@3": [
    ["iPhone 14 Pro Max", "iPhone15,3"],
    ["iPhone 15 Plus", "iPhone15,5"],
    ["iPhone 15 Pro Max", "iPhone16,2"],
    ["iPhone 16 Plus", "iPhone17,4"],
  ],
  "402x874@3": [
    ["iPhone 16 Pro", "iPhone17,1"],
    ["iPhone 17 Pro", "iPhone18,1"],
    ["iPhone 17", "iPhone18,3"],
  ],
  "440x956@3": [
    ["iPhone 16 Pro Max", "iPhone17,2"],
    ["iPhone 17 Pro Max", "iPhone18,2"],
  ],
  "420x912@3": [["iPhone Air", "iPhone18,4"]],
};

/** Models that have such a screen; none where the screen is zoomed or newer. @param {Screen} screen */
export function modelsOf({ width, height, ratio }) {
  return MODELS[`${Math.min(width, height)}x${Math.max(width, height)}@${Math.round(ratio)}`] ?? [];
}

/** Identifier that the visitor chose, "" where none is known. */
export function phoneModel() {
  const kept = readItem(MODEL_KEY) ?? "";
  return kept === NONE ? "" : kept;
}

/**
 * Asks for the model on an iPhone whose screen leaves some, once; asks nothing anywhere else.
 * @param {AbortSignal} signal takes the question away
 * @param {{userAgent: string, screen: Screen}} [browser]
 * @returns {Promise<string>} the identifier; "" where it is not known
 */
export async function askPhoneModel(signal, browser = here()) {
  const models = IPHONE.test(browser.userAgent) ? modelsOf(browser.screen) : [];
  if (readItem(MODEL_KEY) || models.length === 0) return phoneModel();
  const model = models.length > 1 ? await ask(models, signal) : models[0][1];
  if (model) keepItem(MODEL_KEY, model);
  return phoneModel();
}

/** @param {Model[]} models @param {AbortSignal} signal @returns {Promise<string>} */
function ask(models, signal) {
  const select = el(
    "select",
    { id: "phone-model" },
    ...models.map(([name, id]) => new Option(name, id)),
    new Option(t("phone.unknown"), NONE),
  );
  const dialog = el(
    "dialog",
    { "aria-labelledby": "phone-question" },
    el(
      "form",
      { method: "dialog" },
      el("h2", {}, el("label", { id: "phone-question", for: "phone-model" }, t("phone.question"))),
      el("p", {}, t("phone.why")),
      select,
      el("div", { class: "actions" }, el("button", { class: "primary" }, t("phone.answer"))),
    ),
  );
  const close = () => dialog.close();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      signal.removeEventListener("abort", close);
      resolve(signal.aborted ? "" : select.value);
    });
    signal.addEventListener("abort", close);
    document.body.append(dialog);
    dialog.showModal();
  });
}

const here = () => ({
  userAgent: navigator.userAgent,
  screen: { width: screen.width, height: screen.height, ratio: devicePixelRatio },
});
