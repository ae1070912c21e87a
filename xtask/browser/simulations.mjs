// Simulations on their way to another time: the page has the thread, the newest time wins, and the picture is that of small steps.
import { open, test } from "./harness.mjs";
import { model } from "./stages.mjs";

/** No task of the page takes longer while simulations are stepped: 120 ms alone, 300 ms beside another browser. */
const TASK_MS_MAX = 500;

/** Whole numbers that mix from step to step, so that a step more or less is another picture. */
const MIXED = `//! simulation mixed
//! start: seeded -> number
//! step: mixed -> number
//! shows: color
//! edges: wrap

fn seeded(cell: vec2i) -> vec4f {
    return vec4f(f32(cell.x * 16 + cell.y) % 251.0, 0.0, 0.0, 0.0);
}

fn mixed(cell: vec2i) -> vec4f {
    let sum = 3.0 * number_at(cell).x + number_at(cell + vec2i(1, 0)).x + 1.0;
    return vec4f(sum - 251.0 * floor((sum + 0.5) / 251.0), 0.0, 0.0, 0.0);
}

fn color(cell: vec2i) -> vec4f {
    return vec4f(vec3f(number_at(cell).x / 251.0), 1.0);
}
`;

/** A step takes five seconds: 2,000 lead to 10,000 s. */
const STAGE = `model = "scene.gltf"

[settings.environment]
source = "studio"

[settings.exposure]
stops = 0

[[simulations]]
name = "mixed"
program = "mixed.wgsl"
cells = [16, 16]
rate_hz = 0.2
material = "screen"
slot = "base_color"
`;

/** In the page: the way to a late time, to another one meanwhile, and to none, because the viewer is disposed of. */
async function jump([backend, stage, model, program]) {
  const faults = [];
  const within = (promise, what) => Promise.race([promise, new Promise((_, refuse) => setTimeout(() => refuse(new Error(`${what} takes more than 120 s`)), 120000))]);
  const { default: init, create } = await import(new URL("manypass_web.js", location.href).href);
  await init();
  const bytes = (text) => new TextEncoder().encode(text);
  const add = async () => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [96, 64];
    const viewer = await create(canvas, backend);
    viewer.loadStage(bytes(stage), { "scene.gltf": bytes(model), "mixed.wgsl": bytes(program) });
    viewer.configure({ quality: "low" });
    await within(viewer.render(), "the first frame");
    return viewer;
  };
  const picture = async (viewer) => (await within(viewer.pixels(), "reading a frame")).join();
  const at = async (viewer, secs) => {
    await viewer.setTime(secs);
    await within(viewer.render(), `a frame at ${secs} s`);
    return picture(viewer);
  };

  // Small steps: each frame makes a few.
  const steady = await add();
  let late;
  for (let secs = 250; secs <= 10000; secs += 250) late = await at(steady, secs);
  const early = await at(steady, 500);
  if (late === early) faults.push("the simulation is not seen");
  // What is asked of the last frame is of its time.
  const radiance = (await within(steady.radiance(), "radiance")).join();
  await steady.setTime(1e4);
  if ((await within(steady.radiance(), "radiance")).join() !== radiance) faults.push("radiance is that of another time than the frame's");
  if (await at(steady, 1e4) !== late) faults.push("a time that was asked for before radiance is not shown");
  steady.dispose();

  // The whole way at once, while the page does something else.
  const viewer = await add();
  const told = [];
  let longest_ms = 0, turns = 0, isStepping = false, last;
  viewer.onsimulating = (progress) => {
    told.push(progress);
    // What comes after the last step is the frame.
    if (progress.done === progress.total) isStepping = false;
  };
  const look = () => {
    const now = performance.now();
    if (!isStepping) return;
    turns++;
    longest_ms = Math.max(longest_ms, now - last);
    last = now;
    setTimeout(look);
  };
  const begun = performance.now();
  viewer.setTime(1e4);
  const frame = viewer.render();
  [isStepping, last] = [true, performance.now()];
  setTimeout(look);
  await within(frame, "the way to 10,000 s");
  const whole_ms = performance.now() - begun;
  if (await picture(viewer) !== late) faults.push("after a jump in time there is another picture");
  const ends = told.filter(({ done, total }) => done === total);
  const rises = told.every(({ done }, index) => index === 0 || done > told[index - 1].done);
  if (told.length < 3 || ends.length !== 1 || !rises || told.some(({ simulation, total }) => simulation !== "mixed" || total !== 2000)) {
    faults.push(`the progress is told as ${JSON.stringify(told.slice(0, 3))} and ${told.length - 3} more`);
  }

  // Another time comes on the way: that frame shows it, and no later frame the former one.
  const progressed = () => new Promise((done) => viewer.addEventListener("simulating", done, { once: true }));
  await at(viewer, 0);
  const totals = new Set();
  viewer.onsimulating = ({ total }) => totals.add(total);
  let next = progressed();
  viewer.setTime(1e4);
  const redirected = viewer.render();
  await within(next, "the first slice");
  if (viewer.setTime(500) !== undefined) faults.push("a newer time waits for the frame that it is for");
  await within(redirected, "a frame whose time changes");
  if (await picture(viewer) !== early) faults.push("the newest time does not win");
  if (await at(viewer, 1e4) !== late) faults.push("after a time that was given up there is another picture");
  if (!totals.has(2000)) faults.push(`steps on the way: ${[...totals]}`);

  // The same event, and a viewer that is disposed of on its way.
  next = progressed();
  await viewer.setTime(0);
  const ended = viewer.render().then(() => viewer.setTime(1e4)).then(() => viewer.render()).then(() => "a frame", (error) => error.name);
  await within(next, "the first slice of a frame that is given up");
  const disposed = performance.now();
  viewer.dispose();
  const name = await within(ended, "the end of a frame that is given up");
  const end_ms = performance.now() - disposed;
  if (name !== "Disposed" || end_ms > 1000) faults.push(`a viewer that is disposed of ends its frame with ${name} after ${end_ms.toFixed(0)} ms`);
  return { faults, longest_ms, turns, whole_ms };
}

/** A jump in time never holds the page. */
export const withSimulations = (browser, origin, backend) => test(`simulations in slices on ${backend}`, async (faults) => {
  const noise = [];
  // A page that draws nothing itself.
  const page = await open(browser, origin, { size: "none" }, { width: 96, height: 64 }, noise);
  const found = await page.evaluate(jump, [backend, STAGE, model, MIXED]);
  faults.push(...found.faults, ...noise.filter((line) => !/CONTEXT_LOST_WEBGL/.test(line)));
  const { longest_ms, turns, whole_ms } = found;
  console.log(`    2,000 steps on ${backend}: ${whole_ms.toFixed(0)} ms, at most ${longest_ms.toFixed(0)} ms at once, ${turns} turns`);
  if (!(turns > 8 && longest_ms <= TASK_MS_MAX)) faults.push(`of ${whole_ms} ms the page waits ${longest_ms} ms at once, in ${turns} turns`);
  await page.close();
});
