import assert from "node:assert/strict";
import { test } from "node:test";
import { splitOpenCV } from "../../infra/web_build/vendor.mjs";

// The smallest module there is, written as the package writes its own: each byte turned into a character.
const BYTES = [0x00, 0x61, 0x73, 0x6d, 1, 0, 0, 0];
const DECODER = "function binaryDecode(bin){for(var i=0,l=bin.length,o=new Uint8Array(l),c;i<l;++i){c=bin.charCodeAt(i);o[i]=~c>>8&c}return o}";
const source = (literal) => `async function cv(){${DECODER}function findWasmBinary(){return binaryDecode('${literal}')}function after(){}}export default cv;`;

test("module and WebAssembly are taken apart at the literal", () => {
  const { module, wasm } = splitOpenCV(source("\\0asm\\x01\\0\\0\\0"));
  assert.deepEqual([...wasm], BYTES);
  assert.match(module, /function findWasmBinary\(\)\{return null\}function after\(\)\{\}/);
});

test("a package that is laid out differently is refused, not guessed at", () => {
  assert.throws(() => splitOpenCV("export default 1"), /laid out/);
  assert.throws(() => splitOpenCV(source("no wasm")), /no valid WebAssembly/);
});
