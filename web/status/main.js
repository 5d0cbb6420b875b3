// Status page: polls every part of the service while the page is visible.
import { el, part, liveRegion } from "../lib/dom.js";
import { language, number, onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { hear, stateOf } from "./health.js";

const INTERVAL_MS = 30_000; // from one answer to the next request
const [HEALTH, SETTINGS] = ["../healthz?deep=1", "../config.json"].map((path) => new URL(path, import.meta.url));
openPage();
const [tell, advise, when] = ["verdict", "advice", "checked"].map((id) => liveRegion(part(id, HTMLElement)));
const [body, again] = [part("parts", HTMLElement), part("again", HTMLButtonElement)];
/** @type {ReturnType<typeof stateOf> | null} */
let shown = null;
/** @type {Date | null} */
let checked = null;
let asking = false;
let timer = 0;

async function check() {
  if (asking) return;
  asking = true;
  again.setAttribute("aria-disabled", "true");
  try {
    const [health, settings] = await Promise.all([hear(HEALTH), hear(SETTINGS)]);
    shown = stateOf(health, settings, Date.now() / 1000);
    checked = new Date();
    show();
  } finally {
    asking = false;
    again.removeAttribute("aria-disabled");
    plan();
  }
}

/** Schedules the next check if the page is visible. */
function plan() {
  clearTimeout(timer);
  if (document.visibilityState === "visible") timer = setTimeout(check, INTERVAL_MS);
}

function show() {
  if (!shown || !checked) return;
  const { rows, verdict } = shown;
  part("verdict", HTMLElement).className = `headline verdict ${verdict === "all" ? "good" : "poor"}`;
  tell(() => t(`status.verdict_${verdict}`));
  advise(() => t(navigator.onLine || verdict !== "nothing" ? `status.advice_${verdict}` : "status.advice_offline"));
  const time = checked;
  when(() => t("status.checked", { time: clockTime(time) }));
  body.replaceChildren(...rows.map(row));
}

/** @param {import("./health.js").Row} row */
function row({ name, state, latency, words: other, at }) {
  const since = at ? t("status.ran_at", { time: clockTime(new Date(1000 * at)) }) : "";
  return el(
    "tr",
    { id: `part-${name}` },
    el(
      "th",
      { scope: "row" },
      t(`status.part_${name}`),
      el("span", { class: "muted" }, [t(`status.about_${name}`), since].filter(Boolean).join(" ")),
    ),
    el(
      "td",
      { class: "words" },
      el("span", { class: `state ${state}` }, t(other ? `status.canary_${other}` : `status.state_${state}`)),
    ),
    el("td", {}, latency === null ? "–" : t("status.ms", { ms: number(latency, latency < 10 ? 1 : 0) })),
  );
}

/** @param {Date} time */
const clockTime = (time) => new Intl.DateTimeFormat(language(), { timeStyle: "medium" }).format(time);

again.addEventListener("click", check);
document.addEventListener("visibilitychange", () => {
  clearTimeout(timer);
  if (document.visibilityState === "visible") void check();
});
addEventListener("online", check);
addEventListener("offline", check);
onLanguage(show);
void check();
