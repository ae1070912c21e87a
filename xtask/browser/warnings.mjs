// What the page says of a model with more warnings than have room.
import { open, test } from "./harness.mjs";

const corners = Buffer.from(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer).toString("base64");
const names = Array.from({ length: 7 }, (_, index) => index);
/** A triangle whose seven materials show images that nobody has. */
const MODEL = JSON.stringify({
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
  meshes: [{ primitives: names.map((material) => ({ attributes: { POSITION: 0, TEXCOORD_0: 1 }, material })) }],
  materials: names.map((index) => ({ pbrMetallicRoughness: { baseColorTexture: { index } } })),
  textures: names.map((source) => ({ source })), images: names.map((index) => ({ uri: `missing${index}.png` })),
  accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
    { bufferView: 1, componentType: 5126, count: 3, type: "VEC2" }],
  bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteLength: 36, byteStride: 12 }],
  buffers: [{ uri: `data:application/octet-stream;base64,${corners}`, byteLength: 36 }],
});

/** The page shows the first warnings and says how many more there are. */
export const withWarnings = (browser, origin) => test("more warnings than have room", async (faults) => {
  // The files that are not there.
  const noise = [];
  const page = await open(browser, origin, { size: "96x64", model: "models/boxes.gltf" }, { width: 96, height: 64 }, noise);
  await page.evaluate((text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], "missing.gltf"));
    window.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, MODEL);
  const said = () => page.evaluate(() => document.getElementById("message").textContent);
  await page.waitForFunction(() => document.getElementById("message").textContent.includes(" more, "), null, { timeout: 20000 });
  const lines = (await said()).split("\n");
  const count = await page.evaluate(() => window.manypass.viewer.warnings().length);
  const isWhole = lines.length === 6 && count >= 7 && lines[5].includes(`and ${count - 5} more`);
  if (!isWhole) faults.push(`of ${count} warnings the page says: ${lines.join(" | ")}`);
  await page.close();
});
