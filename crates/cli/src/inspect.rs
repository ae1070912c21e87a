//! `info` and `adapters`: what is in a file and on this machine.

use crate::camera::{self, CameraSpec, DEFAULT_ORBIT, Place};
use crate::failure::Failure;
use crate::input::{Input, InputScene};
use crate::memory;
use crate::older::{self, ToldNames};
use crate::scenes;
use crate::session::{self, list};
use glam::Vec3;
use manypass::{Gpu, GpuError, ShadedIn, View};
use manypass_offline::camera::{CameraData, scene_cameras};
use manypass_offline::manifest;
use manypass_scene::gltf_file::SUPPORTED_EXTENSIONS;
use manypass_scene::{Aabb, Framing, LightKind, Primitive, Scene, Topology};
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::fmt::Write as _;

/// The size of the picture whose cameras `info` prints; their fields of view to the side depend on its shape.
const CAMERA_SIZE_PX: (u32, u32) = (1280, 720);

/// What `info` says, in the order in which people read it.
const KEYS: [&str; 20] = [
    "input",
    "extensions",
    "scenes",
    "nodes",
    "meshes",
    "primitives",
    "triangles",
    "triangles_drawn",
    "levels",
    "bounds_m",
    "materials",
    "textures",
    "images",
    "lights",
    "variants",
    "cameras",
    "automatic_camera",
    "skins",
    "animations",
    "warnings",
];

/// The one file that an argument names.
///
/// # Errors
/// It names more than one.
pub fn one(argument: impl AsRef<OsStr>) -> Result<Input, Failure> {
    let argument = argument.as_ref();
    let mut inputs = Input::parse(argument)?;
    match inputs.pop() {
        Some(input) if inputs.is_empty() => Ok(input),
        _ => Err(Failure::usage(format!("`{}` is more than one file", argument.display()), "name one model")),
    }
}

/// Runs `adapters`.
///
/// # Errors
/// If there is none, or standard output is full.
pub fn adapters(as_json: bool) -> Result<(), Failure> {
    memory::check_driver()?;
    let adapters = Gpu::adapters();
    if adapters.is_empty() {
        return Err(session::gpu_failure(&GpuError::NoAdapter));
    }
    if as_json {
        return list(&format!("{:#}\n", json!(adapters)));
    }
    let mut text = String::new();
    for adapter in adapters {
        let _ = writeln!(text, "{}  {}  {}  {}", adapter.name, adapter.backend, adapter.device_type, adapter.driver);
    }
    list(&text)
}

/// Runs `info`.
///
/// # Errors
/// An input that cannot be read.
pub fn info(argument: &OsStr, scene: Option<&str>, as_json: bool) -> Result<(), Failure> {
    let input = one(argument)?;
    let InputScene { scene: mut loaded, mut warnings, stage } = input.load()?;
    ToldNames::default().say(&input.name(), &older::of_input(&input, stage.as_ref()));
    scenes::show(&mut loaded, scene, &mut warnings)?;
    // As `render` draws it.
    let has_moved = loaded.bring_near();
    warnings.extend(has_moved.then(|| loaded.bounds_of_meshes().far_warning()).flatten());
    let value = describe(&input.name(), &loaded, warnings)?;
    list(&if as_json { format!("{value:#}\n") } else { as_text(&value) })
}

fn triangles(primitive: &Primitive) -> u64 {
    let count = if primitive.indices.is_empty() { primitive.positions.len() } else { primitive.indices.len() };
    if primitive.topology == Topology::Triangles { count as u64 / 3 } else { 0 }
}

fn describe(name: &str, scene: &Scene, mut warnings: Vec<String>) -> Result<Value, Failure> {
    let of_mesh =
        |index: usize| -> u64 { scene.meshes.get(index).map_or(0, |mesh| mesh.primitives.iter().map(triangles).sum()) };
    let visible = scene.visible_nodes();
    let drawn: u64 = visible.iter().filter_map(|id| scene.node(*id).mesh).map(of_mesh).sum();
    let mut images = Vec::new();
    for image in &scene.images {
        let size = image.dimensions().map_err(|error| warnings.push(error.to_string())).ok();
        images.push(json!({ "name": image.name, "width": size.map(|s| s.0), "height": size.map(|s| s.1) }));
    }
    let lights = |is_kind: fn(&LightKind) -> bool| {
        let held = visible.iter().filter_map(|id| scene.lights.get(scene.node(*id).light?));
        held.filter(|light| is_kind(&light.kind)).count()
    };
    let (width, height) = CAMERA_SIZE_PX;
    let framing = Framing::of_scene(scene);
    // As it is posed; what is drawn by boxes alone, such as a scene without vertices, has none.
    let whole = framing.outliers().map_or(*framing.bounds_world(), |outliers| outliers.bounds_world);
    let bounds = if scene.bounds_world().is_empty() { Aabb::EMPTY } else { whole };
    warnings.extend(bounds.far_warning());
    let in_file = |place: Vec3| (place.as_dvec3() + scene.origin_m.as_dvec3()).to_array();
    let bounds = (!bounds.is_empty()).then(|| json!({ "min": in_file(bounds.min), "max": in_file(bounds.max) }));
    Ok(json!({
        "input": name,
        "extensions": scene.extensions_used.iter().map(|name| json!({
            "name": name, "is_read": SUPPORTED_EXTENSIONS.contains(&name.as_str()),
        })).collect::<Vec<_>>(),
        "scenes": scene.scenes.iter().enumerate().map(|(index, roots)| json!({
            "index": index, "name": roots.name, "is_shown": scene.shown_scene == Some(index),
        })).collect::<Vec<_>>(),
        "nodes": manifest::nodes(scene),
        "meshes": scene.meshes.len(),
        "primitives": scene.meshes.iter().map(|mesh| mesh.primitives.len()).sum::<usize>(),
        "triangles": (0..scene.meshes.len()).map(of_mesh).sum::<u64>(),
        "triangles_drawn": drawn,
        "levels": manifest::levels(scene),
        "materials": manifest::materials(scene),
        "textures": scene.textures.len(),
        "images": images,
        "lights": {
            "directional": lights(|kind| matches!(kind, LightKind::Directional)),
            "point": lights(|kind| matches!(kind, LightKind::Point)),
            "spot": lights(|kind| matches!(kind, LightKind::Spot { .. })),
        },
        "camera_size_px": [width, height],
        "variants": scene.variants,
        "cameras": scene_cameras(scene, width, height),
        "automatic_camera": automatic_camera(scene, &framing)?,
        "skins": scene.skins.len(),
        "animations": scene.animations.iter().map(|animation| json!({
            "name": animation.name, "duration_secs": animation.duration_secs(), "channels": animation.channels.len() + animation.properties.len(),
        })).collect::<Vec<_>>(),
        "bounds_m": bounds,
        "warnings": warnings,
    }))
}

