// ?model=URL|demo:hall  ?backend=auto|webgpu|webgl  ?size=WIDTHxHEIGHT (without it the canvas fills the window)  ?time=SECONDS
import init, { create, modelFiles, stageEnvironment, stageImages, stageModel } from "./manypass_web.js";

const query = new URLSearchParams(location.search);
const canvas = document.getElementById("canvas");
const message = document.getElementById("message");
const state = (window.manypass = { viewer: null, ready: false, error: null, isWhole: false, draw });
/** Nothing until the user turns: then the view sets out from the file's camera. */
let orbit;
/** Whether there is a model to draw. */
let isLoaded = false;
/** Rises with every wish, so that older ones give way. */
let latest = 0;
/** Rises with every model, so that textures of former ones are left alone. */
let opened = 0;
/** With a fixed size, for tests and pictures, a frame is one sample a pixel, and nothing but the canvas is shown. */
const bare = query.has("size");

const play = document.getElementById("play");
/** The time that is shown in seconds, and when that was; nothing while it stands. */
let time = Number(query.get("time")) || 0;
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
    while (!bare && mine === latest && await state.viewer.refine()) await new Promise(requestAnimationFrame);
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

async function openFiles(files) {
  const main = files.find((file) => isStage(file.name)) ?? files.find((file) => /\.(glb|gltf|obj|stl|ply|3mf)$/i.test(file.name));
  if (!main) throw new Error("Choose a model (.glb, .obj, .stl, .ply, .3mf), a .gltf together with its other files, or a .stage.toml together with its model.");
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
    play.hidden = !state.viewer.moves();
    if (time > 0) state.viewer.setTime(time);
    state.isWhole = isWhole;
    orbit = undefined;
    say(state.viewer.warnings().slice(0, 5).join("\n"));
  });
  await draw();
}

/** Gives the model its textures as they come, those in its own file first, and draws after each; with a fixed size once, after all. */
async function dress(late) {
  const mine = opened;
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
  if (mine !== opened) return;
  if (came) {
    say(state.viewer.warnings().slice(0, 5).join("\n"));
    await draw();
  }
  state.isWhole = mine === opened;
}

/** Leaves the file's camera as soon as the user turns or zooms. */
function turn(change) {
  if (!isLoaded) return;
  orbit ??= state.viewer.startOrbit();
  change(orbit);
  orbit.pitch = Math.max(-89, Math.min(89, orbit.pitch));
  tried(draw());
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
  if (bare) {
    [canvas.width, canvas.height] = query.get("size").split("x").map(Number);
    document.body.classList.add("bare");
  } else setSize();
  say("Loading …");
  await init();
  state.viewer = await create(canvas, query.get("backend") ?? "auto");
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => event.buttons && turn((orbit) => {
    orbit.yaw -= event.movementX * 0.4;
    orbit.pitch += event.movementY * 0.4;
  }));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    turn((orbit) => { orbit.radius *= Math.exp(event.deltaY * 0.001); });
  }, { passive: false });
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
  if (!query.has("model")) say("The built-in hall. Drop a .glb here, or a .gltf or .stage.toml together with its files. Drag to turn, scroll to zoom.");
  state.ready = true;
} catch (error) {
  document.body.classList.remove("bare");
  state.error = error.message ?? String(error);
  say(state.error);
}
