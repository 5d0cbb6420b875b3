// The pages' build of OpenCV, under node.
import { readFileSync } from "node:fs";
import createOpenCV from "../../infra/web_build/detector/opencv.js";

const wasm = new WebAssembly.Module(
  readFileSync(new URL("../../infra/web_build/detector/opencv.wasm", import.meta.url)),
);
export const cv = await createOpenCV({
  instantiateWasm(imports, done) {
    done(new WebAssembly.Instance(wasm, imports), wasm);
    return {};
  },
});
