//! Files with very many things of one kind. What it takes to read and draw one is to grow as their number does, not as
//! the square of it.

use crate::data_uri;
use std::fmt::Write as _;

/// What a file has many of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrowthAxis {
    /// Nodes with names beside each other that show the same triangle.
    Nodes,
    /// Nodes below each other.
    Generations,
    /// Nodes that share a skin, of which each is a joint.
    Skinned,
    /// Point lights, each held by a node.
    Lights,
    /// Materials, each of a primitive.
    Materials,
    /// Materials that nothing uses.
    UnusedMaterials,
    /// Primitives of one mesh.
    Primitives,
    /// Cameras, each held by a node.
    Cameras,
    /// Channels of an animation, each of which changes the emission of a material.
    Channels,
    /// Corners of a polygon, a star.
    Corners,
    /// Points of a cloud, evenly on a disc.
    Points,
    /// Lines of OBJ that go on in the next.
    Continuations,
    /// Items of an overlay, each beside a node of its own.
    Items,
}

impl GrowthAxis {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Nodes,
        Self::Generations,
        Self::Skinned,
        Self::Lights,
        Self::Materials,
        Self::UnusedMaterials,
        Self::Primitives,
        Self::Cameras,
        Self::Channels,
        Self::Corners,
        Self::Points,
        Self::Continuations,
        Self::Items,
    ];

    /// What they are called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Generations => "generations of nodes",
            Self::Skinned => "nodes of one skin",
            Self::Lights => "lights",
            Self::Materials => "materials",
            Self::UnusedMaterials => "unused materials",
            Self::Primitives => "primitives",
            Self::Cameras => "cameras",
            Self::Channels => "animated materials",
            Self::Corners => "corners of a polygon",
            Self::Points => "points",
            Self::Continuations => "lines that go on",
            Self::Items => "overlay items",
        }
    }

    /// The name of the file with `count` of them. That of [`Self::Items`] is a stage; its model is the file of as many
    /// [`Self::Nodes`].
    pub fn file_name(self, count: usize) -> String {
        let stem = self.name().replace(' ', "-");
        let ending = match self {
            Self::Corners | Self::Points => "ply",
            Self::Continuations => "obj",
            Self::Items => "stage.toml",
            _ => "gltf",
        };
        format!("{stem}-{count}.{ending}")
    }

    /// The text of that file.
    pub fn text(self, count: usize) -> String {
        match self {
            Self::Corners => star(count),
            Self::Points => cloud(count),
            Self::Continuations => {
                let lines = "1 \\\n".repeat(count);
                format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl {lines}2\n")
            }
            Self::Items => {
                let mut text = format!("model = \"{}\"\n", Self::Nodes.file_name(count));
                (0..count).for_each(|i| {
                    let _ = write!(text, "[[overlay]]\ntext = \"a\"\nnode = \"n{i}\"\n");
                });
                text
            }
            _ => self.gltf(count),
        }
    }

    fn gltf(self, count: usize) -> String {
        let each = |item: &dyn Fn(usize) -> String| (0..count).map(item).collect::<Vec<_>>().join(",");
        // On a square, a metre apart.
        let side = (1..).find(|side| side * side >= count).unwrap_or(1);
        let at = |i: usize| format!("\"translation\":[{},{},0]", i % side, i / side);
        let triangle = "{\"attributes\":{\"POSITION\":0}}";
        let (mut nodes, mut roots, mut others) = ("{\"mesh\":0}".to_owned(), "0".to_owned(), String::new());
        let mut primitives = triangle.to_owned();
        let held = |what: &str| each(&|i| format!("{{{},{}}}", at(i), what.replace('#', &i.to_string())));
        let beside =
            |nodes: String| (format!("{{\"mesh\":0}},{nodes}"), format!("0,{}", each(&|i| (i + 1).to_string())));
        let of_material = || each(&|i| format!("{{\"attributes\":{{\"POSITION\":0}},\"material\":{i}}}"));
        match self {
            Self::Nodes => (nodes, roots) = (held("\"mesh\":0,\"name\":\"n#\""), each(&|i| i.to_string())),
            Self::Generations => {
                nodes =
                    each(&|i| format!("{{\"translation\":[0.0001,0,0],\"children\":[{}]}}", i + 1)) + ",{\"mesh\":0}";
            }
            Self::Skinned => {
                (nodes, roots) = (held("\"mesh\":0,\"skin\":0"), each(&|i| i.to_string()));
                primitives = "{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":3,\"WEIGHTS_0\":4}}".to_owned();
                others = format!(",\"skins\":[{{\"joints\":[{roots}]}}]");
            }
            Self::Lights => {
                (nodes, roots) = beside(held("\"extensions\":{\"KHR_lights_punctual\":{\"light\":#}}"));
                let lights = each(&|_| "{\"type\":\"point\",\"intensity\":1,\"range\":2}".to_owned());
                others = format!(
                    ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\
                     \"extensions\":{{\"KHR_lights_punctual\":{{\"lights\":[{lights}]}}}}"
                );
            }
            Self::Cameras => {
                (nodes, roots) = beside(held("\"camera\":#"));
                let camera = "{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}";
                others = format!(",\"cameras\":[{}]", each(&|_| camera.to_owned()));
            }
            Self::Materials => {
                primitives = of_material();
                let material = |i: usize| {
                    format!("{{\"pbrMetallicRoughness\":{{\"roughnessFactor\":{:.6}}}}}", i as f64 / count as f64)
                };
                others = format!(",\"materials\":[{}]", each(&material));
            }
            Self::UnusedMaterials => others = format!(",\"materials\":[{}]", each(&|_| "{}".to_owned())),
            Self::Primitives => primitives = each(&|_| triangle.to_owned()),
            Self::Channels => {
                primitives = of_material();
                let channel = |i: usize| {
                    format!(
                        "{{\"sampler\":0,\"target\":{{\"path\":\"pointer\",\"extensions\":{{\"KHR_animation_pointer\":\
                         {{\"pointer\":\"/materials/{i}/emissiveFactor\"}}}}}}}}"
                    )
                };
                others = format!(
                    ",\"extensionsUsed\":[\"KHR_animation_pointer\"],\"materials\":[{}],\
                     \"animations\":[{{\"samplers\":[{{\"input\":1,\"output\":2}}],\"channels\":[{}]}}]",
                    each(&|_| "{}".to_owned()),
                    each(&channel)
                );
            }
            Self::Corners | Self::Points | Self::Continuations | Self::Items => {}
        }
        // Positions, times and colours of an animation, weights of joints. Joints are all 0, as the first position is.
        let floats: [f32; 29] = [
            0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1., 0., 0., 0., 1., 1., 1., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.,
            0., 0.,
        ];
        let bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
        let uri = data_uri("application/octet-stream", &bytes);
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[{roots}]}}],\"nodes\":[{nodes}],\
             \"meshes\":[{{\"primitives\":[{primitives}]}}],\"accessors\":[\
             {{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}},\
             {{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"min\":[0],\"max\":[1]}},\
             {{\"bufferView\":2,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}},\
             {{\"bufferView\":3,\"componentType\":5121,\"count\":3,\"type\":\"VEC4\"}},\
             {{\"bufferView\":4,\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}}],\
             \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}},{{\"buffer\":0,\"byteOffset\":36,\"byteLength\":8}},\
             {{\"buffer\":0,\"byteOffset\":44,\"byteLength\":24}},{{\"buffer\":0,\"byteLength\":12}},\
             {{\"buffer\":0,\"byteOffset\":68,\"byteLength\":48}}],\
             \"buffers\":[{{\"byteLength\":116,\"uri\":\"{uri}\"}}]{others}}}"
        )
    }
}

