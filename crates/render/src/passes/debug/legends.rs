//! What each view draws with, and what its colours mean: the legend and the picture take their colours from here.

use super::settings::DebugView;
use crate::constants::{
    DEBUG_CASCADES, DEBUG_CLUSTERS, DEBUG_FLAGS, DEBUG_LEVELS, DEBUG_LIGHTS, DEBUG_NORMALS, DEBUG_OVERDRAW,
    DEBUG_PROBE_WEIGHTS, DEBUG_TEXEL_DENSITY, DEBUG_UV,
};
use crate::record::LegendEntry;

/// A colour, sRGB.
pub type Color = [u8; 3];

/// The colour where there is no surface.
pub const BACKGROUND: Color = [0, 0, 0];

/// What is drawn for a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Legend {
    /// Colours, of which these stand for all.
    Colors(&'static [(Color, &'static str)]),
    /// Numbers; each step has the colour of those from its own on, up to the next.
    Steps(&'static [(f32, Color, &'static str)]),
}

/// How a view comes about.
#[derive(Clone, Copy, Debug)]
pub struct ViewDrawing {
    /// What `surfaces.wgsl` shows.
    pub number: u32,
    /// What that writes.
    pub drawn: Legend,
    /// Whether hidden surfaces count, too.
    pub adds_hidden: bool,
    /// Whether blended surfaces add to what is behind them; else they hide it.
    pub adds_blended: bool,
    /// Whether each level of detail has a pass of its own, whose shader is told the level.
    pub parts_levels: bool,
}

impl ViewDrawing {
    /// That of a view; none if it is off.
    pub fn of(view: DebugView) -> Option<Self> {
        let (number, drawn) = match view {
            DebugView::Off | DebugView::Probes => return None,
            DebugView::Lights => (DEBUG_LIGHTS, Legend::Steps(COUNTS)),
            DebugView::Overdraw => (DEBUG_OVERDRAW, Legend::Steps(COUNTS)),
            DebugView::Uv => (DEBUG_UV, Legend::Colors(CORNERS)),
            DebugView::Normals => (DEBUG_NORMALS, Legend::Colors(DIRECTIONS)),
            DebugView::TexelDensity => (DEBUG_TEXEL_DENSITY, Legend::Steps(DENSITIES)),
            DebugView::Flags => (DEBUG_FLAGS, Legend::Steps(FLAGS)),
            DebugView::Clusters => (DEBUG_CLUSTERS, Legend::Steps(SLICES)),
            DebugView::Cascades => (DEBUG_CASCADES, Legend::Steps(CASCADES)),
            DebugView::Levels => (DEBUG_LEVELS, Legend::Steps(LEVELS)),
            DebugView::ProbeWeights => (DEBUG_PROBE_WEIGHTS, Legend::Colors(PROBES)),
        };
        let adds_hidden = view == DebugView::Overdraw;
        Some(Self {
            number,
            drawn,
            adds_hidden,
            adds_blended: adds_hidden || view == DebugView::Lights,
            parts_levels: view == DebugView::Levels,
        })
    }

    /// What its colours mean.
    pub fn legend(&self) -> Vec<LegendEntry> {
        let entry = |color_srgb, label: &'static str| LegendEntry { label: label.into(), color_srgb };
        let mut entries: Vec<_> = match self.drawn {
            Legend::Colors(colors) => colors.iter().map(|(color, label)| entry(*color, label)).collect(),
            Legend::Steps(steps) => steps.iter().map(|(_, color, label)| entry(*color, label)).collect(),
        };
        entries.push(entry(BACKGROUND, "no surface"));
        entries
    }
}

const COUNTS: &[(f32, Color, &str)] = &[
    (0.0, [60, 56, 90], "0"),
    (0.5, [66, 84, 200], "1"),
    (1.5, [70, 128, 245], "2"),
    (2.5, [50, 164, 232], "3"),
    (3.5, [30, 195, 190], "4"),
    (4.5, [50, 216, 140], "5"),
    (5.5, [110, 236, 90], "6"),
    (6.5, [170, 246, 60], "7"),
    (7.5, [214, 228, 50], "8"),
    (8.5, [248, 190, 50], "9 to 16"),
    (16.5, [252, 136, 36], "17 to 32"),
    (32.5, [228, 72, 16], "33 to 64"),
    (64.5, [172, 22, 6], "65 to 128"),
    (128.5, [255, 0, 255], "more than 128"),
];

