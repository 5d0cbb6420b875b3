// First sheet: the cameras of this device, what each delivers, and the other devices.
import { LENS_TYPES, cameras, deviceFaultText, requestStream } from "../lib/camera.js";
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";

/**
 * @import { Choice } from "../lib/capture/streams.js"
 * @import { Parts } from "./parts.js"
 */

/**
 * @typedef {{id: string, label: string, used: HTMLInputElement, layout: HTMLSelectElement, lens: HTMLSelectElement}}
 *   Row
 */

export const MIN_CAMERAS = 2;
export const MAX_CAMERAS = 8;
const LAYOUTS = ["one", "side_by_side", "top_bottom"];
const CODE = /^[A-Z0-9]{6}$/;

export class Setup {
  #parts;
  #parameters;
  #joins;
  /** @type {Row[]} */
  #rows = [];

  /** @param {Parts} parts @param {URLSearchParams} parameters @param {boolean} joins */
  constructor(parts, parameters, joins) {
    this.#parts = parts;
    this.#parameters = parameters;
    this.#joins = joins;
    parts.code.value = parameters.get("code") ?? "";
    parts.cameras.addEventListener("change", () => this.#sum());
    parts.allow.addEventListener("click", () => void this.allow());
    navigator.mediaDevices?.addEventListener("devicechange", () => void this.list());
    this.#writeOthers();
  }

  /**
   * Lists the cameras that the browser names; the choices are kept.
   * @param {boolean} [inNewLanguage] rebuild the list although its cameras are the same
   */
  async list(inNewLanguage = false) {
    const found = (await cameras(this.#parameters)).filter(({ id, named }) => id !== "virtual" && named);
    const { cameras: place, allow, camerasNote } = this.#parts;
    const chosen = new Map(this.#rows.map((row) => [row.id, row]));
    if (inNewLanguage || found.map(({ id }) => id).join() !== this.#rows.map(({ id }) => id).join()) {
      this.#rows = found.map(({ id, label }, index) =>
        this.#row(id, label, index < (this.#joins ? 1 : 2), chosen.get(id)),
      );
      place.replaceChildren(
        ...this.#rows.map(({ label, used, layout, lens }) =>
          el(
            "div",
            { class: "camera" },
            el("label", { class: "choice" }, used, el("span", {}, label)),
            el("div", { class: "fields" }, field(layout, t("rig.layout")), field(lens, t("rig.lens"))),
          ),
        ),
      );
    }
    allow.hidden = found.length > 0;
    camerasNote.textContent = found.length === 0 ? t("rig.not_listed") : "";
    this.#sum();
  }

  /** Asks for permission, without which a browser names no camera. */
  async allow() {
    const { camerasNote, setupProblem } = this.#parts;
    setupProblem.textContent = "";
    camerasNote.textContent = t("rig.allowing");
    try {
      const stream = await requestStream(true);
      await this.list();
      for (const track of stream.getTracks()) track.stop();
      if (this.#rows.length === 0) camerasNote.textContent = t("rig.none_found");
    } catch (error) {
      camerasNote.textContent = "";
      setupProblem.textContent = deviceFaultText(error);
      if (!setupProblem.textContent) throw error;
    }
  }

  /** @param {string} id @param {string} label @param {boolean} checked unless chosen otherwise @param {Row} [before] */
  #row(id, label, checked, before) {
    const used = el("input", { type: "checkbox", autocomplete: "off" });
    used.checked = before?.used.checked ?? checked;
    const select = (/** @type {string} */ kind, /** @type {readonly string[]} */ names) =>
      el(
        "select",
        { "aria-label": `${t(`rig.${kind}`)}: ${label}` },
        ...names.map((name) => new Option(t(kind === "lens" ? `capture.lens_${name}` : `rig.layout_${name}`), name)),
      );
    const [layout, lens] = [select("layout", LAYOUTS), select("lens", LENS_TYPES)];
    if (before) [layout.value, lens.value] = [before.layout.value, before.lens.value];
    return { id, label, used, layout, lens };
  }

  /** Fills in the numbers of cameras that other devices may have. */
  #writeOthers() {
    const { others } = this.#parts;
    const { value } = others;
    others.replaceChildren(
      ...Array.from({ length: MAX_CAMERAS }, (_, count) => new Option(String(count), String(count))),
    );
    others.value = value || "0";
  }

  #sum() {
    const { others } = this.#parts;
    const own = this.own;
    for (const option of others.options) option.disabled = own + Number(option.value) > MAX_CAMERAS;
    if (own > 0 && own < MIN_CAMERAS && others.value === "0") others.value = String(MIN_CAMERAS - own);
  }

  /** Number of pictures of the chosen cameras. */
  get own() {
    return this.choices.reduce((sum, { layout }) => sum + (layout === "one" ? 1 : 2), 0);
  }

  /** @returns {Choice[]} */
  get choices() {
    return this.#rows
      .filter(({ used }) => used.checked)
      .map(({ id, label, layout, lens }) => ({
        id,
        label,
        layout: /** @type {Choice["layout"]} */ (layout.value),
        distortion_model: /** @type {Choice["distortion_model"]} */ (lens.value),
      }));
  }

  /** Code as the service takes it. */
  get code() {
    return this.#parts.code.value.toUpperCase().replaceAll(/[^A-Z0-9]/g, "");
  }

  /** Side of a square, metres; null: not measured. */
  get squareSize() {
    const value = Number(this.#parts.square.value);
    return value > 0 ? value / 1000 : null;
  }

  /** Cameras of the rig, in all. */
  get count() {
    return this.own + Number(this.#parts.others.value);
  }

  /** Reason why it cannot begin so; "" where it can. @param {boolean} virtual simulated cameras are used */
  problem(virtual) {
    if (this.#joins && !CODE.test(this.code)) return t("rig.need_code");
    if (virtual) return "";
    if (this.own === 0) return t("rig.need_camera");
    if (this.#joins) return "";
    if (this.count < MIN_CAMERAS) return t("rig.need_two");
    return this.count > MAX_CAMERAS ? t("rig.too_many", { count: MAX_CAMERAS }) : "";
  }
}

/** @param {HTMLSelectElement} select @param {string} words */
function field(select, words) {
  return el("div", { class: "field" }, el("span", { class: "label", "aria-hidden": "true" }, words), select);
}
