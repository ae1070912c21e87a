// ?model=URL|demo:hall  ?backend=auto|webgpu|webgl  ?size=WIDTHxHEIGHT (without it the canvas fills the window)  ?time=SECONDS
// ?draw=later: nothing is drawn before `window.manypass.draw()` is called, for a page that changes the viewer first
import { follow } from "./controls.js";
import init, { create, modelFiles, stageEnvironment, stageImages, stageModel } from "./manypass_web.js";

const query = new URLSearchParams(location.search);
const canvas = document.getElementById("canvas");
const message = document.getElementById("message");
const state = (window.manypass = { viewer: null, ready: false, error: null, isWhole: false, draw: drawNow, orbit: () => orbit });
/** Nothing until the user turns: then the view sets out from the file's camera. */
let orbit;
/** The nearest and the farthest that the user may be. */
let nearest_m, farthest_m;
/** Whether there is a model to draw. */
let isLoaded = false;
/** Whether nothing is drawn yet. */
let isHeld = query.get("draw") === "later";
/** Rises with every wish, so that older ones give way. */
let latest = 0;
/** Rises with every model, so that textures of former ones are left alone. */
let opened = 0;
/** Whether textures are still to come: edges are smoothed once all are there. */
let isComing = false;
/** Effects of dropped files, by name of file, in their order. They stay when another model comes. */
const effects = new Map();
/** With a fixed size, for tests and pictures, a frame is one sample a pixel, and nothing but the canvas is shown. */
const bare = query.has("size");

const play = document.getElementById("play");
/** The time that is shown in seconds, and when that was; nothing while it stands. */
let time = 0;
let shownAt;

/** So many warnings have room. */
const WARNINGS_SHOWN = 5;

const say = (text) => { message.textContent = text; };
/** The first warnings, and how many more there are. */
function sayWarnings(viewer) {
  const warnings = viewer.warnings(), shown = warnings.slice(0, WARNINGS_SHOWN);
  if (warnings.length > shown.length) shown.push(`… and ${warnings.length - shown.length} more, which viewer.warnings() has.`);
  say(shown.join("\n"));
}
const tried = (action) => action.catch((error) => say(error.message ?? String(error)));

/** What takes several calls of the viewer waits here for its turn. */
let queue = Promise.resolve();
const inTurn = (action) => (queue = queue.catch(() => {}).then(action));

/** Draws; gives way to a later wish, and smooths edges for as long as there is none. */
function draw() {
  const mine = ++latest;
  return inTurn(async () => {
    if (!isLoaded || isHeld || mine !== latest) return;
    if (shownAt !== undefined) {
      const now = performance.now();
      // What waited for long does not make up for it.
      time += Math.min(now - shownAt, 100) / 1000;
      shownAt = now;
      await state.viewer.setTime(time);
    }
    await state.viewer.render(orbit);
    await new Promise(requestAnimationFrame);
    if (shownAt !== undefined) return void tried(draw());
    while (!bare && !isComing && mine === latest && await state.viewer.refine()) await new Promise(requestAnimationFrame);
  });
}

function drawNow() {
  isHeld = false;
  return draw();
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

/**
 * Shows a model or a stage; `get` fetches what they refer to, by a path (of a stage) or an address (of a model, from the model's
 * place). `adorn` is called with the viewer when it is loaded.
 */
async function open(name, bytes, get, adorn) {
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
    const load = (viewer, found) => viewer.loadBeforeImages(bytes, found, images);
    await show(name, await parts(bytes, buffers), load, { isWhole: false, adorn });
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
  return show(name, found, (viewer, found) => viewer.loadStage(bytes, found), { adorn });
}

async function openUrl(address) {
  if (address.startsWith("demo:")) return show(address, [], (viewer) => viewer.loadDemo(address.slice(5)));
  const get = async (url) => {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
    return new Uint8Array(await answer.arrayBuffer());
  };
  const base = new URL(address, location.href);
  return open(base.pathname, await get(base), (uri, from = "") => get(new URL(uri, new URL(from, base))));
}

/** Lights what is shown with a picture, or puts an effect over it. */
async function adornWith(viewer, { name }, content) {
  if (/\.(hdr|exr)$/i.test(name)) return viewer.loadEnvironment(content);
  const former = effects.get(name);
  effects.set(name, { file: name, source: new TextDecoder().decode(content) });
  try {
    await viewer.setEffects([...effects.values()]);
  } catch (error) {
    // What does not compile leaves everything as it was.
    former ? effects.set(name, former) : effects.delete(name);
    throw error;
  }
}

async function openFiles(files) {
  const main = files.find((file) => isStage(file.name)) ?? files.find((file) => /\.(glb|gltf|obj|stl|ply|3mf)$/i.test(file.name));
  const beside = files.filter((file) => /\.(hdr|exr|wgsl|cube)$/i.test(file.name));
  if (!main && !beside.length) {
    throw new Error("Choose a model (.glb, .obj, .stl, .ply, .3mf), a .gltf together with its other files, a .stage.toml together with its model, an environment (.hdr, .exr), an effect (.wgsl) or a look-up table (.cube).");
  }
  const read = async (file) => new Uint8Array(await file.arrayBuffer());
  const contents = await Promise.all(beside.map(async (file) => [file, await read(file)]));
  /** What the model or stage names itself. */
  const taken = new Set();
  const adorn = async (viewer) => {
    for (const [file, content] of contents) {
      if (!taken.has(file)) await adornWith(viewer, file, content);
    }
  };
  if (main) {
    return open(main.name, await read(main), async (uri) => {
      const name = decodeURIComponent(uri).split("/").pop();
      const file = files.find((candidate) => candidate.name === name);
      if (!file) throw new Error(`${main.name} refers to ${uri}: choose that file too.`);
      taken.add(file);
      return read(file);
    }, adorn);
  }
  await inTurn(() => adorn(state.viewer));
  say(beside.map((file) => file.name).join(", "));
  await draw();
}

/** Loads with what was found of the files that are referred to; `isWhole` says whether its images come with it. */
async function show(name, found, load, { isWhole = true, adorn } = {}) {
  latest++;
  opened++;
  /** The model is shown all the same. */
  let fault;
  await inTurn(async () => {
    const viewer = state.viewer;
    isLoaded = isComing = false;
    try {
      await load(viewer, new Map(found));
    } finally {
      // A file that cannot be read leaves the model before.
      isLoaded = viewer.modelRadius() !== undefined;
    }
    isComing = viewer.waitsForImages();
    play.hidden = !viewer.moves();
    if (time > 0) await viewer.setTime(time);
    state.isWhole = isWhole;
    orbit = undefined;
    canvas.setAttribute("aria-label", `3D view of ${name.split("/").pop()}`);
    await adorn?.(viewer)?.catch((error) => { fault = error; });
    sayWarnings(viewer);
  });
  await draw();
  if (fault) throw fault;
}

/** Gives the model its textures and draws after each; edges are smoothed once all are there. With a fixed size it draws once, after all. */
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
    sayWarnings(state.viewer);
    await draw();
  }
  state.isWhole = mine === opened;
}

