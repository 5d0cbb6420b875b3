// Boards that people own or are sold, by the names under which they know them. Pure.
import { DEFAULT_BOARD, DEFAULT_TAG_SPACING } from "./board.js";

/** @typedef {import("./board.js").SentBoard} SentBoard */

/** @type {{id: string, name: string, board: SentBoard}[]} name: a proper name, the same in every language */
export const PRESETS = [
  { id: "calibdb", name: "calibDB", board: DEFAULT_BOARD },
  {
    id: "photonvision",
    name: "PhotonVision 8 × 8",
    board: { squares: [8, 8], marker_ratio: 0.75, dictionary: "DICT_4X4_1000", legacy: false },
  },
  {
    id: "calibio",
    name: "calib.io 14 × 9",
    board: { squares: [14, 9], marker_ratio: 0.75, dictionary: "DICT_5X5_100", legacy: false },
  },
  {
    id: "opencv_charuco",
    name: "OpenCV ChArUco 5 × 7",
    board: { squares: [5, 7], marker_ratio: 0.5, dictionary: "DICT_6X6_250", legacy: false },
  },
  {
    id: "opencv_chessboard",
    name: "OpenCV 10 × 7",
    board: { kind: "chessboard", squares: [10, 7], marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false },
  },
  {
    id: "kalibr",
    name: "Kalibr AprilGrid 6 × 6",
    board: {
      kind: "aprilgrid",
      squares: [6, 6],
      marker_ratio: 0.65,
      dictionary: "DICT_APRILTAG_36h11",
      legacy: false,
      tag_spacing: DEFAULT_TAG_SPACING,
    },
  },
];
