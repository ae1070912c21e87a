// The page itself, beside the pictures that it draws.
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { open, out, test } from "./harness.mjs";

/** Keys, wheel, buttons and fingers, which leave the view where something is to be seen; and what a screen reader finds. */
async function controls(page, faults) {
  const orbit = () => page.evaluate(() => window.manypass.orbit() && { ...window.manypass.orbit() });
  const isMoved = (a, b) => a.target.some((at, axis) => at !== b.target[axis]);
  await page.focus("#canvas");
  await page.keyboard.press("Home");
  if (await orbit()) faults.push("Home does not show the model as at first");
  await page.keyboard.press("ArrowRight");
  const turned = await orbit();
  await page.keyboard.press("ArrowRight");
  if (!(Math.abs((await orbit()).yaw - turned.yaw - 5) < 1e-6)) faults.push("an arrow key does not turn by 5 degrees");
  await page.keyboard.press("Shift+ArrowRight");
  if (!isMoved(await orbit(), turned)) faults.push("Shift and an arrow key move nothing");
  for (const [button, key] of [["right"], ["left", "Shift"]]) {
    const before = await orbit();
    if (key) await page.keyboard.down(key);
    await page.mouse.move(300, 200);
    await page.mouse.down({ button });
    await page.mouse.move(340, 210);
    await page.mouse.up({ button });
    if (key) await page.keyboard.up(key);
    const after = await orbit();
    if (!isMoved(after, before) || after.yaw !== before.yaw) faults.push(`the ${button} button with ${key ?? "no key"} does not move the view`);
  }
  const wheel = (deltaY) => page.evaluate((deltaY) => {
    for (let turn = 0; turn < 60; turn++) document.getElementById("canvas").dispatchEvent(new WheelEvent("wheel", { deltaY, cancelable: true }));
    return window.manypass.orbit().radius;
  }, deltaY);
  const [far, near] = [await wheel(1e9), await wheel(-1e9)];
  if (!(Math.abs(far / near / 1000 - 1) < 1e-3)) faults.push(`the wheel zooms from ${near} to ${far} m`);
  await page.mouse.dblclick(300, 200);
  if (await orbit()) faults.push("a double click does not show the model as at first");
  await page.keyboard.press("-");
  await page.keyboard.press("-");
  await page.keyboard.press("-");
  const before = await orbit();
  const touch = await page.context().newCDPSession(page);
  const fingers = (type, ...places) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: places.map(([x, y], id) => ({ x, y, id })) });
  await fingers("touchStart", [300, 180], [340, 180]);
  await fingers("touchMove", [290, 180], [350, 180]);
  await fingers("touchEnd");
  const pinched = (await orbit()).radius / before.radius;
  if (!(Math.abs(pinched - 2 / 3) < 0.02)) faults.push(`two fingers half as far apart again change the radius by ${pinched}`);
  await page.keyboard.press("Home");
  const found = await page.evaluate(() => {
    const canvas = document.querySelector("main canvas[role=img]");
    return { headings: document.querySelectorAll("main h1").length, label: canvas?.getAttribute("aria-label"), tabIndex: canvas?.tabIndex };
  });
  if (found.headings !== 1 || found.tabIndex !== 0 || !/demo:hall/.test(found.label)) faults.push(`a screen reader finds ${JSON.stringify(found)}`);
}

/** What the address asks for that is no such thing is refused by name. */
export const withWrongAddress = (browser, origin) => test("address", async (faults) => {
  for (const [key, value] of [["size", "abc"], ["size", "0x10"], ["time", "soon"]]) {
    const page = await open(browser, origin, { [key]: value }, { width: 96, height: 54 }, []);
    const error = await page.evaluate(() => document.getElementById("message").textContent);
    if (!error.startsWith(`?${key}=${value}: ${key} is `)) faults.push(`?${key}=${value} says: ${error}`);
    await page.close();
  }
});