/** Those in the model's own file first, then the others as they come; says whether there were any. */
async function giveTextures(late, mine) {
  const step = async (action) => {
    for (;;) {
      try {
        return await inTurn(() => mine === opened && action(state.viewer));
      } catch (error) {
        if (error.name !== "ContextLost") throw error;
        await new Promise((done) => state.viewer.addEventListener("restored", done, { once: true }));
      }
    }
  };
  /** A frame that fails says so, and the next texture comes all the same. */
  const drawn = () => mine === opened && !bare && tried(draw());
  let came = late.length > 0;
  while (await step((viewer) => viewer.nextImage())) {
    came = true;
    await drawn();
  }
  for (const [uri, file] of late) {
    try {
      const bytes = await file;
      await step((viewer) => viewer.giveImage(decodeURIComponent(uri), bytes));
    } catch (error) {
      // The model stays without what cannot be had; the rest comes all the same.
      console.warn(`${uri}: ${error.message ?? error}`);
      await step((viewer) => viewer.missImage(decodeURIComponent(uri), String(error.message ?? error)));
      continue;
    }
    await drawn();
  }
  return came;
}

/** Leaves the file's camera as soon as the user turns, moves or zooms. */
function turn(change) {
  if (!isLoaded) return;
  if (!orbit) {
    orbit = state.viewer.startOrbit();
    if (!orbit) return;
    // Nearer there is nothing to see but the inside, and farther nothing at all; files' own cameras may stand there.
    const model_m = state.viewer.modelRadius() || orbit.radius;
    [nearest_m, farthest_m] = [Math.min(0.05 * model_m, orbit.radius), Math.max(50 * model_m, orbit.radius)];
  }
  change(orbit);
  orbit.pitch = Math.max(-89, Math.min(89, orbit.pitch));
  orbit.radius = Math.max(nearest_m, Math.min(farthest_m, orbit.radius));
  tried(draw());
}

/** Shows the model as it was at first. */
function reset() {
  orbit = undefined;
  tried(draw());
}

/** The numbers of a key of the address, which `pattern` finds; undefined without the key. What is wrong is told by name. */
function asked(key, pattern, expected) {
  const text = query.get(key);
  if (text === null) return undefined;
  const found = pattern.exec(text);
  if (!found) throw new Error(`?${key}=${text}: ${key} is ${expected}.`);
  return found.slice(1).map(Number);
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

/** Says what became of the graphics, and draws again. */
function followLoss(viewer) {
  viewer.onlost = () => say("The browser took the graphics away; waiting for it to give them back …");
  viewer.onrestored = () => {
    say("");
    tried(draw());
  };
}

/** Says how far simulations are on their way to another time, and then what was said before. */
function followSimulations(viewer) {
  let before, own;
  viewer.onsimulating = ({ simulation, done, total }) => {
    // What plays makes a few steps a frame.
    if (total < 100) return;
    if (message.textContent !== own) before = message.textContent;
    own = done < total ? `The simulation ${simulation}: ${done} of ${total} steps …` : before;
    say(own);
  };
}

try {
  [time] = asked("time", /^(\d+(?:\.\d+)?)$/, "a number of seconds, such as 1.5") ?? [0];
  if (bare) {
    [canvas.width, canvas.height] = asked("size", /^([1-9]\d{0,4})x([1-9]\d{0,4})$/, "WIDTHxHEIGHT in pixels, such as 640x360");
    document.body.classList.add("bare");
  } else setSize();
  say("Loading …");
  await init();
  state.viewer = await create(canvas, query.get("backend") ?? "auto");
  followLoss(state.viewer);
  followSimulations(state.viewer);
  follow(canvas, turn, reset);
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
  if (!query.has("model")) say("The built-in hall. Drop a .glb here, or a .gltf or .stage.toml together with its files. Drag to turn, scroll or pinch to zoom, drag with the right button or two fingers to move; a double click shows the whole again.");
  state.ready = true;
} catch (error) {
  document.body.classList.remove("bare");
  state.error = error.message ?? String(error);
  say(state.error);
}
