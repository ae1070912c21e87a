// ?model=URL|demo:hall  ?backend=auto|webgpu|webgl  ?size=WIDTHxHEIGHT (without it the canvas fills the window)  ?time=SECONDS
import init, { create, modelFiles, stageEnvironment, stageImages, stageModel } from "./manypass_web.js";

const query = new URLSearchParams(location.search);
const canvas = document.getElementById("canvas");
const message = document.getElementById("message");
const state = (window.manypass = { viewer: null, ready: false, error: null, isWhole: false, draw, orbit: () => orbit });
/** Nothing until the user turns: then the view sets out from the file's camera. */
let orbit;
/** Whether there is a model to draw. */
let isLoaded = false;
/** Rises with every wish, so that older ones give way. */
let latest = 0;
/** Rises with every model, so that textures of former ones are left alone. */
let opened = 0;
/** Whether textures are still to come: edges are smoothed once all are there. */
let isComing = false;
/** Effects of dropped files, by name of file, in their order. */
const effects = new Map();
/** With a fixed size, for tests and pictures, a frame is one sample a pixel, and nothing but the canvas is shown. */
const bare = query.has("size");

const play = document.getElementById("play");
/** The time that is shown in seconds, and when that was; nothing while it stands. */
let time = 0;
let shownAt;

const say = (text) => { message.textContent = text; };
const tried = (action) => action.catch((error) => say(error.message ?? String(error)));

/** The viewer takes one call at a time: everything that calls it waits here for its turn. */
let queue = Promise.resolve();
const inTurn = (action) => (queue = queue.catch(() => {}).then(action));

/** Draws; gives way to a later wish, and smooths edges for as long as there is none. */
function draw() {
  const mine = ++latest;
  return inTurn(async () => {
    if (!isLoaded || mine !== latest) return;
    if (shownAt !== undefined) {
      const now = performance.now();
      // What waited for long does not make up for it.
      time += Math.min(now - shownAt, 100) / 1000;
      shownAt = now;
      state.viewer.setTime(time);
    }
    await state.viewer.render(orbit);
    await new Promise(requestAnimationFrame);
    if (shownAt !== undefined) return void tried(draw());
    while (!bare && !isComing && mine === latest && await state.viewer.refine()) await new Promise(requestAnimationFrame);
  });
}

/** Relative addresses of buffers and of images in a .gltf; none for other models, of which the viewer reads what is in the file itself. */
function references(bytes) {
  const none = { buffers: [], images: [] };
  if (new TextDecoder().decode(bytes.subarray(0, 4)) === "glTF") return none;
  let json;
  try { json = JSON.parse(new TextDecoder().decode(bytes)); } catch { return none; }
  const addresses = (entries) => [...new Set((entries ?? []).map((entry) => entry.uri).filter((uri) => uri && !/^data:/i.test(uri)))];
  return { buffers: addresses(json.buffers), images: addresses(json.images) };
}

const isStage = (name) => /\.stage\.toml$/i.test(name);

/** Shows a model or a stage; `get` fetches what they refer to, by a path (of a stage) or an address (of a model, from the model's place). */
async function open(name, bytes, get) {
  const parts = async (bytes, addresses, model) => {
    const found = await Promise.all(addresses.map(async (uri) => [uri, await get(uri, model)]));
    // An OBJ names libraries of materials, and those name textures. What is not there is warned of by the viewer.
    const tried = new Set();
    for (;;) {
      const names = modelFiles(bytes, new Map(found)).filter((name) => !tried.has(name));
      if (!names.length) return found;
      await Promise.all(names.map(async (name) => {
        tried.add(name);
        const path = name.split("/").map(encodeURIComponent).join("/");
        await get(path, model).then((file) => found.push([name, file]), () => {});
      }));
    }
  };
  if (!isStage(name)) {
    const { buffers, images } = references(bytes);
    const late = images.map((uri) => [uri, get(uri)]);
    // What fails is said when its turn comes.
    for (const [, file] of late) file.catch(() => {});
    await show(await parts(bytes, buffers), (viewer, found) => viewer.loadBeforeImages(bytes, found, images), false);
    return dress(late);
  }
  const model = stageModel(bytes);
  const isBuiltIn = model.startsWith("demo:");
  const path = model.split("/").map(encodeURIComponent).join("/");
  const modelBytes = isBuiltIn ? undefined : await get(path);
  const found = isBuiltIn ? [] : [[model, modelBytes], ...await parts(modelBytes, Object.values(references(modelBytes)).flat(), path)];
  const environment = stageEnvironment(bytes);
  for (const file of [...environment ? [environment] : [], ...stageImages(bytes)]) {
    found.push([file, await get(file.split("/").map(encodeURIComponent).join("/"))]);
  }
  return show(found, (viewer, found) => viewer.loadStage(bytes, found));
}

async function openUrl(address) {
  if (address.startsWith("demo:")) return show([], (viewer) => viewer.loadDemo(address.slice(5)));
  const get = async (url) => {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
    return new Uint8Array(await answer.arrayBuffer());
  };
  const base = new URL(address, location.href);
  return open(base.pathname, await get(base), (uri, from = "") => get(new URL(uri, new URL(from, base))));
}

