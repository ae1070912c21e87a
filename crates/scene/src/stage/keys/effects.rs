//! The keys of simulations, particles, decals and water.

use super::declaration::{FINITE, SHARE, StageTable, StageType, UV_SET, from, key, length, required};
use crate::stage::words::{COUNT_MAX, QUALITIES, SLOTS};

const RATE_HZ_MAX: f64 = crate::simulation::RATE_HZ_MAX as f64;

/// Simulations.
pub(crate) const SIMULATIONS: StageTable = StageTable {
    name: "simulations",
    doc: "A simulation on a grid, step by step: waves of water, or a texture that a material shows.",
    keys: &[
        required("name", StageType::Text, "Its name in reports, and for `simulation` of `[[water]]`."),
        required(
            "program",
            StageType::Text,
            "The program: ripples, gray_scott, fluid or trails, which are built in, or a .wgsl file, its path from \
             the folder of the stage.",
        ),
        key(
            "parameters",
            StageType::Values,
            "Values of the program's parameters by name, { damping_per_s = 0.2 }; the program's defaults.",
        ),
        key("cells", StageType::Pair, "Width and height in cells, 1 to 2048 each; the program's defaults."),
        key(
            "rate_hz",
            StageType::Number { min: 0.0, is_above: true, max: RATE_HZ_MAX },
            "The number of steps in a second; the program's default.",
        ),
        key(
            "seed",
            StageType::Number { min: 0.0, is_above: false, max: 16_777_216.0 },
            "The seed of random numbers; 0.",
        ),
        key(
            "over",
            StageType::Text,
            "The name of a node with a flat mesh, whose rectangle the cells cover. By default they cover the water \
             that shows the simulation, else a square of 1 m.",
        ),
        key(
            "bodies",
            StageType::Texts,
            "The names of nodes that move through it, as spheres; * stands for any letters; none.",
        ),
        key(
            "walls",
            StageType::Texts,
            "The names of nodes that stand in its way, as boxes; * stands for any letters; none. Bodies and walls \
             are 16 at most.",
        ),
        key(
            "material",
            StageType::Text,
            "The name of the materials that show a picture of it; * stands for any letters.",
        ),
        key(
            "sees",
            StageType::Text,
            "A camera of the model, by its name or its node's. The simulation reads its distances at each step: what \
             stands on the ground, seen from below.",
        ),
        key("layers", StageType::Layers, "The layers that this camera sees, by number (`layers` of `[[nodes]]`); all."),
        key("picture", StageType::Text, "The simulation's picture that materials show; color."),
        key("normal_picture", StageType::Text, "The simulation's picture that is the materials' normal map; none."),
        key(
            "slot",
            StageType::Word(SLOTS),
            "Whether the picture is the materials' emission, as on screens, or their base colour, which is lit; \
             emission.",
        ),
        key(
            "luminance_cd_m2",
            from(0.0),
            "The luminance of white. Without it, the materials' own factor of emission, or 1 where that is 0.",
        ),
        key("texcoord", UV_SET, "The UV set; that of the replaced map, or 0."),
    ],
};

