// Page of the calibrations that were made in this browser: open them, compare two, or one with the consensus or a file,
// forget them.
import { ApiError } from "../lib/api.js";
import { splitLabel } from "../lib/camera-name.js";
import { button, el, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { dateText, formatSize, onLanguage, pageUrl, rough, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { forgetOwn, ownCalibrations, ownOf } from "../lib/own-calibrations.js";
import { comparisonView } from "../lib/result/comparison.js";
import { factsOf, knownCalibrations, load } from "../lib/result/source.js";
import { readCamera, sourceOf } from "../lib/conversion.js";

/** @import { Own } from "../lib/own-calibrations.js" */

/**
 * @typedef {Awaited<ReturnType<typeof load>>} Loaded
 */

const place = part("own", HTMLElement);
/** Ids of those that are compared. @type {Set<string>} */
const ticked = new Set();
/** Calibration that the address names, if it was made elsewhere. @type {Own | null} */
let guest = null;
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
    ...(id === guest?.id
      ? []
      : [
          button(t("cameras.forget"), () => forget(id), {
            class: "small",
            "aria-label": t("cameras.forget_this", { camera: name }),
          }),
        ]),
  );
}

/**
 * Compares the first that is ticked with another calibration.
 * @param {HTMLElement} shown
 * @param {HTMLElement} status
 * @param {(one: Loaded) => Promise<Loaded | string>} find the other, or why there is none
 * @param {string | null} [name] of the other, instead of its date
 */
async function compare(shown, status, find, name = null) {
  const own = ++asked;
  status.textContent = t("cameras.comparing");
  try {
    const one = await load([...ticked][0]);
    const other = await find(one);
    if (own !== asked) return;
    const isOneSize = typeof other !== "string" && `${one.calibration.img_size}` === `${other.calibration.img_size}`;
    status.textContent = isOneSize ? "" : typeof other === "string" ? other : t("mine.other_size");
    if (isOneSize) shown.replaceChildren(comparisonView(one, other, name));
  } catch (error) {
    if (own === asked) status.textContent = explain(error);
  }
}

/** Chooser of a file to compare with. @param {HTMLElement} shown @param {HTMLElement} status */
function fileChooser(shown, status) {
  const input = el("input", { class: "unseen", type: "file", id: "with-file" });
  input.addEventListener("change", () => {
    const [file] = input.files ?? [];
    if (file) void compare(shown, status, ({ calibration }) => cameraOf(file, calibration.img_size), file.name);
  });
  return el("label", { class: "button" }, input, el("span", {}, t("mine.with_file")));
}

/**
 * The camera in a file.
 * @param {File} file @param {[number, number]} img_size if the file says none
 * @returns {Promise<Loaded | string>}
 */
async function cameraOf(file, img_size) {
  const source = sourceOf(await file.arrayBuffer(), await file.text());
  try {
    if (!source) return t("import.no_camera");
    const camera = await readCamera(source, { img_size });
    const calibration = /** @type {Loaded["calibration"]} */ (/** @type {unknown} */ ({ ...camera, id: null }));
    return { calibration, report: null };
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 422) throw error;
    return t("import.no_camera");
  }
}

/** Consensus of the camera. @param {Loaded} loaded @returns {Promise<Loaded | string>} */
async function consensusOf({ calibration: { id, img_size, distortion_model } }) {
  const key = factsOf(id)?.cameraKey;
  const known = key ? await knownCalibrations(key, img_size) : [];
  const calibration = known.find((each) => each.distortion_model === distortion_model) ?? known[0];
  return calibration ? { calibration, report: null } : t("mine.no_consensus");
}

function draw() {
  const all = [...(guest ? [guest] : []), ...ownCalibrations()];
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
        ? [
            button(t("mine.with_consensus"), () => void compare(shown, status, consensusOf, t("mine.consensus")), {
              id: "with-consensus",
            }),
            fileChooser(shown, status),
          ]
        : []),
      status,
    ),
    shown,
    ...(all.length > 1
      ? [
          el(
            "div",
            { class: "actions" },
            button(t("cameras.forget_all"), () => forget(), { id: "forget-all" }),
          ),
        ]
      : []),
  );
  if (ticked.size === 2) void compare(shown, status, () => load([...ticked][1]));
}

/** Ticks the calibration that the address names, of any contributor. */
async function tickNamed() {
  const id = new URLSearchParams(location.search).get("with");
  if (!id) return;
  try {
    if (!ownCalibrations().some((own) => own.id === id)) {
      const { calibration, report } = await load(id);
      guest = ownOf({ ...calibration, id }, report);
    }
    ticked.add(id);
    draw();
  } catch (error) {
    place.prepend(el("p", { class: "problem" }, explain(error)));
  }
}

openPage();
onLanguage(draw);
draw();
void tickNamed();
