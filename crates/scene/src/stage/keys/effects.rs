//! The keys of simulations, particles, decals and water.

use super::declaration::{FINITE, SHARE, StageTable, StageType, UV_SET, from, key, length, required};
use crate::stage::words::{COUNT_MAX, QUALITIES, SLOTS};

const RATE_HZ_MAX: f64 = crate::simulation::RATE_HZ_MAX as f64;

/// Simulations.
pub(crate) const SIMULATIONS: StageTable = StageTable {
    name: "simulations",
    doc: "Pictures that follow from themselves, step by step: waves of water, or what a material shows.",
    keys: &[
        required("name", StageType::Text, "Its name: in reports, and for `simulation` of `[[water]]`."),
        required(
            "program",
            StageType::Text,
            "What it does: ripples, gray_scott, fluid or trails, which are built in, or a .wgsl file, its path from the folder of the stage.",
        ),
        key(
            "parameters",
            StageType::Values,
            "The values of its parameters by their names, { damping_per_s = 0.2 }; those that its program says.",
        ),
        key("cells", StageType::Pair, "Width and height in cells, 1 to 2048 each; those that its program says."),
        key(
            "rate_hz",
            StageType::Number { min: 0.0, is_above: true, max: RATE_HZ_MAX },
            "How many steps there are in a second; as many as its program says.",
        ),
        key(
            "seed",
            StageType::Number { min: 0.0, is_above: false, max: 16_777_216.0 },
            "Another number is another course of what chance decides; 0.",
        ),
        key(
            "over",
            StageType::Text,
            "The name of a node with a flat mesh whose rectangle its cells lie over; the water that shows it. Without either they are a square of 1 m.",
        ),
        key(
            "bodies",
            StageType::Texts,
            "The names of nodes that move through it, as spheres, in which * stands for any letters; none.",
        ),
        key(
            "walls",
            StageType::Texts,
            "The names of nodes that stand in its way, as boxes; none. Bodies and walls are 16 at most.",
        ),
        key(
            "material",
            StageType::Text,
            "The name of the materials that show a picture of it, in which * stands for any letters.",
        ),
        key(
            "sees",
            StageType::Text,
            "A camera of the model, by its name or that of the node that holds it, whose distances it reads at each step: what stands on the ground as it is seen from below.",
        ),
        key(
            "layers",
            StageType::Layers,
            "The layers of which that sees the surfaces, by number (`layers` of `[[nodes]]`); all.",
        ),
        key("picture", StageType::Text, "Which of its pictures materials show; color."),
        key("normal_picture", StageType::Text, "Which of its pictures is the materials' normal map; none."),
        key(
            "slot",
            StageType::Word(SLOTS),
            "Whether it is what they emit, as screens do, or their base colour, which light reaches; emission.",
        ),
        key(
            "luminance_cd_m2",
            from(0.0),
            "How bright white is. Without it the materials' own factor of emission, or 1 where that is 0.",
        ),
        key("texcoord", UV_SET, "The UV set that it lies on; that of the map whose place it takes, or 0."),
    ],
};

