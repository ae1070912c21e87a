//! Ways of anti-aliasing and of upscaling against stills of many samples, measured by a bench of the renderer's.

use super::Bench;
use crate::step::{cargo, last_json};
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result, ensure};
use serde_json::Value;

/// The row that the times of others are ratios to.
const BARE: &str = "none";

/// What was measured of a way.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    name: String,
    psnr_db: f64,
    ssim: f64,
    flip: f64,
    flicker: f64,
    ms: f64,
}

impl Row {
    fn parse(value: &Value) -> Result<Self> {
        let number = |key: &str| value[key].as_f64().with_context(|| format!("no {key} in {value}"));
        Ok(Self {
            name: value["name"].as_str().context("a way without a name")?.to_owned(),
            psnr_db: number("psnr_db")?,
            ssim: number("ssim")?,
            flip: number("flip")?,
            flicker: number("flicker")?,
            ms: number("ms")?,
        })
    }

    /// What the table shows, beside the time of a frame without anti-aliasing.
    fn cells(&self, bare_ms: f64) -> Vec<String> {
        vec![
            self.name.clone(),
            format!("{:.2}", self.psnr_db),
            format!("{:.4}", self.ssim),
            format!("{:.4}", self.flip),
            format!("{:.4}", self.flicker),
            milliseconds(self.ms),
            ratio(self.ms / bare_ms),
        ]
    }
}

/// The ways of a scene, in the order of the bench.
fn rows_of(scene: &Value) -> Result<Vec<Row>> {
    let rows = scene["rows"].as_array().context("a scene without rows")?;
    let rows: Vec<Row> = rows.iter().map(Row::parse).collect::<Result<_>>()?;
    ensure!(rows.iter().any(|row| row.name == BARE), "no row is called `{BARE}`");
    Ok(rows)
}

/// Prints a table for each of the scenes.
///
/// # Errors
/// They could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let mut command = if bench.is_trial() {
        cargo(["test", "--quiet", "-p", "manypass", "--bench", "antialiasing", "--"])
    } else {
        cargo(["bench", "--quiet", "-p", "manypass", "--bench", "antialiasing", "--"])
    };
    if bench.options.all_frames {
        command.args(["--stride", "1"]);
    }
    let measured = last_json(&mut command)?;
    let columns = [
        ("anti-aliasing", 18),
        ("PSNR, dB", 9),
        ("SSIM", 7),
        ("FLIP", 7),
        ("flicker, FLIP", 7),
        ("ms a frame", 9),
        ("ratio to none", 7),
    ];
    for scene in measured["scenes"].as_array().context("no scenes were measured")? {
        let rows = rows_of(scene)?;
        let bare_ms = rows.iter().find(|row| row.name == BARE).map_or(f64::NAN, |row| row.ms);
        let (name, frames) = (scene["name"].as_str().unwrap_or_default(), &scene["frames"]);
        let title = format!("Anti-aliasing, 480x270, {name}, a move of {frames} frames");
        bench.report.begin(&title, &columns);
        rows.into_iter().for_each(|row| bench.report.row(row.cells(bare_ms)));
        bench.report.note(&format!(
            "{} of the frames are compared, with stills of {} samples; the mean of them. Flicker is from frame to frame of a \
             camera that stands; times are until a frame was read back, and only their ratios say anything.",
            scene["compared"], measured["samples"]
        ));
    }
    for reason in measured["skipped"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        bench.report.note(&format!("SKIPPED: {reason}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rows_are_read_and_times_are_ratios() {
        let row = |name: &str, ms: f64| json!({ "name": name, "psnr_db": 30.125, "ssim": 0.96544, "flip": 0.0289, "flicker": 0, "ms": ms });
        let rows = rows_of(&json!({ "rows": [row("none", 20.0), row("TAA", 30.0)] })).expect("rows");
        let cells = rows[1].cells(rows[0].ms);
        assert_eq!(cells[0], "TAA");
        assert_eq!(cells[2..5], ["0.9654", "0.0289", "0.0000"]);
        assert_eq!(cells[6], ratio(1.5));
        assert!(rows_of(&json!({ "rows": [row("TAA", 30.0)] })).is_err(), "nothing that ratios are to");
        assert!(rows_of(&json!({ "rows": [{ "name": "none" }] })).is_err(), "no numbers");
    }
}
