//! What decals cost beside the pass that draws the G-buffer without them.

use super::Bench;
use crate::step::last_json;
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const SIZE: &str = "1280x720";
/// Each is measured so often, in turns; the least counts.
const TURNS: usize = 4;

/// What the G-buffer with a thousand small decals may take, beside that without.
const THOUSAND_MAX: f64 = 1.3;

/// Leaves strewn over the floor of the hall.
fn strewn(count: u32, side_m: f32) -> String {
    format!(
        "model = \"demo:hall\"\n[[decals]]\nimage = \"leaf.png\"\nposition = [0, 0, 5]\nsize_m = [{side_m}, {side_m}]\n\
         depth_m = 0.1\ncount = {count}\nspread_m = [10, 0, 30]\nroughness = 0.6\n"
    )
}

/// Prints the table. Decals that cost more than they may are a failure, unless it was built for a trial.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let columns = [
        ("on the floor of the hall", 34),
        ("without, ms", 8),
        ("marking, ms", 8),
        ("decals, ms", 8),
        ("with / without", 8),
        ("draws", 6),
    ];
    bench.report.begin(&format!("Decals: the pass `geometry`, {SIZE}"), &columns);
    let folder = &bench.measurements.folder;
    let leaf = include_bytes!("leaf.png");
    std::fs::write(folder.join("leaf.png"), leaf).context("writing leaf.png")?;
    let rows = [
        ("1 leaf of 0.17 m", 1, 0.17, None),
        ("1,000 leaves of 0.17 m", 1000, 0.17, Some(THOUSAND_MAX)),
        ("4,000 leaves of 0.17 m", 4000, 0.17, None),
        ("1,000 leaves of 0.5 m", 1000, 0.5, None),
    ];
    for (at, (name, count, side_m, most)) in rows.into_iter().enumerate() {
        let stage = bench.measurements.folder.join(format!("decals-{at}.stage.toml"));
        std::fs::write(&stage, strewn(count, side_m)).with_context(|| format!("writing {}", stage.display()))?;
        let mut least = [f64::INFINITY; 3];
        let mut draws = f64::NAN;
        for _ in 0..TURNS {
            let info = passes(&bench.measurements.program, &stage)?;
            draws = info["draws"].as_f64().unwrap_or(f64::NAN);
            let of = |name: &str| {
                let known = info["passes"].as_array().into_iter().flatten().find(|pass| pass["name"] == name)?;
                known["gpu_ms"].as_f64()
            };
            for (least, name) in least.iter_mut().zip(["geometry", "geometry.decals_mark", "geometry.decals"]) {
                let ms = of(name).with_context(|| format!("no time of the pass {name}"))?;
                *least = least.min(ms);
            }
        }
        let [without, mark, decals] = least;
        let times = (without + mark + decals) / without;
        bench.report.row(vec![
            name.to_owned(),
            milliseconds(without),
            milliseconds(mark),
            milliseconds(decals),
            ratio(times),
            draws.to_string(),
        ]);
        let is_trial = bench.is_trial();
        if let Some(most) = most.filter(|most| times > *most && !is_trial) {
            bench.failures.push(format!("Decals: {name} cost {times:.2} of the pass, and may cost {most}"));
        }
    }
    bench
        .report
        .note("The pass `geometry` draws surfaces without decals, and two more draw these where they are seen.");
    Ok(())
}

/// What the report of some frames says.
fn passes(program: &Path, stage: &Path) -> Result<Value> {
    let mut command = Command::new(program);
    command.arg("bench").arg(stage).args(["--size", SIZE, "--count", "8", "--json"]);
    Ok(last_json(&mut command)?["info"].clone())
}
