// Page of the calibrations that were made in this browser: open them, compare two or one with the consensus, forget
// them.
import { splitLabel } from "../lib/camera-name.js";
import { el, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { dateText, formatSize, onLanguage, pageUrl, rough, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { forgetOwn, ownCalibrations } from "../lib/own-calibrations.js";
import { comparisonView } from "../lib/result/comparison.js";
import { factsOf, knownCalibrations, load } from "../lib/result/source.js";
import { button } from "../lib/result/views.js";

/** @typedef {import("../lib/own-calibrations.js").Own} Own */

const place = part("own", HTMLElement);
/** Ids of those that are compared. @type {Set<string>} */
const ticked = new Set();
/** The current comparison; an answer to anything else comes too late. */
let asked = 0;

/** @param {string} [id] all of them without one */
function forget(id) {
  forgetOwn(id);
  ticked.clear();
  draw();
  part("title", HTMLElement).focus();
}

/** @param {Own} own */
function row({ id, camera, img_size, time, level, rms }) {
  const { name } = splitLabel(camera);
  const box = el("input", {
    type: "checkbox",
    id: `tick-${id}`,
    "aria-label": t("mine.compare_this", { camera: name, date: dateText(time) }),
  });
  box.checked = ticked.has(id);
  box.disabled = ticked.size === 2 && !box.checked;
  box.addEventListener("change", () => {
    if (box.checked) ticked.add(id);
    else ticked.delete(id);
    draw();
    document.getElementById(box.id)?.focus();
  });
  return el(
    "li",
    {},
    el("label", { class: "tick" }, box),
    el(
      "a",
      { href: pageUrl(`result/?${new URLSearchParams({ id })}`).href },
      el("strong", {}, name),
      ` ${formatSize(img_size)}`,
    ),
    el("span", { class: `verdict tint ${level}` }, t(`result.level_${level}`)),
    el("span", { class: "muted number" }, `± ${rough(rms)}\u00a0px · ${dateText(time)}`),
    button(t("cameras.forget"), () => forget(id), {
      class: "small",
      "aria-label": t("cameras.forget_this", { camera: name }),
    }),
  );
}

/**
 * Compares what is ticked; one calibration with the consensus of its camera.
 * @param {HTMLElement} shown
 * @param {HTMLElement} status
 */
async function compare(shown, status) {
  const own = ++asked;
  status.textContent = t("cameras.comparing");
  try {
    const [one, other] = await Promise.all([...ticked].map((id) => load(id)));
    const pair = [one, other ?? (await consensusOf(one.calibration))];
    if (own !== asked) return;
    const isOneSize = pair[1] !== null && String(pair[0].calibration.img_size) === String(pair[1].calibration.img_size);
    status.textContent = isOneSize ? "" : t(pair[1] ? "mine.other_size" : "mine.no_consensus");
    if (isOneSize) shown.replaceChildren(comparisonView(pair[0], pair[1], other ? null : t("mine.consensus")));
  } catch (error) {
    if (own === asked) status.textContent = explain(error);
  }
}

/**
 * @param {Awaited<ReturnType<typeof load>>["calibration"]} calibration
 * @returns {Promise<Awaited<ReturnType<typeof load>> | null>} null: there is none
 */
async function consensusOf({ id, img_size, distortion_model }) {
  const key = factsOf(id)?.cameraKey;
  const known = key ? await knownCalibrations(key, img_size) : [];
  const calibration = known.find((each) => each.distortion_model === distortion_model) ?? known[0];
  return calibration ? { calibration, report: null } : null;
}

function draw() {
  const all = ownCalibrations();
  if (all.length === 0) {
    return place.replaceChildren(
      el(
        "div",
        { class: "nothing" },
        el("p", {}, t("mine.empty")),
        el(
          "div",
          { class: "actions", id: "first" },
          el("a", { class: "button primary", href: pageUrl("calibrate/").href }, t("cameras.calibrate_yours")),
          el("a", { class: "button", href: pageUrl("photos/").href }, t("cameras.from_photos")),
        ),
      ),
    );
  }
  const shown = el("div", { class: "comparison" });
  const status = el("p", { class: "muted", role: "status" }, t(ticked.size ? "mine.tick_another" : "cameras.tick_two"));
  place.replaceChildren(
    el("ul", { class: "own" }, ...all.map(row)),
    el(
      "div",
      { class: "actions" },
      ...(ticked.size === 1
        ? [button(t("mine.with_consensus"), () => void compare(shown, status), { id: "with-consensus" })]
        : []),
      status,
    ),
    shown,
    el(
      "div",
      { class: "actions" },
      el("a", { class: "button", href: pageUrl("import/").href }, t("mine.with_file")),
      ...(all.length > 1 ? [button(t("cameras.forget_all"), () => forget(), { id: "forget-all" })] : []),
    ),
  );
  if (ticked.size === 2) void compare(shown, status);
}

openPage();
onLanguage(draw);
draw();
