//! Builds small glTF models in code.
#![allow(dead_code, reason = "each test file uses a part")]
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use manypass_scene::{LoadError, LoadedScene, Primitive, load_bytes};
use serde_json::{Value, json};

/// glTF's numbers of component types.
pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A model with one scene, one node, one mesh and one primitive, whose accessors lie in one buffer.
pub struct Model {
    pub json: Value,
    pub buffer: Vec<u8>,
}

impl Model {
    /// A model of `mode` with these positions.
    pub fn with_positions(mode: u32, positions: &[[f32; 3]]) -> Self {
        let mut model = Self::empty(mode);
        model.attribute("POSITION", F32, "VEC3", &floats(positions.as_flattened()));
        model
    }

    /// A triangle of one metre.
    pub fn triangle() -> Self {
        Self::with_positions(4, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    /// A model whose primitive of `mode` has no attributes yet.
    pub fn empty(mode: u32) -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "mode": mode, "attributes": {} }] }],
            "accessors": [], "bufferViews": [], "buffers": [{ "uri": "buffer.bin" }],
        });
        Self { json, buffer: Vec::new() }
    }

    /// Adds a buffer view; gives its index.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() });
        self.buffer.extend(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    /// Adds a tightly packed accessor of as many elements as `bytes` hold; gives its index.
    pub fn accessor(&mut self, component: u32, kind: &str, bytes: &[u8]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "MAT4" => 16,
            vector => usize::from(vector.as_bytes()[3] - b'0'),
        };
        let element_bytes = width * [1, 1, 2, 2, 0, 4, 4][component as usize - 5120];
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component, "type": kind, "count": bytes.len() / element_bytes });
        push(&mut self.json["accessors"], accessor)
    }

    /// Adds an accessor and an attribute of the primitive that is read from it; gives the accessor.
    pub fn attribute(&mut self, name: &str, component: u32, kind: &str, bytes: &[u8]) -> usize {
        let accessor = self.accessor(component, kind, bytes);
        self.primitive()["attributes"][name] = json!(accessor);
        accessor
    }

    /// The JSON of the primitive.
    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Reads the model, its buffer as a file beside it.
    pub fn try_load(mut self) -> Result<LoadedScene, LoadError> {
        self.json["buffers"][0]["byteLength"] = json!(self.buffer.len());
        load_bytes(self.json.to_string().as_bytes(), &mut |_| Ok(self.buffer.clone()), "model.gltf")
    }

    /// Reads the model, which must be faultless.
    #[track_caller]
    pub fn load(self) -> LoadedScene {
        let loaded = self.try_load().unwrap();
        assert_eq!(loaded.warnings, [""; 0]);
        loaded
    }

    /// Reads the model and gives its primitive.
    #[track_caller]
    pub fn load_primitive(self) -> Primitive {
        self.load().scene.meshes[0].primitives[0].clone()
    }
}

/// Appends to an array; gives the index.
pub fn push(array: &mut Value, item: Value) -> usize {
    if !array.is_array() {
        *array = json!([]);
    }
    let array = array.as_array_mut().unwrap();
    array.push(item);
    array.len() - 1
}

/// The bytes of floats.
pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// The bytes of integers of a component type.
pub fn integers(component: u32, values: &[i64]) -> Vec<u8> {
    let bytes = [1, 1, 2, 2, 0, 4][component as usize - 5120];
    values.iter().flat_map(|value| value.to_le_bytes().into_iter().take(bytes)).collect()
}

pub mod twins;
