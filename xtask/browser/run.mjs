// run.mjs CASES: opens the page with every model on each backend, fails on errors of page or driver, and saves into
// target/browser what the viewer reads back (NAME-BACKEND.png), what the canvas shows (NAME-BACKEND-canvas.png) and the
// exposure (NAME-BACKEND-exposure.json).
// CASES is JSON: [{ name, model: "demo:NAME" or a file, width, height, groups, options, effects }]; with `groups` eighths of
// the lights must add up to all of them; `options` and `effects` are what the viewer is given.
import { createServer } from "node:http";
import { readFile, writeFile, mkdir } from "node:fs/promises";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";

const cases = JSON.parse(process.argv[2]);
const web = "target/web", out = "target/browser";
await mkdir(out, { recursive: true });
const { chromium } = createRequire(join(process.cwd(), out, "package.json"))("playwright-core");

const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
const models = new Map(cases.map(({ name, model }) => [`/models/${name}.glb`, model]));
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
const origin = `http://127.0.0.1:${server.address().port}`;

const launch = (more) => chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  headless: true,
  args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--force-color-profile=srgb", ...more],
});
// Both APIs without a GPU.
const software = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-unsafe-webgpu",
  "--use-webgpu-adapter=swiftshader", "--use-vulkan=swiftshader", "--enable-features=Vulkan"];
let browser = await launch(software);
let failed = 0;

/** A page whose errors, and the driver's, end up in `faults`. WebGL's errors reach only the console. */
async function open(address, viewport, faults) {
  const page = await browser.newPage({ viewport });
  page.on("console", (line) => {
    if (/INVALID_|GL_|Uncaptured|validation/i.test(line.text().replace(/GPU stall due to ReadPixels/, "")) && !/Performance|performance/.test(line.text())
      || line.type() === "error") faults.push(`console: ${line.text()}`);
  });
  page.on("pageerror", (error) => faults.push(`page: ${error}`));
  await page.goto(`${origin}/?${new URLSearchParams(address)}`);
  await page.waitForFunction(() => window.manypass?.ready || window.manypass?.error, null, { timeout: 120000 });
  return page;
}

async function test(name, action) {
  const faults = [];
  try { await action(faults); } catch (error) { faults.push(String(error)); }
  for (const fault of new Set(faults)) console.error(`error: ${name}: ${fault}`);
  failed += faults.length > 0;
}

for (const { name, model, width, height, groups, options, effects } of cases) {
  for (const backend of ["webgpu", "webgl"]) {
    await test(`${name} on ${backend}`, async (faults) => {
      const address = { backend, size: `${width}x${height}`, model: model.startsWith("demo:") ? model : `models/${name}.glb` };
      const page = await open(address, { width, height }, faults);
      try {
        const result = await page.evaluate(async ({ groups, options, effects }) => {
          let groupRatio, offPixels;
          if (window.manypass.error) throw new Error(window.manypass.error);
          const viewer = window.manypass.viewer;
          const isChanged = Object.keys(options).length + effects.length > 0;
          if (isChanged) {
            viewer.configure(options);
            viewer.setEffects(effects);
            await window.manypass.draw();
          }
          let pixels = await viewer.pixels();
          // The pixels are there, so the frame is finished; the clock began with the navigation.
          const first = performance.now();
          // The page must show the same frame again when nothing changed.
          await window.manypass.draw();
          const again = await viewer.pixels();
          const second = performance.now() - first;
          // An effect that keeps what it made makes more of it.
          const isSame = pixels.every((value, index) => value === again[index]);
          if (effects.length && isSame) throw new Error("an effect with a history makes nothing of it");
          if (!effects.length && !isSame) throw new Error("the second frame differs from the first");
          if (groups) {
            const total = async (lightSubset) => {
              viewer.configure({ lightSubset });
              await window.manypass.draw();
              return (await viewer.radiance()).filter((_, i) => i % 4 < 3);
            };
            // What shines by itself is in every group; no scene has so many lights that the last of 65,536 is taken.
            const whole = await total(null), dark = await total([65535, 65536]);
            const sum = Float64Array.from(dark, (value) => -7 * value);
            for (let group = 0; group < 8; group++) (await total([group, 8])).forEach((value, i) => { sum[i] += value; });
            viewer.configure({ lightSubset: null });
            await window.manypass.draw();
            const all = (values) => values.reduce((a, b) => a + b, 0);
            groupRatio = all(sum) / all(whole);
            offPixels = whole.reduce((n, value, i) => n + (Math.abs(sum[i] - value) > 0.01 * Math.max(value, 0.01)), 0) / whole.length;
          }
          const info = viewer.info();
          const canvas = document.createElement("canvas");
          [canvas.width, canvas.height] = [info.width, info.height];
          canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(pixels), info.width, info.height), 0, 0);
          return { info, exposure: viewer.exposure(), first, second, groupRatio, offPixels, warnings: viewer.warnings(), png: canvas.toDataURL("image/png").split(",")[1] };
        }, { groups, options, effects });
        await writeFile(join(out, `${name}-${backend}.png`), Buffer.from(result.png, "base64"));
        await writeFile(join(out, `${name}-${backend}-exposure.json`), JSON.stringify(result.exposure));
        await page.screenshot({ path: join(out, `${name}-${backend}-canvas.png`) });
        if (result.info.backend !== backend) faults.push(`asked for ${backend}, got ${result.info.backend}`);
        if (groups) {
          console.log(`    ${name} on ${backend}: 8 groups of lights over all lights ${result.groupRatio.toFixed(5)}, ${(100 * result.offPixels).toFixed(3)} % of values off by more than 1 %`);
          if (!(Math.abs(result.groupRatio - 1) < 0.005 && result.offPixels < 0.001)) faults.push("groups of lights do not add up to the whole");
        }
        const notes = result.warnings.length ? `; ${result.warnings.length} warnings, first: ${result.warnings[0]}` : "";
        console.log(`    ${name} on ${backend}: first frame ${result.first.toFixed(0)} ms after the page was opened, next ${result.second.toFixed(0)} ms${notes}`);
      } finally { await page.close(); }
    });
  }
}

