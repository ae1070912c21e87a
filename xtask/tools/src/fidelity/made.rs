//! Models of extensions that no sample model shows well, or none that is at hand: written as glTF, which we and the
//! path tracer read.

use anyhow::{Context, Result};
use image::{Rgb, RgbImage};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// What a model shows.
#[derive(Clone, Copy, Debug)]
pub(super) enum Subject {
    /// Above, highlights along directions from 0 to 90 degrees; below, along those of a map, of more and more rough
    /// metal.
    Anisotropy,
    /// Balls and bent leaves, which ever more light comes through.
    DiffuseTransmission,
    /// Balls of five glossinesses, and of specular colours that metal and roughness have and have not.
    SpecularGlossiness,
}

/// The number of bodies in a row, and of rows.
const COLUMNS: usize = 5;
const ROWS: usize = 2;

impl Subject {
    fn name(self) -> &'static str {
        match self {
            Self::Anisotropy => "anisotropy",
            Self::DiffuseTransmission => "diffuse_transmission",
            Self::SpecularGlossiness => "specular_glossiness",
        }
    }

    fn material(self, column: usize, row: usize) -> Value {
        let share = column as f64 / (COLUMNS - 1) as f64;
        match (self, row) {
            (Self::Anisotropy, 0) => json!({
                "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.77, 0.34, 1.0], "roughnessFactor": 0.3 },
                "extensions": { "KHR_materials_anisotropy": { "anisotropyStrength": 0.9, "anisotropyRotation": share * PI / 2.0 } },
            }),
            (Self::Anisotropy, _) => json!({
                "pbrMetallicRoughness": { "baseColorFactor": [0.9, 0.9, 0.95, 1.0], "roughnessFactor": 0.1 + 0.5 * share },
                "extensions": {
                    "KHR_materials_anisotropy": { "anisotropyStrength": 0.8, "anisotropyTexture": { "index": 0 } },
                },
            }),
            (Self::DiffuseTransmission, _) => json!({
                "doubleSided": true,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.2, 0.6, 0.15, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5,
                },
                "extensions": { "KHR_materials_diffuse_transmission": {
                    "diffuseTransmissionFactor": share, "diffuseTransmissionColorFactor": [0.9, 0.8, 0.2],
                } },
            }),
            (Self::SpecularGlossiness, row) => {
                let ([diffuse, specular], glossiness) = if row == 0 {
                    ([[0.6, 0.1, 0.1], [0.2, 0.2, 0.2]], share)
                } else {
                    let colors = [
                        [[0.5, 0.5, 0.5], [0.0, 0.0, 0.0]],
                        [[0.1, 0.2, 0.6], [0.04, 0.04, 0.04]],
                        [[0.1, 0.1, 0.5], [0.6, 0.1, 0.1]],
                        [[0.3, 0.6, 0.3], [0.5, 0.5, 0.5]],
                        [[0.0, 0.0, 0.0], [1.0, 0.77, 0.34]],
                    ];
                    (colors[column], 0.7)
                };
                json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {
                    "diffuseFactor": [diffuse[0], diffuse[1], diffuse[2], 1.0],
                    "specularFactor": specular,
                    "glossinessFactor": glossiness,
                } } })
            }
        }
    }
}

/// Vertices of one kind after the other, and triangles.
#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

impl Mesh {
    /// A part of a ball of half a metre: `around` and `down` are the shares of its angles, which begin in front and
    /// above.
    fn ball(around: [f64; 2], down: [f64; 2]) -> Self {
        const STEPS: [u32; 2] = [64, 32];
        let mut mesh = Self::default();
        for row in 0..=STEPS[1] {
            for column in 0..=STEPS[0] {
                let uv = [f64::from(column) / f64::from(STEPS[0]), f64::from(row) / f64::from(STEPS[1])];
                let place = |[from, to]: [f64; 2], share: f64| from + (to - from) * share;
                let (sin, cos) = (2.0 * PI * place(around, uv[0])).sin_cos();
                let (ring, height) = (PI * place(down, uv[1])).sin_cos();
                let normal = [sin * ring, height, cos * ring].map(|value| value as f32);
                mesh.normals.push(normal);
                mesh.positions.push(normal.map(|value| 0.5 * value));
                mesh.tangents.push([cos as f32, 0.0, -sin as f32, 1.0]);
                mesh.uvs.push(uv.map(|value| value as f32));
                if row < STEPS[1] && column < STEPS[0] {
                    let first = row * (STEPS[0] + 1) + column;
                    let below = first + STEPS[0] + 1;
                    mesh.indices.extend([first, below, first + 1, first + 1, below, below + 1]);
                }
            }
        }
        mesh
    }
}

