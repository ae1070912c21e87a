//! glTF files that a test changes before they are read, and pictures of what is in them.

use super::framed;
use manypass::{Background, Environment, FrameRequest, Renderer, Tonemap, View};
use manypass_scene::{Scene, load_bytes};
use manypass_testkit::compare::{Picture, assert_looks_same, flip};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The sides of pictures in pixels.
pub const SIDE_PX: u32 = 256;
/// What is behind a model, in sRGB: nothing that a model is likely to show.
const BEHIND: [f32; 3] = [0.05, 0.0, 0.1];

/// A file: its JSON, and its first buffer where it is in the file.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    pub buffer: Vec<u8>,
    path: PathBuf,
}

impl File {
    /// Reads a .gltf or .glb.
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let path = path.to_owned();
        if !bytes.starts_with(b"glTF") {
            return Self { json: serde_json::from_slice(&bytes).unwrap(), buffer: Vec::new(), path };
        }
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let mut json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        json["buffers"][0]["uri"] = json!("");
        Self { json, buffer: bytes[28 + length..].to_vec(), path }
    }

    /// A file that is nowhere.
    pub fn new(json: Value, buffer: Vec<u8>) -> Self {
        Self { json, buffer, path: PathBuf::from("made.gltf") }
    }

    /// The scene, which must be read without a warning.
    pub fn scene(&self) -> Scene {
        let mut beside = |uri: &str| {
            if uri.is_empty() {
                return Ok(self.buffer.clone());
            }
            std::fs::read(self.path.with_file_name(uri)).map_err(|error| error.to_string())
        };
        let name = self.path.display().to_string();
        let loaded = load_bytes(self.json.to_string().as_bytes(), &mut beside, &name).unwrap();
        assert_eq!(loaded.warnings, [""; 0], "{name}");
        loaded.scene
    }

    /// The floats of an accessor, which lie one after the other.
    pub fn floats<const N: usize>(&self, accessor: usize) -> Vec<[f32; N]> {
        let accessor = &self.json["accessors"][accessor];
        assert_eq!(accessor["componentType"], 5126);
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let from = |value: &Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        let bytes = &self.buffer[from(view) + from(accessor)..][..4 * N * count];
        let floats = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect::<Vec<_>>();
        floats.as_chunks().0.to_vec()
    }
}

/// A picture of a scene in the studio by a view, without shadows, curve or noise.
pub fn picture(renderer: &mut Renderer, scene: &Scene, view: View) -> Picture {
    let request = FrameRequest::new(SIDE_PX, SIDE_PX, view).with(|settings| {
        settings.environment.source = Environment::Studio;
        settings.background.source = Background::Color(BEHIND);
        settings.shadows.enabled = false;
        settings.tone_map.curve = Tonemap::None;
        settings.tone_map.dither = 0.0;
    });
    renderer.load(scene).unwrap();
    renderer.render(scene, &request).unwrap();
    Picture::from_rgba8(SIDE_PX as usize, SIDE_PX as usize, &renderer.read_display().unwrap())
}

/// Writes pictures to the folder that `MANYPASS_TWINS` names, for whoever wants to look at them; without it none.
pub fn keep(name: &str, pictures: &[(&str, &Picture)]) {
    let Some(folder) = std::env::var_os("MANYPASS_TWINS") else { return };
    for (which, picture) in pictures {
        let path = Path::new(&folder).join(format!("{}.{which}.png", name.replace(['/', ' '], "_")));
        image::save_buffer(path, picture.pixels.as_flattened(), SIDE_PX, SIDE_PX, image::ColorType::Rgba8).unwrap();
    }
}

/// Asserts that two scenes look the same by the camera that frames the first one, and that there is something to look
/// at. Gives the first picture.
#[track_caller]
pub fn assert_twins(name: &str, [first, second]: [&Scene; 2], most: f64) -> Picture {
    let mut renderer = super::renderer();
    let view = framed(&first.posed_bounds_world());
    let [first, second] = [first, second].map(|scene| picture(&mut renderer, scene, view));
    keep(name, &[("a", &first), ("b", &second)]);
    let corner = first.pixels[0];
    let shown = first.pixels.iter().filter(|pixel| **pixel != corner).count();
    let least = (SIDE_PX * SIDE_PX / 12) as usize;
    assert!(shown > least, "{name}: {shown} pixels show something");
    println!("{name}: FLIP {:.5}, {shown} pixels", flip(&first, &second).mean());
    assert_looks_same(&first, &second, most);
    first
}