// The page as a user meets it: it turns, refuses, and takes dropped files.
await test("page", async (faults) => {
  const page = await open({}, { width: 640, height: 360 }, faults);
  const error = await page.evaluate(() => window.manypass.error);
  if (error) throw new Error(error);
  const picture = () => page.evaluate(async () => {
    await window.manypass.draw();
    return (await window.manypass.viewer.pixels()).reduce((hash, value) => (hash * 31 + value) | 0, 7);
  });
  const before = await picture();
  await page.mouse.move(300, 200);
  await page.mouse.down();
  await page.mouse.move(360, 220, { steps: 3 });
  await page.mouse.up();
  if (await picture() === before) faults.push("dragging does not turn the camera");
  const lit = await page.evaluate(async () => {
    const pixels = await window.manypass.viewer.pixels();
    return pixels.reduce((count, value, i) => count + (i % 4 < 3 && value > 16), 0) / pixels.length;
  });
  if (lit < 0.1) faults.push(`after turning only ${(100 * lit).toFixed(1)} % of the picture is lit`);
  await page.screenshot({ path: join(out, "page.png") });
  const drop = (files) => page.evaluate(async (files) => {
    const data = new DataTransfer();
    for (const [name, text] of files) data.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
    window.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, files);
  const said = (pattern) => page.waitForFunction((source) => new RegExp(source).test(document.getElementById("message").textContent), pattern, { timeout: 20000 });
  const base64 = (value) => Buffer.from(value).toString("base64");
  const corners = base64(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer);
  const gltf = base64(JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: 36 }], buffers: [{ uri: "my%20corners.bin", byteLength: 36 }],
  }));
  await drop([["broken.glb", base64("not a model")]]);
  await said("not a glTF|neither a .glb|glTF");
  await drop([["triangle.gltf", gltf]]);
  await said("choose that file too");
  await drop([["triangle.gltf", gltf], ["my corners.bin", corners]]);
  await said("^$");
  if (await picture() === before) faults.push("a dropped model does not replace the former one");
  await page.close();
});

// Without either API the page says so.
await browser.close();
browser = await launch(["--disable-gpu", "--disable-webgl", "--disable-3d-apis", "--disable-features=WebGPU"]);
await test("no API", async () => {
  const page = await open({}, { width: 640, height: 360 }, []);
  const text = await page.textContent("#message");
  await page.screenshot({ path: join(out, "no-api.png") });
  if (!/neither WebGPU nor WebGL 2/.test(text)) throw new Error(`the page says only: ${text}`);
  await page.close();
});
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
