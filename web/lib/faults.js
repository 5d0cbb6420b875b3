// Messages for errors, in the language of the page, which a person can act on.
import { ApiError } from "./api.js";
import { hasMessage, t } from "./i18n.js";
import { isOffline } from "./network.js";
import { LookupError } from "../sdk/request.js";
import { SettingsError } from "./settings.js";

/**
 * @param {unknown} error what the service or the network did is explained; anything else is the page's own mistake
 * @returns {string}
 */
export function explain(error) {
  if (isOffline(error) || (error instanceof LookupError && error.status === 0)) return t("faults.offline");
  if (error instanceof SettingsError) return t("faults.settings");
  if (error instanceof ApiError) return service(error.status, error.kind, error.message);
  if (error instanceof LookupError) return service(error.status, "", error.message);
  console.error(error);
  return t("faults.unforeseen", { message: String(error) });
}

/**
 * Its own words only where the page has none: they are English.
 * @param {number} status
 * @param {string} kind
 * @param {string} detail
 */
function service(status, kind, detail) {
  const keys = [
    `faults.kind_${kind.replaceAll("-", "_")}`,
    `faults.status_${status}`,
    status >= 500 ? "faults.status_500" : "",
  ];
  return t(keys.find(hasMessage) ?? "faults.refused", { detail });
}
