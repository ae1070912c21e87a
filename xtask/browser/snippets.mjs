// JavaScript of README.md and docs: each snippet is run in a page of its own, which has a canvas.
import { readdir, readFile } from "node:fs/promises";
import { test, watched } from "./harness.mjs";

/** What is served in place of models and images of the user's. */
const STAND_INS = [["**/*.glb", "xtask/browser/boxes.gltf"], ["**/*.png", "docs/examples/compass.png"]];
/** What a snippet finds that has no viewer of its own: one that shows a model, and the bytes of an image. */
const BEFORE = `
  import init, { create } from "./manypass_web.js";
  await init();
  const viewer = await create(canvas);
  viewer.load(new Uint8Array(await (await fetch("model.glb")).arrayBuffer()));
  const bytes = new Uint8Array(await (await fetch("logo.png")).arrayBuffer());
  await viewer.render();
  await look(viewer.info().backend);
`;
/** A page that takes longer hangs. */
const LIMIT_MS = 30000;

/** The snippets with their places. */
async function snippets() {
  const names = (await readdir("docs", { recursive: true })).filter((name) => name.endsWith(".md")).sort();
  const found = [];
  for (const page of ["README.md", ...names.map((name) => `docs/${name}`)]) {
    const text = await readFile(page, "utf8");
    for (const { index, 1: language, 2: code } of text.matchAll(/^```(js|html)\n(.*?)^```/gms)) {
      found.push({ place: `${page}:${text.slice(0, index).split("\n").length + 1}`, language, code });
    }
  }
  return found;
}

/** A page with the snippet. It tells when it has ended, and has itself looked at: at the end, or before it disposes of the viewer. */
function pageOf({ language, code }) {
  if (language === "html") return `<!doctype html><canvas id="canvas" hidden></canvas>${code}`;
  const hasViewer = /\bviewer = /.test(code);
  const looked = code.replace(/^( *)viewer\.dispose\(\)/m, "$1await look(viewer.info().backend);\n$&");
  const after = looked === code ? "await viewer.render();\nawait look(viewer.info().backend);" : "";
  return `<!doctype html><canvas id="canvas" width="160" height="90"></canvas>
    <script type="module">${hasViewer ? "" : BEFORE}${looked}\n${after}\nwindow.hasEnded = true;</script>`;
}

/** How many colours a PNG has. */
async function colours(page, png) {
  return page.evaluate(async (text) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${text}`)).blob());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer)).size;
  }, png.toString("base64"));
}

/** Runs a snippet: it ends without an error and shows something, which is another picture than before it. */
async function run(browser, origin, backend, snippet, faults) {
  const page = await watched(browser, { width: 160, height: 90 }, faults);
  try {
    const pictures = [];
    await page.exposeFunction("look", async (bound) => {
      if (bound !== backend) faults.push(`the viewer draws with ${bound}`);
      pictures.push(await page.locator("#canvas").screenshot());
    });
    if (backend === "webgl") await page.addInitScript(() => Object.defineProperty(navigator, "gpu", { value: undefined }));
    for (const [pattern, path] of STAND_INS) await page.route(pattern, (route) => route.fulfill({ path }));
    await page.route("**/snippet.html", (route) => route.fulfill({ contentType: "text/html", body: pageOf(snippet) }));
    const failed = page.waitForEvent("pageerror", { timeout: LIMIT_MS }).catch(() => {});
    await page.goto(`${origin}/snippet.html`);
    if (snippet.language === "html") return await page.waitForLoadState("networkidle");
    await Promise.race([failed, page.waitForFunction(() => window.hasEnded, null, { timeout: LIMIT_MS })]);
    if (faults.length) return;
    const last = pictures.at(-1);
    const count = last ? await colours(page, last) : 0;
    if (count < 16) faults.push(`the canvas has ${count} colours`);
    if (pictures.length > 1 && last.equals(pictures[0])) faults.push("the snippet changes nothing in the picture");
  } finally {
    await page.close();
  }
}

/** All snippets of the pages, but for those that load a script from the network. */
export const withSnippets = (browser, origin, backend) => test(`docs snippets on ${backend}`, async (faults) => {
  const started = performance.now();
  const all = await snippets();
  const local = all.filter(({ code }) => !/\bsrc="https?:/.test(code));
  for (const { place } of all.filter((snippet) => !local.includes(snippet))) {
    console.log(`    ${place} is not run: it loads a script from the network`);
  }
  if (local.length < 2) faults.push(`${local.length} snippets are found`);
  for (const snippet of local) {
    const own = [];
    await run(browser, origin, backend, snippet, own).catch((error) => own.push(String(error)));
    faults.push(...own.map((fault) => `${snippet.place}: ${fault}`));
  }
  console.log(`    docs snippets on ${backend}: ${local.length} in ${(performance.now() - started).toFixed(0)} ms`);
});
