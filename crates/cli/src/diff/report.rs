//! What `diff` prints.

use super::{Comparison, DiffArgs};
use manypass_flip::Exposures;
use manypass_offline::decode::Light;
use serde_json::json;

/// The shares of the sum of all errors at which errors are reported.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// Lines for people.
pub fn text(comparison: &Comparison) -> String {
    let Comparison { map, exposures, .. } = comparison;
    let largest = map.largest();
    let [first, median, third] = map.weighted_quantiles(SHARES);
    let mut text = format!("FLIP mean {:.6}, largest {:.6}", map.mean(), largest.error);
    if largest.error > 0.0 {
        text += &format!(" at column {}, row {}", largest.x, largest.y);
        text += &format!("\nhalf of the sum is in pixels up to {median:.6} (quartiles {first:.6}, {third:.6})");
    }
    if let Some(Exposures { start_ev, stop_ev, count }) = exposures {
        text += &format!("\nthe largest over {count} exposures from {start_ev:.2} to {stop_ev:.2} stops");
    }
    text + "\n"
}

/// One JSON object.
pub fn json(comparison: &Comparison, args: &DiffArgs) -> String {
    let Comparison { a, b, map, exposures, pixels_per_degree } = comparison;
    let largest = map.largest();
    let [first, median, third] = map.weighted_quantiles(SHARES);
    let mean = map.mean();
    let exposures = exposures.map(
        |Exposures { start_ev, stop_ev, count }| json!({"start_ev": start_ev, "stop_ev": stop_ev, "count": count}),
    );
    let value = json!({
        "a": a.name,
        "b": b.name,
        "size_px": [map.width, map.height],
        "flip": {
            "kind": if a.light == Light::Scene { "hdr" } else { "ldr" },
            "mean": mean,
            "largest": largest.error,
            "largest_at_px": [largest.x, largest.y],
            "weighted_median": median,
            "weighted_quartiles": [first, third],
            "pixels_per_degree": pixels_per_degree,
            "exposures": exposures,
        },
        "threshold": args.threshold,
        "is_above_threshold": args.threshold.map(|threshold| mean > threshold),
        "sheet": args.output.as_ref().map(|path| path.display().to_string()),
    });
    format!("{value}\n")
}
