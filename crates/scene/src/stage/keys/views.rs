//! The keys of captures: monitors, mirrors, portals, irradiance probes and reflection probes.

use super::declaration::{SHARE, StageTable, StageType, UV_SET, from, key, required};
use crate::stage::words::{QUALITIES, SLOTS, UPDATES};

/// Monitors.
pub(crate) const MONITORS: StageTable = StageTable {
    name: "monitors",
    doc: "A monitor (render to texture): the view of a camera of the scene, on the screens of a material or as an item \
          of `[[overlay]]`.",
    keys: &[
        required("name", StageType::Text, "Its name in reports, and for `monitor` of an `[[overlay]]`."),
        key(
            "camera",
            StageType::Text,
            "The name of a camera of the model, or of its node. Without it `position` and `target` place the camera.",
        ),
        key("position", StageType::Vector, "The position of the camera, in metres."),
        key("target", StageType::Vector, "The point at which the camera looks, in metres."),
        key(
            "fov_deg",
            StageType::Number { min: 0.0, is_above: true, max: 179.0 },
            "The vertical field of view of a camera at `position`, in degrees; 45.",
        ),
        key("material", StageType::Text, "The name of the materials that show it; * stands for any letters."),
        key(
            "slot",
            StageType::Word(SLOTS),
            "Whether the picture is the materials' emission, as on screens, or their base colour, which is lit; \
             emission.",
        ),
        key(
            "luminance_cd_m2",
            from(0.0),
            "The luminance of white on a screen. Without it, the materials' own factor of emission, or 1 where that \
             is 0.",
        ),
        key("texcoord", UV_SET, "The UV set; that of the replaced map, or 0."),
        key("size_px", StageType::Pair, "Width and height of its picture in texels, 1 to 4096 each; [512, 288]."),
        key(
            "exposure_stops",
            StageType::Number { min: -32.0, is_above: false, max: 32.0 },
            "Its exposure relative to the picture that shows it, in stops; 0.",
        ),
        key(
            "update",
            StageType::Word(UPDATES),
            "Whether a live view redraws it in every frame that shows it, or draws it once. Stills and sequences \
             always redraw it; always.",
        ),
        key(
            "every",
            StageType::Number { min: 1.0, is_above: false, max: 1e6 },
            "A live view redraws it in one of this many frames; 1.",
        ),
        key("layers", StageType::Layers, "The layers that it shows, by number (`layers` of `[[nodes]]`); all."),
        key("quality", StageType::Word(QUALITIES), "The quality tier of its view; the settings of the picture."),
    ],
};

/// Flat mirrors.
pub(crate) const MIRRORS: StageTable = StageTable {
    name: "mirrors",
    doc: "A flat mirror (planar reflection), which also reflects what the picture does not show: nodes of the model, \
          or a rectangle.",
    keys: &[
        key(
            "node",
            StageType::Text,
            "The name of nodes of the model; * stands for any letters. Each is a mirror of its own. Without it \
             `position`, `facing` and `size_m` add a rectangle to the scene.",
        ),
        key("position", StageType::Vector, "The middle of the rectangle, in metres."),
        key("facing", StageType::Vector, "The direction that it faces, of any length."),
        key("size_m", StageType::Pair, "Its width and height in metres."),
        key("name", StageType::Text, "Its name in reports; the name of the node, or mirror."),
        key(
            "color",
            StageType::Color,
            "Makes the node's material polished metal of this colour, without layers; its normal map stays. Without \
             it the node keeps its material; a rectangle is silver.",
        ),
        key("roughness", SHARE, "The roughness of the node's material; 0 is a mirror, 0.2 brushed metal."),
        key(
            "scale",
            StageType::Number { min: 0.0, is_above: true, max: 2.0 },
            "Width and height of its view, as a share of those of the picture; 1.",
        ),
        key("layers", StageType::Layers, "The layers that it shows, by number (`layers` of `[[nodes]]`); all."),
        key("quality", StageType::Word(QUALITIES), "The quality tier of its view; the settings of the picture."),
    ],
};

