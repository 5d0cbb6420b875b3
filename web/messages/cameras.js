// Cameras page: a file for each language.
import de from "./cameras.de.js";
import en from "./cameras.en.js";
import uk from "./cameras.uk.js";

/** @type {import("../lib/i18n.js").Catalog} */
export default { en, de, uk };
