// Page of one stored calibration: /result/?id=…
import { ApiError } from "../lib/api.js";
import { el, part, liveRegion } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { loadSettings } from "../lib/settings.js";
import { pageTitle } from "../lib/result/card.js";
import { load } from "../lib/result/source.js";
import { ResultView } from "../lib/result/view.js";

/** @import { Result } from "../lib/result/numbers.js" */

openPage();
const query = new URLSearchParams(location.search);
const say = liveRegion(part("status", HTMLElement));
const view = new ResultView(part("result", HTMLElement));

/** Title of the page, which tabs, histories and bookmarks show. @param {Result} result */
function entitle({ calibration, report }) {
  const write = () => void (document.title = pageTitle(calibration, report));
  onLanguage(write);
  write();
}

/** Reason why there is nothing to show, and the way on. @param {() => string} why */
function leadOn(why) {
  const ways = el("div", { class: "actions" });
  liveRegion(ways)(() => [
    el("a", { class: "button primary", href: "../cameras/" }, t("result.search")),
    el("a", { class: "button", href: "../calibrate/" }, t("result.calibrate")),
  ]);
  part("skeleton", HTMLElement).hidden = true;
  part("waiting", HTMLElement).append(ways);
  say(why);
}

async function show() {
  const id = query.get("id");
  if (!id) return leadOn(() => t("result.no_id"));
  const onRetry = (/** @type {object | null} */ retry) => say(() => t(retry ? "faults.retry" : "result.loading"));
  onRetry(null);
  try {
    const [{ calibration, report }, { return_origins: returnOrigins }] = await Promise.all([
      load(id, [], { onRetry }),
      loadSettings(),
    ]);
    part("waiting", HTMLElement).hidden = true;
    /** @type {Result} */
    const result = { calibration, report, origin: "stored", returnTo: query.get("return_to"), returnOrigins, explain };
    entitle(result);
    view.show(result);
  } catch (error) {
    const missing = error instanceof ApiError && error.status === 404;
    leadOn(() => (missing ? t("result.missing") : explain(error)));
  }
}

void show();