/// Portals.
pub(crate) const PORTALS: StageTable = StageTable {
    name: "portals",
    doc: "A portal: two flat places that lead into each other. They are nodes of the model, whose own meshes are not \
          drawn then, or rectangles.",
    keys: &[
        key(
            "node",
            StageType::Text,
            "The name of the node of the first end. Without it `position`, `facing` and `size_m` place that end.",
        ),
        key("position", StageType::Vector, "The middle of the first end, in metres."),
        key("facing", StageType::Vector, "The direction that the first end faces, of any length."),
        key("to_node", StageType::Text, "The name of the node of the other end."),
        key("to_position", StageType::Vector, "The middle of the other end, in metres."),
        key(
            "to_facing",
            StageType::Vector,
            "The direction that the other end faces. The first end shows what lies there.",
        ),
        key("size_m", StageType::Pair, "Width and height of rectangular ends, in metres."),
        key("name", StageType::Text, "Its name in reports; portal."),
        key(
            "carries",
            StageType::Text,
            "The name of nodes that pass through, with all nodes below them; * stands for any letters. Meshes that \
             are half through are drawn at both ends, and light shines through.",
        ),
        key(
            "scale",
            StageType::Number { min: 0.0, is_above: true, max: 2.0 },
            "Width and height of its view, as a share of those of the picture; 1.",
        ),
        key(
            "layers",
            StageType::Layers,
            "The layers that are seen through it, by number (`layers` of `[[nodes]]`); all.",
        ),
        key("quality", StageType::Word(QUALITIES), "The quality tier of its view; the settings of the picture."),
    ],
};

/// Grids of irradiance probes.
pub(crate) const PROBES: StageTable = StageTable {
    name: "probes",
    doc: "A grid of irradiance probes: the diffuse light at points in a box. It lights surfaces without light maps, \
          and objects that move. `manypass bake --what probes` computes it; else frames do.",
    keys: &[
        key("name", StageType::Text, "Its name, by which baked light in a file is found; probes."),
        key("center", StageType::Vector, "The middle of its box in metres; that of the model."),
        key("size_m", StageType::Vector, "The extent of its box along X, Y and Z in metres; that of the model."),
        key(
            "spacing_m",
            StageType::Number { min: 0.0, is_above: true, max: f32::MAX as f64 },
            "The distance between probes in metres; by default there are about 2,000 probes.",
        ),
        key(
            "counts",
            StageType::Vector,
            "The number of probes along X, Y and Z, in place of `spacing_m`: at most 128 each, and 16,384 together.",
        ),
        key(
            "fade_m",
            from(0.0),
            "The distance within the box's faces over which the environment takes over, in metres; 0.",
        ),
        key(
            "basis",
            StageType::Word(&crate::probes::ProbeBasis::NAMES),
            "The basis of a probe's light: spherical harmonics of order 2, or an ambient cube of six colours; \
             harmonics. The cube is smaller in the file and coarser.",
        ),
        key(
            "live",
            StageType::Boolean,
            "Whether frames compute the light by drawing views around each probe, again when something moves; true, \
             unless the file has the light.",
        ),
        key(
            "bounces",
            StageType::Number { min: 1.0, is_above: false, max: crate::probes::LIVE_BOUNCES_MAX as f64 },
            "The bounces of live probes: how often they are drawn, each time in the light of the time before; 3.",
        ),
        key("layers", StageType::Layers, "The layers that live probes see, by number (`layers` of `[[nodes]]`); all."),
    ],
};

/// Reflection probes.
pub(crate) const REFLECTION_PROBES: StageTable = StageTable {
    name: "reflection_probes",
    doc: "A reflection probe: six pictures around a point. They replace the environment for the surfaces within a box, \
          such as a room or the surroundings of a glossy object.",
    keys: &[
        required("center", StageType::Vector, "The middle of the box whose surfaces reflect it, in metres."),
        required("size_m", StageType::Vector, "The extent of that box along X, Y and Z, in metres."),
        key(
            "fade_m",
            from(0.0),
            "The distance within the box's faces over which the environment takes over, in metres; 0.",
        ),
        key("position", StageType::Vector, "The point from which the pictures are taken, in metres; `center`."),
        key(
            "parallax_correction",
            StageType::Boolean,
            "Whether reflections are shifted to the walls of a box (parallax correction), as rooms need it; true.",
        ),
        key(
            "bounces",
            StageType::Number { min: 1.0, is_above: false, max: 4.0 },
            "The bounces of light: how often the pictures are taken, each time in the light of those before; 2.",
        ),
        key("parallax_center", StageType::Vector, "The middle of the box with those walls, in metres; `center`."),
        key(
            "parallax_size_m",
            StageType::Vector,
            "The extent of the box with those walls along X, Y and Z, in metres; `size_m`.",
        ),
        key("name", StageType::Text, "Its name in reports; room."),
        key(
            "layers",
            StageType::Layers,
            "The layers that the pictures show, by number (`layers` of `[[nodes]]`); all.",
        ),
        key(
            "update",
            StageType::Word(UPDATES),
            "Whether a live view redraws the pictures in every frame, or draws them once. Stills and sequences \
             always redraw them; always.",
        ),
        key(
            "every",
            StageType::Number { min: 1.0, is_above: false, max: 1e6 },
            "A live view redraws the pictures in one of this many frames; 1.",
        ),
        key("quality", StageType::Word(QUALITIES), "The quality tier of the pictures; the settings of the picture."),
    ],
};
