// What the browser tests stand on: a server for the web package and the models, browsers, and pages whose errors are counted.
import { createServer } from "node:http";
import { readFile, mkdir } from "node:fs/promises";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";

const web = "target/web";
/** Where pictures and values go. */
export const out = "target/browser";
await mkdir(out, { recursive: true });
const { chromium } = createRequire(join(process.cwd(), out, "package.json"))("playwright-core");

/** Serves the web package, and the files of `models` by their addresses. */
export async function serve(models) {
  const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
  const server = createServer(async (request, response) => {
    try {
      let path = normalize(new URL(request.url, "http://localhost").pathname);
      if (path === "/favicon.ico") return response.writeHead(204).end();
      if (path === "/") path = "/index.html";
      const bytes = await readFile(models.get(path) ?? join(web, path));
      response.writeHead(200, { "content-type": types[extname(path)] ?? "application/octet-stream" }).end(bytes);
    } catch { response.writeHead(404).end(); }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { origin: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

const launch = (more) => chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  headless: true,
  args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--force-color-profile=srgb", ...more],
});

/** Both APIs without a GPU. */
export const launchWithBoth = () => launch(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
  "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--use-vulkan=swiftshader", "--enable-features=Vulkan"]);
export const launchWithNeither = () =>
  launch(["--disable-gpu", "--disable-webgl", "--disable-3d-apis", "--disable-features=WebGPU"]);

/** An empty page whose errors, and the driver's, end up in what `sink` gives. WebGL's errors reach only the console. */
async function watchedBy(browser, viewport, sink) {
  const page = await browser.newPage({ viewport });
  page.on("console", (line) => {
    if (/INVALID_|GL_|Uncaptured|validation/i.test(line.text().replace(/GPU stall due to ReadPixels/, "")) && !/Performance|performance/.test(line.text())
      || line.type() === "error") sink().push(`console: ${line.text()}`);
  });
  page.on("pageerror", (error) => sink().push(`page: ${error}`));
  return page;
}

/** An empty page whose errors, and the driver's, end up in `faults`. */
export const watched = (browser, viewport, faults) => watchedBy(browser, viewport, () => faults);

const LIMIT_MS = 300000;
const isReady = () => window.manypass?.ready || window.manypass?.error;

/** The page of the package, once it is ready or says why it is not. */
export async function open(browser, origin, address, viewport, faults) {
  const page = await watched(browser, viewport, faults);
  await page.goto(`${origin}/?${new URLSearchParams(address)}`);
  await page.waitForFunction(isReady, null, { timeout: LIMIT_MS });
  return page;
}

/** So many addresses are opened in a page: with WebGL fewer than a browser has contexts. */
const OPENED_MAX = { webgpu: 24, webgl: 6 };

/**
 * A page of the browser that opens addresses one after the other, each as if it was the first: the page's script runs anew,
 * on another canvas and with a viewer of its own, while the module stays as the browser has optimised it. With WebGPU a small
 * viewer stays, too, so that all share its device, and what one of them compiles is there for the others.
 */
export class Tab {
  #backend;
  #browser;
  #origin;
  #page;
  #faults = [];
  #count = 0;

  constructor(browser, origin, backend) {
    this.#backend = backend;
    this.#browser = browser;
    this.#origin = origin;
  }

  /** As [`open`]; `release` ends it. */
  async open(address, viewport, faults) {
    this.#faults = faults;
    if (this.#count % OPENED_MAX[this.#backend] === 0) await this.close();
    this.#page ??= await this.#begin();
    const page = this.#page;
    try {
      await this.#show(page, address, viewport);
    } catch (error) {
      await this.close();
      throw error;
    }
    return page;
  }

  async #show(page, address, viewport) {
    await page.setViewportSize(viewport);
    await page.evaluate(async ([query, count]) => {
      const text = await (await fetch("index.html")).text();
      document.body.innerHTML = new DOMParser().parseFromString(text, "text/html").body.innerHTML;
      document.body.className = "";
      history.replaceState(null, "", `?${query}`);
      window.manypass = undefined;
      window.openedAt = performance.now();
      // A module of another address runs again; those that it imports do not.
      await import(new URL(`page.js?${count}`, location.href).href);
    }, [String(new URLSearchParams(address)), ++this.#count]);
    await page.waitForFunction(isReady, null, { timeout: LIMIT_MS });
  }

  /** Ends what was opened; after a fault the next one has another page. */
  async release() {
    if (this.#faults.length > 0) return this.close();
    await this.#page.evaluate(() => window.manypass.viewer.dispose());
  }

  /** Closes the page. */
  async close() {
    await this.#page?.close();
    this.#page = undefined;
  }

  async #begin() {
    const page = await watchedBy(this.#browser, { width: 16, height: 16 }, () => this.#faults);
    // The page's own script does not run in what is no page of its package.
    await page.route("**/empty.html", (route) => route.fulfill({ contentType: "text/html", body: "<!doctype html>" }));
    await page.goto(`${this.#origin}/empty.html`);
    await page.evaluate(async (backend) => {
      const head = new DOMParser().parseFromString(await (await fetch("index.html")).text(), "text/html").head;
      document.head.innerHTML = head.innerHTML;
      if (backend !== "webgpu") return;
      const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
      await init();
      const canvas = document.createElement("canvas");
      canvas.width = canvas.height = 16;
      window.kept = await create(canvas, backend);
    }, this.#backend);
    return page;
  }
}

let failed = 0;
/** How many tests failed so far. */
export const failures = () => failed;

/** Runs a test, which adds to the faults that it is given. */
export async function test(name, action) {
  const faults = [];
  try { await action(faults); } catch (error) { faults.push(String(error)); }
  for (const fault of new Set(faults)) console.error(`error: ${name}: ${fault}`);
  failed += faults.length > 0;
}
