// Calibration of several cameras together, in the visitor's language.
import de from "./rig.de.js";
import en from "./rig.en.js";
import uk from "./rig.uk.js";

/** @type {import("../lib/i18n.js").Catalog} */
export default { en, de, uk };
