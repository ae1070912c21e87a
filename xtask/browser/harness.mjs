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

/** An empty page whose errors, and the driver's, end up in `faults`. WebGL's errors reach only the console. */
export async function watched(browser, viewport, faults) {
  const page = await browser.newPage({ viewport });
  page.on("console", (line) => {
    if (/INVALID_|GL_|Uncaptured|validation/i.test(line.text().replace(/GPU stall due to ReadPixels/, "")) && !/Performance|performance/.test(line.text())
      || line.type() === "error") faults.push(`console: ${line.text()}`);
  });
  page.on("pageerror", (error) => faults.push(`page: ${error}`));
  return page;
}

/** The page of the package, once it is ready or says why it is not. */
export async function open(browser, origin, address, viewport, faults) {
  const page = await watched(browser, viewport, faults);
  await page.goto(`${origin}/?${new URLSearchParams(address)}`);
  await page.waitForFunction(() => window.manypass?.ready || window.manypass?.error, null, { timeout: 300000 });
  return page;
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