/// Particles.
pub(crate) const PARTICLES: StageTable = StageTable {
    name: "particles",
    doc: "A particle system, moved by a simulation: sparks, smoke, rain, or others by their parameters.",
    keys: &[
        required(
            "preset",
            StageType::Word(crate::particles::Preset::NAMES),
            "The preset: looks and motion where the other keys do not say otherwise.",
        ),
        key("name", StageType::Text, "Its name in reports; the preset."),
        key(
            "count",
            StageType::Number { min: 1.0, is_above: false, max: COUNT_MAX },
            "The most particles at once; 10000.",
        ),
        key(
            "rate_per_s",
            from(0.0),
            "The number of particles born in a second; 0, the most that `count` has room for.",
        ),
        key("center", StageType::Vector, "The middle of the box in which they are born, in metres; [0, 0, 0]."),
        key("size_m", StageType::Vector, "The extent of that box along X, Y and Z, in metres; [0, 0, 0]."),
        key(
            "parameters",
            StageType::Values,
            "Values of the simulation's parameters by name, { wind_m_s = [2, 0, 0] }: docs/simulations.md lists them.",
        ),
        key("radius_m", StageType::Pair, "Their radius at the beginning and at the end of their life, in metres."),
        key("color", StageType::Color, "Their colour, for scattered and emitted light."),
        key(
            "emission",
            from(0.0),
            "Their emission, times their colour, in the units of the scene (cd/m² where lights are lux and candela).",
        ),
        key("opacity", SHARE, "The opacity of their middle; with 0 only their emission is visible."),
        key("stretch_s", from(0.0), "The seconds of motion over which they are stretched, like an exposure time."),
        key(
            "softness_m",
            from(0.0),
            "The distance before a surface at which they begin to fade (soft particles), in metres.",
        ),
        key("raggedness", SHARE, "How ragged their edges are, from 0 (round) to 1; 1 for smoke, else 0."),
        key(
            "meets",
            StageType::Text,
            "A camera of the model, by its name or its node's. Particles collide with the surfaces that it sees in a \
             square picture at the beginning, whichever camera shows them.",
        ),
        key("layers", StageType::Layers, "The layers that this camera sees, by number (`layers` of `[[nodes]]`); all."),
        key(
            "seed",
            StageType::Number { min: 0.0, is_above: false, max: 16_777_216.0 },
            "The seed of random numbers; 0.",
        ),
        key(
            "rate_hz",
            StageType::Number { min: 0.0, is_above: true, max: RATE_HZ_MAX },
            "The number of steps in a second; 60.",
        ),
        key(
            "program",
            StageType::Text,
            "The program that moves them, in place of the built-in `particles`: a .wgsl file with the states `place` \
             and `velocity`.",
        ),
    ],
};

/// Decals.
pub(crate) const DECALS: StageTable = StageTable {
    name: "decals",
    doc: "A decal: a box that projects a picture onto the surfaces within it, such as markings, cracks, stains, leaves \
          or dents. Without an image a decal is a plain rectangle.",
    keys: &[
        key("name", StageType::Text, "Its name in messages; decal."),
        key(
            "image",
            StageType::Text,
            "Base colour in sRGB, with the decal's coverage in alpha. It is an image file, its path from the folder \
             of the stage; or `model:NAME`, an image of the model by its name or number.",
        ),
        key("color", StageType::Color, "Multiplies the base colour; white."),
        key("opacity", SHARE, "The opacity over base colour and metallic of the surface; 1."),
        key(
            "metallic",
            SHARE,
            "Metallic, from 0 to 1; 0. A `rough_metal_map` multiplies it by blue, and then it is 1.",
        ),
        key(
            "roughness",
            SHARE,
            "Roughness; by default the surface keeps its own. A `rough_metal_map` multiplies it by green; 1.",
        ),
        key(
            "rough_metal_map",
            StageType::Text,
            "Roughness in green and metallic in blue, linear, as in glTF: an image.",
        ),
        key("roughness_opacity", SHARE, "The opacity over the roughness of the surface; 1."),
        key(
            "normal_map",
            StageType::Text,
            "A normal map as in glTF, linear: an image. Green points to the upper edge.",
        ),
        key("normal_scale", from(0.0), "The strength of the normal map; 1."),
        key("normal_opacity", SHARE, "The opacity over the bumps of the surface; 1."),
        key(
            "emission",
            from(0.0),
            "Emission, in the units of the scene (cd/m² where lights are lux and candela); 0, or 1 with an \
             `emission_map`.",
        ),
        key("emission_color", StageType::Color, "The colour of the emission; white."),
        key("emission_map", StageType::Text, "Multiplies the emission, in sRGB: an image."),
        key("emission_opacity", SHARE, "The opacity over the emission of the surface; 1 if the decal emits anything."),
        key(
            "node",
            StageType::Text,
            "The name of nodes of the model; * stands for any letters. Positions and directions are in their space, \
             and the decal moves with them. Without it they are in world space.",
        ),
        key("position", StageType::Vector, "The middle of the box, in metres; [0, 0, 0]."),
        key("positions", StageType::Vectors, "Several positions; each has a decal."),
        key("direction", StageType::Vector, "The direction of projection, of any length; [0, -1, 0], down."),
        key(
            "up",
            StageType::Vector,
            "The direction from the middle of the picture to its upper edge; +Y, or −Z if it is projected up or down.",
        ),
        key("turn_deg", FINITE, "The rotation of the picture in degrees, counterclockwise as seen by the viewer; 0."),
        key("size_m", StageType::Pair, "Width and height of the picture, in metres; [1, 1]."),
        key("depth_m", length(f32::MAX), "The depth of the box along the direction, in metres; 0.5."),
        key(
            "count",
            StageType::Number { min: 1.0, is_above: false, max: crate::decal::DECALS_MAX as f64 },
            "Scatters this many decals around each position, at any turn. Their sizes differ by 30 %.",
        ),
        key("spread_m", StageType::Vector, "The extent of scattering along X, Y and Z, in metres; [1, 0, 1]."),
        key("seed", StageType::Number { min: 0.0, is_above: false, max: 16_777_216.0 }, "The seed of scattering; 0."),
        key(
            "angle_deg",
            StageType::Pair,
            "Angles between the surface's normal and the direction that the decal comes from, in degrees; [60, 80]. \
             The decal is full up to the first and gone from the second.",
        ),
        key(
            "layers",
            StageType::Layers,
            "The layers on whose surfaces it is, by number (`layers` of `[[nodes]]`); all.",
        ),
        key(
            "order",
            StageType::Number { min: -1e6, is_above: false, max: 1e6 },
            "Decals of higher order lie over those of lower order. With equal order later ones lie over earlier \
             ones; 0.",
        ),
    ],
};