/** Lights the model with a picture, or puts effects over it. */
async function openBeside(files) {
  for (const file of files) {
    const isPicture = /\.(hdr|exr)$/i.test(file.name);
    const content = isPicture ? new Uint8Array(await file.arrayBuffer()) : await file.text();
    await inTurn(() => {
      if (isPicture) return state.viewer.loadEnvironment(content);
      const former = effects.get(file.name);
      effects.set(file.name, { file: file.name, source: content });
      try {
        state.viewer.setEffects([...effects.values()]);
      } catch (error) {
        // What does not compile leaves everything as it was.
        former ? effects.set(file.name, former) : effects.delete(file.name);
        throw error;
      }
    });
  }
  say(files.map((file) => file.name).join(", "));
  await draw();
}

async function openFiles(files) {
  const beside = files.filter((file) => /\.(hdr|exr|wgsl|cube)$/i.test(file.name));
  if (beside.length && beside.length === files.length) return openBeside(beside);
  const main = files.find((file) => isStage(file.name)) ?? files.find((file) => /\.(glb|gltf|obj|stl|ply|3mf)$/i.test(file.name));
  if (!main) throw new Error("Choose a model (.glb, .obj, .stl, .ply, .3mf), a .gltf together with its other files, a .stage.toml together with its model, an environment (.hdr, .exr), or an effect (.wgsl, .cube).");
  const read = async (file) => new Uint8Array(await file.arrayBuffer());
  return open(main.name, await read(main), async (uri) => {
    const name = decodeURIComponent(uri).split("/").pop();
    const file = files.find((candidate) => candidate.name === name);
    if (!file) throw new Error(`${main.name} refers to ${uri}: choose that file too.`);
    return read(file);
  });
}

/** Loads with what was found of the files that are referred to; `isWhole` says whether its images come with it. */
async function show(found, load, isWhole = true) {
  latest++;
  opened++;
  await inTurn(() => {
    isLoaded = false;
    load(state.viewer, new Map(found));
    isLoaded = true;
    isComing = state.viewer.waitsForImages();
    play.hidden = !state.viewer.moves();
    if (time > 0) state.viewer.setTime(time);
    state.isWhole = isWhole;
    orbit = undefined;
    say(state.viewer.warnings().slice(0, 5).join("\n"));
  });
  await draw();
}

/** Gives the model its textures, draws after each, and smooths edges once all are there; with a fixed size draws once, after all. */
async function dress(late) {
  const mine = opened;
  let came = false;
  try {
    came = await giveTextures(late, mine);
  } finally {
    if (mine === opened) isComing = false;
  }
  if (mine !== opened) return;
  if (came) {
    say(state.viewer.warnings().slice(0, 5).join("\n"));
    await draw();
  }
  state.isWhole = mine === opened;
}

/** Those in the model's own file first, then the others as they come; says whether there were any. */
async function giveTextures(late, mine) {
  const step = (action) => inTurn(() => mine === opened && action(state.viewer));
  const drawn = () => mine === opened && !bare && draw();
  let came = late.length > 0;
  while (await step((viewer) => viewer.nextImage())) {
    came = true;
    await drawn();
  }
  for (const [uri, file] of late) {
    try {
      const bytes = await file;
      await step((viewer) => viewer.giveImage(decodeURIComponent(uri), bytes));
      await drawn();
    } catch (error) {
      // The model stays without what cannot be had; the rest comes all the same.
      console.warn(`${uri}: ${error.message ?? error}`);
      await step((viewer) => viewer.missImage(decodeURIComponent(uri), String(error.message ?? error)));
    }
  }
  return came;
}

/** Leaves the file's camera as soon as the user turns, moves or zooms. */
function turn(change) {
  if (!isLoaded) return;
  orbit ??= state.viewer.startOrbit();
  if (!orbit) return;
  // Beyond that there is nothing to see of the model.
  const whole = (orbit.whole ??= orbit.radius);
  change(orbit);
  orbit.pitch = Math.max(-89, Math.min(89, orbit.pitch));
  orbit.radius = Math.max(whole / 1000, Math.min(whole * 1000, orbit.radius));
  tried(draw());
}

/** Moves what is looked at by pixels, so that it stays under the pointer. */
function pan(orbit, right_px, down_px) {
  const [yaw, pitch] = [orbit.yaw, orbit.pitch].map((angle) => angle * Math.PI / 180);
  // As wide as a pixel is at the target under a field of view of 45 degrees.
  const pixel = 2 * Math.tan(Math.PI / 8) * orbit.radius / Math.max(canvas.clientHeight, 1);
  const right = [Math.cos(yaw), 0, -Math.sin(yaw)];
  const up = [-Math.sin(yaw) * Math.sin(pitch), Math.cos(pitch), -Math.cos(yaw) * Math.sin(pitch)];
  orbit.target = orbit.target.map((at, axis) => at + pixel * (down_px * up[axis] - right_px * right[axis]));
}