/// Writes the model below `folder`, with lights of its own or without.
///
/// # Errors
/// It cannot be written.
pub(super) fn write(subject: Subject, has_lights: bool, folder: &Path) -> Result<PathBuf> {
    let name = format!("{}-{}", subject.name(), if has_lights { "lamps" } else { "sky" });
    let mut document = Document::default();
    let ball = document.add(&Mesh::ball([0.0, 1.0], [0.0, 1.0]));
    let leaf = document.add(&Mesh::ball([0.25, 0.75], [0.1, 0.9]));
    for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let is_leaf = matches!(subject, Subject::DiffuseTransmission) && row == 1;
        let mut primitive = if is_leaf { leaf.clone() } else { ball.clone() };
        primitive["material"] = json!(row * COLUMNS + column);
        let place = [1.2 * (column as f64 - 2.0), 0.6 - 1.2 * row as f64, 0.0];
        document.nodes.push(json!({ "mesh": document.meshes.len(), "translation": place }));
        document.meshes.push(json!({ "primitives": [primitive] }));
    }
    if has_lights {
        // The sun from the upper left and before, a lamp from behind.
        document.nodes.push(json!({
            "rotation": [-0.2826, -0.3262, -0.1028, 0.8962], "extensions": { "KHR_lights_punctual": { "light": 0 } },
        }));
        document.nodes.push(json!({
            "translation": [1.5, 1.5, -3.0], "extensions": { "KHR_lights_punctual": { "light": 1 } },
        }));
    }
    let materials = (0..ROWS * COLUMNS).map(|index| subject.material(index % COLUMNS, index / COLUMNS)).collect();
    let mut written = document.json(materials, &format!("{name}.bin"));
    if has_lights {
        written["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
            { "type": "directional", "intensity": 3.0 },
            { "type": "point", "intensity": 40.0, "color": [1.0, 0.8, 0.6] },
        ] } });
    }
    if matches!(subject, Subject::Anisotropy) {
        written["images"] = json!([{ "uri": "anisotropy.png" }]);
        written["textures"] = json!([{ "source": 0 }]);
        turning().save(folder.join("anisotropy.png")).context("writing anisotropy.png")?;
    }
    let path = folder.join(format!("{name}.gltf"));
    std::fs::write(folder.join(format!("{name}.bin")), &document.bytes).context("writing a buffer")?;
    std::fs::write(&path, format!("{written:#}\n")).with_context(|| format!("writing {}", path.display()))?;
    Ok(path)
}

/// Directions that turn around once from the left to the right, and strengths that grow downwards.
fn turning() -> RgbImage {
    RgbImage::from_fn(128, 64, |x, y| {
        let (sin, cos) = (2.0 * PI * (f64::from(x) + 0.5) / 128.0).sin_cos();
        let byte = |value: f64| (255.0 * value).round() as u8;
        Rgb([byte(0.5 + 0.5 * cos), byte(0.5 + 0.5 * sin), byte(0.4 + 0.6 * f64::from(y) / 63.0)])
    })
}

/// What is written of a file so far.
#[derive(Default)]
struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl Document {
    fn accessor<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let limit = |fold: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|i| values.iter().map(|value| value[i]).reduce(fold).unwrap_or(0.0)).collect()
        };
        let (min, max) = (limit(f32::min), limit(f32::max));
        let bytes = values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        self.put(bytes, json!({ "componentType": 5126, "count": values.len(), "type": kind, "min": min, "max": max }))
    }

    fn put(&mut self, bytes: Vec<u8>, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// A primitive without material.
    fn add(&mut self, mesh: &Mesh) -> Value {
        let attributes = json!({
            "POSITION": self.accessor(&mesh.positions, "VEC3"),
            "NORMAL": self.accessor(&mesh.normals, "VEC3"),
            "TANGENT": self.accessor(&mesh.tangents, "VEC4"),
            "TEXCOORD_0": self.accessor(&mesh.uvs, "VEC2"),
        });
        let indices = mesh.indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let indices =
            self.put(indices, json!({ "componentType": 5125, "count": mesh.indices.len(), "type": "SCALAR" }));
        json!({ "attributes": attributes, "indices": indices })
    }

    fn json(&self, materials: Vec<Value>, buffer: &str) -> Value {
        let mut used: Vec<&str> = materials
            .iter()
            .filter_map(|material| material["extensions"].as_object())
            .flat_map(|all| all.keys().map(String::as_str))
            .collect();
        used.push("KHR_lights_punctual");
        used.sort_unstable();
        used.dedup();
        json!({
            "asset": { "version": "2.0" },
            "extensionsUsed": used,
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "uri": buffer, "byteLength": self.bytes.len() }],
        })
    }
}
