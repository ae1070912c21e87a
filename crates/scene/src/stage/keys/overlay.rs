//! The keys of the overlay.

use super::declaration::{FINITE, SHARE, StageTable, StageType, key, length};
use crate::overlay::{Anchor, SIDE_PX_MAX, TEXT_SIZE_PX_MAX, TextAlign};

/// Items of the overlay.
pub(crate) const OVERLAY: StageTable = StageTable {
    name: "overlay",
    doc: "An item over the finished picture: `text`, a `sprite`, a `monitor`, or a line through `points` or \
          `points_world`. Later items are drawn over earlier ones.",
    keys: &[
        key("text", StageType::Text, "Text; `\\n` ends a line. Letters that the font lacks are boxes."),
        key(
            "sprite",
            StageType::Text,
            "An image: a PNG, JPEG, WebP or KTX2 file, its path from the folder of the stage.",
        ),
        key("monitor", StageType::Text, "The name of a monitor that the item shows: picture in picture."),
        key(
            "points",
            StageType::Pairs,
            "A line through these points, in pixels from the upper left corner of the picture. Numbers below 0 count \
             from its right or lower edge. With `anchor`, `at_world` or `node` points count from there.",
        ),
        key("points_world", StageType::Vectors, "A line through these points of the world, in metres."),
        key(
            "position",
            StageType::Pair,
            "The position in pixels to the right and down, from the upper left corner of the picture, or from \
             `anchor`, `at_world` or `node`. Without those, a number below 0 counts from the right or lower edge to \
             that of the item; [0, 0].",
        ),
        key(
            "anchor",
            StageType::Word(Anchor::NAMES),
            "The point of the item that lies at its position, and the point of the picture from which the position \
             counts. With `at_world` and `node` it is the item's point alone, by default `center`.",
        ),
        key("at_world", StageType::Vector, "A point of the world from which the position counts, in metres."),
        key("node", StageType::Text, "The name of a node from whose origin the position counts."),
        key(
            "depth_test",
            StageType::Boolean,
            "Whether opaque surfaces hide items behind them, for items at points of the world; false.",
        ),
        key(
            "depth_offset_m",
            FINITE,
            "The distance by which the item counts as nearer to the eye in the depth test, in metres; 0.",
        ),
        key("color", StageType::Color, "The colour; it multiplies sprites; white."),
        key("opacity", SHARE, "Multiplies the item's coverage; 1."),
        key("size_px", length(TEXT_SIZE_PX_MAX), "The size of the font (its em) in pixels; 16."),
        key("align", StageType::Word(TextAlign::NAMES), "The alignment of shorter lines of text; left."),
        key(
            "font",
            StageType::Text,
            "A TrueType or OpenType file in place of the built-in font, its path from the folder of the stage.",
        ),
        key("background", StageType::Color, "The colour of a box behind the text."),
        key("background_opacity", SHARE, "The opacity of that box; 1."),
        key(
            "padding_px",
            StageType::Number { min: 0.0, is_above: false, max: SIDE_PX_MAX as f64 },
            "The padding of the box around the text, in pixels. It also moves the text away from its anchor; 0.",
        ),
        key(
            "width_px",
            length(SIDE_PX_MAX),
            "The width of a line in pixels, 1; or of a sprite or monitor, by default its texels.",
        ),
        key(
            "height_px",
            length(SIDE_PX_MAX),
            "The height of a sprite or monitor in pixels. If one side is given, the other keeps the image's aspect \
             ratio.",
        ),
        key("rotation_deg", FINITE, "The rotation of a sprite or monitor in degrees, clockwise around its middle; 0."),
    ],
};
