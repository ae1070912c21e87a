// ?model=URL  ?backend=auto|webgpu|webgl  ?size=WIDTHxHEIGHT
import init, { create } from "./manypass_web.js";

const query = new URLSearchParams(location.search);
const canvas = document.getElementById("canvas");
const message = document.getElementById("message");
const state = (window.manypass = { viewer: null, ready: false, error: null });
const orbit = { yaw_deg: 30, pitch_deg: 15, radius_m: 0 };
const say = (text) => { message.textContent = text; };
const draw = () => state.viewer.render(orbit.yaw_deg, orbit.pitch_deg, orbit.radius_m);

/** Relative addresses in a .gltf; nothing for a .glb. */
function references(bytes) {
  if (new TextDecoder().decode(bytes.subarray(0, 4)) === "glTF") return [];
  const json = JSON.parse(new TextDecoder().decode(bytes));
  return [...(json.buffers ?? []), ...(json.images ?? [])].map((entry) => entry.uri).filter((uri) => uri && !uri.startsWith("data:"));
}

async function openUrl(url) {
  const get = async (address) => {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`${address}: ${answer.status} ${answer.statusText}`);
    return new Uint8Array(await answer.arrayBuffer());
  };
  const base = new URL(url, location.href);
  const bytes = await get(base);
  const pairs = await Promise.all(references(bytes).map(async (uri) => [uri, await get(new URL(uri, base))]));
  show(bytes, new Map(pairs));
}

async function openFiles(files) {
  const main = files.find((file) => /\.(glb|gltf)$/i.test(file.name));
  if (!main) throw new Error("Choose a .glb, or a .gltf together with its other files.");
  const read = async (file) => new Uint8Array(await file.arrayBuffer());
  const bytes = await read(main);
  const pairs = await Promise.all(references(bytes).map(async (uri) => {
    const name = decodeURIComponent(uri).split("/").pop();
    const file = files.find((candidate) => candidate.name === name);
    if (!file) throw new Error(`${main.name} refers to ${uri}: choose that file too.`);
    return [uri, await read(file)];
  }));
  show(bytes, new Map(pairs));
}

function show(bytes, resources) { state.viewer.load(bytes, resources); say(""); draw(); }
const tried = (action) => action.catch((error) => say(error.message ?? String(error)));

try {
  await init();
  const [width, height] = (query.get("size") ?? `${innerWidth}x${innerHeight}`).split("x").map(Number);
  [canvas.width, canvas.height] = [width, height];
  state.viewer = await create(canvas, query.get("backend") ?? "auto");
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    orbit.yaw_deg -= event.movementX * 0.4;
    orbit.pitch_deg = Math.max(-89, Math.min(89, orbit.pitch_deg + event.movementY * 0.4));
    draw();
  });
  document.getElementById("files").addEventListener("change", (event) => tried(openFiles([...event.target.files])));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => { event.preventDefault(); tried(openFiles([...event.dataTransfer.files])); });
  draw();
  if (query.has("model")) await openUrl(query.get("model"));
  state.ready = true;
} catch (error) {
  state.error = error.message ?? String(error);
  say(state.error);
}
