//! Light that is found beforehand: by rays and by pictures at equal error, measured by a bench of the program's; and what frames
//! with it cost.

use super::Bench;
use crate::step::{cargo, check, last_json};
use crate::table::{median, milliseconds, ratio};
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

const SIZE: &str = "1280x720";
/// Frames are measured so often, in turns; the least median counts.
const TURNS: usize = 3;

/// The hall with what is baked: the name of a row, the words for `manypass bake`, and more of a stage.
const BAKED: [(&str, &str, &str); 2] = [
    ("16x16x16 probes", "probes", "\n[[probes]]\nname = \"hall\"\ncounts = [16, 16, 16]\n"),
    ("light maps of 2 texels a metre", "lightmap", ""),
];

/// The environment is that which is baked, so that light of the same places is looked up with it and without.
const STAGE: &str = "model = \"demo:hall\"\n[environment]\nsource = \"studio\"\n";

/// What was measured of one way to find light.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    name: String,
    count: f64,
    unit: String,
    ms: f64,
    error: f64,
}

impl Row {
    fn parse(value: &Value) -> Result<Self> {
        let number = |key: &str| value[key].as_f64().with_context(|| format!("no {key} in {value}"));
        let text = |key: &str| value[key].as_str().map(str::to_owned).with_context(|| format!("no {key} in {value}"));
        Ok(Self {
            name: text("name")?,
            count: number("count")?,
            unit: text("unit")?,
            ms: number("ms")?,
            error: number("error")?,
        })
    }

    fn is_rays(&self) -> bool {
        self.unit == "rays"
    }

    /// Of rays those that are as right with the least of them; none for rays themselves, or where none is.
    fn equal<'r>(&self, rows: &'r [Self]) -> Option<&'r Self> {
        rows.iter().filter(|row| row.is_rays() && !self.is_rays()).find(|row| row.error <= self.error)
    }

    /// What the table shows.
    fn cells(&self, rows: &[Self]) -> Vec<String> {
        let equal = self.equal(rows);
        vec![
            self.name.clone(),
            format!("{} {}", self.count, self.unit),
            format!("{:.2} %", 100.0 * self.error),
            format!("{:.4}", self.ms),
            equal.map_or_else(|| "-".into(), |rays| format!("{} rays", rays.count)),
            equal.map_or_else(|| "-".into(), |rays| ratio(self.ms / rays.ms)),
        ]
    }
}

/// Prints the tables.
///
/// # Errors
/// They could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let mut command = if bench.is_trial() {
        cargo(["test", "--quiet", "-p", "manypass-cli", "--bench", "baking", "--", "--json"])
    } else {
        cargo(["bench", "--quiet", "-p", "manypass-cli", "--bench", "baking", "--", "--json"])
    };
    let measured = last_json(&mut command)?;
    let (probes, texels) = (&measured["probes"], &measured["texels"]);
    print_rows(bench, "Probes of the Cornell box, by rays and by frames", "ms a probe", probes)?;
    bench.report.note(&format!(
        "{} probes, of which {} are on. Frames look around each {} times, with one bounce less; milliseconds are of all of that. \
         The error is the mean relative one of irradiance over 16 normals, beside {} rays. Equal are the fewest rays whose error is no greater.",
        probes["count"], probes["on"], probes["rounds"], probes["reference"]
    ));
    print_rows(bench, "Texels of the Cornell box, by rays and by hemicubes", "ms a texel and round", texels)?;
    bench.report.note(&format!(
        "Error of {} texels of the floor and a wall, in light of the lamp and what surfaces send back of it {} times, beside {} rays, \
         with the noise left in; rays are timed over all {} texels. Views are drawn, and waited for, not read.",
        texels["points"], texels["bounces"], texels["reference"], texels["count"]
    ));
    print_frames(bench)
}