/// Neighbours differ in hue and brightness.
const SLICES: &[(f32, Color, &str)] = &[
    (0.0, [66, 84, 200], "slice 0, 8, 16, ..."),
    (0.5, [250, 190, 60], "slice 1, 9, 17, ..."),
    (1.5, [30, 150, 150], "slice 2, 10, 18, ..."),
    (2.5, [240, 100, 80], "slice 3, 11, 19, ..."),
    (3.5, [60, 130, 50], "slice 4, 12, 20, ..."),
    (4.5, [220, 130, 240], "slice 5, 13, 21, ..."),
    (5.5, [120, 60, 30], "slice 6, 14, 22, ..."),
    (6.5, [170, 230, 110], "slice 7, 15, 23, ..."),
];

const CASCADES: &[(f32, Color, &str)] = &[
    (0.0, [96, 96, 96], "no cascade"),
    (0.5, [222, 64, 16], "cascade 1"),
    (1.5, [252, 136, 36], "cascade 2"),
    (2.5, [248, 210, 50], "cascade 3"),
    (3.5, [110, 216, 90], "cascade 4"),
    (4.5, [30, 195, 190], "cascade 5"),
    (5.5, [50, 150, 240], "cascade 6"),
    (6.5, [66, 84, 200], "cascade 7"),
    (7.5, [150, 70, 200], "cascade 8"),
];

const LEVELS: &[(f32, Color, &str)] = &[
    (0.0, [222, 64, 16], "level 0, the finest"),
    (0.5, [252, 136, 36], "level 1"),
    (1.5, [248, 210, 50], "level 2"),
    (2.5, [110, 216, 90], "level 3"),
    (3.5, [30, 195, 190], "level 4"),
    (4.5, [50, 150, 240], "level 5"),
    (5.5, [66, 84, 200], "level 6"),
    (6.5, [150, 70, 200], "level 7 and coarser"),
];

/// By the numbers of a probe along the axes of its grid; `probe_weights.wgsl` has 0.2, 0.8 and 1 for 51, 204 and 255.
const PROBES: &[(Color, &str)] = &[
    ([51, 51, 51], "probe: x even, y even, z even"),
    ([204, 51, 51], "probe: x odd, y even, z even"),
    ([51, 204, 51], "probe: x even, y odd, z even"),
    ([204, 204, 51], "probe: x odd, y odd, z even"),
    ([51, 51, 204], "probe: x even, y even, z odd"),
    ([204, 51, 204], "probe: x odd, y even, z odd"),
    ([51, 204, 204], "probe: x even, y odd, z odd"),
    ([204, 204, 204], "probe: x odd, y odd, z odd"),
    ([255, 255, 255], "no probe"),
];

const CORNERS: &[(Color, &str)] = &[
    ([0, 0, 64], "u 0, v 0 (every other 1/8 is darker)"),
    ([255, 0, 64], "u 1, v 0"),
    ([0, 255, 64], "u 0, v 1"),
    ([255, 255, 64], "u 1, v 1"),
];

const DIRECTIONS: &[(Color, &str)] = &[
    ([255, 128, 128], "+X"),
    ([0, 128, 128], "-X"),
    ([128, 255, 128], "+Y"),
    ([128, 0, 128], "-Y"),
    ([128, 128, 255], "+Z"),
    ([128, 128, 0], "-Z"),
];

/// `texel_density.wgsl` gives 0 where there is no texture, and at least 0.001 where there is one.
const DENSITIES: &[(f32, Color, &str)] = &[
    (0.0, [96, 96, 96], "no texture"),
    (0.0005, [58, 48, 140], "under 1/8 texel a pixel"),
    (0.125, [66, 92, 220], "1/8 to 1/4"),
    (0.25, [50, 150, 240], "1/4 to 1/2"),
    (0.5, [30, 195, 190], "1/2 to 1"),
    (1.0, [80, 226, 110], "1 to 2"),
    (2.0, [214, 228, 50], "2 to 4"),
    (4.0, [252, 136, 36], "4 to 8"),
    (8.0, [222, 64, 16], "8 to 16"),
    (16.0, [160, 20, 10], "16 to 32"),
    (32.0, [255, 0, 255], "32 texels a pixel and more"),
];

/// The numbers are those of `flags.wgsl`.
const FLAGS: &[(f32, Color, &str)] = &[
    (0.0, [72, 76, 80], "nothing wrong"),
    (0.5, [255, 230, 0], "metallic neither 0 nor 1"),
    (1.5, [0, 60, 255], "base colour under sRGB 30"),
    (2.5, [0, 255, 255], "base colour over sRGB 240"),
    (3.5, [255, 110, 0], "normal map without tangents"),
    (4.5, [255, 0, 255], "not a number"),
];
