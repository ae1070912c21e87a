//! Pictures of the environment: prefiltering one, having it from the cache, and the studio.

use super::Bench;
use crate::step::{cargo, last_json};
use crate::table::milliseconds;
use anyhow::{Context, Result};

/// The rows: what is measured, the number of the bench in milliseconds, and what it may take at most.
const ROWS: [(&str, &str, f64); 4] = [
    ("a picture of 2048x1024, in no cache", "cold_ms", 1500.0),
    ("the same, from a cache", "cached_ms", 50.0),
    ("the studio, first in a process", "studio_first_ms", 50.0),
    ("the studio, computed before", "studio_ms", 50.0),
];

/// Prints the table.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let mut command = if bench.is_trial() {
        cargo(["test", "--quiet", "--workspace", "--bench", "environment"])
    } else {
        cargo(["bench", "--quiet", "-p", "manypass", "--bench", "environment"])
    };
    let measured = last_json(&mut command)?;
    let number = |key: &str| measured[key].as_f64().with_context(|| format!("no {key} in {measured}"));
    let columns = [("a frame of 16x16 pixels with", 36), ("ms", 9), ("limit, ms", 9)];
    bench.report.begin("Pictures of the environment", &columns);
    for (name, key, limit_ms) in ROWS {
        bench.report.row(vec![name.to_owned(), milliseconds(number(key)?), milliseconds(limit_ms)]);
    }
    let mebibytes = number("cached_bytes")? / f64::from(1 << 20);
    bench.report.note(&format!("Its tiles take {mebibytes:.1} MiB; docs/environment.md has the samples of a texel."));
    Ok(())
}