/// The camera of a picture without a camera's flags, as if the file had no cameras.
fn automatic_camera(scene: &Scene, framing: &Framing) -> Result<CameraData, Failure> {
    let (width, height) = CAMERA_SIZE_PX;
    let place = if scene.placed_cameras().is_empty() { Place::Default } else { DEFAULT_ORBIT };
    let spec = CameraSpec { place, ..CameraSpec::default() };
    let aspect = width as f32 / height as f32;
    let (world_from_view, projection) = camera::resolve(&spec, scene, framing, aspect, 0.0)?;
    Ok(CameraData::from_origin(&View { world_from_view, projection }, scene.origin_m, width, height))
}

/// What people read of a camera.
const CAMERA_KEYS: [&str; 8] = ["index", "name", "kind", "eye_world_m", "fov_y_deg", "height_m", "near_m", "far_m"];

/// What people read of a material: its name, and if it is not shaded from the G-buffer, where it is and because of
/// what.
fn material(material: &Value) -> Value {
    let name = material["name"].as_str().filter(|name| !name.is_empty()).unwrap_or("(no name)");
    let layers: Vec<&str> = material["layers"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let shading = material["shading"].as_str().unwrap_or_default();
    if shading == ShadedIn::Deferred.name() {
        return name.into();
    }
    let because = if layers.is_empty() { String::new() } else { format!(" because of {}", layers.join(", ")) };
    format!("{name} ({shading}{because})").into()
}

/// What people read of a value: of nodes their number, of materials their names, of cameras no matrices.
fn shortened(key: &str, value: &Value) -> Value {
    let camera = |camera: &Value| {
        let fields = CAMERA_KEYS.iter().filter_map(|key| Some(((*key).to_owned(), camera.get(key)?.clone())));
        Value::Object(fields.filter(|(key, value)| !value.is_null() || key == "far_m").collect())
    };
    let list = |each: &dyn Fn(&Value) -> Value| value.as_array().map(|entries| entries.iter().map(each).collect());
    match key {
        "extensions" => list(&|extension| match extension["is_read"].as_bool() {
            Some(true) => extension["name"].clone(),
            _ => {
                format!("{} (not read: the model is drawn without it)", extension["name"].as_str().unwrap_or_default())
                    .into()
            }
        })
        .unwrap_or_default(),
        "nodes" => value.as_array().map_or(0, Vec::len).into(),
        "levels" => list(&|levels| {
            format!(
                "{}: {} coarser",
                levels["name"].as_str().unwrap_or_default(),
                levels["coarser"].as_array().map_or(0, Vec::len)
            )
            .into()
        })
        .unwrap_or_default(),
        "materials" => list(&material).unwrap_or_default(),
        "cameras" => list(&camera).unwrap_or_default(),
        "automatic_camera" => camera(value),
        _ => value.clone(),
    }
}

/// The same for people: numbers on lines of their own, lists as one indented line an entry.
fn as_text(value: &Value) -> String {
    let mut text = String::new();
    for key in KEYS {
        let label = key.replace('_', " ");
        let _ = match &shortened(key, &value[key]) {
            Value::Array(entries) => {
                let lines: String = entries.iter().map(|entry| format!("  {}\n", inline(entry))).collect();
                write!(text, "{label}: {}\n{lines}", entries.len())
            }
            value => writeln!(text, "{label}: {}", inline(value)),
        };
    }
    text
}

fn inline(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) if text.is_empty() => "(no name)".into(),
        Value::String(text) => text.clone(),
        Value::Array(entries) => entries.iter().map(inline).collect::<Vec<_>>().join(" "),
        Value::Object(fields) => {
            let field = |(key, value): (&String, &Value)| format!("{} {}", key.replace('_', " "), inline(value));
            fields.iter().map(field).collect::<Vec<_>>().join(", ")
        }
        Value::Number(number) if number.is_f64() => {
            let rounded = format!("{:.3}", number.as_f64().unwrap_or(0.0));
            rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
        }
        value => value.to_string(),
    }
}
