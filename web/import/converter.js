// Converter of files that have a camera and no measurements: view the camera, write it for another program, compare
// it with the database. Only what is asked for is sent, and nothing is stored.
import { ApiError } from "../lib/api.js";
import { button, el } from "../lib/dom.js";
import { number, rough, formatSize, t } from "../lib/i18n.js";
import { lensDifference } from "../lib/lens-difference.js";
import { conversionText } from "../lib/result/download.js";
import { figure } from "../lib/result/tiles.js";
import { distortionPlot, heatPlot } from "../lib/result/plots.js";
import { straightPart } from "../lib/result/straight-part.js";
import { FORMATS } from "../vendor/formats.js";
import { COEFFICIENTS } from "../sdk/projection.js";
import { knownCalibrations } from "../lib/result/source.js";
import { readCamera, saveAs, searchCameras } from "../lib/conversion.js";

/** @import { Camera, Hints, Source } from "../lib/conversion.js" */

const CORNERS_ALONE = "corners-vnl"; // a table of what was measured: there is nothing to write into it
const MAX_FOUND = 8; // cameras that are offered for a comparison

export class Converter {
  #root;
  #explain;
  /** @type {(() => void) | null} */
  #dispose = null;
  /** Files so far: what arrives for an earlier one comes too late. */
  #turn = 0;

  /** @param {HTMLElement} root @param {(error: unknown) => string} explain */
  constructor(root, explain) {
    this.#root = root;
    this.#explain = explain;
  }

  clear() {
    this.#turn += 1;
    this.#dispose?.();
    this.#dispose = null;
    this.#root.replaceChildren();
    this.#root.hidden = true;
  }

  /**
   * Offers to open a file.
   * @param {Source} source @param {string} name of the file
   * @param {(() => Promise<void>) | null} [unpack] calibrates from the corners that it has packed; null: there are none
   */
  offer(source, name, unpack = null) {
    this.clear();
    this.#root.hidden = false;
    const status = el("p", { class: "problem", id: "convert-status", role: "status" });
    const open = el("button", { type: "button", class: "primary", id: "open-file" }, t("import.open"));
    const size = sizeFields();
    open.addEventListener("click", async () => {
      open.disabled = true;
      const own = this.#turn;
      status.textContent = "";
      try {
        /** @type {Hints} */
        const hints = { ...size.hint() };
        const camera = await readCamera(source, hints);
        if (own === this.#turn)
          this.#show(
            source,
            { ...hints, ...(camera.camera === "camera" ? { camera: name.replace(/\.[^.]*$/, "").slice(0, 128) } : {}) },
            camera,
          );
      } catch (error) {
        if (own !== this.#turn) return;
        const isSize = error instanceof ApiError && error.status === 422 && /img_size/.test(error.message);
        if (isSize) size.show();
        status.textContent = isSize
          ? t("import.needs_size")
          : error instanceof ApiError && error.status === 422
            ? t("import.no_camera")
            : this.#explain(error);
      } finally {
        open.disabled = false;
      }
    });
    const corners = el("button", { type: "button", class: "primary", id: "unpack" }, t("import.unpack"));
    corners.addEventListener("click", async () => {
      corners.disabled = true;
      try {
        await unpack?.();
      } catch (error) {
        status.textContent =
          error instanceof ApiError && error.status === 422 ? t("import.wrong_empty") : this.#explain(error);
      } finally {
        corners.disabled = false;
      }
    });
    if (unpack) open.classList.remove("primary");
    this.#root.append(
      el("p", {}, t("import.open_text")),
      size.element,
      el("div", { class: "actions" }, unpack && corners, open),
      status,
    );
  }

  /** @param {Source} source @param {Hints} hints @param {Camera} camera */
  #show(source, hints, camera) {
    const record = { ...calibrationOf(camera), camera: hints.camera ?? camera.camera };
    const straight = straightPart(record, null, (picture) => {
      this.#dispose?.();
      const again = straightPart(record, picture, () => {});
      this.#dispose = again.dispose;
      straightPlace.replaceChildren(again.element);
    });
    this.#dispose = straight.dispose;
    const straightPlace = el("div", {}, straight.element);
    this.#root.replaceChildren(
      section("camera", values(record)),
      section("convert", this.#formats(source, hints, camera)),
      section("view", el("div", { class: "converted" }, straightPlace, figure(distortionPlot(record)))),
      section("compare", this.#comparison(record)),
    );
    document.getElementById("converter-camera")?.focus();
  }