/// Particles.
pub(crate) const PARTICLES: StageTable = StageTable {
    name: "particles",
    doc: "Many small things that a simulation moves: sparks, smoke, rain, or what else its parameters make of them.",
    keys: &[
        required(
            "preset",
            StageType::Word(crate::particles::Preset::NAMES),
            "What they are made of, and how they move, where the other keys do not say.",
        ),
        key("name", StageType::Text, "What they are called in reports; the preset."),
        key(
            "count",
            StageType::Number { min: 1.0, is_above: false, max: COUNT_MAX },
            "How many there are at once, at most; 10000.",
        ),
        key(
            "rate_per_s",
            from(0.0),
            "How many are born in a second; 0, as many as there is place for, which is the most.",
        ),
        key("center", StageType::Vector, "The middle of where they are born, in metres; [0, 0, 0]."),
        key("size_m", StageType::Vector, "The extent of that along X, Y and Z; [0, 0, 0]."),
        key(
            "parameters",
            StageType::Values,
            "The values of the parameters of what moves them by their names, { wind_m_s = [2, 0, 0] }: docs/simulations.md lists them.",
        ),
        key("radius_m", StageType::Pair, "Their radius at the beginning of their life and at its end, in metres."),
        key("color", StageType::Color, "Their colour: of the light that they scatter, and of what they emit."),
        key(
            "emission",
            from(0.0),
            "What they emit, times their colour, in the units of the scene (cd/m² where lights are lux and candela).",
        ),
        key("opacity", SHARE, "How much their middle hides; 0 of what is seen by what it emits alone."),
        key(
            "stretch_s",
            from(0.0),
            "For how many seconds of their way they are drawn, as in a picture that is exposed so long.",
        ),
        key("softness_m", from(0.0), "How far before a surface they begin to fade, in metres."),
        key("raggedness", SHARE, "How ragged their edges are, from 0 (round) to 1; 1 of smoke, else 0."),
        key(
            "meets",
            StageType::Text,
            "A camera of the model, by its name or that of the node that holds it: particles meet the surfaces that it sees in a square \
             picture at the beginning, whoever looks at them.",
        ),
        key("layers", StageType::Layers, "The layers of which it sees them, by number (`layers` of `[[nodes]]`); all."),
        key(
            "seed",
            StageType::Number { min: 0.0, is_above: false, max: 16_777_216.0 },
            "Another number is another course of what chance decides; 0.",
        ),
        key(
            "rate_hz",
            StageType::Number { min: 0.0, is_above: true, max: RATE_HZ_MAX },
            "How many steps there are in a second; 60.",
        ),
        key(
            "program",
            StageType::Text,
            "What moves them in place of `particles`, which is built in: a .wgsl file with the states `place` and `velocity`.",
        ),
    ],
};

/// Decals.
pub(crate) const DECALS: StageTable = StageTable {
    name: "decals",
    doc: "Pictures that boxes throw onto the surfaces within them: markings, cracks, stains, leaves, dents. Without an image a decal is a plain rectangle.",
    keys: &[
        key("name", StageType::Text, "What it is called in messages; decal."),
        key(
            "image",
            StageType::Text,
            "Base colour in sRGB, and in alpha how much of the decal there is: an image file, its path from the folder of the stage, or `model:NAME`, an image of the model by its name or number.",
        ),
        key("color", StageType::Color, "What the base colour is multiplied by; white."),
        key("opacity", SHARE, "How much of the base colour below, and of whether that is metal, is hidden; 1."),
        key(
            "metallic",
            SHARE,
            "Whether its colour is that of metal; 0. A `rough_metal_map` multiplies it by blue, and then it is 1.",
        ),
        key(
            "roughness",
            SHARE,
            "How rough it is; what is below stays as it is. A `rough_metal_map` multiplies it by green; 1.",
        ),
        key(
            "rough_metal_map",
            StageType::Text,
            "Roughness in green and metallic in blue, linear, as in glTF: an image.",
        ),
        key("roughness_opacity", SHARE, "How much of the roughness below is hidden; 1."),
        key(
            "normal_map",
            StageType::Text,
            "Normals as of glTF, linear, of which green points to the upper edge: an image.",
        ),
        key("normal_scale", from(0.0), "How strongly they lean; 1."),
        key("normal_opacity", SHARE, "How much of the bumps below is hidden; 1."),
        key(
            "emission",
            from(0.0),
            "What it emits, in the units of the scene (cd/m² where lights are lux and candela); 0, or 1 with an `emission_map`.",
        ),
        key("emission_color", StageType::Color, "The colour of that; white."),
        key("emission_map", StageType::Text, "What multiplies it, in sRGB: an image."),
        key("emission_opacity", SHARE, "How much of the emission below is hidden; 1 if it emits anything."),
        key(
            "node",
            StageType::Text,
            "The name of nodes of the model, in which * stands for any letters: places and directions are those of their space, and the decal goes with them. \
             Without it they are the world's.",
        ),
        key("position", StageType::Vector, "The middle of the box, in metres; [0, 0, 0]."),
        key("positions", StageType::Vectors, "Several of them, a decal each."),
        key("direction", StageType::Vector, "Where it is thrown, of any length; [0, -1, 0], down."),
        key(
            "up",
            StageType::Vector,
            "Where the upper edge of the picture is, from its middle; +Y, or −Z of what is thrown up or down.",
        ),
        key("turn_deg", FINITE, "By how many degrees the picture is turned, counterclockwise as one sees it; 0."),
        key("size_m", StageType::Pair, "Width and height of the picture, in metres; [1, 1]."),
        key("depth_m", length(f32::MAX), "How deep the box is along the direction, in metres; 0.5."),
        key(
            "count",
            StageType::Number { min: 1.0, is_above: false, max: crate::decal::DECALS_MAX as f64 },
            "Strews so many around each position, at any turn, of sizes that differ by 30 %.",
        ),
        key("spread_m", StageType::Vector, "The extent along X, Y and Z of where those are; [1, 0, 1]."),
        key(
            "seed",
            StageType::Number { min: 0.0, is_above: false, max: 16_777_216.0 },
            "Another number strews them otherwise; 0.",
        ),
        key(
            "angle_deg",
            StageType::Pair,
            "How far surfaces may be turned away from where it comes from: up to the first angle they show all of it, from the second on nothing, in degrees; [60, 80].",
        ),
        key(
            "layers",
            StageType::Layers,
            "The layers on whose surfaces it is, by number (`layers` of `[[nodes]]`); all.",
        ),
        key(
            "order",
            StageType::Number { min: -1e6, is_above: false, max: 1e6 },
            "Those of higher order lie over those of lower; of equal ones later ones over earlier ones; 0.",
        ),
    ],
};

