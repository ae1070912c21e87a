//! What `diff` prints.

use super::comparison::{Comparison, ModelComparison};
use super::models::Placement;
use super::variables::{ChangeShares, Variable, Variables, unit};
use crate::args::diff::DiffArgs;
use manypass_flip::Exposures;
use manypass_offline::decode::Light;
use serde_json::{Value, json};

/// The shares of the sum of all errors at which errors are reported.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// The unit of what is the same or not.
const SHARE: &str = "share";

/// Lines for people.
pub fn text(comparison: &Comparison) -> String {
    let Comparison { map, exposures, linear, models, .. } = comparison;
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
    if let Some(linear) = linear {
        let (share, ratio) = (linear.mean_absolute / linear.mean_a, linear.mean_b / linear.mean_a);
        if share.is_finite() {
            text += &format!(
                "\nradiance: mean difference {:.3} % of A's mean, B's mean {:.3} % of it",
                100.0 * share,
                100.0 * ratio
            );
        }
    }
    text += "\n";
    if let Some(ModelComparison { variables, placement, .. }) = models {
        text += &placement_text(placement);
        text += &variables_text(variables);
    }
    text
}

/// How far apart models lie that no picture shows both of; nothing of others.
fn placement_text(placement: &Placement) -> String {
    if !placement.is_far {
        return String::new();
    }
    let [x, y, z] = placement.offset_m;
    let distance_m = x.hypot(y).hypot(z);
    format!("B lies {distance_m:.0} m from A, {x:.1} {y:.1} {z:.1} m away: no picture shows both\n")
}

/// What changed of models, and a line for each variable.
fn variables_text(variables: &Variables) -> String {
    let Variables { all, changed: ChangeShares { geometry, material, light }, only: [only_a, only_b] } = variables;
    let percent = |share: f64| 100.0 * share;
    let mut text = format!(
        "of the pixels that show either model: geometry changed in {:.2} %, else material in {:.2} %, else light in {:.2} %\n",
        percent(*geometry),
        percent(*material),
        percent(*light)
    );
    if only_a + only_b > 0.0 {
        text += &format!("{:.2} % show A alone, {:.2} % B alone\n", percent(*only_a), percent(*only_b));
    }
    for Variable { aov, mean, largest, largest_at_px: (x, y), share, .. } in all {
        let name = aov.name();
        if *share == 0.0 {
            text += &format!("  {name:16} same\n");
            continue;
        }
        text += &format!("  {name:16} {:6.2} % of pixels", percent(*share));
        let unit = unit(*aov);
        if unit != SHARE {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            text += &format!(", mean {mean:.4}{unit}, largest {largest:.4}{unit} at column {x}, row {y}");
        }
        text.push('\n');
    }
    text
}

/// One JSON object.
pub fn json(comparison: &Comparison, args: &DiffArgs) -> String {
    let Comparison { a, b, map, exposures, pixels_per_degree, linear, models } = comparison;
    let largest = map.largest();
    let [first, median, third] = map.weighted_quantiles(SHARES);
    let mean = map.mean();
    let exposures = exposures.map(
        |Exposures { start_ev, stop_ev, count }| json!({"start_ev": start_ev, "stop_ev": stop_ev, "count": count}),
    );
    let linear = linear.map(|linear| {
        json!({
            "mean_a": linear.mean_a,
            "mean_b": linear.mean_b,
            "mean_absolute": linear.mean_absolute,
            "root_mean_square": linear.root_mean_square,
        })
    });
    let mut value = json!({
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
        "radiance": linear,
        "threshold": args.threshold,
        "is_above_threshold": args.threshold.map(|threshold| mean > threshold),
        "sheet": args.output.as_ref().map(|path| path.display().to_string()),
    });
    if let (Some(compared), Some(fields)) = (models, value.as_object_mut()) {
        let ModelComparison { camera, variables, placement, .. } = compared;
        let ChangeShares { geometry, material, light } = variables.changed;
        fields.insert("changed".into(), json!({ "geometry": geometry, "material": material, "light": light }));
        fields.insert("only".into(), json!({ "a": variables.only[0], "b": variables.only[1] }));
        fields.insert("variables".into(), variables.all.iter().map(variable).collect());
        fields.insert("camera".into(), json!(camera));
        fields.insert("offset_m".into(), json!(placement.offset_m));
        fields.insert("is_far".into(), placement.is_far.into());
    }
    format!("{value}\n")
}

fn variable(variable: &Variable) -> Value {
    json!({
        "name": variable.aov.name(),
        "unit": unit(variable.aov),
        "share": variable.share,
        "mean": variable.mean,
        "largest": variable.largest,
        "largest_at_px": [variable.largest_at_px.0, variable.largest_at_px.1],
    })
}
