//! Levels of detail: many small things with all that they have, with coarser meshes, and with less and less of their
//! materials.

use super::Bench;
use super::measure::Scene;
use super::way::{Effort, LEVELS};
use crate::step::open_picture;
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result};
use manypass_testkit::compare::flip;

/// Prints the table.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let scene = Scene::new("demo:crowd", "demo:crowd", (960, 540));
    let columns = [
        ("drawn with", 28),
        ("median ms", 9),
        ("ratio", 6),
        ("geometry ms", 11),
        ("layered ms", 10),
        ("draws", 7),
        ("binding changes", 8),
        ("triangles", 11),
        ("FLIP", 7),
    ];
    bench.report.begin("10,000 small things (`demo:crowd`), 960x540", &columns);
    let ways: Vec<_> = LEVELS.iter().map(|way| (*way, Effort::Frames)).collect();
    bench.measurements.measure_in_turns(&scene, &ways);
    let measured = |way| bench.measurements.cell(&scene, way)?.context("it was not measured");
    let whole = measured(LEVELS[0])?;
    let truth = open_picture(&whole.picture)?;
    let mut rows = Vec::new();
    for way in LEVELS {
        let cell = measured(way)?;
        let passes = cell.info["passes"].as_array().into_iter().flatten();
        let pass_ms = |name: &str| {
            let of_name = passes.clone().filter(|pass| pass["name"] == name);
            milliseconds(of_name.filter_map(|pass| pass["gpu_ms"].as_f64()).sum())
        };
        rows.push(vec![
            way.name.to_owned(),
            milliseconds(cell.median_ms),
            ratio(cell.median_ms / whole.median_ms),
            pass_ms("geometry"),
            pass_ms("layered"),
            cell.number("draws").to_string(),
            cell.number("binding_changes").to_string(),
            cell.number("triangles").to_string(),
            format!("{:.4}", flip(&truth, &open_picture(&cell.picture)?).mean()),
        ]);
    }
    rows.into_iter().for_each(|row| bench.report.row(row));
    bench.report.note("FLIP is that to the picture with all. Fading is as it is by default.");
    Ok(())
}