  /** @param {Source} source @param {Hints} hints @param {Camera} camera */
  #formats(source, hints, camera) {
    const formats = FORMATS.filter((format) => format !== CORNERS_ALONE);
    const select = el(
      "select",
      { id: "convert-format", "aria-describedby": "convert-about" },
      ...formats.map((format) => new Option(t(`formats.name_${format}`), format)),
    );
    const about = el("p", { class: "muted", id: "convert-about" }, t(`formats.for_${select.value}`));
    const status = el("p", { class: "saved", id: "convert-done", role: "status" });
    const button = el("button", { type: "button", class: "primary", id: "convert" }, t("import.convert"));
    select.addEventListener("change", () => {
      about.textContent = t(`formats.for_${select.value}`);
      status.textContent = "";
    });
    button.addEventListener("click", async () => {
      button.disabled = true;
      status.classList.remove("problem");
      status.textContent = t("formats.writing");
      try {
        status.textContent = conversionText(await saveAs(source, hints, select.value, camera));
      } catch (error) {
        status.classList.add("problem");
        const far = error instanceof ApiError && error.status === 422 ? /([\d.]+) px/.exec(error.message) : null;
        status.textContent = far
          ? t("formats.impossible_far", { error: number(Number(far[1]), 0) })
          : error instanceof ApiError && error.status === 422
            ? t("formats.impossible_lens")
            : this.#explain(error);
      } finally {
        button.disabled = false;
      }
    });
    return el(
      "div",
      { class: "take" },
      el(
        "div",
        { class: "fields" },
        el("div", { class: "field" }, el("label", { for: "convert-format" }, t("import.format")), select),
        button,
      ),
      about,
      status,
    );
  }

  /** @param {Camera} camera */
  #comparison(camera) {
    const input = el("input", {
      id: "compare-query",
      type: "search",
      autocomplete: "off",
      placeholder: t("import.compare_example"),
      maxlength: 128,
    });
    const found = el("ul", { class: "facts", id: "compare-found" });
    const place = el("div", { id: "compare-result", role: "status" });
    const form = el(
      "form",
      { class: "fields", role: "search" },
      el("div", { class: "field" }, el("label", { for: "compare-query" }, t("import.compare_label")), input),
      el("button", { type: "submit", id: "compare-search" }, t("import.compare_search")),
    );
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      place.replaceChildren();
      found.replaceChildren();
      try {
        const cameras = await searchCameras(input.value.trim());
        if (cameras.length === 0) place.replaceChildren(t("import.compare_none"));
        found.replaceChildren(
          ...cameras.slice(0, MAX_FOUND).map(({ key, camera: label, platform }) => {
            const choose = button(label, () => void this.#compare(camera, key, place), { class: "small" });
            return el("li", {}, choose, ` ${platform}`);
          }),
        );
      } catch (error) {
        place.replaceChildren(this.#explain(error));
      }
    });
    return el("div", { class: "take" }, el("p", {}, t("import.compare_text")), form, found, place);
  }

  /** @param {Camera} camera @param {string} key @param {HTMLElement} place */
  async #compare(camera, key, place) {
    try {
      const known = (await knownCalibrations(key, camera.img_size)).filter(
        ({ distortion_model: model }) => model in COEFFICIENTS,
      );
      const other = known.find(({ distortion_model: model }) => model === camera.distortion_model) ?? known[0];
      if (!other) {
        place.replaceChildren(t("import.compare_no_size", { size: formatSize(camera.img_size) }));
        return;
      }
      const { px, rms, max } = lensDifference(camera, other);
      const texts = { rms: rough(rms), max: rough(max) };
      place.replaceChildren(
        figure({
          ...heatPlot(camera.img_size, px, max, t("import.difference_label", texts)),
          caption: t("import.difference_caption", texts),
        }),
      );
    } catch (error) {
      place.replaceChildren(this.#explain(error));
    }
  }
}

/** @param {string} name @param {Node} content */
const section = (name, content) =>
  el(
    "section",
    { "aria-labelledby": `converter-${name}` },
    el("h2", { id: `converter-${name}`, tabindex: -1 }, t(`import.part_${name}`)),
    content,
  );

/** The camera as figures take it. @param {Camera} camera */
function calibrationOf(camera) {
  return /** @type {import("../lib/result/numbers.js").Calibration & Camera} */ (
    /** @type {unknown} */ ({ ...camera, id: null })
  );
}

/** @param {Camera} camera */
function values({
  camera,
  img_size,
  camera_matrix: [[fx, , cx], [, fy, cy]],
  distortion_model: model,
  distortion_coefficients: coefficients,
}) {
  const rows = [
    [t("import.value_name"), camera],
    [t("import.value_size"), `${formatSize(img_size)} px`],
    ["fx, fy", `${number(fx, 2)}, ${number(fy, 2)} px`],
    ["cx, cy", `${number(cx, 2)}, ${number(cy, 2)} px`],
    [t("import.value_model"), t(`photos.model_${model}`)],
    ...coefficients.map((value, index) => [(COEFFICIENTS[model] ?? [])[index] ?? `d${index}`, number(value, 6)]),
  ];
  return el(
    "table",
    { class: "values", id: "converted-values" },
    el(
      "tbody",
      {},
      ...rows.map(([name, value]) =>
        el("tr", {}, el("th", { scope: "row" }, name), el("td", { class: "number" }, value)),
      ),
    ),
  );
}

/** Fields of the size of the pictures, hidden until a file is found not to say it. */
function sizeFields() {
  const input = (/** @type {string} */ name) =>
    el("input", {
      id: `convert-${name}`,
      type: "number",
      min: 16,
      max: 16384,
      step: 1,
      "aria-label": t(`import.${name}`),
    });
  const [width, height] = [input("width"), input("height")];
  const element = el(
    "fieldset",
    { class: "pair", hidden: true },
    el("legend", {}, t("import.size")),
    width,
    " × ",
    height,
  );
  return {
    element,
    show() {
      element.hidden = false;
      width.focus();
    },
    /** @returns {Hints} */
    hint: () =>
      width.valueAsNumber > 0 && height.valueAsNumber > 0
        ? { img_size: [width.valueAsNumber, height.valueAsNumber] }
        : {},
  };
}
