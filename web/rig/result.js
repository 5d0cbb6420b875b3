// Result of a rig: how good it is, where the cameras are, the rectified pair, files, each camera's calibration, code.
import { codeBlocks } from "../lib/result/code-part.js";
import { boardSentence } from "../lib/result/meaning.js";
import { copyButton } from "../lib/result/menu.js";
import { digitsFor } from "../lib/result/numbers.js";
import { addCopyButton } from "../lib/code-block.js";
import { ApiError } from "../lib/api.js";
import { corners } from "../lib/board.js";
import { el } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { offerResponse } from "../lib/files.js";
import { joinFacts, number, onLanguage, rough, formatSize, t } from "../lib/i18n.js";
import { isVirtual } from "../lib/camera-name.js";
import { Rig } from "../sdk/rig.js";
import { rectifiedPart } from "./rectified-part.js";
import { sceneOf, scenePlot } from "../lib/scene-plot.js";
import { boardInRig, relationOf } from "./relations.js";
import { cameraName, cameraNames, labelText } from "./status-text.js";

/** @import { RigResult, RigService, RigState } from "./service.js" */

/**
 * @typedef {{service: RigService, pictures: Map<number, ImageBitmap>, views: {position: number,
 *   corners: import("../lib/board-outline.js").Corners}[]}} Sources
 *   pictures and views that this page has taken
 */

const FORMATS = ["opencv_stereo", "ros", "kalibr", "colmap", "mrcal", "gltf", "json"];

export class RigView {
  #root;
  #state;
  #sources;
  /** @type {(() => void)[]} */
  #held = [];

  /** @param {HTMLElement} root @param {RigState} state of a finished rig @param {Sources} sources */
  constructor(root, state, sources) {
    this.#root = root;
    this.#state = state;
    this.#sources = sources;
    onLanguage(() => this.draw());
  }

