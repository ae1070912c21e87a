//! Pictures within the picture: what mirrors and monitors cost beside the frame without them.

use super::Bench;
use crate::step::last_json;
use crate::table::{median, milliseconds, ratio};
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const SIZE: &str = "960x540";
/// Each is measured so often, in turns; the least median counts.
const TURNS: usize = 3;

/// What the frame with a mirror at half the size may take more, as a share of the frame without it.
const HALF_MIRROR_MAX: f64 = 0.45;

/// A mirror across the nave of the hall, and one at its end that is out of sight.
fn mirror(scale: f32, z_m: f32, facing: i32) -> String {
    format!(
        "model = \"demo:hall\"\n[[mirrors]]\nposition = [0, 3.5, {z_m}]\nfacing = [0, 0, {facing}]\nsize_m = [13.8, 7]\n\
         scale = {scale}\n"
    )
}

/// What is measured: the name, the stage, and what it may cost.
fn rows() -> Vec<(&'static str, String, Option<f64>)> {
    vec![
        ("a mirror across the hall, half the size", mirror(0.5, 12.0, 1), Some(HALF_MIRROR_MAX)),
        ("the same, the whole size", mirror(1.0, 12.0, 1), None),
        ("a mirror that turns its back", mirror(1.0, 12.0, -1), None),
        ("a lake and a pool, against the environment in them", "model = \"demo:water\"\n".into(), None),
        ("a doorway and two openings that face each other", "model = \"demo:portals\"\n".into(), None),
        ("a reflection probe of a room", "model = \"demo:reflection_probes\"\n".into(), None),
        ("the same, drawn once", "model = \"demo:gallery\"\n[[reflection_probes]]\ncenter = [0, 1.5, 0]\nsize_m = [8.2, 3.1, 7.2]\nupdate = \"once\"\n".into(), None),
        ("three monitors that see each other", "model = \"demo:monitors\"\n".into(), None),
    ]
}

/// Prints the table. A mirror that costs more than it may is a failure, unless it was built for a trial.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let columns = [
        ("a live frame with", 40),
        ("ms", 8),
        ("without, ms", 8),
        ("cost, share of the frame", 10),
        ("views", 6),
        ("draws", 6),
        ("without", 8),
        ("textures, MiB", 9),
    ];
    bench.report.begin(&format!("Pictures within the picture, {SIZE}"), &columns);
    for (at, (name, text, most)) in rows().into_iter().enumerate() {
        let stage = bench.measurements.folder.join(format!("captures-{at}.stage.toml"));
        std::fs::write(&stage, text).with_context(|| format!("writing {}", stage.display()))?;
        let (mut with, mut without) = (Vec::new(), Vec::new());
        for _ in 0..TURNS {
            with.push(frames(&bench.measurements.program, &stage, true)?);
            without.push(frames(&bench.measurements.program, &stage, false)?);
        }
        let least = |frames: &[(f64, Value)]| frames.iter().map(|(ms, _)| *ms).fold(f64::INFINITY, f64::min);
        let (with_ms, without_ms) = (least(&with), least(&without));
        let cost = (with_ms - without_ms) / without_ms;
        let number = |frames: &[(f64, Value)], key: &str| {
            frames.first().and_then(|(_, info)| info[key].as_f64()).unwrap_or(f64::NAN)
        };
        bench.report.row(vec![
            name.to_owned(),
            milliseconds(with_ms),
            milliseconds(without_ms),
            ratio(cost),
            number(&with, "captures").to_string(),
            number(&with, "draws").to_string(),
            number(&without, "draws").to_string(),
            format!("{:.1}", number(&with, "texture_bytes") / f64::from(1 << 20)),
        ]);
        let is_trial = bench.is_trial();
        if let Some(most) = most.filter(|most| cost > *most && !is_trial) {
            bench.failures.push(format!("Captures: {name} costs {cost:.2} of the frame, and may cost {most}"));
        }
    }
    bench.report.note("Without them the same stage is drawn with `captures.enabled=false`.");
    Ok(())
}

/// The median of some live frames in milliseconds, and what the report says.
fn frames(program: &Path, stage: &Path, has_captures: bool) -> Result<(f64, Value)> {
    let mut command = Command::new(program);
    command.arg("bench").arg(stage).args(["--size", SIZE, "--count", "10", "--live", "--json"]);
    command.arg("--set").arg(format!("captures.enabled={has_captures}"));
    let result = last_json(&mut command)?;
    let frames = result["frames"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    let median_ms = median(frames).with_context(|| format!("no frames of {}", stage.display()))?;
    Ok((median_ms, result["info"].clone()))
}
