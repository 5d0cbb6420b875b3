// Trouble that the capture page suspects in grey pictures.
//
//     node suspect.mjs < {pictures: [{path, size: [w, h]}], board}     # path: of w x h bytes
//
// Prints [{ids, points, suspected}] of each picture.
import { readFileSync } from "node:fs";
import { HEALTHY, diagnose } from "../../web/lib/capture/sight.js";
import { createCharucoFinder } from "../../web/lib/charuco-finder.js";
import { cv } from "./opencv.mjs";

const { pictures, board } = JSON.parse(readFileSync(0, "utf8"));
const finder = createCharucoFinder(cv, board);
const answers = pictures.map(({ path, size: [width, height] }) => {
  const detection = finder.find({ width, height, data: new Uint8Array(readFileSync(path)) }, true);
  const { suspected } = diagnose(HEALTHY, { ...detection, size: [width, height], elapsed: 0, memory: 0 }, 0, 0);
  return { ids: detection.ids, points: detection.points, suspected };
});
process.stdout.write(JSON.stringify(answers));