/// PLY with one polygon, every second of whose corners is not convex.
fn star(count: usize) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list int int vertex_indices\nend_header\n"
    );
    for i in 0..count {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / count as f64).sin_cos();
        let radius = if i % 2 == 0 { 1.0 } else { 0.5 };
        let _ = writeln!(text, "{:.7} {:.7} 0", radius * cos, radius * sin);
    }
    let _ = write!(text, "{count}");
    (0..count).for_each(|i| {
        let _ = write!(text, " {i}");
    });
    text.push('\n');
    text
}

/// PLY with points alone, on a disc of radius 1: each has as much of it (Vogel 1979).
fn cloud(count: usize) -> String {
    const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    );
    for i in 0..count {
        let (sin, cos) = (GOLDEN_ANGLE_RAD * i as f64).sin_cos();
        let radius = ((i as f64 + 0.5) / count as f64).sqrt();
        let _ = writeln!(text, "{:.6} {:.6} 0", radius * cos, radius * sin);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::{formats, stage};

    #[test]
    fn every_file_has_as_many_as_it_says() {
        const COUNT: usize = 7;
        for many in GrowthAxis::ALL {
            let (name, text) = (many.file_name(COUNT), many.text(COUNT));
            let mut resolve = |_: &str| Ok(GrowthAxis::Nodes.text(COUNT).into_bytes());
            let (scene, warnings) = if many == GrowthAxis::Items {
                let staged = stage::load_bytes(text.as_bytes(), &mut resolve, &name).expect("a stage");
                (staged.scene, staged.warnings)
            } else {
                let loaded = formats::load_bytes(text.as_bytes(), &mut resolve, &name).expect("a model");
                (loaded.scene, loaded.warnings)
            };
            assert!(warnings.is_empty(), "{name}: {warnings:?}");
            let primitives = scene.meshes.iter().map(|mesh| mesh.primitives.len()).sum::<usize>();
            let found = match many {
                GrowthAxis::Nodes => scene.nodes.len(),
                GrowthAxis::Generations => scene.nodes.len() - 1,
                GrowthAxis::Skinned => scene.nodes.iter().filter(|node| node.skin == Some(0)).count(),
                GrowthAxis::Lights => scene.lights.len(),
                GrowthAxis::Materials => scene.materials.len().min(primitives),
                GrowthAxis::UnusedMaterials => scene.materials.len(),
                GrowthAxis::Primitives => primitives,
                GrowthAxis::Cameras => scene.placed_cameras().len(),
                GrowthAxis::Channels => scene.animations[0].properties.len(),
                GrowthAxis::Corners => scene.meshes[0].primitives[0].indices.len() / 3 + 2,
                GrowthAxis::Points => scene.meshes[0].primitives[0].positions.len(),
                // The triangle, and a line from each vertex to the next.
                GrowthAxis::Continuations => scene.meshes[0].primitives[1].indices.len() / 2,
                GrowthAxis::Items => scene.overlay.items.len(),
            };
            assert_eq!(found, COUNT, "{name}");
        }
    }
}
