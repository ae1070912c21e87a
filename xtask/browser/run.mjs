// Opens the page on each backend, fails on errors of page or driver, and saves the picture as PNG.
import { createServer } from "node:http";
import { readFile, writeFile, mkdir } from "node:fs/promises";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";

const web = "target/web", out = "target/browser";
await mkdir(out, { recursive: true });
const require = createRequire(join(process.cwd(), out, "package.json"));
const { chromium } = require("playwright-core");
const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
const server = createServer(async (request, response) => {
  try {
    const path = normalize(new URL(request.url, "http://localhost").pathname);
    if (path === "/favicon.ico") return response.writeHead(204).end();
    const bytes = await readFile(join(web, path === "/" ? "index.html" : path));
    response.writeHead(200, { "content-type": types[extname(path === "/" ? ".html" : path)] ?? (path === "/" ? "text/html" : "application/octet-stream") }).end(bytes);
  } catch { response.writeHead(404).end(); }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const origin = `http://127.0.0.1:${server.address().port}`;

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  headless: true,
  args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader",
    "--use-vulkan=swiftshader", "--enable-features=Vulkan"],
});
let failed = 0;
for (const backend of ["webgpu", "webgl"]) {
  const faults = [];
  const page = await browser.newPage({ viewport: { width: 400, height: 300 } });
  page.on("console", (line) => { if (/INVALID_/.test(line.text()) || line.type() === "error") faults.push(line.text()); });
  page.on("pageerror", (error) => faults.push(String(error)));
  try {
    await page.goto(`${origin}/?backend=${backend}&size=256x256`);
    await page.waitForFunction(() => window.manypass?.ready || window.manypass?.error, null, { timeout: 60000 });
    const result = await page.evaluate(async () => {
      if (window.manypass.error) throw new Error(window.manypass.error);
      const viewer = window.manypass.viewer;
      viewer.render(90, 0, 0);
      const pixels = await viewer.pixels();
      const info = viewer.info();
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [info.width, info.height];
      canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(pixels), info.width, info.height), 0, 0);
      return { info, first: [...pixels.slice(0, 4)], png: canvas.toDataURL("image/png").split(",")[1] };
    });
    await writeFile(join(out, `clear-${backend}.png`), Buffer.from(result.png, "base64"));
    if (result.info.backend !== backend) faults.push(`asked for ${backend}, got ${result.info.backend}`);
    console.log(`    ${backend}: ${JSON.stringify(result.info)}, first pixel ${result.first}`);
  } catch (error) { faults.push(String(error)); }
  for (const fault of faults) console.error(`error: ${backend}: ${fault}`);
  failed += faults.length > 0;
  await page.close();
}
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