/** In the page: a viewer of its own with a triangle, which loses its context or device, and is resized before. */
async function loseAndRestore(backend) {
  const faults = [];
  const within = (promise, what) => Promise.race([promise, new Promise((_, refuse) => setTimeout(() => refuse(new Error(`${what} takes more than 15 s`)), 15000))]);
  const named = (promise, what) => within(promise, what).then(() => "", (error) => error.name ?? String(error));
  // Textures that hold memory, by what makes and frees them, and buffers that frames were read into.
  const held = new Set(), read = new Set(), devices = [];
  const count = (owner, make, free) => {
    const [made, freed] = [owner.prototype[make], owner.prototype[free]];
    owner.prototype[make] = function (...args) { const object = made.apply(this, args); held.add(object); return object; };
    owner.prototype[free] = function (object) { held.delete(object); return freed.call(this, object); };
  };
  if (backend === "webgl") {
    count(WebGL2RenderingContext, "createTexture", "deleteTexture");
    count(WebGL2RenderingContext, "createRenderbuffer", "deleteRenderbuffer");
  } else {
    const { createTexture } = GPUDevice.prototype, { destroy } = GPUTexture.prototype, { requestDevice } = GPUAdapter.prototype;
    GPUDevice.prototype.createTexture = function (descriptor) {
      const texture = createTexture.call(this, descriptor);
      if (texture.width * texture.height >= 64 * 64) held.add(texture);
      return texture;
    };
    GPUTexture.prototype.destroy = function () { held.delete(this); return destroy.call(this); };
    const { createBuffer } = GPUDevice.prototype, { destroy: destroyBuffer } = GPUBuffer.prototype;
    GPUDevice.prototype.createBuffer = function (descriptor) {
      const buffer = createBuffer.call(this, descriptor);
      if (descriptor.usage & GPUBufferUsage.MAP_READ) read.add(buffer);
      return buffer;
    };
    GPUBuffer.prototype.destroy = function () { read.delete(this); return destroyBuffer.call(this); };
    GPUAdapter.prototype.requestDevice = async function (...args) {
      const device = await requestDevice.apply(this, args);
      devices.push(device);
      return device;
    };
  }
  const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
  await init();
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 80;
  const viewer = await create(canvas, backend);
  const corners = btoa(String.fromCharCode(...new Uint8Array(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer)));
  viewer.load(new TextEncoder().encode(JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: 36 }], buffers: [{ uri: `data:application/octet-stream;base64,${corners}`, byteLength: 36 }],
  })));
  viewer.configure({ tonemap: "none", quality: "low" });
  const counts = [];
  for (let size = 80; size < 176; size += 8) {
    canvas.width = canvas.height = size;
    await within(viewer.render(), "a frame");
    // What frames used is free once they are done.
    await within(viewer.pixels(), "reading a frame");
    counts.push(held.size);
  }
  if (counts.at(-1) > counts[3] + 20) faults.push(`textures of former sizes are kept: ${counts}`);
  if (read.size > 1) faults.push(`${read.size} buffers are kept that frames were read into`);
  // Calls may overlap, and what is asked meanwhile is answered.
  canvas.width = canvas.height = 80;
  const calls = [viewer.render(), viewer.setTime(0), viewer.refine(), viewer.render({ yaw: 20 }), viewer.pixels()];
  // So that the first has begun.
  await null;
  await null;
  const answered = [viewer.info().width, viewer.moves(), viewer.startOrbit().target.length];
  if (answered.join() !== "80,false,3") faults.push(`while frames are drawn the viewer says ${answered}`);
  const before = (await within(Promise.all(calls), "overlapping calls")).at(-1);
  const extension = backend === "webgl" ? canvas.getContext("webgl2").getExtension("WEBGL_lose_context") : null;
  const lose = () => (extension ? extension.loseContext() : devices.at(-1).destroy());
  const lost = new Promise((done) => { viewer.onlost = (error) => done(error.name); });
  const restored = new Promise((done) => viewer.addEventListener("restored", done, { once: true }));
  const underWay = named(Promise.all([viewer.render(), viewer.pixels()]), "what is under way when the device is lost");
  await new Promise((done) => setTimeout(done));
  lose();
  const name = await within(lost, "the loss");
  if (name !== "ContextLost") faults.push(`the loss is told as ${name}`);
  const ended = await underWay;
  if (!["", "ContextLost"].includes(ended)) faults.push(`what was under way ends with ${ended}`);
  // A device of WebGPU may be there again already.
  const later = extension ? await named(viewer.pixels(), "a call after the loss") : "ContextLost";
  if (later !== "ContextLost") faults.push(`a later call ends with ${later}`);
  // Not while the event of the loss is told.
  await new Promise((done) => setTimeout(done, 50));
  extension?.restoreContext();
  await within(restored, "the restoring");
  await within(viewer.render({ yaw: 20 }), "a frame of another device");
  const after = await viewer.pixels();
  const differing = after.filter((value, index) => Math.abs(value - before[index]) > 1).length;
  if (after.length !== before.length || differing > 0) faults.push(`after the loss ${differing} of ${after.length} values differ`);
  // Whatever is under way, and twice.
  const last = named(viewer.render(), "a frame of a viewer that is disposed of");
  lose();
  viewer.dispose();
  viewer.dispose();
  if (!["ContextLost", "Disposed"].includes(await last)) faults.push(`disposing of the viewer lets its frame end with ${await last}`);
  return faults;
}

