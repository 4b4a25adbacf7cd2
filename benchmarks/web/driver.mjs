// Times one viewer on one scene and prints one JSON object.
//
//     node driver.mjs PEER --scene 200k --scenes DIR --picture OUT.png --chromium PATH
//                     [--frames 8] [--runs 3] [--warm 3]
//
// PEER is a file of pages/.  Needs a display (Xvfb will do) for Chromium's own EGL.

import { build } from "esbuild";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import puppeteer from "puppeteer-core";
import { serve } from "./server.mjs";

const HERE = dirname(fileURLToPath(import.meta.url));
const PACKAGES = {
  playcanvas: "playcanvas",
  gaussiansplats3d: "@mkkellogg/gaussian-splats-3d",
  spark: "@sparkjsdev/spark",
};
const TIMEOUT_MS = 280_000;

const FLAGS = [
  "--use-angle=gl-egl", // the system's Mesa, not the browser's own SwiftShader
  "--ignore-gpu-blocklist",
  "--disable-gpu-sandbox",
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--no-default-browser-check",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--disable-extensions",
  "--disable-gpu-watchdog", // a software frame may take seconds
  "--disable-background-timer-throttling",
  "--disable-renderer-backgrounding",
  "--disable-backgrounding-occluded-windows",
  "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", // nothing leaves the machine
  "--force-device-scale-factor=1",
  "--window-size=1280,800",
];

function readOptions() {
  const string = (fallback) => ({ type: "string", default: fallback });
  const { values, positionals } = parseArgs({
    allowPositionals: true,
    options: {
      scene: string("200k"),
      scenes: string("."),
      picture: string(""),
      chromium: string("/usr/bin/chromium"),
      frames: string("8"),
      runs: string("3"),
      warm: string("3"),
    },
  });
  if (!(positionals[0] in PACKAGES)) throw new Error(`peer is one of ${Object.keys(PACKAGES)}`);
  return { ...values, peer: positionals[0] };
}

async function bundle(peer) {
  const built = await build({
    entryPoints: [join(HERE, "pages", `${peer}.mjs`)],
    bundle: true,
    format: "esm",
    minify: true,
    write: false,
    logLevel: "error",
    nodePaths: [join(HERE, "node_modules")],
  });
  return built.outputFiles[0].text;
}

async function version(peer) {
  const manifest = join(HERE, "node_modules", PACKAGES[peer], "package.json");
  return JSON.parse(await readFile(manifest, "utf8")).version;
}

async function time(browser, url, options) {
  const page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 720, deviceScaleFactor: 1 });
  page.on("pageerror", (error) => process.stderr.write(`page: ${error.message}\n`));
  page.on("console", (message) => process.stderr.write(`console: ${message.text().slice(0, 500)}\n`));
  await page.goto(url, { timeout: TIMEOUT_MS });
  await page.waitForFunction("window.timeViewer !== undefined", { timeout: 60_000 });
  const plan = { scene: options.scene };
  for (const key of ["frames", "runs", "warm"]) plan[key] = Number(options[key]);
  return page.evaluate((plan) => window.timeViewer(plan), plan);
}

async function main() {
  const options = readOptions();
  const server = await serve(await bundle(options.peer), options.scenes);
  const profile = await mkdtemp(join(tmpdir(), "peers-profile-"));
  let browser;
  try {
    browser = await puppeteer.launch({
      executablePath: options.chromium,
      headless: false,
      userDataDir: profile,
      protocolTimeout: TIMEOUT_MS,
      args: FLAGS,
    });
    const { picture, ...record } = await time(browser, server.url, options);
    if (options.picture) await writeFile(options.picture, Buffer.from(picture.split(",")[1], "base64"));
    const versions = { version: await version(options.peer), browser: await browser.version() };
    process.stdout.write(`${JSON.stringify({ ...versions, ...record })}\n`);
  } finally {
    await browser?.close();
    server.close();
    await rm(profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  }
}

await main();
