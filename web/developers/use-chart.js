// Use of a token over time: bars, and the same as a table.
import { el, make } from "../lib/dom.js";
import { language, t } from "../lib/i18n.js";
import { short, ticks } from "../lib/svg.js";

/** @import { TokenUse } from "../vendor/api.js" */

/**
 * @typedef {"hours" | "days"} Period
 * @typedef {{sessions: number, views: number, poses: number, lookups: number}} Counts
 * @typedef {typeof KINDS[number]} Kind
 */

export const KINDS = /** @type {const} */ (["lookups", "sessions", "views", "poses"]);
const [WIDTH, HEIGHT, LEFT, TOP, BOTTOM] = [640, 200, 46, 10, 26];
const GAP = 0.25; // of a bar's place
const NAMED = 6; // bars from one that has a name to the next

/** @param {TokenUse} use @param {Period} period @returns {{name: string, counts: Counts}[]} oldest first */
function seriesOf(use, period) {
  return period === "hours"
    ? use.hours.map(({ hour, ...counts }) => ({
        name: timeOf(`${hour}:00Z`, { weekday: "short", hour: "2-digit", minute: "2-digit" }),
        counts: whole(counts),
      }))
    : use.days.map(({ day, ...counts }) => ({
        name: timeOf(`${day}T12:00Z`, { day: "numeric", month: "short", timeZone: "UTC" }),
        counts: whole(counts),
      }));
}

/** @param {Partial<Counts>} counts @returns {Counts} */
const whole = ({ sessions = 0, views = 0, poses = 0, lookups = 0 }) => ({ sessions, views, poses, lookups });

/** @param {string} instant @param {Intl.DateTimeFormatOptions} form */
const timeOf = (instant, form) => new Intl.DateTimeFormat(language(), form).format(new Date(instant));

/** @param {number} count */
export const formatCount = (count) => count.toLocaleString(language());

/** @param {TokenUse} use @param {Period} period @param {Kind} kind */
export function useChart(use, period, kind) {
  const series = seriesOf(use, period);
  const values = series.map(({ counts }) => counts[kind]);
  const total = values.reduce((sum, value) => sum + value, 0);
  const most = Math.max(...values);
  const steps = ticks(Math.max(most, 4), 4).filter(Number.isInteger);
  const top = Math.max(most, steps.at(-1) ?? 4);
  const up = (/** @type {number} */ value) => HEIGHT - BOTTOM - (value / top) * (HEIGHT - TOP - BOTTOM);
  const place = (WIDTH - LEFT) / series.length;
  const caption = t(`developers.total_${period}`, {
    what: t(`developers.kind_${kind}`),
    total: formatCount(total),
    most: formatCount(most),
  });
  const svg = make("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
    role: "img",
    "aria-label": caption,
    class: "use-chart",
  });
  for (const step of steps) {
    svg.append(
      make("path", { d: `M${LEFT} ${short(up(step))}H${WIDTH}`, class: "grid" }),
      make("text", { x: LEFT - 8, y: short(up(step) + 4), "text-anchor": "end" }, [formatCount(step)]),
    );
  }
  values.forEach((value, index) => {
    const [x, y] = [LEFT + (index + GAP / 2) * place, up(value)];
    if (value > 0)
      svg.append(
        make(
          "rect",
          {
            x: short(x),
            y: short(y),
            width: short((1 - GAP) * place),
            height: short(HEIGHT - BOTTOM - y),
            class: "bar",
          },
          [make("title", {}, [`${series[index].name}: ${formatCount(value)}`])],
        ),
      );
    if ((series.length - 1 - index) % (2 * NAMED) === NAMED)
      svg.append(
        make("text", { x: short(x + place / 2), y: HEIGHT - 7, "text-anchor": "middle" }, [series[index].name]),
      );
  });
  svg.append(make("path", { d: `M${LEFT} ${HEIGHT - BOTTOM}H${WIDTH}`, class: "axis" }));
  return el("figure", { class: "figure" }, svg, el("figcaption", {}, caption));
}

/** The same numbers to be read, the newest first. @param {TokenUse} use @param {Period} period */
export function useTable(use, period) {
  const rows = seriesOf(use, period).reverse();
  const head = el(
    "tr",
    {},
    el("th", { scope: "col" }, t(period === "hours" ? "developers.hour" : "developers.day")),
    ...KINDS.map((kind) => el("th", { scope: "col", class: "number" }, t(`developers.kind_${kind}`))),
  );
  return el(
    "table",
    { class: "use-table" },
    el("caption", {}, t(`developers.table_${period}`)),
    el("thead", {}, head),
    el(
      "tbody",
      {},
      ...rows.map(({ name, counts }) =>
        el("tr", {}, el("th", { scope: "row" }, name), ...KINDS.map((kind) => el("td", {}, formatCount(counts[kind])))),
      ),
    ),
  );
}
