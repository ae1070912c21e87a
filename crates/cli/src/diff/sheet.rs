//! The sheet of `diff`: A, B and the map of their differences.

use super::Comparison;
use crate::failure::Failure;
use crate::session::output_failure;
use manypass::LegendEntry;
use manypass_flip::{Exposures, Picture, magma};
use manypass_offline::encode;
use manypass_offline::sheet::{Entry, contact_sheet_of};

/// The longest side of a picture of the sheet in pixels.
const CELL_PX: u32 = 640;
/// HDR-FLIP's lowest exposure shows the brightest pixel at 2.12, and its highest the median one; this far below they are white, 1,
/// and mid grey, 0.18.
const WHITE_BELOW_START_EV: f64 = 1.08;
const GREY_BELOW_STOP_EV: f64 = 3.56;

/// The sheet as a PNG file.
///
/// # Errors
/// If it is too large for the encoder.
pub fn png(comparison: &Comparison) -> Result<Vec<u8>, Failure> {
    let Comparison { a, b, map, exposures, .. } = comparison;
    // Half way between showing what is brightest and showing what is common.
    let between = |exposures: Exposures| {
        0.5 * (exposures.start_ev - WHITE_BELOW_START_EV + exposures.stop_ev - GREY_BELOW_STOP_EV)
    };
    let stops_ev = exposures.map(between);
    let factor = stops_ev.unwrap_or(0.0).exp2() as f32;
    let exposed = stops_ev.map_or(String::new(), |stops| format!(" at {stops:+.1} stops"));
    let labels = [
        format!("A: {}{exposed}", a.name),
        format!("B: {}{exposed}", b.name),
        format!("FLIP: mean {:.4}, largest {:.4}", map.mean(), map.largest().error),
    ];
    let shown: Vec<u8> = map.errors.iter().flat_map(|&error| opaque(magma(error))).collect();
    let pictures = [shown_picture(&a.picture, factor), shown_picture(&b.picture, factor), shown];
    let legend = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
        .map(|error| LegendEntry { label: format!("{error:.1}").into(), color_srgb: magma(error) });
    let entries: Vec<Entry<'_>> = labels
        .iter()
        .zip(&pictures)
        .enumerate()
        .map(|(index, (label, rgba8))| Entry {
            label,
            width: map.width as u32,
            height: map.height as u32,
            rgba8,
            legend: if index == 2 { &legend } else { &[] },
        })
        .collect();
    let (width, height, pixels) = contact_sheet_of(&entries, 3, CELL_PX).map_err(output_failure)?;
    encode::png_rgba8(width, height, &pixels).map_err(output_failure)
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

/// Bytes of sRGB for a display; `factor` exposes radiance.
fn shown_picture(picture: &Picture, factor: f32) -> Vec<u8> {
    let encoded = |linear: f32| {
        let linear = (linear * factor).clamp(0.0, 1.0);
        let value = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        (value * 255.0).round() as u8
    };
    picture.rgb_linear().iter().flat_map(|rgb| opaque(rgb.map(encoded))).collect()
}