  draw() {
    for (const release of this.#held.splice(0)) release();
    const { result } = this.#state;
    if (!result) return;
    const rig = new Rig(
      /** @type {import("../sdk/rig.js").RigData} */ (
        /** @type {unknown} */ ({ ...result, rig_id: this.#state.rig_id })
      ),
    );
    const rectified = rectifiedPart(rig, this.#sources.pictures);
    this.#held.push(rectified.dispose);
    this.#root.replaceChildren(
      el("div", { class: "outlook" }, head(this.#state, result), this.#scene(result)),
      section("where", relations(result)),
      section("pair", rectified.element),
      section("files", this.#files()),
      section("each", cameraList(this.#state, result)),
      section("code", codes(this.#state.rig_id)),
    );
  }

  /** Cameras and boards as a figure. @param {RigResult} result */
  #scene(result) {
    const { board, square_size: size } = this.#state;
    const square = result.unit === "metres" && size ? size : 1;
    const boards =
      result.board_poses ??
      this.#sources.views
        .map(({ position, corners }) => boardInRig(result, position, corners, board, square))
        .filter((pose) => pose !== null);
    const plot = scenePlot(
      sceneOf(result.calibrations, result.extrinsics, boards, board, square),
      t("rig.plot_label", { count: result.cameras.length }),
    );
    return el(
      "figure",
      { class: "figure" },
      plot,
      el("figcaption", {}, t(boards.length ? "rig.plot_caption_boards" : "rig.plot_caption")),
    );
  }

  #files() {
    const status = el("p", { role: "status" });
    const say = (/** @type {string} */ words, /** @type {boolean} */ bad) => {
      status.classList.toggle("problem", bad);
      status.textContent = words;
    };
    const buttons = FORMATS.map((format) => {
      const button = el(
        "button",
        { type: "button", id: `file-${format}`, "data-format": format },
        t(`rig.format_${format}`),
      );
      button.addEventListener("click", async () => {
        button.disabled = true;
        try {
          say(t("rig.saved", { name: await this.#save(format) }), false);
        } catch (error) {
          say(error instanceof ApiError && error.status === 422 ? t("rig.no_such_file") : explain(error), true);
        }
        button.disabled = false;
      });
      return el("li", {}, button, el("span", { class: "muted" }, t(`rig.for_${format}`)));
    });
    return el("div", {}, el("ul", { class: "files" }, ...buttons), status);
  }

  /** Hands a file to the browser. @param {string} format @returns {Promise<string>} its name */
  async #save(format) {
    const response = await this.#sources.service.file(this.#state.rig_id, format === "json" ? "" : format);
    return offerResponse(response, `rig-${this.#state.rig_id.slice(0, 8)}.${format === "json" ? "json" : "zip"}`);
  }
}

/** @param {string} id @param {HTMLElement} content */
function section(id, content) {
  return el(
    "section",
    { class: "band", "aria-labelledby": `rig-${id}` },
    el("h2", { id: `rig-${id}` }, t(`rig.part_${id}`)),
    content,
  );
}

/** Longer extent of a board's corners, mm; null if its squares were not measured. @param {RigState} state */
function lengthOf({ board, square_size: size }) {
  if (!size) return null;
  const points = corners(board);
  const extents = [0, 1].map((axis) => {
    const places = points.map((point) => point[axis]);
    return Math.max(...places) - Math.min(...places);
  });
  return 1000 * size * Math.max(...extents);
}

/** @param {RigState} state @param {RigResult} result */
function head(state, { verdict, rms, held_out_rms: heldOut, uncertainty, cameras: all, board_shape: shape }) {
  const { cameras, rig_id: id, moments } = state;
  const { level } = verdict;
  const practice = cameras.some(({ camera }) => isVirtual(camera ?? ""));
  const aside = moments.flatMap(({ set_aside: views = [] }) => views).length;
  const figures = [
    t("rig.figure_rms", { rms: rough(rms) }),
    ...(heldOut ? [t("rig.figure_held_out", { rms: rough(heldOut) })] : []),
    t("rig.figure_moments", { count: moments.length }),
    ...(aside ? [t("rig.figure_aside", { count: aside })] : []),
  ];
  return el(
    "header",
    { class: "opening" },
    practice && el("p", { class: "practice" }, t("rig.practice_result")),
    el("h1", { id: "result-title", tabindex: -1 }, t("rig.result_title", { count: all.length })),
    el("p", { id: "verdict", class: `verdict tint ${level}` }, t(`rig.level_${level}`)),
    uncertainty &&
      el(
        "p",
        { class: "lead" },
        t("rig.uncertainty", {
          rms: rough(uncertainty.rms),
          rotation: rough(uncertainty.rotation_deg),
          translation: rough(uncertainty.translation_percent),
        }),
      ),
    ...boardSentence(shape, lengthOf(state)).map((text) => el("p", {}, text)),
    el("p", { class: "muted small" }, joinFacts(figures)),
    el(
      "div",
      { class: "actions" },
      copyButton(t("rig.copy_link"), () => new URL(`?id=${encodeURIComponent(id)}`, location.href).href),
      el("a", { class: "button", href: "./" }, t("rig.another")),
    ),
  );
}

/** @param {RigResult} result */
function relations({ extrinsics, unit }) {
  const cell = (/** @type {string} */ words, /** @type {string} */ kind = "") => el("td", { class: kind }, words);
  const rows = extrinsics
    .filter(({ position }) => position > 0)
    .map((extrinsic) => {
      const { distance, distanceStd, angle, angleStd } = relationOf(extrinsic);
      const [factor, name] = unit === "metres" ? (distance < 1 ? [1000, "mm"] : [1, "m"]) : [1, t("rig.squares")];
      return el(
        "tr",
        {},
        el("th", { scope: "row" }, t("rig.relation", { from: 1, to: extrinsic.position + 1 })),
        cell(withError(distance * factor, distanceStd * factor, name)),
        cell(withError(angle, angleStd, "°")),
      );
    });
  const heads = [t("rig.col_cameras"), t("rig.col_distance"), t("rig.col_angle")];
  const vectors = extrinsics
    .filter(({ position }) => position > 0)
    .map(
      ({ position, rvec, tvec, std }) =>
        `${cameraName(position)}\nrvec = [${rvec.join(", ")}]\ntvec = [${tvec.join(", ")}]\nstd  = [${std.join(", ")}]`,
    )
    .join("\n\n");
  return el(
    "div",
    { class: "relations" },
    el(
      "div",
      { class: "scrolls", tabindex: 0, role: "group", "aria-labelledby": "rig-where" },
      el(
        "table",
        {},
        el("caption", {}, t("rig.relations_caption")),
        el(
          "thead",
          {},
          el("tr", {}, ...heads.map((words, index) => el("th", { scope: "col", class: index ? "number" : "" }, words))),
        ),
        el("tbody", {}, ...rows),
      ),
    ),
    el(
      "details",
      {},
      el("summary", {}, t("rig.vectors")),
      el("p", { class: "muted" }, t("rig.vectors_text", { unit: unit === "metres" ? "m" : t("rig.squares") })),
      addCopyButton(el("pre", { tabindex: 0, "aria-label": t("rig.vectors") }, el("code", {}, vectors))),
    ),
  );
}

/**
 * A value with as many digits as its error is worth.
 * @param {number} value
 * @param {number} error
 * @param {string} unit
 */
function withError(value, error, unit) {
  const digits = digitsFor(error);
  const space = unit === "°" ? "" : "\u00a0";
  return `${number(value, digits)} ± ${number(error, digits)}${space}${unit}`;
}

/** @param {RigState} state @param {RigResult} result */
function cameraList({ cameras }, { cameras: ids, calibrations }) {
  return el(
    "ul",
    { class: "each" },
    ...ids.map((id, position) => {
      const label = cameras[position]?.camera ?? calibrations[position].camera;
      const link = new URL(`../result/?${new URLSearchParams({ id })}`, location.href).href;
      return el(
        "li",
        {},
        el("a", { href: link }, t("rig.own_calibration", { camera: cameraName(position) })),
        " ",
        el(
          "span",
          { class: "muted" },
          [labelText(label), formatSize(calibrations[position].img_size)].filter(Boolean).join(" · "),
        ),
      );
    }),
  );
}

/** @param {string} id */
function codes(id) {
  const origin = new URL("../", location.href).origin;
  const javascript = `import { rig, rectifyPair } from "${origin}/sdk/calibdb.js";

const token = "cdb_…"; // yours
const stereo = await rig("${id}", { token });
stereo.pose(1).tvec; // from camera 0 to camera 1, in ${"`stereo.unit`"}
const pair = await rectifyPair(leftVideo, rightVideo, stereo);
document.body.append(pair.left, pair.right);
`;
  const python = `import cv2

file = cv2.FileStorage("stereo-0-1.yml", cv2.FILE_STORAGE_READ)
names = "K1 D1 K2 D2 R T".split()
K1, D1, K2, D2, R, T = (file.getNode(name).mat() for name in names)
`;
  return codeBlocks([
    ["javascript", "JavaScript", javascript],
    ["python", t("rig.python"), python],
  ]);
}

/** Sentence about cameras that a rig has, for a page's title. @param {RigState} state */
export const titleOf = ({ cameras }) =>
  t("rig.title_of", { cameras: cameraNames(cameras.map(({ position }) => position)) });
