// Operator of this service, as the deployment names them: name, contact, imprint. Without any of it the page says that
// it is a private copy.
import { el, part } from "./dom.js";
import { onLanguage, t } from "./i18n.js";
import { OfflineError } from "./network.js";
import { SettingsError, loadSettings, storedSettings } from "./settings.js";

/** @typedef {{name?: string, contact?: string, imprint?: string}} Operator */
/** Keys of the words for them. @typedef {{name: string, contact: string, imprint: string}} Words */

/**
 * Shows the operator on the page, in words of the page's own catalog, and returns it.
 * @param {Words} words
 * @returns {Promise<Operator>}
 */
export async function showOperator(words) {
  const operator = (await settings())?.operator ?? {};
  if (Object.keys(operator).length === 0) return operator;
  const list = part("operator", HTMLElement);
  const show = () =>
    list.replaceChildren(
      ...row(t(words.name), operator.name),
      ...row(t(words.contact), operator.contact && link(operator.contact)),
      ...row(t(words.imprint), ...imprint(operator.imprint ?? "")),
    );
  onLanguage(show);
  show();
  list.hidden = false;
  part("private-copy", HTMLElement).hidden = true;
  return operator;
}

async function settings() {
  try {
    return await loadSettings();
  } catch (error) {
    if (!(error instanceof OfflineError) && !(error instanceof SettingsError)) throw error;
    return storedSettings();
  }
}

/** @param {string} term @param {...(Node | string | undefined)} content */
function row(term, ...content) {
  const there = content.filter((each) => each !== undefined && each !== "");
  return there.length ? [el("dt", {}, term), el("dd", {}, .../** @type {(Node | string)[]} */ (there))] : [];
}

/** An address as people read it. @param {string} address mailto: or https: */
const link = (address) => el("a", { href: address }, address.replace(/^(mailto:|https:\/\/)/, "").replace(/\/$/, ""));

/** Lines, or a link. @param {string} text */
function imprint(text) {
  if (text.startsWith("https://")) return [link(text)];
  return text.split("|").flatMap((line, index) => (index > 0 ? [el("br"), line.trim()] : [line.trim()]));
}
