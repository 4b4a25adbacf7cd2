// A server of one page, its bundle and the scene files, on the loopback interface.
//
// Cross-origin isolation gives the page SharedArrayBuffer, which the sort workers of some viewers
// want, and a clock of 5 us.

import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { join } from "node:path";

const ISOLATED = {
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Cache-Control": "no-store",
};
const PAGE = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
<style>html, body { margin: 0; background: #000; overflow: hidden } canvas { display: block }</style>
<body><script type="module" src="/page.js"></script></body>`;

function send(response, type, body) {
  response.writeHead(200, { ...ISOLATED, "Content-Type": type });
  response.end(body);
}

async function sendFile(response, path) {
  const { size } = await stat(path);
  const headers = { ...ISOLATED, "Content-Type": "application/octet-stream", "Content-Length": size };
  response.writeHead(200, headers);
  createReadStream(path).pipe(response);
}

// Serves until `close`; resolves to { url, close }.
export function serve(script, sceneFolder) {
  const server = createServer((request, response) => {
    const name = new URL(request.url, "http://localhost").pathname;
    if (name === "/") return send(response, "text/html", PAGE);
    if (name === "/page.js") return send(response, "text/javascript", script);
    const file = /^\/scenes\/([\w-]+\.(?:ply|splat|json))$/.exec(name);
    const missing = () => response.writeHead(404, ISOLATED).end();
    return file ? sendFile(response, join(sceneFolder, file[1])).catch(missing) : missing();
  });
  return new Promise((resolve) => {
    server.listen(0, "127.0.0.1", () => {
      const url = `http://127.0.0.1:${server.address().port}/`;
      resolve({ url, close: () => (server.closeAllConnections(), server.close()) });
    });
  });
}
