// The page itself, beside the pictures that it draws.
import { join } from "node:path";
import { open, out, test } from "./harness.mjs";

/** The page as a user meets it: it turns, refuses, and takes dropped files. */
export const asUser = (browser, origin) => test("page", async (faults) => {
  const page = await open(browser, origin, {}, { width: 640, height: 360 }, faults);
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
