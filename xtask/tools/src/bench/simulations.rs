//! Steps of simulations beside a copy of their states, measured by a bench of the renderer's.

use super::Bench;
use crate::step::{cargo, last_json};
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result};

/// What a step of particles may take, beside a copy of their states.
const PARTICLES_MAX: f64 = 4.0;

/// Prints the table. Particles that cost more than they may are a failure, unless it was built for a trial.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let mut command = if bench.is_trial() {
        cargo(["test", "--quiet", "-p", "manypass", "--bench", "simulations", "--", "--json"])
    } else {
        cargo(["bench", "--quiet", "-p", "manypass", "--bench", "simulations", "--", "--json"])
    };
    let measured = last_json(&mut command)?;
    let columns = [
        ("a step of", 40),
        ("ms", 8),
        ("a copy of its states, ms", 10),
        ("ratio", 8),
        ("passes", 7),
        ("states and pictures, MiB", 10),
    ];
    bench.report.begin("Simulations", &columns);
    for row in measured["rows"].as_array().context("nothing was measured")? {
        let number = |key: &str| row[key].as_f64().with_context(|| format!("no {key} in {row}"));
        let (name, times) = (row["name"].as_str().unwrap_or_default(), number("ratio")?);
        bench.report.row(vec![
            name.to_owned(),
            milliseconds(number("ms")?),
            milliseconds(number("copy_ms")?),
            ratio(times),
            number("passes")?.to_string(),
            format!("{:.1}", number("bytes")? / f64::from(1 << 20)),
        ]);
        if name.starts_with("100,000 particles") && times > PARTICLES_MAX && !bench.is_trial() {
            bench.failures.push(format!(
                "Simulations: a step of particles takes {times:.2} copies, and may take {PARTICLES_MAX}"
            ));
        }
    }
    bench.report.note("A copy is a simulation whose passes give each state back as it is.");
    Ok(())
}
