import type { Backend, ContextLostError, DisposedError, Viewer as Module } from "./manypass_raw.js";

export * from "./manypass_raw.js";
export type { BuiltInEffectName, QualityName, Settings, VariableName } from "./manypass_settings.js";
export { default } from "./manypass_raw.js";

type Slow = "loadBeforeImages" | "pick" | "pixels" | "radiance" | "refine" | "render" | "variable";
type Answers = "exposure" | "info" | "missingImages" | "modelRadius" | "moves" | "scenes" | "startOrbit" | "variants"
  | "waitsForImages" | "warnings";
type Own = "dispose" | "free" | "loss" | "restore" | "shownTime" | symbol;
type Quick = Exclude<keyof Module, Slow | Answers | Own>;
type Calls = Pick<Module, Slow | Answers> & {
  [Name in Quick]: (...args: Parameters<Module[Name]>) => ReturnType<Module[Name]> | Promise<ReturnType<Module[Name]>>;
};

/**
 * A canvas with a renderer behind it. Calls may overlap: each waits until those before it have settled.
 *
 * - What takes time (`render`, `refine`, `pick`, `loadBeforeImages` …) gives a promise.
 * - What changes the viewer (`load`, `configure`, `setTime` …) happens at once while nothing is under way, and throws what is wrong.
 *   Else it gives a promise. `await` is right for both.
 * - An earlier time wins: `setTime` while `render` steps simulations takes effect at once, and that frame shows it. A later one is the next frame's.
 * - What only says something (`info`, `moves`, `startOrbit` …) answers at once; while a frame is drawn, as it was before the frame.
 */
export interface Viewer extends Calls {}
/** How far a simulation is on its way to the time of `setTime`, in steps. */
export interface SimulationProgress { simulation: string; done: number; total: number; }
export class Viewer extends EventTarget {
  private constructor();
  /** Called when the WebGL context or the WebGPU device was lost, as the event `lost`, whose `detail` is the error. */
  onlost: ((error: ContextLost) => void) | null;
  /** Called when the viewer is as it was before the loss, as the event `restored`: call `render` then. */
  onrestored: (() => void) | null;
  /**
   * Called while `render` steps simulations to a time in several slices: after each slice, and at the end of each simulation. As the
   * event `simulating`, whose `detail` is the progress.
   */
  onsimulating: ((progress: SimulationProgress) => void) | null;
  /**
   * Asks for a device again after a loss. The viewer does so by itself: with WebGL when the browser restores the context, with
   * WebGPU four times within 11 seconds. Rejects with a `ContextLost` when there is none; resolves at once when nothing is lost.
   */
  restore(): Promise<void>;
  /**
   * Frees the GPU's memory and lets go of the canvas, whatever is under way: that rejects with a `Disposed`. Once is enough. `create`
   * may bind the canvas again.
   */
  dispose(): void;
}
export class ContextLost extends Error implements ContextLostError { name: "ContextLost"; reason: ContextLostError["reason"]; }
export class Disposed extends Error implements DisposedError { name: "Disposed"; }

/**
 * Binds `canvas`. A canvas keeps the first kind of context it was given, so `auto` decides before it touches one. Rejects when the
 * browser has no adapter for `backend`; the message says what to turn on.
 */
export function create(canvas: HTMLCanvasElement, backend?: Backend | null): Promise<Viewer>;
