// Calibration files that are neither JSON nor tables: XML, YAML, ROS's .ini. What they are, and the camera matrix in
// them. Pure.

const NAMES = [
  String.raw`cam(?:era)?[ _-]?mat(?:rix)?|camera[ _-]?intrinsics?|intrinsic[_-]?matrix|intrinsics?`,
  String.raw`projection_parameters|mtx|K|M\d|fx|fc|(?:camera\d?\.)fx`,
].join("|");
const MEMBER = new RegExp(
  String.raw`^[ \t]*(?:<(?:${NAMES})\b|["']?(?:${NAMES})\d?["']?[ \t]*(?:[:=]|\r?$)|cam\d+[ \t]*:)`,
  "gim",
);
const MAX_MENTIONS = 100; // that are looked at
const NEAR = 800; // characters after a name in which its numbers stand
const NUMBER = /[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?/gi;

/**
 * The camera matrix in a text, null where it has a camera but no matrix that is found, undefined where it has no
 * camera.
 * @param {string} content @returns {number[][] | null | undefined}
 */
export function cameraIn(content) {
  /** @type {null | undefined} */
  let found;
  let count = 0;
  for (const match of content.matchAll(MEMBER)) {
    if (count++ >= MAX_MENTIONS) break;
    found = null;
    const end = match.index + match[0].length;
    const matrix = square(numbersIn(content.slice(end, end + NEAR)));
    if (matrix) return matrix;
  }
  return found;
}

/** The first numbers of a text, without those that say how many there are. @param {string} text */
function numbersIn(text) {
  const plain = text
    .replace(/^[^\n<>]{0,80}>/, " ")
    .replace(/<(rows|cols|dt)>[^<]{0,20}<\/\1>/g, " ")
    .replace(/<[^<>]{0,80}>/g, " ")
    .replace(/\b(?:rows|cols|dt)\b\s*:\s*\w+/g, " ");
  return (plain.match(NUMBER) ?? []).slice(0, 9).map(Number);
}

/** Nine numbers as a camera matrix, null where they are none. @param {number[]} values @returns {number[][] | null} */
export function square(values) {
  const [fx, , , zero, fy, , left, middle, one] = values;
  if (
    values.length !== 9 ||
    !values.every(Number.isFinite) ||
    !(fx > 0 && fy > 0) ||
    zero !== 0 ||
    left !== 0 ||
    middle !== 0 ||
    one !== 1
  )
    return null;
  return [values.slice(0, 3), values.slice(3, 6), values.slice(6)];
}

/** Text of a file in UTF-8 or UTF-16, whichever it is. @param {ArrayBuffer} bytes */
export function decode(bytes) {
  const [first, second] = new Uint8Array(bytes, 0, Math.min(2, bytes.byteLength));
  const wide =
    (first === 0xff && second === 0xfe) || (second === 0 && first !== 0)
      ? "utf-16le"
      : (first === 0xfe && second === 0xff) || (first === 0 && second !== 0)
        ? "utf-16be"
        : "utf-8";
  return new TextDecoder(wide).decode(bytes);
}
