// EXIF data of a photograph's camera. EXIF 2.32 (CIPA DC-008), in JPEG, PNG, WebP and TIFF files.

/**
 * @typedef {object} Exif
 * @property {string} make "" where the file does not say, as below
 * @property {string} model
 * @property {string} lens
 * @property {number} focal length, mm; 0
 * @property {number} focal35 its equivalent on 35 mm film, mm; 0
 * @property {{at: number, little: boolean, value: number} | null} orientation and where in the file it is written
 */

const TAGS = {
  make: 0x010f,
  model: 0x0110,
  orientation: 0x0112,
  more: 0x8769,
  focal: 0x920a,
  focal35: 0xa405,
  lens: 0xa434,
};
const TYPES = { ascii: 2, short: 3, rational: 5 };
const SIZES = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8]; // bytes of one value, by type
/** @type {Exif} */
const NOTHING = { make: "", model: "", lens: "", focal: 0, focal35: 0, orientation: null };

/**
 * @param {ArrayBuffer} file
 * @returns {Exif}
 */
export function readExif(file) {
  const view = new DataView(file);
  const start = blockStart(view);
  if (start === null) return NOTHING;
  try {
    return readBlock(view, start);
  } catch (error) {
    // An offset that leads out of the file: what is written there is of no use.
    if (error instanceof RangeError) return NOTHING;
    throw error;
  }
}

/** Offset of the TIFF header in the EXIF block. @param {DataView} view @returns {number | null} */
function blockStart(view) {
  const name = (/** @type {number} */ at, /** @type {number} */ length) => text(view, at, length);
  if (view.byteLength < 12) return null;
  if (view.getUint16(0) === 0xffd8) return inJpeg(view);
  if (view.getUint32(0) === 0x89504e47) return inChunks(view, 8, "eXIf", { little: false, head: 8, foot: 4 });
  if (name(0, 4) === "RIFF" && name(8, 4) === "WEBP")
    return inChunks(view, 12, "EXIF", { little: true, head: 8, foot: 0 });
  return ["II*\0", "MM\0*"].includes(name(0, 4)) ? 0 : null;
}

/** @param {DataView} view */
function inJpeg(view) {
  for (let at = 2; at + 10 <= view.byteLength;) {
    const marker = view.getUint16(at);
    // Past the headers; what follows is the picture.
    if ((marker < 0xffe0 && marker !== 0xffdb && marker !== 0xffc4) || marker === 0xffda) return null;
    if (marker === 0xffe1 && text(view, at + 4, 6) === "Exif\0\0") return at + 10;
    at += 2 + view.getUint16(at + 2);
  }
  return null;
}

/**
 * @param {DataView} view
 * @param {number} from
 * @param {string} wanted
 * @param {{little: boolean, head: number, foot: number}} layout
 */
function inChunks(view, from, wanted, { little, head, foot }) {
  for (let at = from; at + head <= view.byteLength;) {
    // PNG names a chunk after its length, RIFF before it; and RIFF pads to even lengths.
    const [length, name] = little
      ? [view.getUint32(at + 4, true), text(view, at, 4)]
      : [view.getUint32(at), text(view, at + 4, 4)];
    if (name === wanted) return text(view, at + head, 6) === "Exif\0\0" ? at + head + 6 : at + head;
    at += head + length + foot + (little ? length % 2 : 0);
  }
  return null;
}

/** @param {DataView} view @param {number} start @returns {Exif} */
function readBlock(view, start) {
  const little = view.getUint16(start) === 0x4949;
  const first = directory(view, start, start + view.getUint32(start + 4, little), little);
  const more = first.get(TAGS.more);
  const second = more ? directory(view, start, start + view.getUint32(more.at, little), little) : new Map();
  const words = (/** @type {Entry | undefined} */ entry) =>
    entry?.type === TYPES.ascii ? text(view, entry.at, entry.count).replace(/\0.*$/s, "").trim() : "";
  const focal = second.get(TAGS.focal);
  const focal35 = second.get(TAGS.focal35);
  const orientation = first.get(TAGS.orientation);
  return {
    make: words(first.get(TAGS.make)),
    model: words(first.get(TAGS.model)),
    lens: words(second.get(TAGS.lens)),
    focal:
      focal?.type === TYPES.rational
        ? ratio(view.getUint32(focal.at, little), view.getUint32(focal.at + 4, little))
        : 0,
    focal35: focal35?.type === TYPES.short ? view.getUint16(focal35.at, little) : 0,
    orientation:
      orientation?.type === TYPES.short
        ? { at: orientation.at, little, value: view.getUint16(orientation.at, little) }
        : null,
  };
}

/** @typedef {{type: number, count: number, at: number}} Entry at: where its value is */

/**
 * @param {DataView} view
 * @param {number} start
 * @param {number} at
 * @param {boolean} little
 * @returns {Map<number, Entry>} by tag
 */
function directory(view, start, at, little) {
  const entries = new Map();
  for (let index = 0; index < view.getUint16(at, little); index++) {
    const entry = at + 2 + 12 * index;
    const [type, count] = [view.getUint16(entry + 2, little), view.getUint32(entry + 4, little)];
    const fits = (SIZES[type] ?? 0) * count <= 4;
    entries.set(view.getUint16(entry, little), {
      type,
      count,
      at: fits ? entry + 8 : start + view.getUint32(entry + 8, little),
    });
  }
  return entries;
}

/** @param {number} a @param {number} b */
const ratio = (a, b) => (b > 0 ? Math.round((1000 * a) / b) / 1000 : 0);

/** @param {DataView} view @param {number} at @param {number} length */
function text(view, at, length) {
  return String.fromCharCode(...new Uint8Array(view.buffer, view.byteOffset + at, Math.min(length, 200)));
}

/**
 * The same file with the sensor's own rows and columns: browsers turn photographs upright, and a turned one has other
 * intrinsics.
 * @param {ArrayBuffer} file @param {Exif} exif of it
 * @returns {ArrayBuffer}
 */
export function unturned(file, { orientation }) {
  if (!orientation || orientation.value === 1) return file;
  const copy = file.slice(0);
  new DataView(copy).setUint16(orientation.at, 1, orientation.little);
  return copy;
}

/**
 * A camera's name as one would say it: "Canon EOS R6, RF24-70mm F2.8 L IS USM".
 * @param {Exif} exif
 * @returns {string} "" where nothing is known
 */
export function cameraName({ make, model, lens }) {
  const brand = make.split(/[\s,]/)[0];
  const body = model.toLowerCase().startsWith(brand.toLowerCase()) ? model : [make, model].filter(Boolean).join(" ");
  return [body, lens].filter(Boolean).join(", ").slice(0, 128);
}
