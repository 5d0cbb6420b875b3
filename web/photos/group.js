// Photographs that one calibration can come from: of one camera and lens, at one focal length and size. Pure.

/**
 * @typedef {object} Found a picture in which the board was looked for
 * @property {string} name
 * @property {string} camera
 * @property {number} focal
 * @property {number} [focal35] its equivalent on 35 mm film, mm; 0
 * @property {"photographs" | "video"} kind
 * @property {[number, number]} size
 * @property {number[]} ids
 * @property {number[][]} points
 * @property {[number, number][] | null} outline
 *
 * @typedef {{id: string, camera: string, focal: number, kind: Found["kind"], size: [number, number], members:
 *   number[]}} Group members: numbers of the pictures that show the board
 */

export const MIN_VIEW_CORNERS = 6; // corners of a view

/** @template {Found} F @param {F} picture */
export const isView = ({ ids }) => ids.length >= MIN_VIEW_CORNERS;

/** @param {Found[]} pictures @returns {Group[]} that with most views first; only those with any */
export function groups(pictures) {
  /** @type {Map<string, Group>} */
  const found = new Map();
  pictures.forEach((picture, index) => {
    if (!isView(picture)) return;
    const { camera, focal, kind, size } = picture;
    const id = JSON.stringify([camera, focal, kind, size]);
    const group = found.get(id) ?? { id, camera, focal, kind, size, members: [] };
    group.members.push(index);
    found.set(id, group);
  });
  return [...found.values()].sort((a, b) => b.members.length - a.members.length);
}
