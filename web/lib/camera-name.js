// Names of cameras and systems as people say them; labels and platforms are what browsers report.

const SYSTEMS = /** @type {[RegExp, string][]} */ ([
  // The first that is found: Android calls itself Linux, too, and iOS "like Mac OS X".
  [/\b(?:iphone|ipad|ipod|ios)\b/i, "iOS"],
  [/\bandroid\b/i, "Android"],
  [/\b(?:cros|chrome ?os|chromium ?os)\b/i, "ChromeOS"],
  [/\bwindows\b|\bwin(?:32|64)\b/i, "Windows"],
  [/\b(?:macintosh|macintel|mac ?os)\b/i, "macOS"],
  [/\b(?:linux|x11|[a-z]*bsd)\b/i, "Linux"],
]);
const NO_DEVICE = /^(?:linux|u|k|wv|mobile|tablet|unknown|rv:[\d.]*|[a-z]{2}[-_][a-z]{2}|android.*)$/i;

/**
 * "Linux" of "X11; Linux x86_64"; on Android with the device's model. What names no system stays as it is.
 * @param {string} platform
 */
export function systemName(platform) {
  const name = SYSTEMS.find(([pattern]) => pattern.test(platform))?.[1];
  if (name !== "Android") return name ?? platform;
  const device = platform
    .split(";")
    .map((part) => part.trim().replace(/ build\/.*$/i, ""))
    .find((part) => part && !NO_DEVICE.test(part));
  return device ? `${name} · ${device}` : name;
}

/**
 * A label without the USB id that Chromium appends, and that id.
 * @param {string} label
 * @returns {{name: string, usb: string | null}}
 */
export function splitLabel(label) {
  const [, name, usb] = /^(.*\S)\s*\(([0-9a-f]{4}:[0-9a-f]{4})\)\s*$/i.exec(label) ?? [];
  return name ? { name, usb: usb.toLowerCase() } : { name: label, usb: null };
}

/** Name of the virtual camera: it distinguishes its calibrations from those of real cameras. */
export const NAME = "calibDB virtual camera";

/** @param {string} label of a camera */
export const isVirtual = (label) => label.startsWith(NAME);
