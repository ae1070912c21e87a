// Several viewers in one page.
import { open, test } from "./harness.mjs";

/** In the page, with WebGPU: viewers share a device with its programs and pipelines, and each outlives the others and a loss. */
async function share() {
  const faults = [];
  const within = (promise, what) => Promise.race([promise, new Promise((_, refuse) => setTimeout(() => refuse(new Error(`${what} takes more than 30 s`)), 30000))]);
  const made = { createRenderPipeline: 0, createShaderModule: 0 }, devices = [];
  for (const name of Object.keys(made)) {
    const call = GPUDevice.prototype[name];
    GPUDevice.prototype[name] = function (...args) { made[name]++; return call.apply(this, args); };
  }
  const { requestDevice } = GPUAdapter.prototype;
  GPUAdapter.prototype.requestDevice = async function (...args) {
    const device = await requestDevice.apply(this, args);
    devices.push(device);
    return device;
  };
  const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
  await init();
  const model = new Uint8Array(await (await fetch("models/boxes.gltf")).arrayBuffer());
  const add = async () => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [96, 54];
    const viewer = await create(canvas, "webgpu");
    viewer.load(model);
    viewer.configure({ quality: "low" });
    return viewer;
  };
  const picture = async (viewer) => {
    await within(viewer.render(), "a frame");
    return (await within(viewer.pixels(), "reading a frame")).join();
  };
  const [first, second] = await Promise.all([add(), add()]);
  const ofFirst = await picture(first), before = { ...made };
  if (await picture(second) !== ofFirst) faults.push("two viewers of a model show two pictures");
  if (devices.length !== 1) faults.push(`two viewers have ${devices.length} devices`);
  for (const name of Object.keys(made)) {
    const more = made[name] - before[name];
    if (before[name] < 5 || more > before[name] / 10) faults.push(`${name}: ${before[name]} by the first viewer, ${more} more by the second`);
  }
  first.dispose();
  if (await picture(second) !== ofFirst) faults.push("a viewer shows another picture once another one is disposed of");
  const third = await add();
  const restored = [second, third].map((viewer) => new Promise((done) => { viewer.onrestored = done; }));
  devices.at(-1).destroy();
  await within(Promise.all(restored), "the restoring");
  if (devices.length !== 2) faults.push(`after a loss two viewers have ${devices.length - 1} devices`);
  if (await picture(third) !== ofFirst || await picture(second) !== ofFirst) faults.push("after a loss there is another picture");
  second.dispose();
  third.dispose();
  return faults;
}

/** In the page, with WebGL: one viewer too many takes the context of the first, which says why, and returns when there is room. */
async function crowd() {
  const faults = [];
  const within = (promise, what) => Promise.race([promise, new Promise((_, refuse) => setTimeout(() => refuse(new Error(`${what} takes more than 15 s`)), 15000))]);
  const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
  await init();
  const canvases = [], viewers = [];
  let lost;
  while (!lost && viewers.length < 40) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 16;
    canvases.push(canvas);
    viewers.push(await within(create(canvas, "webgl"), "a viewer"));
    viewers[0].onlost = (error) => { lost = error; };
    // Events come later than the loss.
    await new Promise((done) => setTimeout(done, 20));
  }
  if (lost?.name !== "ContextLost" || lost.reason !== "too-many-contexts") faults.push(`${viewers.length} viewers: the first is told ${lost}, ${lost?.reason}`);
  const restored = new Promise((done) => { viewers[0].onrestored = done; });
  viewers[3].dispose();
  await within(restored, "the restoring of the first viewer");
  viewers[4].dispose();
  const again = await within(create(canvases[3], "webgl"), "another viewer on a canvas");
  if (again.info().backend !== "webgl" || canvases[3].getContext("webgl2").isContextLost()) faults.push("a canvas cannot be bound again");
  for (const viewer of [...viewers, again]) viewer.dispose();
  return faults;
}

