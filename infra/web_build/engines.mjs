// The engines of web/examples/, each in one file with nothing in it but what its example uses.
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const modules = fileURLToPath(new URL("../../node_modules/", import.meta.url));
const buffer = fileURLToPath(new URL("./buffer.mjs", import.meta.url));

const ENGINES = {
  three: `
    export { BoxGeometry, Group, Mesh, MeshBasicMaterial, PerspectiveCamera, PlaneGeometry, Scene } from "three";
    export { WebGLRenderer } from "three";`,
  "@babylonjs/core": `
    export { FreeCamera } from "@babylonjs/core/Cameras/freeCamera.js";
    export { Engine } from "@babylonjs/core/Engines/engine.js";
    export { Color3, Color4 } from "@babylonjs/core/Maths/math.color.js";
    export { HemisphericLight } from "@babylonjs/core/Lights/hemisphericLight.js";
    export { Matrix, Quaternion, Vector3 } from "@babylonjs/core/Maths/math.vector.js";
    export { CreateBox } from "@babylonjs/core/Meshes/Builders/boxBuilder.js";
    export { CreatePlane } from "@babylonjs/core/Meshes/Builders/planeBuilder.js";
    export { TransformNode } from "@babylonjs/core/Meshes/transformNode.js";
    export { StandardMaterial } from "@babylonjs/core/Materials/standardMaterial.js";
    export { Scene } from "@babylonjs/core/scene.js";`,
  // From its source: what npm has built puts its styles into the page, where our policy refuses them.
  aframe: 'import "./aframe/src/index.js"; export default globalThis.AFRAME;',
};
const NAMES = { three: "three", "@babylonjs/core": "babylon", aframe: "aframe" };

/** A-Frame's text makes its getters from strings, which our policy refuses, too. */
const withoutStrings = {
  name: "without strings",
  setup({ onLoad }) {
    onLoad({ filter: /layout-bmfont-text[\\/]index\.js$/ }, ({ path }) => {
      const source = readFileSync(path, "utf8");
      const contents = source.replace(
        /return \(?new Function\(\[.*?\]\.join\('\\n'\)\)\)?\(\)/s,
        "return function () { return this['_' + name]; }",
      );
      if (contents === source || contents.includes("new Function"))
        throw new Error("layout-bmfont-text is not written as expected");
      return { contents };
    });
  },
};

/** Bundles what a few lines of code export. @param {import("esbuild").BuildOptions} [options] others than the usual */
export const bundle = (stdin, outfile, options = {}) =>
  build({
    stdin,
    outfile,
    bundle: true,
    minify: true,
    format: "esm",
    define: { "process.env.NODE_ENV": '"production"', INSPECTOR_VERSION: '""' },
    logLevel: "error",
    ...options,
  });

export async function vendorEngines(folder) {
  const outdir = `${folder}engines`;
  mkdirSync(outdir, { recursive: true });
  for (const [name, contents] of Object.entries(ENGINES)) {
    const file = NAMES[name];
    await bundle({ contents, resolveDir: modules, sourcefile: `${file}.js` }, `${outdir}/${file}.js`, {
      plugins: [withoutStrings],
      inject: file === "aframe" ? [buffer] : [],
    });
    const names = [...contents.matchAll(/export \{([^}]*)\}/g)].flatMap(([, list]) => list.split(","));
    const types =
      names.map((each) => `export const ${each.trim()}: any;\n`).join("") ||
      "declare const engine: any;\nexport default engine;\n";
    writeFileSync(`${outdir}/${file}.d.ts`, types);
    copyFileSync(
      `${modules}${name}/${name === "@babylonjs/core" ? "license.md" : "LICENSE"}`,
      `${outdir}/${file}.LICENSE`,
    );
  }
}
