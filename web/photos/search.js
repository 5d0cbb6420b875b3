// Search for the board in files: picture by picture, and what could not be read.
import { observedOutline } from "../lib/board-outline.js";
import { t } from "../lib/i18n.js";
import { mark, thumbnail } from "./card.js";
import { UnreadableError, conversion, shots } from "./files.js";

/**
 * @import { Board } from "../lib/board.js"
 * @import { Detector } from "../lib/detector.js"
 * @import { Picture } from "./card.js"
 */

/**
 * @typedef {{onFile: (file: File, share: number) => void, onPicture: (picture: Picture, file: File) => void}} Listener
 *   onFile: with the share of all files that has been looked at, 0 to 1
 */

// ms for the board in one picture: they may have a hundred times the pixels of a frame
const DETECTION_TIMEOUT_MS = 120_000;

/**
 * Looks for the board in files.
 * @param {Detector} detector
 * @param {Board} board that it looks for
 * @param {File[]} files
 * @param {AbortSignal} signal
 * @param {Listener & {mirrored: boolean}} options mirrored: the pictures are, and are turned back
 * @returns {Promise<UnreadableError[]>} files that could not be read
 */
export async function search(detector, board, files, signal, { onFile, onPicture, mirrored }) {
  /** @type {UnreadableError[]} */
  const unreadable = [];
  for (const [index, file] of files.entries()) {
    onFile(file, index / files.length);
    try {
      for await (const shot of shots(file, signal, { mirrored })) {
        const picture = await find(detector, board, shot);
        if (signal.aborted) return unreadable;
        onPicture(picture, file);
        onFile(file, (index + shot.share) / files.length);
      }
    } catch (error) {
      if (!(error instanceof UnreadableError)) throw error;
      unreadable.push(error);
    }
    if (signal.aborted) break;
  }
  return unreadable;
}

/** Files that were not read: by name, and why. @param {UnreadableError[]} errors @returns {string[]} */
export function unreadableTexts(errors) {
  const codes = [...new Set(errors.map(({ code }) => code))];
  return codes.map((code) => {
    const names = errors.filter((each) => each.code === code).map(({ message }) => message);
    return t(`photos.unreadable_${code}`, { names: names.join(", "), command: conversion(names[0]) });
  });
}

/**
 * @param {Detector} detector
 * @param {Board} board
 * @param {import("./files.js").Shot} shot
 * @returns {Promise<Picture>}
 */
async function find(detector, board, { name, picture, camera, focal, focal35, kind }) {
  const small = thumbnail(picture);
  const { ids, points, size } = await detector.detect(picture, { full: true, timeout: DETECTION_TIMEOUT_MS });
  mark(small, points, size[0]);
  return {
    name,
    camera,
    focal,
    focal35,
    kind,
    size,
    ids,
    points,
    outline: observedOutline(board, { ids, points }),
    thumbnail: small,
  };
}
