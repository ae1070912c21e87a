// Frames that fail, on the page: once their cause is lifted, pictures are those of a viewer for which nothing failed. The same
// of the renderer is crates/render/tests/frames_commit.rs.
import { open, test } from "./harness.mjs";
import { model } from "./stages.mjs";

/** A box on a ground under the sky, and a screen that shows the zenith, drawn once. */
const STAGE = `model = "scene.gltf"

[environment]
source = "sky"

[settings.background]
source = "environment"

[settings.ground]
mode = "808080"

[settings.render]
path = "forward"

[[monitors]]
name = "zenith"
position = [0, 5, 0]
target = [0, 9, 0.5]
fov_deg = 60
size_px = [32, 32]
material = "screen"
slot = "base_color"
update = "once"
`;

/** Reads what the forward path does not have. */
const MOVED = `//! effect moved
//! reads: radiance, motion
//! pixel: changed
fn changed(color: vec4f, position: vec2f) -> vec4f {
    return color + vec4f(textureLoad(motion, vec2i(position), 0).rg, 0.0, 0.0);
}
`;

/** In the page: lets first and later frames fail of each cause, and the device refuse a command and go away. */
async function fail([backend, stage, model, moved]) {
  const faults = [], devices = [];
  const within = (promise, what) => Promise.race([promise, new Promise((_, refuse) => setTimeout(() => refuse(new Error(`${what} takes more than 60 s`)), 60000))]);
  const pause = (ms) => new Promise((done) => setTimeout(done, ms));
  if (backend === "webgpu") {
    const { requestDevice } = GPUAdapter.prototype;
    GPUAdapter.prototype.requestDevice = async function (...args) {
      devices.push(await requestDevice.apply(this, args));
      return devices.at(-1);
    };
  }
  const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
  await init();
  const bytes = (text) => new TextEncoder().encode(text);
  let exposure = "auto", canvas;
  const add = async () => {
    canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [96, 64];
    const viewer = await within(create(canvas, backend), "a viewer");
    viewer.loadStage(bytes(stage), { "scene.gltf": bytes(model) });
    viewer.configure({ exposure });
    return viewer;
  };
  const VIEWS = [undefined, { yaw: 25, pitch: 20 }];
  const pixels = async (viewer) => (await within(viewer.pixels(), "reading a frame")).join();
  const picture = async (viewer, view) => {
    await within(viewer.render(view), "a frame");
    return pixels(viewer);
  };
  /** What a frame fails of; nothing if it does not. */
  const failure = (viewer, view) => within(viewer.render(view), "a frame that fails").then(() => "", (error) => String(error.message ?? error));

  // Metered once, so that frames that fail meter nothing.
  const meter = await add();
  await within(meter.render(), "the first frame");
  exposure = meter.exposure().stops;
  meter.dispose();
  const steady = await add();
  const expected = [await picture(steady, VIEWS[0]), await picture(steady, VIEWS[1])];
  if (expected[0] === expected[1] || new Set(expected[0].split(",")).size < 32) faults.push("the test shows nothing");
  if (await picture(steady, VIEWS[0]) !== expected[0]) faults.push("a live view does not come back to its picture");
  steady.dispose();

  const causes = [
    ["an effect that reads motion", (viewer) => viewer.setEffects([{ file: "moved.wgsl", source: moved }]), (viewer) => viewer.setEffects([])],
    ["a setting of another path", (viewer) => viewer.configure({ settings: { "gi.enabled": true } }), (viewer) => viewer.configure({ settings: { "gi.enabled": false } })],
  ];
  let viewer;
  for (const [cause, bring, lift] of causes) {
    viewer?.dispose();
    viewer = await add();
    bring(viewer);
    const first = await failure(viewer, VIEWS[0]);
    if (!first.includes("render.path=deferred")) faults.push(`${cause}: the frame ends with «${first}»`);
    if (await viewer.pixels().then(() => true, () => false)) faults.push(`${cause}: a picture is read that nobody has drawn`);
    lift(viewer);
    for (let frame = 0; frame < 2; frame++) {
      if (await picture(viewer, VIEWS[0]) !== expected[0]) faults.push(`${cause}: after a first frame that failed, frame ${frame} is another one`);
    }
    bring(viewer);
    if (!await failure(viewer, VIEWS[1])) faults.push(`${cause}: a later frame does not fail`);
    if (await pixels(viewer) !== expected[0]) faults.push(`${cause}: the former picture is gone`);
    lift(viewer);
    for (const view of [1, 0]) {
      if (await picture(viewer, VIEWS[view]) !== expected[view]) faults.push(`${cause}: view ${view} is another one after a later frame that failed`);
    }
  }

  // The device refuses a command while a frame is drawn: a frame says so, and the next one is whole.
  if (backend === "webgpu") {
    const frame = failure(viewer, VIEWS[1]);
    await null;
    devices.at(-1).createBuffer({ label: "refused on purpose", size: 4, usage: 0 });
    let refusal = await frame;
    for (let tries = 0; tries < 10 && !refusal; tries++) {
      await pause(50);
      refusal = await failure(viewer, VIEWS[1]);
    }
    if (!refusal.includes("refused")) faults.push(`a command that is refused is told as «${refusal}»`);
    for (const view of [1, 0]) {
      if (await picture(viewer, VIEWS[view]) !== expected[view]) faults.push(`view ${view} is another one after a command was refused`);
    }
  }

  // The device goes away while a frame is drawn.
  const extension = backend === "webgl" ? canvas.getContext("webgl2").getExtension("WEBGL_lose_context") : null;
  const restored = new Promise((done) => viewer.addEventListener("restored", done, { once: true }));
  const underWay = viewer.render(VIEWS[1]).then(() => "", (error) => error.name);
  await pause(0);
  if (extension) extension.loseContext();
  else devices.at(-1).destroy();
  const ended = await within(underWay, "a frame whose device goes away");
  if (!["", "ContextLost"].includes(ended)) faults.push(`a frame whose device goes away ends with ${ended}`);
  // Not while the event of the loss is told.
  await pause(50);
  extension?.restoreContext();
  await within(restored, "the restoring");
  for (const view of [1, 0]) {
    const [found, whole] = [await picture(viewer, VIEWS[view]), expected[view]].map((text) => text.split(",").map(Number));
    const differing = found.filter((value, index) => Math.abs(value - whole[index]) > 1).length;
    if (found.length !== whole.length || differing) faults.push(`after the loss ${differing} values of view ${view} differ`);
  }
  viewer.dispose();
  return faults;
}

/** Frames commit, or change nothing. */
export const withFailures = (browser, origin, backend) => test(`frames that fail on ${backend}`, async (faults) => {
  const started = performance.now();
  const noise = [];
  // A page that draws nothing itself.
  const page = await open(browser, origin, { size: "none" }, { width: 96, height: 64 }, noise);
  faults.push(...await page.evaluate(fail, [backend, STAGE, model, MOVED]));
  // What is refused and lost on purpose is on the console.
  faults.push(...noise.filter((line) => !/refused on purpose|usage|CONTEXT_LOST_WEBGL|[Dd]evice.*(lost|destroyed)/.test(line)));
  console.log(`    frames that fail on ${backend}: ${(performance.now() - started).toFixed(0)} ms`);
  await page.close();
});
