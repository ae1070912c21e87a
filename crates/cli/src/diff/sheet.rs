//! The sheet of `diff`: A, B and the map of their differences; of models also the variables that differ.

use super::comparison::{Comparison, ModelComparison};
use super::swatch::{opaque, range, shown, srgb};
use super::variables::{Variable, unit};
use crate::failure::Failure;
use crate::session::output_failure;
use manypass::LegendEntry;
use manypass_flip::{Exposures, Picture, magma};
use manypass_offline::encode;
use manypass_offline::sheet::{Entry, contact_sheet_of};

/// The longest side of a picture of the sheet in pixels; of sheets with variables.
const CELL_PX: u32 = 640;
const SMALL_CELL_PX: u32 = 400;
/// HDR-FLIP's lowest exposure shows the brightest pixel at 2.12, and its highest the median one; this far below they
/// are white, 1, and mid grey, 0.18.
const WHITE_BELOW_START_EV: f64 = 1.08;
const GREY_BELOW_STOP_EV: f64 = 3.56;

/// A picture of the sheet.
struct Cell {
    label: String,
    rgba8: Vec<u8>,
    legend: Vec<LegendEntry>,
}

/// The sheet as a PNG file.
///
/// # Errors
/// If it is too large for the encoder.
pub fn png(comparison: &Comparison) -> Result<Vec<u8>, Failure> {
    let map = &comparison.map;
    let mut cells: Vec<Cell> = pictures(comparison).into();
    let mut cell_px = CELL_PX;
    if let Some(compared) = &comparison.models {
        cell_px = SMALL_CELL_PX;
        cells.extend(variable_cells(compared));
    }
    let entries: Vec<Entry<'_>> = cells
        .iter()
        .map(|cell| Entry {
            label: &cell.label,
            group: "",
            width: map.width as u32,
            height: map.height as u32,
            rgba8: &cell.rgba8,
            legend: &cell.legend,
        })
        .collect();
    let (width, height, pixels) = contact_sheet_of(&entries, 3, cell_px).map_err(output_failure)?;
    encode::png_rgba8(width, height, &pixels).map_err(output_failure)
}

/// A, B and the map of FLIP.
fn pictures(comparison: &Comparison) -> [Cell; 3] {
    let Comparison { a, b, map, exposures, .. } = comparison;
    // Half way between showing what is brightest and showing what is common.
    let between = |exposures: Exposures| {
        0.5 * (exposures.start_ev - WHITE_BELOW_START_EV + exposures.stop_ev - GREY_BELOW_STOP_EV)
    };
    let stops_ev = exposures.map(between);
    let factor = stops_ev.unwrap_or(0.0).exp2() as f32;
    let exposed = stops_ev.map_or(String::new(), |stops| format!(" at {stops:+.1} stops"));
    let errors = map.errors.iter().flat_map(|&error| opaque(magma(error))).collect();
    let legend = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
        .map(|error| LegendEntry { label: format!("{error:.1}").into(), color_srgb: magma(error) });
    let plain = |label: String, rgba8: Vec<u8>| Cell { label, rgba8, legend: Vec::new() };
    [
        plain(format!("A: {}{exposed}", a.name), shown_picture(&a.picture, factor)),
        plain(format!("B: {}{exposed}", b.name), shown_picture(&b.picture, factor)),
        Cell {
            label: format!("FLIP: mean {:.4}, largest {:.4}", map.mean(), map.largest().error),
            rgba8: errors,
            legend: legend.into(),
        },
    ]
}

/// Bytes of sRGB for a display; `factor` exposes radiance.
fn shown_picture(picture: &Picture, factor: f32) -> Vec<u8> {
    picture.rgb_linear().iter().flat_map(|rgb| opaque(rgb.map(|linear| srgb(linear * factor)))).collect()
}

/// Three cells for each variable that differs: of A, of B, and the difference up to its largest.
fn variable_cells(compared: &ModelComparison) -> Vec<Cell> {
    let ModelComparison { layers: [a, b], variables, .. } = compared;
    let layers = |aov| a.iter().zip(b).find(|(a, _)| a.aov == aov);
    let differing = variables.all.iter().filter(|variable| variable.share > 0.0);
    differing
        .filter_map(|variable| Some((variable, layers(variable.aov)?)))
        .flat_map(|(variable, (a, b))| {
            let Variable { aov, largest, differences, share, .. } = variable;
            let range = range([&a.samples, &b.samples]);
            let name = aov.name();
            let plain = |which: &str, samples| Cell {
                label: format!("{which}: {name}"),
                rgba8: shown(*aov, samples, range),
                legend: Vec::new(),
            };
            let scale = 1.0 / largest.max(f32::MIN_POSITIVE);
            let difference = Cell {
                label: format!("{name}: {:.2} % of pixels differ", 100.0 * share),
                rgba8: differences.iter().flat_map(|difference| opaque(magma(difference * scale))).collect(),
                legend: [0.0, 0.5, 1.0].map(|part| difference_legend(part, *largest, unit(*aov))).into(),
            };
            [plain("A", &a.samples), plain("B", &b.samples), difference]
        })
        .collect()
}

fn difference_legend(part: f32, largest: f32, unit: &str) -> LegendEntry {
    let value = part * largest;
    let digits = if largest >= 10.0 { 1 } else { 3 };
    let unit = if matches!(unit, "1" | "share") { String::new() } else { format!(" {unit}") };
    LegendEntry { label: format!("{value:.digits$}{unit}").into(), color_srgb: magma(part) }
}
