//! The keys of what is drawn over the picture.

use super::declaration::{FINITE, SHARE, StageTable, StageType, key, length};
use crate::overlay::{Anchor, SIDE_PX_MAX, TEXT_SIZE_PX_MAX, TextAlign};

/// What is drawn over the picture.
pub(crate) const OVERLAY: StageTable = StageTable {
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