/** Shows the model as it was at first. */
function reset() {
  orbit = undefined;
  tried(draw());
}

/** One pointer turns, with the right button or Shift it moves; two pointers move and zoom. */
function followPointers() {
  const pointers = new Map();
  const middle = () => {
    const all = [...pointers.values()];
    const [x, y] = [0, 1].map((axis) => all.reduce((sum, at) => sum + at[axis], 0) / all.length);
    return { x, y, apart: all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0 };
  };
  const forget = (event) => pointers.delete(event.pointerId);
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    const before = middle();
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const after = middle();
    const [right, down] = [after.x - before.x, after.y - before.y];
    turn((orbit) => {
      if (pointers.size > 1 || event.shiftKey || event.buttons & 6) return void zoomAndPan(orbit);
      orbit.yaw -= right * 0.4;
      orbit.pitch += down * 0.4;
    });
    function zoomAndPan(orbit) {
      if (before.apart > 0 && after.apart > 0) orbit.radius *= before.apart / after.apart;
      pan(orbit, right, down);
    }
  });
  canvas.addEventListener("pointerup", forget);
  canvas.addEventListener("pointercancel", forget);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    // Lines and pages are some browsers' units.
    const unit_px = [1, 16, canvas.clientHeight][event.deltaMode] ?? 1;
    turn((orbit) => { orbit.radius *= Math.exp(Math.max(-500, Math.min(500, event.deltaY * unit_px)) * 0.001); });
  }, { passive: false });
  canvas.addEventListener("dblclick", (event) => tried(lookAt(event)));
}

/** Turns around what lies under the pointer; over the background the whole model is shown again. */
async function lookAt(event) {
  if (!isLoaded) return;
  const scale = canvas.width / Math.max(canvas.clientWidth, 1);
  const under = await inTurn(() => state.viewer.pick(event.offsetX * scale, event.offsetY * scale));
  if (!under) return reset();
  turn((orbit) => { orbit.target = [...under.position]; });
}

/** The keys that the canvas takes while it has the focus. */
function followKeys(event) {
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  const zoom = { "+": 1 / 1.2, "=": 1 / 1.2, "-": 1.2 }[event.key];
  if (!arrow && !zoom && event.key !== "Home" || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  if (event.key === "Home") return reset();
  turn((orbit) => {
    if (zoom) orbit.radius *= zoom;
    else if (event.shiftKey) pan(orbit, -20 * arrow[0], -20 * arrow[1]);
    else [orbit.yaw, orbit.pitch] = [orbit.yaw + 5 * arrow[0], orbit.pitch - 5 * arrow[1]];
  });
}

/** The value of a key of the address, which `pattern` describes; errors say what it should be. */
function asked(key, pattern, example) {
  const text = query.get(key);
  const found = text === null ? null : pattern.exec(text);
  if (text !== null && !found) throw new Error(`?${key}=${text} is no ${key}: write for example ?${key}=${example}`);
  return found?.slice(1).map(Number);
}

/** Lets time go by, or stand. */
function playOrPause() {
  shownAt = shownAt === undefined ? performance.now() : undefined;
  play.textContent = shownAt === undefined ? "Play" : "Pause";
  return draw();
}

function setSize() {
  const scale = Math.min(devicePixelRatio, 2);
  [canvas.width, canvas.height] = [Math.round(innerWidth * scale), Math.round(innerHeight * scale)];
  [canvas.style.width, canvas.style.height] = [`${innerWidth}px`, `${innerHeight}px`];
}

try {
  [time] = asked("time", /^(\d+(?:\.\d+)?)$/, "1.5") ?? [0];
  if (bare) {
    const size = asked("size", /^([1-9]\d{0,4})x([1-9]\d{0,4})$/, "640x360");
    [canvas.width, canvas.height] = size;
    document.body.classList.add("bare");
  } else setSize();
  say("Loading …");
  await init();
  state.viewer = await create(canvas, query.get("backend") ?? "auto");
  followPointers();
  canvas.addEventListener("keydown", followKeys);
  play.addEventListener("click", () => tried(playOrPause()));
  document.getElementById("files").addEventListener("change", (event) => tried(openFiles([...event.target.files])));
  const dropping = (is) => document.body.classList.toggle("dropping", is);
  addEventListener("dragover", (event) => { event.preventDefault(); dropping(true); });
  addEventListener("dragleave", () => dropping(false));
  addEventListener("drop", (event) => {
    event.preventDefault();
    dropping(false);
    tried(openFiles([...event.dataTransfer.files]));
  });
  if (!bare) addEventListener("resize", () => { tried(inTurn(setSize)); tried(draw()); });
  await openUrl(query.get("model") ?? "demo:hall");
  if (!query.has("model")) say("The built-in hall. Drop a .glb here, or a .gltf or .stage.toml together with its files. Drag to turn, scroll or pinch to zoom, drag with the right button or two fingers to move, double-click to turn around a point.");
  state.ready = true;
} catch (error) {
  document.body.classList.remove("bare");
  state.error = error.message ?? String(error);
  say(state.error);
}
