//! Ours and another build of the program in turns, on the same fields of lights.

use super::Bench;
use super::measure::numbers;
use crate::step::last_json;
use crate::table::{median, milliseconds, ratio};
use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;

/// How often each program is started for a field.
const TURNS: usize = 5;
const FRAMES: &str = "16";
const BUDGET_MS: &str = "3000";
const LIGHTS: [usize; 2] = [16, 1024];

/// Medians of frames in milliseconds, of each turn: ours and the other's.
type Turns = Vec<[f64; 2]>;

/// Prints the table.
pub(super) fn print(bench: &mut Bench, other: &Path) -> Result<()> {
    let columns =
        [("lights", 8), ("ours, ms", 9), ("baseline, ms", 9), ("ours/baseline", 9), ("least", 6), ("most", 6)];
    bench.report.begin("Our frame and that of another build in turns, 960x540", &columns);
    for (lights, scene) in bench.field_scenes(false)?.into_iter().filter(|(lights, _)| LIGHTS.contains(lights)) {
        let mut turns = Turns::new();
        for turn in 0..TURNS {
            let mut pair = [f64::NAN; 2];
            // Who comes first takes turns, too.
            for step in 0..2 {
                let at = (turn + step) % 2;
                pair[at] = frame_ms([&bench.measurements.program, other][at], &scene.input)?;
            }
            turns.push(pair);
        }
        let [ours, theirs, of_medians, least, most] = summary(&turns).context("no turns")?;
        bench.report.row(vec![
            lights.to_string(),
            milliseconds(ours),
            milliseconds(theirs),
            ratio(of_medians),
            ratio(least),
            ratio(most),
        ]);
    }
    bench.report.note(&format!(
        "Medians of the medians of {TURNS} turns; least and most are the ratios of single turns. Pictures are not compared here."
    ));
    Ok(())
}

/// The median of the frames of a program, which may be older than this one.
fn frame_ms(program: &Path, input: &str) -> Result<f64> {
    let mut command = Command::new(program);
    command.args(["bench", input, "--size", "960x540", "--json", "--count", FRAMES, "--budget-ms", BUDGET_MS]);
    let result = last_json(&mut command)?;
    match median(numbers(&result["frames"])) {
        Some(ms) => Ok(ms),
        None => bail!("{command:?} measured no frames"),
    }
}

/// The medians of both, the ratio of the medians, and the least and the most of the ratios of single turns.
fn summary(turns: &[[f64; 2]]) -> Option<[f64; 5]> {
    let of = |at: usize| median(turns.iter().map(|pair| pair[at]).collect());
    let ratios = || turns.iter().map(|[ours, theirs]| ours / theirs);
    let (ours, theirs) = (of(0)?, of(1)?);
    Some([ours, theirs, ours / theirs, ratios().fold(f64::NAN, f64::min), ratios().fold(f64::NAN, f64::max)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_is_that_of_medians_and_its_spread_that_of_turns() {
        let turns = [[70.0, 100.0], [140.0, 100.0], [60.0, 120.0]];
        assert_eq!(summary(&turns), Some([70.0, 100.0, 0.7, 0.5, 1.4]));
        assert_eq!(summary(&[]), None);
    }
}
