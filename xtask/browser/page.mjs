// The page itself, beside the pictures that it draws.
import { join } from "node:path";
import { open, out, test } from "./harness.mjs";

/** The page as a user meets it: it turns, refuses, and takes dropped files. */
export const asUser = (browser, origin) => test("page", async (faults) => {
  const page = await open(browser, origin, {}, { width: 640, height: 360 }, faults);
  const error = await page.evaluate(() => window.manypass.error);
  if (error) throw new Error(error);
  const picture = (draws = true) => page.evaluate(async (draws) => {
    if (draws) await window.manypass.draw();
    return (await window.manypass.viewer.pixels()).reduce((hash, value) => (hash * 31 + value) | 0, 7);
  }, draws);
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
  const triangle = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: 36 }], buffers: [{ uri: "my%20corners.bin", byteLength: 36 }],
  };
  const gltf = base64(JSON.stringify(triangle));
  // The same, red by a texture.
  const painted = base64(JSON.stringify({
    ...triangle, meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }], textures: [{ source: 0 }], images: [{ uri: "red.png" }],
    accessors: [...triangle.accessors, { bufferView: 1, componentType: 5126, count: 3, type: "VEC2" }],
    bufferViews: [...triangle.bufferViews, { buffer: 0, byteLength: 36, byteStride: 12 }],
  }));
  const red = await page.evaluate(() => {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 2;
    const context = canvas.getContext("2d");
    context.fillStyle = "red";
    context.fillRect(0, 0, 2, 2);
    return canvas.toDataURL("image/png").split(",")[1];
  });
  await drop([["broken.glb", base64("not a model")]]);
  await said("not a glTF|neither a .glb|glTF");
  await drop([["triangle.gltf", gltf]]);
  await said("choose that file too");
  await drop([["triangle.gltf", gltf], ["my corners.bin", corners]]);
  await said("^$");
  const unlit = await picture();
  if (unlit === before) faults.push("a dropped model does not replace the former one");
  const stage = (text) => ["my.stage.toml", base64(`model = "triangle.gltf"\n${text}`)];
  await drop([stage("colour = 1"), ["triangle.gltf", gltf], ["my corners.bin", corners]]);
  await said("the stage:2:1: error: no key of a stage");
  await drop([stage('[environment]\ncolor = "ff0000"'), ["triangle.gltf", gltf]]);
  await said("choose that file too");
  await drop([stage('[environment]\ncolor = "ff0000"'), ["triangle.gltf", gltf], ["my corners.bin", corners]]);
  await said("^$");
  if (await picture() === unlit) faults.push("a dropped stage does not change its model");
  await drop([["broken.glb", base64("not a model")]]);
  await said("not a glTF|neither a .glb|glTF");
  await drop([["triangle.gltf", gltf], ["my corners.bin", corners]]);
  await said("^$");
  if (await picture() !== unlit) faults.push("settings of a stage outlast it");
  // An image that never comes, and one that comes after its model; both are drawn as soon as they are whole. One sample
  // of each will do.
  await page.evaluate(() => { window.manypass.viewer.refine = async () => false; });
  const unpainted = await picture();
  const whole = () => page.waitForFunction(() => window.manypass.isWhole, null, { timeout: 60000 });
  await drop([["painted.gltf", painted], ["my corners.bin", corners]]);
  await said("image `red.png` did not come, and materials do without it");
  await whole();
  if (await picture(false) !== unpainted) faults.push("a model whose image does not come is not drawn as without it");
  await drop([["painted.gltf", painted], ["my corners.bin", corners], ["red.png", red]]);
  await said("^$");
  await whole();
  if (await picture(false) === unpainted) faults.push("an image that comes late is not shown");
  await page.close();
});

/** A budget of time, far too small and then as large as can be, leads to the last rung and to the first one. */
export const withBudget = (browser, origin, backend) => test(`budget on ${backend}`, async (faults) => {
  // No machine draws it in a hundredth of a millisecond.
  const started = performance.now();
  const page = await open(browser, origin, { backend, size: "96x54", model: "models/boxes.gltf" }, { width: 96, height: 54 }, faults);
  const found = await page.evaluate(async () => {
    if (window.manypass.error) throw new Error(window.manypass.error);
    const viewer = window.manypass.viewer;
    const after = async (budgetMs) => {
      viewer.configure({ settings: { "quality.budget_ms": budgetMs } });
      // Two frames say nothing, three change the rung, and the next is drawn with that.
      for (let frame = 0; frame < 6; frame++) await window.manypass.draw();
      return { quality: viewer.info().quality, pixels: Array.from(await viewer.pixels()) };
    };
    const before = viewer.info().quality, tiny = await after(0.01), huge = await after(100000);
    viewer.configure({ settings: { "quality.budget_ms": 0 } });
    return { before, tiny, huge, none: viewer.info().quality };
  });
  for (const [budgetMs, rung, scale, { quality }] of [[0.01, "low, 0.25", 0.25, found.tiny], [100000, "ultra", undefined, found.huge]]) {
    const is = Math.abs(quality?.budgetMs - budgetMs) < 1e-6 * budgetMs && quality.rung === rung && quality.settings["render.scale"] === scale && quality.changes === 1 && quality.settledAfterFrames === 5;
    if (!is) faults.push(`for ${budgetMs} ms a frame there is ${JSON.stringify(quality)}`);
  }
  if (!(found.tiny.quality?.medianMs === null && found.huge.quality?.medianMs === null)) faults.push("frames before a change count after it");
  const differing = found.tiny.pixels.filter((value, index) => Math.abs(value - found.huge.pixels[index]) > 8).length;
  if (differing < 0.05 * found.tiny.pixels.length) faults.push(`the rungs draw the same: ${differing} values differ`);
  if (found.before !== null || found.none !== null) faults.push("there is a rung without a budget");
  console.log(`    budget on ${backend}: ${(performance.now() - started).toFixed(0)} ms for 13 frames of three rungs`);
  await page.close();
});

/** Without either API the page says so. */
export const withoutApi = (browser, origin) => test("no API", async () => {
  const page = await open(browser, origin, {}, { width: 640, height: 360 }, []);
  const text = await page.textContent("#message");
  await page.screenshot({ path: join(out, "no-api.png") });
  if (!/neither WebGPU nor WebGL 2/.test(text)) throw new Error(`the page says only: ${text}`);
  await page.close();
});
