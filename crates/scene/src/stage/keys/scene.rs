//! The keys of lights, nodes and materials.

use super::declaration::{StageTable, StageType, UV_SET, from, key, required};
use crate::light::RANGE_MIN_M;
use crate::stage::words::{CONVENTIONS, ENCODINGS, METHODS};

/// The words of `kind`.
const KINDS: &[&str] = &["point", "spot", "directional"];

/// Lights that are added or changed.
pub(crate) const LIGHTS: StageTable = StageTable {
    name: "lights",
    doc: "A light: a new one if it has a `kind`; else every light of the model with that `name` is changed. Under a sky lights of a stage and of its model are not in the unit of daylight.",
    keys: &[
        key("kind", StageType::Word(KINDS), "What a new light is."),
        key(
            "name",
            StageType::Text,
            "The name of a new light; or of the lights to be changed or of nodes that hold them, in which * stands for any \
             letters.",
        ),
        key("position", StageType::Vector, "Where a new light is, in metres. Points and spots need it."),
        key(
            "direction",
            StageType::Vector,
            "Where a new light shines, of any length. Spots and directional lights need it, or `target`.",
        ),
        key("target", StageType::Vector, "A point that a new light shines at, in metres; it needs `position`."),
        key("color", StageType::Color, "Its colour; white."),
        key(
            "intensity",
            from(0.0),
            "Candela of points and spots, lux of directional lights; 1 for a new light. 0 puts it out.",
        ),
        key(
            "range_m",
            StageType::Number { min: RANGE_MIN_M, is_above: false, max: f32::MAX as f64 },
            "Beyond this distance in metres it is nothing. Without it, it only falls off with the square. Not of directional \
             lights.",
        ),
        key(
            "inner_cone_deg",
            StageType::Number { min: 0.0, is_above: false, max: 90.0 },
            "Within this angle from its axis a new spot is at its full strength, in degrees; below `outer_cone_deg`; 0.",
        ),
        key(
            "outer_cone_deg",
            StageType::Number { min: 0.0, is_above: true, max: 90.0 },
            "Beyond this angle from its axis a new spot gives no light, in degrees; 45.",
        ),
        key(
            "radius_m",
            from(0.0),
            "The radius in metres of the sphere that gives the light, for the width of its penumbrae; 0. Not of directional \
             lights.",
        ),
        key(
            "angle_deg",
            StageType::Number { min: 0.0, is_above: false, max: 90.0 },
            "How large a directional light's source is in the sky, in degrees, for the width of its penumbrae; 0. The sun's \
             is 0.53.",
        ),
        key("cast", StageType::Boolean, "Whether surfaces keep its light from what lies behind them; true."),
        key(
            "mode",
            StageType::Word(&crate::LightMode::NAMES),
            "Who adds up its light: `dynamic`, frames alone; `mixed`, frames what comes straight from it and `manypass bake` what \
             surfaces send back; `baked`, all of it is in light maps and probes; mixed.",
        ),
    ],
};

/// Nodes that are changed.
pub(crate) const NODES: StageTable = StageTable {
    name: "nodes",
    doc: "Every node of the model with that name is changed.",
    keys: &[
        required("name", StageType::Text, "The name of the nodes, in which * stands for any letters."),
        key("cast_shadow", StageType::Boolean, "Whether their meshes keep light from what lies behind them."),
        key(
            "layers",
            StageType::Layers,
            "The layers that their meshes are in, by number; [0]. A monitor shows what is in one of its own. The picture itself shows all; light and \
             shadows are those of all.",
        ),
    ],
};

/// Materials that are changed.
pub(crate) const MATERIALS: StageTable = StageTable {
    name: "materials",
    doc: "Every material of the model with that name is changed.",
    keys: &[
        required("name", StageType::Text, "The name of the materials, in which * stands for any letters."),
        key("cast_shadow", StageType::Boolean, "Whether their surfaces keep light from what lies behind them."),
        key(
            "normal_convention",
            StageType::Word(CONVENTIONS),
            "Where green of their normal maps points, of detail normal maps, too: up, as in OpenGL and glTF, or down, as in DirectX; opengl.",
        ),
        key(
            "light_map",
            StageType::Text,
            "Light that was baked: an image, its path from the folder of the stage; also a Radiance (.hdr) or OpenEXR (.exr) file, which is linear and may exceed 1.",
        ),
        key("light_map_texcoord", UV_SET, "The UV set of the light map; 1."),
        key(
            "light_map_intensity",
            from(0.0),
            "What the light map is multiplied by. A texel of 1 lets a surface send back its base colour; 1.",
        ),
        key(
            "light_map_encoding",
            StageType::Word(ENCODINGS),
            "Whether its texels are linear or sRGB; linear, as those of .hdr and .exr always are.",
        ),
        key(
            "light_map_direction",
            StageType::Text,
            "Where the light of the light map comes from, so that normal maps bend it: an image of linear 8 bits, placed as the light map is, as `manypass bake --directional` writes it.",
        ),
        key("occlusion_map", StageType::Text, "Baked occlusion, in red and linear: an image in place of the model's."),
        key("occlusion_texcoord", UV_SET, "The UV set of `occlusion_map`; 1."),
        key(
            "emissive_map",
            StageType::Text,
            "Emission, in sRGB: an image in place of the model's. It is multiplied by the model's factor, or by 1 where that is 0.",
        ),
        key("emissive_texcoord", UV_SET, "The UV set of `emissive_map`; 1."),
        key(
            "height_map",
            StageType::Text,
            "Heights, in red and linear, of 8 or 16 bits: an image. White lies on the triangles, black `height_depth_m` below \
             them. It is placed as the base colour is.",
        ),
        key(
            "height_depth_m",
            StageType::Number { min: 0.0, is_above: true, max: 1e6 },
            "How far below the triangles black lies, in metres of the mesh's own space. Without `height_map` it is that of \
             heights that the model brings.",
        ),
        key(
            "height_method",
            StageType::Word(METHODS),
            "What is done with the heights: normals alone, one shift of all maps, coarse steps along the line of sight, or fine \
             ones; occlusion. Without `height_map` it is done with heights that the model brings.",
        ),
        key(
            "self_shadow",
            StageType::Boolean,
            "Whether heights shadow each other as finely as they are seen, from lights without shadow maps, too; true with the \
             method occlusion.",
        ),
        key("detail_normal_map", StageType::Text, "Normals that are laid over the others: an image."),
        key("detail_normal_scale", from(0.0), "How strong these normals are; 1."),
        key(
            "detail_color_map",
            StageType::Text,
            "Colours in sRGB, of which twice the linear value multiplies the base colour: an image.",
        ),
        key(
            "detail_scale",
            StageType::Number { min: 0.0, is_above: true, max: 1e6 },
            "How often detail maps repeat across the UV set of the base colour; 8.",
        ),
    ],
};
