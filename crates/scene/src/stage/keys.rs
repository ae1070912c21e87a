//! The keys of stage files, declared once: for the reader, the schema for editors, and the documentation.

use crate::light::RANGE_MIN_M;
use crate::overlay::{Anchor, SIDE_PX_MAX, TEXT_SIZE_PX_MAX, TextAlign};

const RATE_HZ_MAX: f64 = crate::simulation::RATE_HZ_MAX as f64;

/// What a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StageType {
    /// Any text.
    Text,
    /// `true` or `false`.
    Boolean,
    /// One of these words.
    Word(&'static [&'static str]),
    /// `rrggbb` in sRGB, `#` optional, or three numbers of at least 0 in linear Rec. 709.
    Color,
    /// Two finite numbers.
    Pair,
    /// Three finite numbers.
    Vector,
    /// A list of whole numbers from 0 to 31.
    Layers,
    /// A list of two or more pairs of finite numbers.
    Pairs,
    /// A list of two or more times three finite numbers.
    Vectors,
    /// A list of texts.
    Texts,
    /// A table of numbers, and of lists of up to four.
    Values,
    /// A finite number of 32 bits.
    Number {
        /// The least one.
        min: f64,
        /// Whether that itself is too small.
        is_above: bool,
        /// The largest one.
        max: f64,
    },
}

/// A key of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageKey {
    /// Its name.
    pub name: &'static str,
    /// What it takes.
    pub kind: StageType,
    /// Whether the table cannot be without it.
    pub is_required: bool,
    /// What it does: sentences, with unit and default.
    pub doc: &'static str,
}

/// A list of tables, `[[name]]`, or what stands before the first of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageTable {
    /// Its name; empty for what stands before all tables.
    pub name: &'static str,
    /// What one of them is.
    pub doc: &'static str,
    /// The keys of one of them.
    pub keys: &'static [StageKey],
}

/// Tables of settings: the name, and what they hold.
pub const SETTINGS_TABLES: [(&str, &str); 4] = [
    ("environment", "The settings `environment.*`; `color` is `source` as a colour."),
    ("fog", "The settings `fog.*`."),
    (
        "effects",
        "The settings `effects.*`: `chain = [\"bloom\", \"own.wgsl\"]`; files are seen from the stage's folder.",
    ),
    (
        "settings",
        "Any other setting, as in files of `--settings`: `[settings.tone_map]`, `curve = \"agx\"`; of effects too.",
    ),
];

const fn key(name: &'static str, kind: StageType, doc: &'static str) -> StageKey {
    StageKey { name, kind, is_required: false, doc }
}

const fn required(name: &'static str, kind: StageType, doc: &'static str) -> StageKey {
    StageKey { name, kind, is_required: true, doc }
}

const fn from(min: f64) -> StageType {
    StageType::Number { min, is_above: false, max: f32::MAX as f64 }
}

/// What a file begins with.
const FILE: StageTable = StageTable {
    name: "",
    doc: "What a stage begins with.",
    keys: &[required(
        "model",
        StageType::Text,
        "The model: a .glb, .gltf, .obj, .stl, .ply or .3mf file, its path from the folder of the stage; or demo:hall, demo:materials, demo:relief, demo:crowd, demo:room, demo:monitors, demo:mirror, demo:shore, demo:water, demo:doors, demo:portals, demo:gallery, demo:surroundings, demo:laboratory, demo:simulations, demo:particles, demo:yard, demo:decals, demo:sandbox, demo:trails, demo:cornell.",
    )],
};

/// The words of `kind`.
pub(super) const KINDS: &[&str] = &["point", "spot", "directional"];

