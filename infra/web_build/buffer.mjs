// Node's Buffer, which A-Frame's loader of fonts takes to be everywhere.
export { Buffer } from "buffer/index.js";