/** In the page: while a model of 40 meshes, or of one primitive of 1.5 million triangles, is read and uploaded, the page has the thread again and again. */
async function loadInSlices([backend, shape]) {
  const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
  await init();
  const viewer = await create(document.createElement("canvas"), backend);
  const ofMany = () => {
    const count = 30000, meshes = Array.from({ length: 40 }, () => ({ primitives: [{ attributes: { POSITION: 0 } }] }));
    // Triangles as small as those of a model that has so many.
    const positions = Float32Array.from({ length: 3 * count }, (_, index) => Math.sin(Math.floor(index / 9) * 0.7 + index % 3) + 0.01 * Math.sin(index));
    return { meshes, count, views: [positions] };
  };
  const ofOne = () => {
    // A bowl of quads whose places are its normals, too.
    const side = 867, count = side * side, positions = new Float32Array(3 * count), indices = new Uint32Array(6 * (side - 1) ** 2);
    for (let at = 0; at < count; at++) {
      const x = 2 * (at % side) / (side - 1) - 1, z = 2 * Math.floor(at / side) / (side - 1) - 1;
      positions.set([x, 0.5 * (x * x + z * z) - 1.005, z], 3 * at);
    }
    for (let quad = 0; quad < (side - 1) ** 2; quad++) {
      const first = Math.floor(quad / (side - 1)) * side + quad % (side - 1);
      indices.set([first, first + side, first + 1, first + 1, first + side, first + side + 1], 6 * quad);
    }
    return { meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 0 }, indices: 1 }] }], count, views: [positions, indices] };
  };
  const { meshes, count, views } = shape === "many" ? ofMany() : ofOne();
  const bytes = new Uint8Array(await new Blob(views).arrayBuffer());
  const [positions, indices] = views;
  const gltf = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: meshes.map((_, index) => index) }], nodes: meshes.map((_, mesh) => ({ mesh })), meshes,
    accessors: [{ bufferView: 0, componentType: 5126, count, type: "VEC3", min: [-1.01, -1.01, -1.01], max: [1.01, 1.01, 1.01] }],
    bufferViews: [{ buffer: 0, byteLength: positions.byteLength }], buffers: [{ uri: "all.bin", byteLength: bytes.length }],
  };
  if (indices) {
    gltf.accessors.push({ bufferView: 1, componentType: 5125, count: indices.length, type: "SCALAR" });
    gltf.bufferViews.push({ buffer: 0, byteOffset: positions.byteLength, byteLength: indices.byteLength });
  }
  let isDone = false, turns = 0, longest_ms = 0, last = performance.now();
  const begun = last;
  const look = () => {
    const now = performance.now();
    turns++;
    longest_ms = Math.max(longest_ms, now - last);
    last = now;
    if (!isDone) setTimeout(look);
  };
  setTimeout(look);
  await viewer.loadBeforeImages(new TextEncoder().encode(JSON.stringify(gltf)), { "all.bin": bytes }, []);
  isDone = true;
  const whole_ms = performance.now() - begun;
  longest_ms = Math.max(longest_ms, performance.now() - last);
  viewer.dispose();
  return { turns, longest_ms, whole_ms };
}

/** Viewers share what the API lets them share, and say what they cannot have. */
export const withMany = (browser, origin, backend) => test(`several viewers on ${backend}`, async (faults) => {
  const started = performance.now();
  const noise = [];
  // A page that draws nothing itself.
  const page = await open(browser, origin, { size: "none" }, { width: 96, height: 54 }, noise);
  faults.push(...await page.evaluate(backend === "webgpu" ? share : crowd));
  for (const [shape, name] of [["many", "40 meshes"], ["one", "one primitive of 1.5 million triangles"]]) {
    const { turns, longest_ms, whole_ms } = await page.evaluate(loadInSlices, [backend, shape]);
    console.log(`    a model of ${name} on ${backend}: ${whole_ms.toFixed(0)} ms, at most ${longest_ms.toFixed(0)} ms at once, ${turns} turns`);
    // What a slice takes while other tests run beside this one; what is copied at once from and to the page, too.
    if (turns < 8 || longest_ms > Math.max(300, 0.5 * whole_ms)) faults.push(`of ${whole_ms} ms a model of ${name} takes ${longest_ms} ms at once, in ${turns} turns`);
  }
  faults.push(...noise.filter((line) => !/CONTEXT_LOST_WEBGL|Too many active WebGL contexts|[Dd]evice.*(lost|destroyed)/.test(line)));
  console.log(`    several viewers on ${backend}: ${(performance.now() - started).toFixed(0)} ms`);
  await page.close();
});
