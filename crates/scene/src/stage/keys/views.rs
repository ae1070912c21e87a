//! The keys of what shows or lights the scene from other places: monitors, mirrors, portals, probes, reflection probes.

use super::declaration::{SHARE, StageTable, StageType, UV_SET, from, key, required};
use crate::stage::words::{QUALITIES, SLOTS, UPDATES};

/// What monitors show.
pub(crate) const MONITORS: StageTable = StageTable {
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
            StageType::Word(SLOTS),
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
            StageType::Word(UPDATES),
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
            StageType::Word(QUALITIES),
            "The tier of quality whose passes draw it; the settings of the picture.",
        ),
    ],
};

/// Flat mirrors.
pub(crate) const MIRRORS: StageTable = StageTable {
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
            StageType::Word(QUALITIES),
            "The tier of quality whose passes draw what it shows; the settings of the picture.",
        ),
    ],
};

/// Portals.
pub(crate) const PORTALS: StageTable = StageTable {
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
            StageType::Word(QUALITIES),
            "The tier of quality whose passes draw what is seen through it; the settings of the picture.",
        ),
    ],
};

/// Light that arrives at places, for the surfaces between them.
pub(crate) const PROBES: StageTable = StageTable {
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
pub(crate) const REFLECTION_PROBES: StageTable = StageTable {
    name: "reflection_probes",
    doc: "Six pictures around a place. They take the place of the environment for the surfaces within a box: a room, or what is around a glossy thing.",
    keys: &[
        required("center", StageType::Vector, "The middle of the box whose surfaces reflect it, in metres."),
        required("size_m", StageType::Vector, "Its extent along X, Y and Z, in metres."),
        key("fade_m", from(0.0), "Over how many metres within its faces the environment takes over; 0."),
        key("position", StageType::Vector, "From where the pictures are taken, in metres; `center`."),
        key(
            "parallax_correction",
            StageType::Boolean,
            "Whether reflections are shifted to where they meet the walls of a box, as rooms need it; true.",
        ),
        key(
            "bounces",
            StageType::Number { min: 1.0, is_above: false, max: 4.0 },
            "How often the pictures are taken, each time in the light of those before; 2.",
        ),
        key("parallax_center", StageType::Vector, "The middle of the box of those walls, in metres; `center`."),
        key("parallax_size_m", StageType::Vector, "The extent of that box along X, Y and Z, in metres; `size_m`."),
        key("name", StageType::Text, "What it is called in reports; room."),
        key(
            "layers",
            StageType::Layers,
            "The layers that the pictures show, by number (`layers` of `[[nodes]]`); all.",
        ),
        key(
            "update",
            StageType::Word(UPDATES),
            "Whether a live view draws them anew in every frame, or once. Stills and sequences always do; always.",
        ),
        key(
            "every",
            StageType::Number { min: 1.0, is_above: false, max: 1e6 },
            "In one of how many frames a live view draws them anew; 1.",
        ),
        key(
            "quality",
            StageType::Word(QUALITIES),
            "The tier of quality whose passes draw them; the settings of the picture.",
        ),
    ],
};
