// Serves a folder as the edge does: HTTP/2, compressed by Brotli, a page for a folder.
//
//     node serve.mjs <folder> <key.pem> <certificate.pem> <service>     prints its port; `/v1/` is the service's
import { existsSync, readFileSync, statSync } from "node:fs";
import { createSecureServer } from "node:http2";
import { brotliCompressSync, constants } from "node:zlib";

const [folder, key, certificate, service] = process.argv.slice(2);
const TYPES = {
  html: "text/html; charset=utf-8",
  js: "text/javascript",
  css: "text/css",
  json: "application/json",
  svg: "image/svg+xml",
  woff2: "font/woff2",
  wasm: "application/wasm",
  webp: "image/webp",
};
const compressed = new Map();

const server = createSecureServer({ key: readFileSync(key), cert: readFileSync(certificate), allowHTTP1: true });
server.on("stream", (stream, headers) => {
  const path = new URL(String(headers[":path"]), "https://x").pathname;
  if (path.startsWith("/v1/")) return void forward(stream, headers);
  const file = `${folder}${path}${path.endsWith("/") ? "index.html" : ""}`;
  if (!existsSync(file) || !statSync(file).isFile()) {
    stream.respond({ ":status": 404 });
    stream.end();
    return;
  }
  const suffix = file.split(".").pop() ?? "";
  const packed = !["woff2", "webp"].includes(suffix);
  if (!compressed.has(file)) {
    const content = readFileSync(file);
    compressed.set(
      file,
      packed ? brotliCompressSync(content, { params: { [constants.BROTLI_PARAM_QUALITY]: 5 } }) : content,
    );
  }
  stream.respond({
    ":status": 200,
    "content-type": TYPES[suffix] ?? "application/octet-stream",
    "cache-control": "public, max-age=0",
    ...(packed ? { "content-encoding": "br" } : {}),
  });
  stream.end(compressed.get(file));
});
/** @param {import("node:http2").ServerHttp2Stream} stream @param {import("node:http2").IncomingHttpHeaders} headers */
async function forward(stream, headers) {
  const body = [];
  for await (const chunk of stream) body.push(chunk);
  const sent = ["authorization", "content-type", "accept"]
    .filter((name) => headers[name])
    .map((name) => [name, String(headers[name])]);
  const response = await fetch(service + headers[":path"], {
    method: headers[":method"],
    headers: sent,
    redirect: "manual",
    ...(body.length ? { body: Buffer.concat(body) } : {}),
  });
  const content = Buffer.from(await response.arrayBuffer());
  if (stream.destroyed) return;
  stream.respond({ ":status": response.status, "content-type": response.headers.get("content-type") ?? "text/plain" });
  stream.end(content);
}

server.listen(0, "127.0.0.1", () => console.log(server.address().port));