/// Surfaces of water.
pub(crate) const WATER: StageTable = StageTable {
    name: "water",
    doc: "Surfaces of water: flat nodes of the model, whose own mesh is not drawn then, or a rectangle that lies.",
    keys: &[
        key(
            "node",
            StageType::Text,
            "The name of nodes of the model, in which * stands for any letters. Each is a surface of its own, as large as a rectangle around \
             it. Without it `position` and `size_m` put a rectangle into the scene.",
        ),
        key("position", StageType::Vector, "Where the middle of the rectangle is, in metres."),
        key("size_m", StageType::Pair, "Its width along X and its depth along Z, in metres."),
        key(
            "turn_deg",
            FINITE,
            "By how many degrees the rectangle is turned around the vertical, counterclockwise from above; 0.",
        ),
        key("name", StageType::Text, "What it is called in reports; the name of the node, or water."),
        key(
            "clarity",
            StageType::Word(crate::water::Clarity::NAMES),
            "How clear it is: absorption 0.34, 0.0565, 0.0092 and scattering 0.0035, 0.004, 0.0054 a metre (of red, green and blue), or absorption \
             0.603, 0.3135, 1.0492 and scattering 0.84, 0.91, 0.99; clear.",
        ),
        key(
            "absorption_per_m",
            StageType::Vector,
            "The share of red, green and blue that is absorbed in a metre; that of `clarity`.",
        ),
        key(
            "scattering_per_m",
            StageType::Vector,
            "The share that is scattered in a metre, as if to all sides alike; that of `clarity`.",
        ),
        key("ior", StageType::Number { min: 1.0, is_above: true, max: 4.0 }, "The refractive index; 1.333."),
        key(
            "wind_m_s",
            StageType::Number { min: 0.0, is_above: false, max: 100.0 },
            "The wind that raises waves, in metres a second: slopes have a mean square of 0.00512 for each. 0 is a surface at rest, a mirror; 2.",
        ),
        key("wind_deg", FINITE, "Where the wind goes: 0 is +X, 90 is −Z; 0."),
        key(
            "wave_m",
            StageType::Number { min: 0.0, is_above: true, max: 1e4 },
            "How long the longest waves are, in metres; 1.",
        ),
        key(
            "normal_map",
            StageType::Text,
            "An image of normals in place of the built-in waves, whose side is four of the longest waves: its path from the folder of the \
             stage. At a wind of 5 m/s it is as steep as it says.",
        ),
        key(
            "simulation",
            StageType::Text,
            "The name of one of `[[simulations]]` whose waves it has, over the rectangle around the node, in place of those of the wind.",
        ),
        key(
            "foam_depth_m",
            StageType::Number { min: 0.0, is_above: false, max: 1e3 },
            "Where the water is as shallow as this, in metres, foam begins; 0, none.",
        ),
        key("caustics", SHARE, "How strongly waves gather light on what lies below; 0."),
        key(
            "scale",
            StageType::Number { min: 0.0, is_above: true, max: 2.0 },
            "Width and height of what is drawn for its reflection, as a share of those of the picture; 0.5, at rest 1.",
        ),
        key("layers", StageType::Layers, "The layers that it reflects, by number (`layers` of `[[nodes]]`); all."),
        key(
            "quality",
            StageType::Word(QUALITIES),
            "The tier of quality whose passes draw what it reflects; the settings of the picture.",
        ),
    ],
};
