// Trouble that the capture page suspects in grey pictures.
//
//     node suspect.mjs < {pictures: [{path, size: [w, h]}], board}     # path: of w x h bytes
//
// Prints [{ids, points, suspected}] of each picture.
import { readFileSync } from "node:fs";
import createOpenCV from "../../infra/web_build/detector/opencv.js";
import { HEALTHY, diagnose } from "../../web/lib/capture/diagnosis.js";
import { createCharucoFinder } from "../../web/lib/charuco-finder.js";

const { pictures, board } = JSON.parse(readFileSync(0, "utf8"));
const wasm = new WebAssembly.Module(
  readFileSync(new URL("../../infra/web_build/detector/opencv.wasm", import.meta.url)),
);
const cv = await createOpenCV({
  instantiateWasm(imports, done) {
    done(new WebAssembly.Instance(wasm, imports), wasm);
    return {};
  },
});
const finder = createCharucoFinder(cv, board);
const answers = pictures.map(({ path, size: [width, height] }) => {
  const found = finder.find({ width, height, data: new Uint8Array(readFileSync(path)) }, true);
  const { suspected } = diagnose(HEALTHY, { ...found, size: [width, height], elapsed: 0, memory: 0 }, 0, 0);
  return { ids: found.ids, points: found.points, suspected };
});
process.stdout.write(JSON.stringify(answers));
