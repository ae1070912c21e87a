//! What goes to JavaScript and comes from it: the types of the page's interface, and values of them.

use crate::camera::Orbit;
use glam::Vec3;
use std::collections::BTreeMap;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
import type { BuiltInEffectName, QualityName, Settings, VariableName } from "./manypass_settings.js";
/** Which API draws. `auto` takes WebGPU where there is an adapter, else WebGL 2. */
export type Backend = "auto" | "webgpu" | "webgl";
/** The adapter in use, and the size of the picture in pixels. */
export interface ViewerInfo {
  backend: "webgpu" | "webgl"; adapter: string; driver: string; width: number; height: number;
  /** What the setting `quality.budget_ms` chose; null without it. */
  quality: QualityInfo | null;
}
/**
 * The rung of the ladder of docs/quality.md that frames are drawn with, the settings that it has in place of those without a
 * budget, how often it changed, after how many frames it did last, and the median of the last frames in milliseconds: from the
 * begin of `render()` until the device has drawn. Null before any frame counts.
 */
export interface QualityInfo {
  budgetMs: number; rung: string; settings: Settings; changes: number; settledAfterFrames: number; medianMs: number | null;
}
/**
 * A camera that looks at `target` (metres) from `radius` metres away. Yaw 0 degrees looks along -Z and grows towards +X;
 * positive pitch looks down from above. What is missing is as in `startOrbit()`.
 */
export interface Orbit { yaw?: number; pitch?: number; radius?: number; target?: [number, number, number]; }
/** How frames are drawn; what is left out keeps its value. The first options are short ways to settings. */
export interface RenderOptions {
  path?: Settings["render.path"];
  lightCulling?: Settings["lights.culling"];
  /**
   * Lights nothing, or with the built-in studio, or with the sky (the settings
   * `environment.sun_elevation_deg` and its neighbours), or with the picture of `loadEnvironment` or the stage, or a colour; `auto` takes
   * the picture if there is one, else the studio, faint where the model has lights.
   */
  environment?: Settings["environment.source"];
  tonemap?: Settings["tone_map.curve"];
  /** Stops, or metered once for a model: "auto", "auto+1", "auto-0.5". Null: "auto" where the model has lights, else 0. */
  exposure?: number | string | null;
  /** Only the lights k, k + n, k + 2n, … of [k, n]; null takes all. */
  lightSubset?: [number, number] | null;
  /** A table of settings that comes before all others (docs/quality.md); null for none. The best that `quality.budget_ms` takes. */
  quality?: QualityName | null;
  /** Settings by key, as in `--set` on the command line: `{ "clusters.tile_px": 32, "tone_map.curve": "agx" }`. */
  settings?: Settings;
}
/**
 * An effect of one's own, as on the command line: the name of its file, which stands in errors, the file's text, and settings
 * by key (`{ "echo.share": 0.25 }`).
 */
export interface EffectFile { file: string; source: string; settings?: Settings; }
/** An effect that is built in, by its name. */
export interface BuiltInEffect { name: BuiltInEffectName; settings?: Settings; }
/**
 * Something that is drawn over the picture: `text`, a `sprite`, or a line through `points` or `points_world`. The keys are those
 * of `[[overlay]]` in stages, which docs/overlay.md explains. Places are pixels from the upper left corner, below 0 from the right
 * or the lower edge; or metres of the world.
 */
export interface OverlayItem {
  text?: string;
  /** The name of an image among the resources. */
  sprite?: string;
  points?: [number, number][];
  points_world?: [number, number, number][];
  position?: [number, number];
  anchor?: "top-left" | "top" | "top-right" | "left" | "center" | "right" | "bottom-left" | "bottom" | "bottom-right";
  at_world?: [number, number, number];
  /** The name of a node of the model. */
  node?: string;
  /** Whether opaque surfaces hide what lies behind them, of items at places of the world. */
  depth_test?: boolean;
  depth_offset_m?: number;
  /** `"rrggbb"` in sRGB, or three numbers in linear light. */
  color?: string | [number, number, number];
  opacity?: number;
  size_px?: number;
  align?: "left" | "center" | "right";
  /** The name of a TrueType or OpenType file among the resources. */
  font?: string;
  background?: string | [number, number, number];
  background_opacity?: number;
  padding_px?: number;
  width_px?: number;
  height_px?: number;
  rotation_deg?: number;
}
/**
 * What calls reject with when the WebGL context or the WebGPU device was lost, those that were under way at once and later ones
 * until the viewer is restored. The viewer restores itself: model, options and effects are as before, simulations begin anew.
 */
