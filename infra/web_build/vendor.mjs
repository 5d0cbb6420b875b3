// Puts third-party code where the pages load it from: web/vendor/, which git ignores and `make` rebuilds.
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { compile } from "json-schema-to-typescript";
import { bundle, vendorEngines } from "./engines.mjs";

const root = fileURLToPath(new URL("../..", import.meta.url));
const vendor = `${root}web/vendor/`;

/** The board detector: committed, since it is built by a compiler that `make` does not need (detector/build.sh). */
function vendorOpenCV() {
  const from = fileURLToPath(new URL("detector/", import.meta.url));
  mkdirSync(`${vendor}opencv`, { recursive: true });
  for (const name of ["opencv.js", "opencv.wasm", "LICENSE"]) copyFileSync(`${from}${name}`, `${vendor}opencv/${name}`);
  // Servers compress the file, so its Content-Length is no measure of how much is still to come.
  const { version, license, bytes } = JSON.parse(readFileSync(`${from}opencv.json`, "utf8"));
  writeFileSync(`${vendor}opencv/opencv.json`, JSON.stringify({ version, license, bytes }) + "\n");
  writeFileSync(
    `${vendor}opencv/opencv.d.ts`,
    "declare const factory: (options: object) => Promise<any>;\nexport default factory;\n",
  );
}

/**
 * OpenAPI 3.1's JSON Schema in the older dialect that json-schema-to-typescript reads well.
 * @param {any} node
 * @param {boolean} [named] is it a schema that keeps its title as its name?
 * @returns {any}
 */
function plainSchema(node, named = false) {
  if (Array.isArray(node)) return node.map((each) => plainSchema(each));
  if (node === null || typeof node !== "object") return node;
  if (node.$ref) return { $ref: node.$ref.replace("#/components/schemas/", "#/definitions/") };
  const { prefixItems, title, default: _, ...rest } = node;
  const each = (map) => Object.fromEntries(Object.entries(map).map(([key, value]) => [key, plainSchema(value)]));
  const plain = each(rest);
  if (rest.properties) plain.properties = each(rest.properties); // its keys are names, "title" among them
  if (named && title) plain.title = title;
  if (prefixItems) plain.items = plainSchema(prefixItems);
  return plain;
}

/** Two variable fonts, for text and for code: Latin, and Cyrillic that only those load who read it. */
function vendorFont() {
  mkdirSync(`${vendor}font`, { recursive: true });
  for (const [name, scripts] of Object.entries({ geologica: ["latin", "cyrillic"], "geist-mono": ["latin"] })) {
    const from = `${root}node_modules/@fontsource-variable/${name}/`;
    for (const script of scripts)
      copyFileSync(`${from}files/${name}-${script}-wght-normal.woff2`, `${vendor}font/${name}-${script}.woff2`);
    copyFileSync(`${from}LICENSE`, `${vendor}font/${name === "geologica" ? "" : `${name}.`}LICENSE`);
  }
}

/** The QR encoder. */
function vendorQr() {
  const from = `${root}node_modules/uqr/`;
  mkdirSync(`${vendor}uqr`, { recursive: true });
  copyFileSync(`${from}dist/index.mjs`, `${vendor}uqr/uqr.js`);
  copyFileSync(`${from}dist/index.d.ts`, `${vendor}uqr/uqr.d.ts`);
  copyFileSync(`${from}LICENSE`, `${vendor}uqr/LICENSE`);
}

/** The search of the documentation. */
async function vendorSearch() {
  const from = `${root}node_modules/minisearch/`;
  const contents = 'export { default as MiniSearch } from "minisearch";';
  await bundle({ contents, resolveDir: root }, `${vendor}minisearch/minisearch.js`);
  writeFileSync(
    `${vendor}minisearch/minisearch.d.ts`,
    `
    export class MiniSearch {
      constructor(options: { fields: string[]; storeFields: string[]; searchOptions: object });
      addAll(documents: readonly object[]): void;
      search(words: string): ({ id: number; terms: string[] } & Record<string, any>)[];
    }\n`,
  );
  copyFileSync(`${from}LICENSE.txt`, `${vendor}minisearch/LICENSE`);
}

/**
 * The parts of the WebXR polyfill that an own device needs: no headsets, no phones' lenses, no navigator that is
 * replaced unasked.
 */
async function vendorWebXR() {
  const from = `${root}node_modules/webxr-polyfill/`;
  const contents = `
      export { default as XRDevice } from "./src/devices/XRDevice.js";
      export { default as classes } from "./src/api/index.js";
      export { PRIVATE as SESSION } from "./src/api/XRSession.js";`;
  await bundle({ contents, resolveDir: from }, `${vendor}webxr/polyfill.js`);
  writeFileSync(
    `${vendor}webxr/polyfill.d.ts`,
    `
    type Device = EventTarget & {
      dispatchEvent(type: string, data: unknown): void;
      environmentBlendMode: string;
    };
    export const XRDevice: new (global: object) => Device;
    export const classes: Record<string, new (...parameters: any[]) => any>;
    export const SESSION: unique symbol;\n`,
  );
  copyFileSync(`${from}LICENSE`, `${vendor}webxr/LICENSE`);
}

function vendorFormats({ paths }) {
  const { parameters } = paths["/v1/calibrations/{id}"].get;
  const { schema } = parameters.find((/** @type {{name: string}} */ { name }) => name === "format");
  const banner = "// Made from openapi.json by infra/web_build/vendor.mjs.\n";
  writeFileSync(`${vendor}formats.js`, `${banner}export const FORMATS = ${JSON.stringify(schema.enum)};\n`);
  writeFileSync(`${vendor}formats.d.ts`, `${banner}export const FORMATS: string[];\n`);
}

/** Types of the API's bodies. */
async function vendorTypes({ components }) {
  const definitions = Object.fromEntries(
    Object.entries(components.schemas).map(([name, schema]) => [name, plainSchema(schema, true)]),
  );
  const types = await compile({ title: "Api", type: "object", definitions }, "Api", {
    bannerComment: "// Made from openapi.json by infra/web_build/vendor.mjs.",
    unreachableDefinitions: true,
    additionalProperties: false,
  });
  writeFileSync(`${vendor}api.d.ts`, types);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  rmSync(vendor, { recursive: true, force: true });
  mkdirSync(vendor, { recursive: true });
  vendorOpenCV();
  vendorFont();
  vendorQr();
  await vendorSearch();
  await vendorWebXR();
  await vendorEngines(vendor);
  const api = JSON.parse(readFileSync(`${root}.build/openapi.json`, "utf8"));
  vendorFormats(api);
  await vendorTypes(api);
}
