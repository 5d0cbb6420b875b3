// Result page: a file for each language.
import de from "./result.de.js";
import en from "./result.en.js";
import uk from "./result.uk.js";

/** @type {import("../lib/i18n.js").Catalog} */
export default { en, de, uk };
