// A board in words.
import { DEFAULT_TAG_SPACING, kindOf } from "./board.js";
import { formatSize, number, t } from "./i18n.js";

/** @typedef {import("./board.js").SentBoard} SentBoard */

/** A board in a few words: "ChArUco, 9 × 6 squares, DICT_4X4_50". @param {SentBoard} board */
export function boardWords(board) {
  const { squares, dictionary, marker_ratio: ratio, tag_spacing: spacing = DEFAULT_TAG_SPACING } = board;
  const words = t(`boards.words_${kindOf(board)}`, {
    size: formatSize(squares),
    dictionary,
    ratio: number(ratio, 2),
    spacing: number(spacing, 2),
  });
  return [
    words,
    ...(board.legacy ? [t("boards.words_legacy")] : []),
    ...(board.inverted ? [t("boards.words_inverted")] : []),
  ].join(", ");
}
