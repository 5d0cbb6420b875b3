// Corners and markers that the pages' detector finds in grey pictures.
//
//     node detect.mjs < {pictures: [{path, size: [w, h]}], board: {squares, marker_ratio, dictionary}}     # path: of w
// x h bytes
//
// Prints [{ids, points, markers}] of each picture: markers by id, with their corners.
import { readFileSync } from "node:fs";
import { MarkerDetector } from "../../web/lib/marker-detector.js";
import { cv } from "./opencv.mjs";

const { pictures, board } = JSON.parse(readFileSync(0, "utf8"));
const dictionary = cv.getPredefinedDictionary(cv[board.dictionary]);
const charuco = new cv.aruco_CharucoBoard(
  new cv.Size(...board.squares),
  1,
  board.marker_ratio,
  dictionary,
  new cv.Mat(),
);
const detector = new cv.aruco_CharucoDetector(
  charuco,
  new cv.aruco_CharucoParameters(),
  new cv.aruco_DetectorParameters(),
  new cv.aruco_RefineParameters(10, 3, true),
);
const tags = new MarkerDetector(cv, board.dictionary);

process.stdout.write(
  JSON.stringify(
    pictures.map(({ path, size: [width, height] }) => {
      const data = new Uint8Array(readFileSync(path));
      const image = new cv.Mat(height, width, cv.CV_8UC1);
      image.data.set(data);
      const [corners, ids] = [new cv.Mat(), new cv.Mat()];
      detector.detectBoard(image, corners, ids, new cv.MatVector(), new cv.Mat());
      const found = ids.rows * ids.cols > 0 ? [...ids.data32S] : [];
      image.delete();
      const markers = tags.find({ width, height, data }).sort((a, b) => a.id - b.id);
      return { ids: found, points: found.map((_, n) => [corners.data32F[2 * n], corners.data32F[2 * n + 1]]), markers };
    }),
  ),
);
