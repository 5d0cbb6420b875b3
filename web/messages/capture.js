// Guided capture: a file for each language.
import de from "./capture.de.js";
import en from "./capture.en.js";
import uk from "./capture.uk.js";

/** @type {import("../lib/i18n.js").Catalog} */
export default { en, de, uk };
