//! Pictures of the environment: prefiltering one, having it from the cache, and the studio.

use super::Bench;
use crate::step::{cargo, last_json};
use crate::table::milliseconds;
use anyhow::{Context, Result};

/// The rows: what is measured, the number of the bench in milliseconds, and what it may take at most.
const ROWS: [(&str, &str, f64); 4] = [
    ("a picture of 2048x1024, in no cache", "cold_ms", 1500.0),
    ("the same, from a cache", "cached_ms", 50.0),
    ("the studio, computed before", "studio_ms", 50.0),
    ("the studio, what computing adds", "studio_added_ms", 50.0),
];

/// What is wrong with a row that takes longer than it may, or no time that can be measured.
fn failure(name: &str, found_ms: f64, limit_ms: f64) -> Option<String> {
    let is_within = found_ms <= limit_ms;
    (!is_within).then(|| format!("Environment: {name} takes {found_ms:.1} ms, and may take {limit_ms:.0}"))
}

/// Prints the table. What takes longer than it may is a failure, unless it was built for a trial.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let mut command = if bench.is_trial() {
        cargo(["test", "--quiet", "--workspace", "--bench", "environment"])
    } else {
        cargo(["bench", "--quiet", "-p", "manypass", "--bench", "environment"])
    };
    let is_trial = bench.is_trial();
    let measured = last_json(&mut command)?;
    let number = |key: &str| measured[key].as_f64().with_context(|| format!("no {key} in {measured}"));
    let columns = [("a frame of 16x16 pixels with", 36), ("ms", 9), ("limit, ms", 9)];
    bench.report.begin("Pictures of the environment", &columns);
    for (name, key, limit_ms) in ROWS {
        let found_ms = number(key)?;
        bench.report.row(vec![name.to_owned(), milliseconds(found_ms), milliseconds(limit_ms)]);
        if let Some(failure) = failure(name, found_ms, limit_ms).filter(|_| !is_trial) {
            bench.failures.push(failure);
        }
    }
    let mebibytes = number("cached_bytes")? / f64::from(1 << 20);
    bench.report.note(&format!("Its tiles take {mebibytes:.1} MiB; docs/environment.md has the samples of a texel."));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_longer_than_it_may_fails() {
        assert_eq!(failure("a", 50.0, 50.0), None);
        assert_eq!(failure("a", 50.2, 50.0).as_deref(), Some("Environment: a takes 50.2 ms, and may take 50"));
        assert!(failure("a", f64::NAN, 50.0).is_some());
    }
}