/// Lights that are added or changed.
pub(super) const LIGHTS: StageTable = StageTable {
    name: "lights",
    doc: "A light: a new one if it has a `kind`; else every light of the model with that `name` is changed.",
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
pub(super) const NODES: StageTable = StageTable {
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

/// What monitors show.
pub(super) const MONITORS: StageTable = StageTable {
    name: "monitors",
    doc: "What a camera of the scene sees, on the screens of a material, or as an item of `[[overlay]]`.",
    keys: &[
        required("name", StageType::Text, "Its name: in reports, and for `monitor` of an `[[overlay]]`."),
        key(
            "camera",
            StageType::Text,
            "The name of a camera of the model, or of the node that holds it. Without it `position` and `target` say from where.",
        ),
        key("position", StageType::Vector, "Where the camera is, in metres."),
        key("target", StageType::Vector, "The point that it looks at, in metres."),
        key(
            "fov_deg",
            StageType::Number { min: 0.0, is_above: true, max: 179.0 },
            "The vertical field of view of a camera at `position`, in degrees; 45.",
        ),
        key("material", StageType::Text, "The name of the materials that show it, in which * stands for any letters."),
        key(
            "slot",
            StageType::Word(super::screens::SLOTS),
            "Whether it is what they emit, as screens do, or their base colour, which light reaches; emission.",
        ),
        key(
            "luminance_cd_m2",
            from(0.0),
            "How bright white is on a screen. Without it the materials' own factor of emission, or 1 where that is 0.",
        ),
        key("texcoord", UV_SET, "The UV set that it lies on; that of the map whose place it takes, or 0."),
        key("size_px", StageType::Pair, "Width and height of its picture in texels, 1 to 4096 each; [512, 288]."),
        key(
            "exposure_stops",
            StageType::Number { min: -32.0, is_above: false, max: 32.0 },
            "By how many stops it is exposed more than the picture that shows it; 0.",
        ),
        key(
            "update",
            StageType::Word(super::monitors::UPDATES),
            "Whether a live view draws it anew in every frame that shows it, or once. Stills and sequences always do; always.",
        ),
        key(
            "every",
            StageType::Number { min: 1.0, is_above: false, max: 1e6 },
            "In one of how many frames a live view draws it anew; 1.",
        ),
        key("layers", StageType::Layers, "The layers that it shows, by number (`layers` of `[[nodes]]`); all."),
        key(
            "quality",
            StageType::Word(super::monitors::QUALITIES),
            "The tier of quality whose passes draw it; the settings of the picture.",
        ),
    ],
};

/// Flat mirrors.
pub(super) const MIRRORS: StageTable = StageTable {
    name: "mirrors",
    doc: "Flat surfaces that reflect what is before them, off the picture, too: nodes of the model, or a rectangle.",
    keys: &[
        key(
            "node",
            StageType::Text,
            "The name of nodes of the model, in which * stands for any letters. Each is a mirror of its own. Without it `position`, \
             `facing` and `size_m` put a rectangle into the scene.",
        ),
        key("position", StageType::Vector, "Where the middle of the rectangle is, in metres."),
        key("facing", StageType::Vector, "Where it faces: a direction of any length."),
        key("size_m", StageType::Pair, "Its width and height in metres."),
        key("name", StageType::Text, "What it is called in reports; the name of the node, or mirror."),
        key(
            "color",
            StageType::Color,
            "Makes the node's material polished metal of this colour, without layers; its normal map stays. Without it the material stays as the model has it; a rectangle is of silver.",
        ),
        key("roughness", SHARE, "Makes the node's material as rough as this; 0 is a mirror, 0.2 brushed metal."),
        key(
            "scale",
            StageType::Number { min: 0.0, is_above: true, max: 2.0 },
            "Width and height of what is drawn for it, as a share of those of the picture; 1.",
        ),
        key("layers", StageType::Layers, "The layers that it shows, by number (`layers` of `[[nodes]]`); all."),
        key(
            "quality",
            StageType::Word(super::monitors::QUALITIES),
            "The tier of quality whose passes draw what it shows; the settings of the picture.",
        ),
    ],
};

/// Simulations.
pub(super) const SIMULATIONS: StageTable = StageTable {
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
            StageType::Word(super::screens::SLOTS),
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
pub(super) const PARTICLES: StageTable = StageTable {
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
            StageType::Number { min: 1.0, is_above: false, max: super::particles::COUNT_MAX },
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
pub(super) const DECALS: StageTable = StageTable {
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
pub(super) const WATER: StageTable = StageTable {
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
            StageType::Word(super::monitors::QUALITIES),
            "The tier of quality whose passes draw what it reflects; the settings of the picture.",
        ),
    ],
};

/// Portals.
pub(super) const PORTALS: StageTable = StageTable {
    name: "portals",
    doc: "Two flat places that lead into each other: nodes of the model, whose own meshes are not drawn then, or rectangles.",
    keys: &[
        key(
            "node",
            StageType::Text,
            "The name of the node that one end is. Without it `position`, `facing` and `size_m` say where that is.",
        ),
        key("position", StageType::Vector, "Where the middle of the one end is, in metres."),
        key("facing", StageType::Vector, "Where it faces: a direction of any length."),
        key("to_node", StageType::Text, "The name of the node that the other end is."),
        key("to_position", StageType::Vector, "Where the middle of the other end is, in metres."),
        key("to_facing", StageType::Vector, "Where that faces: what is seen in the one end is what lies there."),
        key("size_m", StageType::Pair, "Width and height of ends that are rectangles, in metres."),
        key("name", StageType::Text, "What it is called in reports; portal."),
        key(
            "carries",
            StageType::Text,
            "The name of nodes that go through, in which * stands for any letters, with all below them: meshes that are half through are drawn at \
             both ends, and light shines through.",
        ),
        key(
            "scale",
            StageType::Number { min: 0.0, is_above: true, max: 2.0 },
            "Width and height of what is drawn for it, as a share of those of the picture; 1.",
        ),
        key(
            "layers",
            StageType::Layers,
            "The layers that are seen through it, by number (`layers` of `[[nodes]]`); all.",
        ),
        key(
            "quality",
            StageType::Word(super::monitors::QUALITIES),
            "The tier of quality whose passes draw what is seen through it; the settings of the picture.",
        ),
    ],
};

/// Light that arrives at places, for the surfaces between them.
pub(super) const PROBES: StageTable = StageTable {
    name: "probes",
    doc: "A grid of probes: the light that arrives at places in a box, for all surfaces there without light maps, what moves among them. `manypass bake --what probes` finds it; else frames do.",
    keys: &[
        key("name", StageType::Text, "What it is called; light that a file has of it is found by this name; probes."),
        key("center", StageType::Vector, "The middle of its box in metres; that of the model."),
        key("size_m", StageType::Vector, "The extent of its box along X, Y and Z in metres; that of the model."),
        key(
            "spacing_m",
            StageType::Number { min: 0.0, is_above: true, max: f32::MAX as f64 },
            "How far probes are apart in metres; so far that there are some 2,000.",
        ),
        key(
            "counts",
            StageType::Vector,
            "How many probes there are along X, Y and Z, in place of `spacing_m`: at most 128 each, and 16,384 together.",
        ),
        key("fade_m", from(0.0), "Over how many metres within the box's faces the environment takes over; 0."),
        key(
            "basis",
            StageType::Word(&crate::probes::ProbeBasis::NAMES),
            "How light is known at a place: by spherical harmonics of order 2, or by six colours, which are smaller in the file and coarser; harmonics.",
        ),
        key(
            "live",
            StageType::Boolean,
            "Whether frames find their light, anew when something moves, by drawing what is around each; true, unless the file has their light.",
        ),
        key(
            "bounces",
            StageType::Number { min: 1.0, is_above: false, max: crate::probes::LIVE_BOUNCES_MAX as f64 },
            "How often live ones are drawn around, each time in the light that was found before; 3.",
        ),
        key("layers", StageType::Layers, "The layers that live ones see, by number (`layers` of `[[nodes]]`); all."),
    ],
};

/// What stands for the environment within a box.
pub(super) const SURROUNDINGS: StageTable = StageTable {
    name: "surroundings",
    doc: "What is to be seen around a place, in place of the environment of the surfaces within a box: a room, or what is around a glossy thing.",
    keys: &[
        required("center", StageType::Vector, "The middle of the box of the surfaces that have them, in metres."),
        required("size_m", StageType::Vector, "Its extent along X, Y and Z, in metres."),
        key("fade_m", from(0.0), "Over how many metres within its faces the environment takes over; 0."),
        key("position", StageType::Vector, "From where they are seen, in metres; `center`."),
        key(
            "walls",
            StageType::Boolean,
            "Whether what is seen are walls, in which reflections are shifted as the place of a surface says; true.",
        ),
        key(
            "bounces",
            StageType::Number { min: 1.0, is_above: false, max: 4.0 },
            "How often they are captured, each time in the light of what was captured before; 2.",
        ),
        key("walls_center", StageType::Vector, "The middle of the box that the walls are, in metres; `center`."),
        key("walls_size_m", StageType::Vector, "The extent of that box along X, Y and Z, in metres; `size_m`."),
        key("name", StageType::Text, "What it is called in reports; room."),
        key("layers", StageType::Layers, "The layers that are seen, by number (`layers` of `[[nodes]]`); all."),
        key(
            "update",
            StageType::Word(super::monitors::UPDATES),
            "Whether a live view draws them anew in every frame, or once. Stills and sequences always do; always.",
        ),
        key(
            "every",
            StageType::Number { min: 1.0, is_above: false, max: 1e6 },
            "In one of how many frames a live view draws them anew; 1.",
        ),
        key(
            "quality",
            StageType::Word(super::monitors::QUALITIES),
            "The tier of quality whose passes draw them; the settings of the picture.",
        ),
    ],
};

/// Materials that are changed.
pub(super) const MATERIALS: StageTable = StageTable {
    name: "materials",
    doc: "Every material of the model with that name is changed.",
    keys: &[
        required("name", StageType::Text, "The name of the materials, in which * stands for any letters."),
        key("cast_shadow", StageType::Boolean, "Whether their surfaces keep light from what lies behind them."),
        key(
            "normal_convention",
            StageType::Word(super::materials::CONVENTIONS),
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
            StageType::Word(super::materials::ENCODINGS),
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
            StageType::Word(super::heights::METHODS),
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

/// A UV set.
const UV_SET: StageType = StageType::Number { min: 0.0, is_above: false, max: 1.0 };

/// From 0 to 1.
const SHARE: StageType = StageType::Number { min: 0.0, is_above: false, max: 1.0 };

/// A length above 0.
const fn length(max: f32) -> StageType {
    StageType::Number { min: 0.0, is_above: true, max: max as f64 }
}

/// Any finite number.
const FINITE: StageType = StageType::Number { min: f32::MIN as f64, is_above: false, max: f32::MAX as f64 };

/// What is drawn over the picture.
pub(super) const OVERLAY: StageTable = StageTable {
    name: "overlay",
    doc: "Something that is drawn over the finished picture: `text`, a `sprite`, a `monitor`, or a line through `points` or `points_world`. \
          Later ones are drawn over earlier ones.",
    keys: &[
        key("text", StageType::Text, "Text; `\\n` ends a line. A letter that the font has not is a box."),
        key(
            "sprite",
            StageType::Text,
            "An image: a PNG, JPEG, WebP or KTX2 file, its path from the folder of the stage.",
        ),
        key("monitor", StageType::Text, "What the monitor of that name shows: picture in picture."),
        key(
            "points",
            StageType::Pairs,
            "A line through these points, in pixels from the upper left corner of the picture, below 0 from its right or lower \
             edge; or from where `anchor`, `at_world` or `node` say.",
        ),
        key("points_world", StageType::Vectors, "A line through these points of the world, in metres."),
        key(
            "position",
            StageType::Pair,
            "Pixels to the right and down, from the upper left corner of the picture, or from where `anchor`, `at_world` or `node` \
             say. Without those a number below 0 counts from the right or the lower edge to that of the item; [0, 0].",
        ),
        key(
            "anchor",
            StageType::Word(Anchor::NAMES),
            "The point of the item that lies at its position, and the point of the picture that this is told from; at `at_world` \
             and `node` of the item alone, and `center` without it.",
        ),
        key("at_world", StageType::Vector, "A place in the world that the position is told from, in metres."),
        key("node", StageType::Text, "The name of a node whose origin the position is told from."),
        key(
            "depth_test",
            StageType::Boolean,
            "Whether opaque surfaces hide what lies behind them, of items at places of the world; false.",
        ),
        key(
            "depth_offset_m",
            FINITE,
            "By how many metres the item counts as nearer to the eye where depth is compared; 0.",
        ),
        key("color", StageType::Color, "Its colour, by which sprites are multiplied; white."),
        key("opacity", SHARE, "What its coverage is multiplied by; 1."),
        key("size_px", length(TEXT_SIZE_PX_MAX), "The size of the font (its em) in pixels; 16."),
        key("align", StageType::Word(TextAlign::NAMES), "Where shorter lines of the text stand; left."),
        key(
            "font",
            StageType::Text,
            "A TrueType or OpenType file, its path from the folder of the stage, in place of the built-in font.",
        ),
        key("background", StageType::Color, "The colour of a box behind the text."),
        key("background_opacity", SHARE, "The opacity of that box; 1."),
        key(
            "padding_px",
            StageType::Number { min: 0.0, is_above: false, max: SIDE_PX_MAX as f64 },
            "By how many pixels the box is larger than the text on every side, and the text's place farther from its anchor; 0.",
        ),
        key(
            "width_px",
            length(SIDE_PX_MAX),
            "The width of a line in pixels, 1; or of a sprite or monitor, its texels.",
        ),
        key(
            "height_px",
            length(SIDE_PX_MAX),
            "The height of a sprite or monitor in pixels. Of one side alone the other follows from the image's shape.",
        ),
        key(
            "rotation_deg",
            FINITE,
            "By how many degrees a sprite or monitor is turned clockwise around its middle; 0.",
        ),
    ],
};

/// All of them but the tables of settings.
pub const TABLES: [StageTable; 14] = [
    FILE,
    LIGHTS,
    NODES,
    MATERIALS,
    MONITORS,
    MIRRORS,
    SIMULATIONS,
    PARTICLES,
    DECALS,
    WATER,
    PORTALS,
    SURROUNDINGS,
    PROBES,
    OVERLAY,
];

impl StageType {
    /// What it takes, in words.
    pub fn expected(&self) -> String {
        match self {
            Self::Text => "a text in quotes".into(),
            Self::Boolean => "true or false".into(),
            Self::Word([before @ .., last]) if !before.is_empty() => {
                format!("\"{}\" or \"{last}\"", before.join("\", \""))
            }
            Self::Word(words) => words.join(", "),
            Self::Color => "a colour such as \"ff8800\", or [r, g, b] of at least 0 in linear light".into(),
            Self::Pair => "two finite numbers in brackets, [x, y]".into(),
            Self::Vector => "three finite numbers in brackets, [x, y, z]".into(),
            Self::Layers => "a list of whole numbers from 0 to 31, [0, 3]".into(),
            Self::Pairs => "a list of points of two finite numbers, [[x, y], [x, y]]".into(),
            Self::Vectors => "a list of points of three finite numbers, [[x, y, z], [x, y, z]]".into(),
            Self::Texts => "a list of texts in quotes, [\"a\", \"b\"]".into(),
            Self::Values => "a table of numbers and lists of numbers, { strength = 0.5, center = [0, 1] }".into(),
            Self::Number { min, is_above, max } => {
                let least = if *is_above { format!("above {min}") } else { format!("of at least {min}") };
                if *max < f64::from(f32::MAX) {
                    return format!("a number {least} and at most {max}");
                }
                format!("a finite number {least}")
            }
        }
    }

    /// Its name in a table.
    pub fn name(&self) -> String {
        match self {
            Self::Text => "text".into(),
            Self::Boolean => "bool".into(),
            Self::Word(words) => words.join(", "),
            Self::Color => "color".into(),
            Self::Pair => "vec2f".into(),
            Self::Vector => "vec3f".into(),
            Self::Layers => "list of u32".into(),
            Self::Pairs => "list of vec2f".into(),
            Self::Vectors => "list of vec3f".into(),
            Self::Texts => "list of text".into(),
            Self::Values => "table".into(),
            Self::Number { min, is_above, max } => {
                let sign = if *is_above { ">" } else { "≥" };
                let most = if *max < f64::from(f32::MAX) { format!(", ≤ {max}") } else { String::new() };
                format!("f32 {sign} {min}{most}")
            }
        }
    }
}
