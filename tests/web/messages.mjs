// Adds the messages of all languages, which a page has in its document.
import { LANGUAGES, addMessages } from "../../web/lib/i18n.js";
import { readMessages } from "../../infra/web_build/messages.mjs";

const WEB = new URL("../../web", import.meta.url).pathname;

/** language → "catalog.key" → text */
export const messages = Object.fromEntries(
  Object.keys(LANGUAGES).map((language) => [language, readMessages(WEB, language)]),
);
for (const [language, texts] of Object.entries(messages)) addMessages(language, texts);