/** A lost context or device ends calls and comes back, calls overlap, and sizes of before take no memory. */
export const withLoss = (browser, origin, backend) => test(`loss on ${backend}`, async (faults) => {
  const started = performance.now();
  const noise = [];
  // A page that draws nothing itself.
  const page = await open(browser, origin, { size: "none" }, { width: 96, height: 54 }, noise);
  faults.push(...await page.evaluate(loseAndRestore, backend));
  // The loss itself is on the console.
  faults.push(...noise.filter((line) => !/CONTEXT_LOST_WEBGL|[Dd]evice.*(lost|destroyed)/.test(line)));
  console.log(`    loss on ${backend}: ${(performance.now() - started).toFixed(0)} ms`);
  await page.close();
});

/** Environments and effects that are dropped, alone and with a model. */
async function extras({ page, drop, said, picture, base64, model }, faults) {
  const plain = await picture();
  const sky = ["sky.hdr", Buffer.concat([Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"), Buffer.alloc(32, Buffer.from([128, 16, 16, 131]))]).toString("base64")];
  const [haze, look] = await Promise.all(["haze.wgsl", "look.cube"].map(async (name) => [name, base64(await readFile(join("xtask/browser", name)))]));
  await drop([sky]);
  await said("^sky.hdr$");
  const lit = await picture();
  if (lit === plain) faults.push("a dropped environment does not light the model");
  await drop([haze]);
  await said("^haze.wgsl$");
  const hazed = await picture();
  if (hazed === lit) faults.push("a dropped effect is not drawn");
  await drop([["broken.wgsl", base64("//! effect broken\n//! reads: radiance\nfn broken( {")]]);
  await said("broken.wgsl:");
  if (await picture() !== hazed) faults.push("a broken effect changes the picture");
  await drop([...model, sky, look]);
  await said("^$");
  if (await picture() === hazed) faults.push("a table of colours that comes with a model is not applied");
  const name = await page.getAttribute("#canvas", "aria-label");
  if (!name.includes(model[0][0])) faults.push(`the canvas is called ${name}`);
}

/** An image that never comes, and one that comes after its model: both are drawn as soon as they are whole. */
async function lateImages({ page, drop, said, picture, painted, red }, faults) {
  // One sample of each will do.
  await page.evaluate(() => {
    const viewer = window.manypass.viewer;
    window.refinedEarly = 0;
    viewer.refine = async () => {
      window.refinedEarly += viewer.waitsForImages();
      return false;
    };
  });
  const unpainted = await picture();
  const whole = () => page.waitForFunction(() => window.manypass.isWhole, null, { timeout: 60000 });
  await drop(painted);
  await said("image `red.png` was not loaded, and materials do without it");
  await whole();
  if (await picture(false) !== unpainted) faults.push("a model whose image does not come is not drawn as without it");
  await drop([...painted, ["red.png", red]]);
  await said("^$");
  await whole();
  if (await picture(false) === unpainted) faults.push("an image that comes late is not shown");
  if (await page.evaluate(() => window.refinedEarly)) faults.push("edges are smoothed before all images have come");
}

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
  await controls(page, faults);
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
  await lateImages({ page, drop, said, picture, painted: [["painted.gltf", painted], ["my corners.bin", corners]], red }, faults);
  await extras({ page, drop, said, picture, base64, model: [["triangle.gltf", gltf], ["my corners.bin", corners]] }, faults);
  const ended = await page.evaluate(async () => {
    const { viewer } = window.manypass;
    const frame = viewer.render();
    await null;
    await null;
    viewer.dispose();
    viewer.dispose();
    return frame.then(() => "a frame", (error) => error.name);
  });
  if (!["Disposed", "a frame"].includes(ended)) faults.push(`a viewer that is disposed of while it draws ends with ${ended}`);
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
