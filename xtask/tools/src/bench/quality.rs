//! Tiers of quality: what a live frame of each takes, and how its picture differs from that of the best with many samples.

use super::Bench;
use super::measure::numbers;
use crate::step::{check, last_json, open_picture};
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result};
use manypass_testkit::compare::flip;
use manypass_testkit::needs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The tiers, the cheapest first.
const TIERS: [&str; 4] = ["low", "medium", "high", "ultra"];
/// Small, because software adapters take seconds for a frame of 1280x720 in the hall.
const SIZE: (u32, u32) = (640, 360);
/// All tiers take turns; the least frame of all counts, because all frames of a tier are the same work, and other work
/// of the machine only makes them slower.
const TURNS: usize = 3;
/// The frames of a turn at most, and the milliseconds after which no more are begun.
const FRAMES: &str = "9";
const BUDGET_MS: &str = "4000";
/// The picture that is taken for right: the best tier with so many samples.
const SAMPLES: &str = "32";
/// Each tier is at least so many times as fast as the next.
const FASTER_MIN: f64 = 1.3;

/// The scenes that are on this machine: names and inputs.
fn scenes() -> Vec<(&'static str, String)> {
    let assets = needs::assets_folder();
    let files = [
        ("DamagedHelmet", "khronos-sample-assets/Models/DamagedHelmet/glTF-Binary/DamagedHelmet.glb"),
        ("Sponza", "sponza/sponza_cd.glb"),
    ];
    let files = files.into_iter().map(|(name, path)| (name, assets.join(path)));
    let files = files.filter(|(_, path)| path.is_file()).map(|(name, path)| (name, path.display().to_string()));
    std::iter::once(("demo:hall", "demo:hall".to_owned())).chain(files).collect()
}

/// What was measured of a tier.
#[derive(Clone, Debug)]
struct Cell {
    ms: f64,
    scene_bytes: f64,
    picture: PathBuf,
}

/// Measures a live frame of one sample.
fn measure(program: &Path, input: &str, tier: &str, picture: PathBuf) -> Result<Cell> {
    let size = format!("{}x{}", SIZE.0, SIZE.1);
    let mut command = Command::new(program);
    command.args(["bench", input, "--live", "--quality", tier, "--size", &size, "--json"]);
    command.args(["--count", FRAMES, "--budget-ms", BUDGET_MS, "--png"]).arg(&picture);
    let result = last_json(&mut command)?;
    let least = numbers(&result["frames"]).into_iter().min_by(f64::total_cmp);
    let ms = least.with_context(|| format!("no times of frames in {result}"))?;
    let scene_bytes = result["info"]["scene_bytes"].as_f64().context("no bytes of the scene")?;
    Ok(Cell { ms, scene_bytes, picture })
}

/// All tiers of a scene, in turns.
fn measured(bench: &Bench, name: &str, input: &str) -> Result<Vec<Cell>> {
    let program = &bench.measurements.program;
    let picture = |tier: &str| bench.measurements.folder.join(format!("{}-{tier}.png", name.replace(':', "-")));
    let turn = || TIERS.iter().map(|tier| measure(program, input, tier, picture(tier))).collect::<Result<Vec<_>>>();
    let mut least = turn()?;
    for _ in 1..TURNS {
        for (cell, again) in least.iter_mut().zip(turn()?) {
            cell.ms = cell.ms.min(again.ms);
        }
    }
    Ok(least)
}

/// Prints the table. A tier that is not so much faster than the next is a failure.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let columns = [
        ("scene", 14),
        ("tier", 7),
        ("ms", 9),
        ("times as fast as the next", 10),
        ("FLIP to ultra of many samples", 10),
        ("meshes and textures, MiB", 10),
    ];
    bench.report.begin(&format!("Tiers of quality, live frames of one sample, {}x{}", SIZE.0, SIZE.1), &columns);
    for (name, input) in scenes() {
        let truth = bench.measurements.folder.join(format!("{}-truth.png", name.replace(':', "-")));
        let size = format!("{}x{}", SIZE.0, SIZE.1);
        let mut command = Command::new(&bench.measurements.program);
        command.args(["render", &input, "--quality", "ultra", "--samples", SAMPLES, "--size", &size, "--quiet", "-o"]);
        check(command.arg(&truth))?;
        let truth = open_picture(&truth)?;
        let cells = measured(bench, name, &input)?;
        for (index, (tier, cell)) in TIERS.iter().zip(&cells).enumerate() {
            let faster = cells.get(index + 1).map(|next| next.ms / cell.ms);
            if let Some(failure) = faster.and_then(|faster| failure(name, tier, faster)) {
                bench.failures.push(failure);
            }
            bench.report.row(vec![
                name.to_owned(),
                (*tier).to_owned(),
                milliseconds(cell.ms),
                faster.map_or("–".into(), ratio),
                format!("{:.4}", flip(&truth, &open_picture(&cell.picture)?).mean()),
                format!("{:.1}", cell.scene_bytes / f64::from(1 << 20)),
            ]);
        }
    }
    bench.report.note(&format!(
        "FLIP (Andersson et al. 2020) is the mean to `render --quality ultra --samples {SAMPLES}`: frames of one sample have hard edges, so \
         that ultra has some, too."
    ));
    Ok(())
}

/// What is wrong with a tier that is too little faster than the next.
fn failure(scene: &str, tier: &str, faster: f64) -> Option<String> {
    let is_fast = faster >= FASTER_MIN;
    (!is_fast).then(|| {
        format!("Quality: {tier} is {faster:.2} times as fast as the next in {scene}, and is to be {FASTER_MIN}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tier_that_is_hardly_faster_is_a_failure() {
        assert_eq!(failure("a", "low", 1.31), None);
        let said = failure("demo:hall", "low", 1.25).expect("too slow");
        assert!(said.contains("low is 1.25 times as fast as the next in demo:hall"), "{said}");
        assert!(failure("a", "low", f64::NAN).is_some());
    }
}
