// A board in words, and the reasons why one cannot be.
import { DEFAULT_TAG_SPACING, kindOf } from "./board.js";
import { formatSize, number, t, onLanguage } from "./i18n.js";

/** @import { Problem, SentBoard } from "./board.js" */

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

/** Reason why a board cannot be. @param {Problem} problem */
export const reason = ({ code, values }) => t(`impossible.because_${code}`, values);

/**
 * Says on a page that the board its address asks for cannot be.
 * @param {HTMLElement} place
 * @param {Problem | null} problem
 */
export function showProblem(place, problem) {
  const say = () => {
    place.textContent = problem ? t("impossible.default_instead", { reason: reason(problem) }) : "";
  };
  place.hidden = problem === null;
  say();
  onLanguage(say);
}
