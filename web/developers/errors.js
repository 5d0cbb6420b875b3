// Messages for what a request about a token came to, which a person can act on.
import { explain } from "../lib/faults.js";
import { hasMessage, t } from "../lib/i18n.js";
import { OfflineError } from "../lib/network.js";
import { ManagementError } from "./management.js";

const [MINUTE_S, HOUR_S] = [60, 3600];

/**
 * @param {unknown} error @param {"create" | "rotate" | "other"} what was asked for
 * @returns {string}
 */
export function failureText(error, what) {
  if (error instanceof OfflineError && what !== "other") return t(`developers.offline_${what}`);
  if (!(error instanceof ManagementError)) return explain(error);
  const { kind, status, retryAfter } = error;
  const key = `developers.problem_${kind.replaceAll("-", "_")}`;
  if (status === 429 && what === "create")
    return t("developers.too_many_tokens", { count: Math.max(1, Math.ceil((retryAfter ?? HOUR_S) / HOUR_S)) });
  if (status === 429)
    return t("developers.too_many_calls", { count: Math.max(1, Math.ceil((retryAfter ?? HOUR_S) / MINUTE_S)) });
  if (hasMessage(key)) return t(key);
  if (status === 401 || status === 403) return t("developers.problem_forbidden");
  if (status === 404) return t("developers.problem_not_here");
  return explain(error);
}

/**
 * A refusal of the origins that were sent; null where it is about something else.
 * @param {unknown} error
 * @param {string[]} origins
 */
export function originsRefused(error, origins) {
  if (!(error instanceof ManagementError)) return null;
  const field = error.fields.find(({ field }) => field.startsWith("origins"));
  if (!field) return null;
  const origin = origins[Number(field.field.split(".")[1])] ?? origins.join(" ");
  return t("developers.origin_refused", { origin });
}
