// Page for developers: a file for each language.
import de from "./developers.de.js";
import en from "./developers.en.js";
import uk from "./developers.uk.js";

/** @type {import("../lib/i18n.js").Catalog} */
export default { en, de, uk };
