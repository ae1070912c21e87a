// What pages import: the module's viewer with calls that wait for their turn, and that outlives its context or device.
// manypass_web.d.ts says what is promised.
import init, { Viewer as Module, create as bind } from "./manypass_raw.js";

export * from "./manypass_raw.js";
export default init;

/** The context or the device went away, and with it what was under way; `reason` says why, as far as that is known. */
export class ContextLost extends Error {
  constructor(message, reason, options) {
    super(message, options);
    this.name = "ContextLost";
    this.reason = reason;
  }
}

/** The viewer was disposed of. */
export class Disposed extends Error {
  constructor() {
    super("the viewer was disposed of");
    this.name = "Disposed";
  }
}

/** Calls that take time. */
const SLOW = new Set(["loadBeforeImages", "pick", "pixels", "radiance", "refine", "render", "variable"]);
/** Calls that only say what is; while a slow one is under way they say what was before it. */
const ANSWERS = ["exposure", "info", "missingImages", "modelRadius", "moves", "scenes", "startOrbit", "variants", "waitsForImages", "warnings"];
/** Calls that are the viewer's own, or nobody's but its. */
const OWN = new Set(["constructor", "dispose", "free", "loss", "restore", "setTime", "shownTime"]);
/** Slow calls that draw. */
const FRAMES = new Set(["refine", "render"]);
/** After so many milliseconds each a lost WebGPU device is asked for again. */
const RETRIES_MS = [0, 500, 2000, 8000];

/** No browser takes a context away because there are others while there are fewer of these: 8 on Android, 16 in Chromium. */
const CONTEXTS_MIN = 8;

/** References to viewers that draw with WebGL, the oldest first: who forgets to dispose of one keeps it no longer than without this. */
const ofWebGl = new Set();

function viewersOfWebGl() {
  return [...ofWebGl].map((reference) => reference.deref()).filter(Boolean);
}

/** Of canvases whose viewer was disposed of: what restores their context, and when its loss was told. */
const released = new WeakMap();
/** The last call that asked for a device, settled or not. */
let binding = Promise.resolve();

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** One after the other: with WebGPU the second viewer takes the device of the first. */
function inOrder(action) {
  const done = binding.then(action);
  binding = done.catch(() => {});
  return done;
}

export class Viewer extends EventTarget {
  /** Called with the error when the context or the device was lost, as the event `lost`. */
  onlost = null;
  /** Called when everything is there again, as the event `restored`: draw then. */
  onrestored = null;
  /** Called with `{ simulation, done, total }` while `render` steps simulations, as the event `simulating`. */
  onsimulating = null;

  #canvas;
  /** The context of WebGL, and what loses and restores it; null with WebGPU. */
  #context;
  #extension;
  #reference = new WeakRef(this);
  #module;
  #loss;
  /** The last of the calls, settled or not; it never rejects. */
  #queue = Promise.resolve();
  /** What rejects the calls that have not settled, and whether they draw. */
  #open = new Map();
  /** What gives a frame under way a newer time. */
  #shownTime;
  /** Whether the module is at a slow call, so that it takes no other. */
  #isBusy = false;
  /** What was answered before the slow call. */
  #answers = {};
  /** Why calls are refused, if they are. */
  #refusal = null;

