// Sentence about the board's shape that a fit has found. Pure.
import { language, rough, t } from "../i18n.js";

const MIN_SIGMAS = 2; // of a shape that is certain
const MAX_STRETCH = 0.01; // share of the length by which a printer may stretch a board

/**
 * Sentence about the board's shape, if it is certain and a printer may have made it.
 * @param {import("./numbers.js").BoardShape | null} [board]
 * @param {number | null} [length] mm, longer extent of the corners; null: the bend is a share of it
 * @returns {string[]}
 */
export function boardSentence(board, length = null) {
  if (!board || !(board.stretch < MAX_STRETCH)) return [];
  const deviations = [];
  if (board.sag > MIN_SIGMAS * board.sag_std)
    deviations.push(
      length === null
        ? t("result.board_bent", { sag: rough(100 * board.sag) })
        : t("result.board_bent_mm", { sag: rough(length * board.sag) }),
    );
  if (board.stretch > MIN_SIGMAS * board.stretch_std)
    deviations.push(t(`result.board_${board.stretch_kind ?? "stretched"}`, { stretch: rough(100 * board.stretch) }));
  if (!deviations.length) return [];
  return [t("result.board", { deviations: new Intl.ListFormat(language()).format(deviations) })];
}
