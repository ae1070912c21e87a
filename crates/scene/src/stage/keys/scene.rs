//! The keys of lights, nodes and materials.

use super::declaration::{StageTable, StageType, UV_SET, from, key, required};
use crate::light::RANGE_MIN_M;
use crate::stage::words::{CONVENTIONS, ENCODINGS, METHODS};

/// The words of `kind`.
const KINDS: &[&str] = &["point", "spot", "directional"];

/// Lights that are added or changed.
pub(crate) const LIGHTS: StageTable = StageTable {
    name: "lights",
    doc: "A light. With a `kind` it is new; else every light of the model with that `name` is changed. Under a sky \
          lights of a stage and of its model are not in the unit of daylight.",
    keys: &[
        key("kind", StageType::Word(KINDS), "The kind of a new light."),
        key(
            "name",
            StageType::Text,
            "The name of a new light; or of the lights to change, or of nodes that hold them; * stands for any \
             letters.",
        ),
        key("position", StageType::Vector, "The position of a new light, in metres. Point and spot lights need it."),
        key(
            "direction",
            StageType::Vector,
            "The direction in which a new light shines, of any length. Spot and directional lights need it, or \
             `target`.",
        ),
        key("target", StageType::Vector, "A point at which a new light shines, in metres; it needs `position`."),
        key("color", StageType::Color, "The colour; white."),
        key(
            "intensity",
            from(0.0),
            "Candela of point and spot lights, lux of directional lights; 1 for a new light. 0 turns it off.",
        ),
        key(
            "range_m",
            StageType::Number { min: RANGE_MIN_M, is_above: false, max: f32::MAX as f64 },
            "The distance in metres beyond which it gives no light. Without it, light only falls off with the square \
             of the distance. Not for directional lights.",
        ),
        key(
            "inner_cone_deg",
            StageType::Number { min: 0.0, is_above: false, max: 90.0 },
            "The angle from its axis within which a new spot light has its full intensity, in degrees; below \
             `outer_cone_deg`; 0.",
        ),
        key(
            "outer_cone_deg",
            StageType::Number { min: 0.0, is_above: true, max: 90.0 },
            "The angle from its axis beyond which a new spot light gives no light, in degrees; 45.",
        ),
        key(
            "radius_m",
            from(0.0),
            "The radius of the light's sphere in metres, for the width of penumbrae; 0. Not for directional lights.",
        ),
        key(
            "angle_deg",
            StageType::Number { min: 0.0, is_above: false, max: 90.0 },
            "The angular size of a directional light's source in degrees, for the width of penumbrae; 0. The sun's \
             is 0.53.",
        ),
        key("cast", StageType::Boolean, "Whether it casts shadows; true."),
        key(
            "mode",
            StageType::Word(&crate::LightMode::NAMES),
            "The mode; mixed. `dynamic` light is computed in frames. Of `mixed` light frames compute the direct \
             part, and `manypass bake` the indirect part. `baked` light is only in light maps and probes.",
        ),
    ],
};

/// Nodes that are changed.
pub(crate) const NODES: StageTable = StageTable {
    name: "nodes",
    doc: "Every node of the model with that name is changed.",
    keys: &[
        required("name", StageType::Text, "The name of the nodes; * stands for any letters."),
        key("cast_shadow", StageType::Boolean, "Whether their meshes cast shadows."),
        key(
            "layers",
            StageType::Layers,
            "The layers of their meshes, by number; [0]. A monitor shows what is in one of its own. The picture \
             shows all layers. Light and shadows ignore layers.",
        ),
    ],
};

/// Materials that are changed.
pub(crate) const MATERIALS: StageTable = StageTable {
    name: "materials",
    doc: "Every material of the model with that name is changed.",
    keys: &[
        required("name", StageType::Text, "The name of the materials; * stands for any letters."),
        key("cast_shadow", StageType::Boolean, "Whether their surfaces cast shadows."),
        key(
            "normal_convention",
            StageType::Word(CONVENTIONS),
            "The direction of green in their normal maps, also detail normal maps: up, as in OpenGL and glTF, or \
             down, as in DirectX; opengl.",
        ),
        key(
            "light_map",
            StageType::Text,
            "A light map: an image, its path from the folder of the stage. Radiance (.hdr) and OpenEXR (.exr) files \
             are linear and may exceed 1.",
        ),
        key("light_map_texcoord", UV_SET, "The UV set of the light map; 1."),
        key(
            "light_map_intensity",
            from(0.0),
            "Multiplies the light map. With a texel of 1 a surface reflects its base colour; 1.",
        ),
        key(
            "light_map_encoding",
            StageType::Word(ENCODINGS),
            "Whether its texels are linear or sRGB; linear, as those of .hdr and .exr always are.",
        ),
        key(
            "light_map_direction",
            StageType::Text,
            "The directions from which the light map's light comes, for normal maps: an image of linear 8 bits, \
             placed as the light map is. `manypass bake --directional` writes it.",
        ),
        key("occlusion_map", StageType::Text, "Baked occlusion, in red and linear: an image in place of the model's."),
        key("occlusion_texcoord", UV_SET, "The UV set of `occlusion_map`; 1."),
        key(
            "emissive_map",
            StageType::Text,
            "Emission, in sRGB: an image in place of the model's. The model's factor multiplies it, or 1 where that \
             is 0.",
        ),
        key("emissive_texcoord", UV_SET, "The UV set of `emissive_map`; 1."),
        key(
            "height_map",
            StageType::Text,
            "A height map, in red and linear, of 8 or 16 bits: an image. White lies on the triangles, black \
             `height_depth_m` below them. It is placed as the base colour is.",
        ),
        key(
            "height_depth_m",
            StageType::Number { min: 0.0, is_above: true, max: 1e6 },
            "The depth of black below the triangles, in metres of the mesh's own space. Without `height_map` it is \
             for heights that the model brings.",
        ),
        key(
            "height_method",
            StageType::Word(METHODS),
            "The use of heights; occlusion. It is bump mapping (normals alone), parallax mapping (one shift of all \
             maps), steep parallax mapping, or parallax occlusion mapping with fine steps. Without `height_map` it \
             is for heights that the model brings.",
        ),
        key(
            "self_shadow",
            StageType::Boolean,
            "Whether heights cast shadows on each other as fine as the picture, also from lights without shadow \
             maps; true with the method occlusion.",
        ),
        key("detail_normal_map", StageType::Text, "A detail normal map, laid over the other normals: an image."),
        key("detail_normal_scale", from(0.0), "The strength of the detail normal map; 1."),
        key(
            "detail_color_map",
            StageType::Text,
            "Detail colours in sRGB: an image. Twice their linear value multiplies the base colour.",
        ),
        key(
            "detail_scale",
            StageType::Number { min: 0.0, is_above: true, max: 1e6 },
            "How often detail maps repeat across the UV set of the base colour; 8.",
        ),
    ],
};