  /** Made by `create`. */
  constructor(canvas, module) {
    super();
    this.#canvas = canvas;
    this.#module = module;
    this.#context = module.info().backend === "webgl" ? canvas.getContext("webgl2") : null;
    // A context that is lost already has none.
    this.#extension = this.#context?.getExtension("WEBGL_lose_context") ?? null;
    this.#watch();
    this.#shownTime = module.shownTime();
    const reference = this.#reference;
    this.#shownTime.listen((simulation, done, total) => reference.deref()?.#tellProgress({ simulation, done, total }));
    if (this.#context) {
      ofWebGl.add(this.#reference);
      canvas.addEventListener("webglcontextlost", this.#onContextLost);
      canvas.addEventListener("webglcontextrestored", this.#onContextRestored);
    }
  }

  /** Frees the GPU's memory and lets go of the canvas, whatever is under way. */
  dispose() {
    if (this.#refusal instanceof Disposed) return;
    this.#canvas.removeEventListener("webglcontextlost", this.#onContextLost);
    this.#canvas.removeEventListener("webglcontextrestored", this.#onContextRestored);
    this.#refuse(new Disposed());
    const module = this.#module;
    const free = () => {
      // What a lost device complains of is nobody's business any more.
      try { module.dispose(); } catch (error) { console.debug(`dispose: ${error}`); }
      this.#release();
    };
    if (this.#isBusy) this.#queue = this.#queue.then(free);
    else free();
  }

  [Symbol.dispose ?? Symbol("dispose")]() { this.dispose(); }

  /** Gives the context back at once: browsers count it until they collect garbage. One that was taken for it may return. */
  #release() {
    ofWebGl.delete(this.#reference);
    if (!this.#context || !this.#extension) return;
    const isLost = this.#context.isContextLost();
    const told = isLost ? Promise.resolve() : new Promise((done) => {
      // Without this a later viewer on the canvas could not have it.
      const keep = (event) => { event.preventDefault(); done(); };
      this.#canvas.addEventListener("webglcontextlost", keep, { once: true });
    });
    released.set(this.#canvas, { extension: this.#extension, told });
    if (isLost) return;
    this.#extension.loseContext();
    for (const viewer of viewersOfWebGl()) {
      if (viewer.#refusal?.reason !== "too-many-contexts" || !viewer.#context.isContextLost()) continue;
      viewer.#extension?.restoreContext();
      return;
    }
  }

  /** Tries again to have a device after a loss; the viewer does so by itself. */
  restore() {
    const done = this.#queue.then(() => this.#restoreNow());
    this.#queue = done.catch(() => {});
    return done;
  }

  #onContextLost = (event) => {
    // Without this the browser never restores it.
    event.preventDefault();
    this.#lose();
  };

  #onContextRestored = () => { this.restore().catch((error) => console.debug(`restore: ${error}`)); };

  #watch() {
    this.#loss = this.#module.loss();
    this.#loss.listen(() => this.#lose());
  }

  /** Rejects all calls, and those to come; what is under way ends in the module. */
  #refuse(error) {
    this.#refusal = error;
    for (const reject of this.#open.keys()) reject(error);
    this.#open.clear();
    this.#loss.happen();
  }

  #lose() {
    if (this.#refusal) return;
    const error = this.#lossNow();
    this.#refuse(error);
    this.onlost?.(error);
    this.dispatchEvent(new CustomEvent("lost", { detail: error }));
    if (!this.#context) this.#restoreLater();
  }

  /** Why the context or the device is lost: what else takes a context takes those of all viewers. */
  #lossNow() {
    const others = viewersOfWebGl().filter((viewer) => viewer !== this && !viewer.#context.isContextLost()).length;
    if (this.#context && others >= CONTEXTS_MIN) {
      return new ContextLost(`the browser took the oldest WebGL context away, because it allows no more than the ${others} others`
        + " (Chromium: 16); the viewer restores itself when another one is disposed of", "too-many-contexts");
    }
    const what = this.#context ? "WebGL context" : "WebGPU device";
    return new ContextLost(`the ${what} was lost; the viewer restores itself when the browser gives another`, "unknown");
  }

  async #restoreLater() {
    for (const after_ms of RETRIES_MS) {
      await pause(after_ms);
      if (!(this.#refusal instanceof ContextLost)) return;
      try { return await this.restore(); } catch (error) { console.debug(`restore: ${error}`); }
    }
  }

  /** In its turn: the call that was under way when the device was lost has ended. */
  async #restoreNow() {
    if (!this.#refusal) return;
    if (!(this.#refusal instanceof ContextLost)) throw this.#refusal;
    if (this.#context?.isContextLost()) throw this.#refusal;
    this.#isBusy = true;
    try {
      await inOrder(() => this.#module.restore());
    } catch (error) {
      const message = `the device was lost, and there is no other: ${error.message ?? error}`;
      const failed = new ContextLost(message, this.#refusal?.reason ?? "unknown", { cause: error });
      if (this.#refusal instanceof ContextLost) this.#refusal = failed;
      throw failed;
    } finally {
      this.#isBusy = false;
    }
    if (this.#refusal instanceof Disposed) throw this.#refusal;
    this.#refusal = null;
    this.#watch();
    if (this.#refusal) throw this.#refusal;
    this.onrestored?.();
    this.dispatchEvent(new Event("restored"));
  }

  /** Why a call that is made now is refused; null if it is not. */
  #refusalNow() {
    // Events come later than the loss.
    if (!this.#refusal && this.#context?.isContextLost()) this.#lose();
    return this.#refusal;
  }

  /** What `action` makes of the module once all calls before have settled. */
  #inTurn(action, draws = false) {
    const refusal = this.#refusalNow();
    if (refusal) return Promise.reject(refusal);
    return new Promise((resolve, reject) => {
      this.#open.set(reject, draws);
      const run = async () => {
        // It was rejected while it waited.
        if (!this.#open.has(reject)) return;
        try {
          const refusal = this.#refusalNow();
          if (refusal) throw refusal;
          const result = await action(this.#module);
          this.#open.delete(reject);
          resolve(result);
        } catch (error) {
          const typed = await this.#typed(error);
          this.#open.delete(reject);
          reject(typed);
        }
      };
      this.#queue = this.#queue.then(run);
    });
  }

  /** The error of a loss in place of what the loss led to, which may come first. */
  async #typed(error) {
    if (!this.#refusalNow() && !this.#context) await pause(0);
    return this.#refusal ?? error;
  }

  #slow(name, args) {
    return this.#inTurn(async (module) => {
      this.#answers = Object.fromEntries(ANSWERS.map((answer) => [answer, module[answer]()]));
      this.#isBusy = true;
      try { return await module[name](...args); } finally { this.#isBusy = false; }
    }, FRAMES.has(name));
  }

  /** A frame that steps simulations turns back to an earlier time, if nothing but frames is to come before. */
  setTime(secs) {
    const areFrames = [...this.#open.values()].every((draws) => draws);
    if (this.#isBusy && areFrames && !this.#refusalNow() && this.#shownTime.redirect(secs)) return;
    return this.#quick("setTime", [secs]);
  }

  #tellProgress(progress) {
    if (this.#refusal) return;
    this.onsimulating?.(progress);
    this.dispatchEvent(new CustomEvent("simulating", { detail: progress }));
  }

  /** At once if nothing is under way, else a promise. */
  #quick(name, args) {
    if (this.#open.size || this.#isBusy) return this.#inTurn((module) => module[name](...args));
    const refusal = this.#refusalNow();
    if (refusal) throw refusal;
    return this.#module[name](...args);
  }

  #answer(name, args) {
    if (this.#refusal instanceof Disposed) throw this.#refusal;
    return this.#isBusy ? structuredClone(this.#answers[name]) : this.#module[name](...args);
  }

  static {
    for (const name of Object.getOwnPropertyNames(Module.prototype)) {
      if (OWN.has(name) || name.startsWith("__")) continue;
      const call = SLOW.has(name) ? function (...args) { return this.#slow(name, args); }
        : ANSWERS.includes(name) ? function (...args) { return this.#answer(name, args); }
        : function (...args) { return this.#quick(name, args); };
      Object.defineProperty(this.prototype, name, { value: call, writable: true, configurable: true });
    }
  }
}

/** Restores the context of a canvas whose viewer was disposed of. */
async function regain(canvas) {
  const former = released.get(canvas);
  if (!former) return;
  released.delete(canvas);
  await Promise.race([former.told, pause(1000)]);
  // Not while the event of the loss is told.
  await pause(0);
  if (!canvas.getContext("webgl2")?.isContextLost()) return;
  const restored = new Promise((done) => canvas.addEventListener("webglcontextrestored", done, { once: true }));
  former.extension.restoreContext();
  // Binding says what is wrong where there is none.
  await Promise.race([restored, pause(5000)]);
}

/** Binds `canvas` to the first of the APIs that there is, or to the one that `backend` names. */
export function create(canvas, backend) {
  return inOrder(async () => {
    await regain(canvas);
    return new Viewer(canvas, await bind(canvas, backend));
  });
}