export interface ContextLostError extends Error {
  name: "ContextLost";
  /**
   * `too-many-contexts`: browsers give a page so many WebGL contexts (Chromium 16, on Android 8) and take the oldest for one more. The
   * viewer restores itself when another one is disposed of. Viewers on WebGPU share a device, and there is no such limit.
   */
  reason: "too-many-contexts" | "unknown";
}
/** What calls of a viewer reject with that was disposed of. */
export interface DisposedError extends Error { name: "Disposed"; }
/** The exposure in use: how it was found, what it comes to, and the log-average luminance if it was metered. */
export interface ExposureInfo { mode: "auto" | "stops"; stops: number; logAverageLuminance: number | null; }
/** The values of a variable: `channels` a pixel, rows from the top. Those of ids are a Uint32Array, all others a Float32Array. */
export interface Variable { name: VariableName; width: number; height: number; channels: number; data: Float32Array | Uint32Array; }
/**
 * What a pixel shows: the ids of the node and the material, which are their indices plus 1, their names, empty where the file
 * gives none, and where the surface is, in metres.
 */
export interface PickedPixel {
  objectId: number; object: string; materialId: number; material: string; position: [number, number, number];
}
/** What a `.gltf` refers to: its relative addresses as written in the file, and the bytes. */
export type Resources = Map<string, Uint8Array> | Record<string, Uint8Array>;
"#;

#[wasm_bindgen]
extern "C" {
    /// `Backend` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Backend")]
    pub type BackendName;
    /// `ViewerInfo` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "ViewerInfo")]
    pub type ViewerInfo;
    /// `Orbit` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Orbit")]
    pub type OrbitObject;
    /// `RenderOptions` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "RenderOptions")]
    pub type RenderOptions;
    /// `ExposureInfo` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "ExposureInfo")]
    pub type ExposureInfo;
    /// `VariableName` of `manypass_settings.d.ts`.
    #[wasm_bindgen(typescript_type = "VariableName")]
    pub type VariableName;
    /// `Variable` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Variable")]
    pub type Variable;
    /// `PickedPixel` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "PickedPixel")]
    pub type PickedPixel;
    /// Effects of the TypeScript section.
    #[wasm_bindgen(typescript_type = "(EffectFile | BuiltInEffect)[]")]
    pub type EffectFiles;
    /// Items of an overlay of the TypeScript section.
    #[wasm_bindgen(typescript_type = "OverlayItem[]")]
    pub type OverlayItems;
    /// `Resources` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Resources | undefined")]
    pub type Resources;
}

/// An object of JavaScript.
pub fn object(entries: &[(&str, JsValue)]) -> JsValue {
    let object = js_sys::Object::new();
    for (key, value) in entries {
        // Setting a property of a plain object cannot fail.
        let _ = js_sys::Reflect::set(&object, &(*key).into(), value);
    }
    object.into()
}

/// An orbit from JavaScript, whose target is told in the space of a file in which world space has its origin at
/// `origin_m`; what is missing, or no number, is taken from `start`.
pub fn read_orbit(value: &JsValue, start: Orbit, origin_m: Vec3) -> Orbit {
    let number = |object: &JsValue, key: &JsValue| {
        js_sys::Reflect::get(object, key).ok()?.as_f64().filter(|n| (*n as f32).is_finite())
    };
    let small = |key: &str| number(value, &key.into()).map(|n| n as f32);
    let target = js_sys::Reflect::get(value, &"target".into()).unwrap_or(JsValue::UNDEFINED);
    let mut target_world = start.target_world;
    for axis in 0..3 {
        if let Some(place_m) = number(&target, &axis.into()) {
            target_world[axis as usize] = (place_m - f64::from(origin_m[axis as usize])) as f32;
        }
    }
    Orbit {
        yaw_deg: small("yaw").unwrap_or(start.yaw_deg),
        pitch_deg: small("pitch").unwrap_or(start.pitch_deg),
        radius_m: small("radius").filter(|m| *m > 0.0).unwrap_or(start.radius_m),
        target_world,
    }
}

/// `uri` without percent-encoding; as it is where that is broken.
pub fn decode_uri(uri: &str) -> String {
    js_sys::decode_uri_component(uri).map_or_else(|_| uri.to_owned(), String::from)
}

/// The files that a model refers to, by their relative addresses.
pub fn read_resources(resources: &JsValue) -> BTreeMap<String, Vec<u8>> {
    let entries = match resources.dyn_ref::<js_sys::Map>() {
        Some(map) => js_sys::Array::from(&map.entries()),
        None => resources.dyn_ref::<js_sys::Object>().map(js_sys::Object::entries).unwrap_or_default(),
    };
    let pair = |entry: JsValue| {
        let entry = js_sys::Array::from(&entry);
        Some((entry.get(0).as_string()?, entry.get(1).dyn_ref::<js_sys::Uint8Array>()?.to_vec()))
    };
    entries.iter().filter_map(pair).collect()
}