fn print_rows(bench: &mut Bench, title: &str, of_time: &str, measured: &Value) -> Result<()> {
    let rows = measured["rows"].as_array().context("nothing was measured")?;
    let rows: Vec<Row> = rows.iter().map(Row::parse).collect::<Result<_>>()?;
    let columns = [("by", 24), ("of each", 12), ("error", 8), (of_time, 12), ("equal", 10), ("ratio to them", 8)];
    bench.report.begin(title, &columns);
    rows.iter().for_each(|row| bench.report.row(row.cells(&rows)));
    Ok(())
}

/// Frames of the hall with light that was found beforehand, beside frames without it.
fn print_frames(bench: &mut Bench) -> Result<()> {
    let columns = [("a frame of the hall with", 32), ("shadows", 8), ("ms", 8), ("without, ms", 8), ("ratio", 6)];
    bench.report.begin(&format!("Frames with baked light, {SIZE}"), &columns);
    let program = bench.measurements.program.clone();
    let bare = bench.measurements.folder.join("baking-none.stage.toml");
    std::fs::write(&bare, STAGE).with_context(|| format!("writing {}", bare.display()))?;
    for (name, what, more) in BAKED {
        let baked = bake(&program, &bench.measurements.folder, what, more)?;
        for shadows in [true, false] {
            let (mut with_ms, mut without_ms) = (f64::INFINITY, f64::INFINITY);
            for _ in 0..TURNS {
                with_ms = with_ms.min(frame_ms(&program, &baked, shadows)?);
                without_ms = without_ms.min(frame_ms(&program, &bare, shadows)?);
            }
            let (times, shadows) = (ratio(with_ms / without_ms), if shadows { "yes" } else { "no" });
            let row = [name, shadows, &milliseconds(with_ms), &milliseconds(without_ms), &times];
            bench.report.row(row.map(str::to_owned).to_vec());
        }
    }
    bench.report.note("All have the diffuse light of the studio: of its picture, or of what was baked in it.");
    Ok(())
}

/// Bakes the hall; the stage of what was baked.
fn bake(program: &Path, folder: &Path, what: &str, more: &str) -> Result<PathBuf> {
    let named = |end: &str| folder.join(format!("baking-{what}{end}"));
    let stage = named(".stage.toml");
    std::fs::write(&stage, format!("{STAGE}{more}")).with_context(|| format!("writing {}", stage.display()))?;
    let mut command = Command::new(program);
    command.arg("bake").arg(&stage).arg("-o").arg(named("-baked.glb"));
    check(command.args(["--what", what, "--density", "2", "--samples", "16", "--quiet"]))?;
    Ok(named("-baked.stage.toml"))
}

/// The median of some frames in milliseconds.
fn frame_ms(program: &Path, stage: &Path, shadows: bool) -> Result<f64> {
    let mut command = Command::new(program);
    command.arg("bench").arg(stage).args(["--size", SIZE, "--count", "10", "--budget-ms", "5000", "--json"]);
    command.arg("--set").arg(format!("shadows.enabled={shadows}"));
    let result = last_json(&mut command)?;
    let frames = result["frames"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    median(frames).with_context(|| format!("no frames of {}", stage.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn views_are_beside_the_fewest_rays_that_are_as_right() {
        let row = |name: &str, count: u32, ms: f64, error: f64| {
            let unit = if name == "rays" { "rays" } else { "views" };
            Row::parse(&json!({ "name": name, "count": count, "unit": unit, "ms": ms, "error": error })).expect("a row")
        };
        let of_rays = [row("rays", 4, 0.5, 0.2), row("rays", 16, 2.0, 0.05), row("rays", 64, 8.0, 0.02)];
        let views = row("six views", 6, 9.0, 0.06);
        let cells = views.cells(&of_rays);
        assert_eq!(cells[1..3], ["6 views", "6.00 %"]);
        assert_eq!(cells[4..], ["16 rays".to_owned(), ratio(4.5)]);
        assert_eq!(of_rays[1].cells(&of_rays)[4..], ["-", "-"]);
        assert_eq!(row("six views", 6, 9.0, 0.01).equal(&of_rays), None, "no rays are as right");
        assert!(Row::parse(&json!({ "name": "rays" })).is_err());
    }
}
