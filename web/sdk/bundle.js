// Bundle of calibrations that comes with an application: lookups without a network, by the rules of the service.
//
//     import { Bundle } from "https://<host>/sdk/bundle.js";
//     const bundle = new Bundle(await (await fetch("cameras.json")).json());
//     const { calibration } = await lookup(track, { bundle });
//
// `python -m infra.ops bundle` writes the file. It has resolved each label to a camera by the service's own rules. This
// module only compares labels, so it does not know a label that the file does not name.

import { CROPPED } from "./key.js";

/**
 * @typedef {import("./key.js").CameraKey} CameraKey
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 *
 * @typedef {object} BundledCamera
 * @property {string} camera label @property {string} platform
 * @property {any[][]} rows its calibrations, one value a column
 *
 * @typedef {object} BundleData as docs/formats.md has it
 * @property {string} format
 * @property {number} version
 * @property {string[]} columns
 * @property {BundledCamera[]} cameras
 * @property {Record<string, number>} labels number of the camera that goes by it on every computer
 * @property {Record<string, Record<string, number>>} places the same of labels that mean a camera on one system only
 */

const SAME_ASPECT = 0.01; // log of the ratio
/**
 * Platform patterns of known systems; others match none.
 * @type {[string, RegExp][]}
 */
const COMPUTERS = [
  ["linux", /^(?:X11|Wayland); (?:Ubuntu; |Fedora; )?Linux \w+(?:; rv:[\d.]+)?$/],
  ["windows", /^Windows NT [\d.]+(?:; (?:Win64|WOW64|x64|ARM64|rv:[\d.]+))*$/],
  ["macos", /^Macintosh; Intel Mac OS X [\d._]+(?:; rv:[\d.]+)?$/],
  ["chromeos", /^X11; CrOS \w+ [\d.]+$/],
];
const PHONE = /^Linux; Android [\d.]+; ([^;]+)$/;

export class Bundle {
  #data;

  /** @param {BundleData} data the file's content; throws a TypeError where it is something else */
  constructor(data) {
    if (data?.format !== "calibdb-bundle" || data.version !== 1)
      throw new TypeError("this is no bundle of calibrations that is understood here");
    this.#data = data;
  }

  /**
   * Answer that a lookup of the service would give, if that is certain. As there, the closest size is marked, and
   * other zooms do not match.
   * @param {CameraKey} key @param {string} model
   * @returns {CalibrationData | null} null: ask the service
   */
  find({ camera, platform, img_size: asked, zoom, resize_mode: mode }, model) {
    const { labels, places, cameras, columns } = this.#data;
    const computer = COMPUTERS.find(([, pattern]) => pattern.test(platform))?.[0];
    const place = computer ?? `android; ${PHONE.exec(platform)?.[1].toLowerCase()}`;
    const number = (computer ? own(labels, camera) : undefined) ?? own(own(places, place) ?? {}, camera);
    if (number === undefined || mode === CROPPED) return null;
    const { rows, ...whose } = cameras[number];
    /** @type {Record<string, any>[]} */
    const known = rows.map((row) => Object.fromEntries(row.map((value, index) => [columns[index], value])));
    const here = known.filter((row) => row.zoom === zoom).sort((a, b) => compareSizes(a.img_size, b.img_size, asked));
    // A model that the closest size lacks may be computed by the service.
    const found = here.find((row) => same(row.img_size, here[0].img_size) && row.distortion_model === model);
    return found ? answerOf(found, whose, asked) : null;
  }
}

/**
 * A row as the service answers it.
 * @param {Record<string, any>} row
 * @param {{camera: string, platform: string}} whose
 * @param {readonly [number, number]} asked
 * @returns {CalibrationData}
 */
function answerOf({ intrinsics, uncertainty: [rms, max, inside, covered], at, ...row }, whose, asked) {
  const { zoom, distortion_coefficients } = /** @type {Record<string, any>} */ (row);
  const matrix = (/** @type {number[]} */ [fx, fy, cx, cy]) => [
    [fx, 0, cx],
    [0, fy, cy],
    [0, 0, 1],
  ];
  const [relation, ...carried] = own(at, asked.join("x")) ?? [row.relation];
  const adapted = carried.length
    ? { img_size: asked, zoom, camera_matrix: matrix(carried), distortion_coefficients, interpolated: false }
    : null;
  return /** @type {any} */ ({
    ...row,
    ...whose,
    camera_matrix: matrix(intrinsics),
    uncertainty: { rms, max, inside, covered },
    reliable: true,
    exact_size: same(row.img_size, asked),
    relation,
    adapted,
  });
}

/** @template T @param {Record<string, T>} table @param {string} name @returns {T | undefined} */
const own = (table, name) => (Object.hasOwn(table, name) ? table[name] : undefined);

/** @param {readonly number[]} a @param {readonly number[]} b */
const same = (a, b) => a[0] === b[0] && a[1] === b[1];

/**
 * Compare the distance of two sizes from the requested one: by aspect, then by area.
 * @param {number[]} a
 * @param {number[]} b
 * @param {readonly number[]} asked
 */
function compareSizes(a, b, [w, h]) {
  const [x, y] = [a, b].map((size) => {
    const aspect = Math.abs(Math.log((size[0] * h) / (size[1] * w)));
    return [
      same(size, [w, h]) ? 0 : 1,
      aspect < SAME_ASPECT ? 0 : aspect,
      Math.abs(Math.log((size[0] * size[1]) / (w * h))),
    ];
  });
  return x[0] - y[0] || x[1] - y[1] || x[2] - y[2];
}
