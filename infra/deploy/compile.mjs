// node infra/deploy/compile.mjs FOLDER: byte-compiles a folder for Lambda's Python where no such Python is installed.
// What is compiled depends on Python's version alone, not on the machine: CPython 3.13 as WebAssembly writes the same.
// Dates do not survive packing, so nothing compares what is compiled to its source.
import { resolve } from "node:path";
import { loadPyodide } from "pyodide";

const python = await loadPyodide();
python.mountNodeFS("/compiled", resolve(process.argv[2]));
const complaint = python.runPython(`
import compileall, py_compile, sys
complaint = "" if sys.version_info[:2] == (3, 13) else f"this is Python {sys.version}"
kept = py_compile.PycInvalidationMode.UNCHECKED_HASH
if not complaint and not compileall.compile_dir("/compiled", quiet=1, invalidation_mode=kept):
    complaint = "some modules cannot be compiled"
complaint
`);
if (complaint) {
  console.error(`calibDB: ${complaint}`);
  process.exit(1);
}
