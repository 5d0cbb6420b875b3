// Consent of the visitor to publish the measurements under CC0. Every page that calibrates asks for it, before or
// after. It is never assumed, and kept on this device until it is changed.
import { onLanguage, t, translate } from "./i18n.js";
import { keepItem, readItem } from "./storage.js";

/**
 * Licence under which dumps are published, an SPDX identifier, and the date of the text on /terms/ that is agreed to.
 */
export const LICENCE = "CC0-1.0";
export const LICENCE_VERSION = "2026-11-22";
const CONSENT_KEY = "calibdb.consent";

/** True if it was given on this device, to the current text. @type {boolean | null} null: not read yet */
let given = null;

/**
 * Publishes measurements from before the visitor agreed; null: there is nothing to publish.
 * @type {(() => Promise<unknown>) | null}
 */
let publish = null;

/** @param {typeof publish} action called once when the person agrees; rejects if the service refuses */
export function publishOnConsent(action) {
  publish = action;
}

/** True if the person agrees. */
export function hasConsent() {
  return (given ??= readItem(CONSENT_KEY) === LICENCE_VERSION);
}

/**
 * Fields of POST /v1/session that say so; none where the person does not agree.
 * @returns {{licence?: "CC0-1.0", licence_version?: string}}
 */
export function consentFields() {
  return hasConsent() ? { licence: LICENCE, licence_version: LICENCE_VERSION } : {};
}

/** Makes the page's consent block work: its check box, and the sentence below it. */
export function offerConsent() {
  const box = /** @type {HTMLInputElement | null} */ (document.getElementById("consent"));
  const note = document.getElementById("consent-note");
  if (!box || !note) throw new TypeError("the page has no consent block");
  translate(/** @type {Element} */ (box.closest(".consent")));
  const show = () => {
    box.checked = hasConsent();
    note.textContent = t(hasConsent() ? "consent.given" : "consent.not_given");
  };
  const take = (/** @type {boolean} */ agreed) => {
    given = agreed;
    keepItem(CONSENT_KEY, agreed ? LICENCE_VERSION : null); // if storage is blocked, it is valid on this page only
    show();
  };
  box.addEventListener("change", async () => {
    take(box.checked);
    if (!box.checked || !publish) return;
    try {
      await publish();
      publish = null;
    } catch (error) {
      console.info("not published:", String(error));
      take(false);
      note.textContent = t("consent.failed");
    }
  });
  // Consent was given or withdrawn in another tab.
  addEventListener("storage", ({ key }) => {
    if (key !== CONSENT_KEY && key !== null) return;
    given = null;
    show();
  });
  onLanguage(show);
  show();
}