/// Surfaces of water.
pub(crate) const WATER: StageTable = StageTable {
    name: "water",
    doc: "A surface of water: flat nodes of the model, or a horizontal rectangle. The nodes' own meshes are not drawn \
          then.",
    keys: &[
        key(
            "node",
            StageType::Text,
            "The name of nodes of the model; * stands for any letters. Each is a surface of its own, as large as its \
             bounding rectangle. Without it `position` and `size_m` add a rectangle to the scene.",
        ),
        key("position", StageType::Vector, "The middle of the rectangle, in metres."),
        key("size_m", StageType::Pair, "Its width along X and its depth along Z, in metres."),
        key(
            "turn_deg",
            FINITE,
            "The rotation of the rectangle about the vertical in degrees, counterclockwise from above; 0.",
        ),
        key("name", StageType::Text, "Its name in reports; the name of the node, or water."),
        key(
            "clarity",
            StageType::Word(crate::water::Clarity::NAMES),
            "The clarity, which sets the two coefficients below for red, green and blue; clear. Clear water has \
             absorption 0.34, 0.0565, 0.0092 and scattering 0.0035, 0.004, 0.0054 a metre. Murky water has \
             absorption 0.603, 0.3135, 1.0492 and scattering 0.84, 0.91, 0.99.",
        ),
        key(
            "absorption_per_m",
            StageType::Vector,
            "The absorption coefficients of red, green and blue, per metre; those of `clarity`.",
        ),
        key(
            "scattering_per_m",
            StageType::Vector,
            "The scattering coefficients of red, green and blue, per metre, as if isotropic; those of `clarity`.",
        ),
        key("ior", StageType::Number { min: 1.0, is_above: true, max: 4.0 }, "The refractive index; 1.333."),
        key(
            "wind_m_s",
            StageType::Number { min: 0.0, is_above: false, max: 100.0 },
            "The wind that raises waves, in metres a second. Each adds 0.00512 to the mean square of slopes. 0 is a \
             flat mirror; 2.",
        ),
        key("wind_deg", FINITE, "The direction in which the wind blows: 0 is +X, 90 is −Z; 0."),
        key(
            "wave_m",
            StageType::Number { min: 0.0, is_above: true, max: 1e4 },
            "The length of the longest waves, in metres; 1.",
        ),
        key(
            "normal_map",
            StageType::Text,
            "A normal map in place of the built-in waves: an image, its path from the folder of the stage. Its side \
             is four of the longest waves. At a wind of 5 m/s it is as steep as stored.",
        ),
        key(
            "simulation",
            StageType::Text,
            "The name of one of `[[simulations]]` whose waves replace those of the wind. It covers the rectangle \
             around the node.",
        ),
        key(
            "foam_depth_m",
            StageType::Number { min: 0.0, is_above: false, max: 1e3 },
            "The depth of water at which foam begins, in metres; 0, none.",
        ),
        key("caustics", SHARE, "The strength of caustics on the ground below; 0."),
        key(
            "scale",
            StageType::Number { min: 0.0, is_above: true, max: 2.0 },
            "Width and height of its reflection, as a share of those of the picture; 0.5, at rest 1.",
        ),
        key("layers", StageType::Layers, "The layers that it reflects, by number (`layers` of `[[nodes]]`); all."),
        key("quality", StageType::Word(QUALITIES), "The quality tier of its reflection; the settings of the picture."),
    ],
};
