//! How what it takes to read a file, and to draw it, grows with the number of things in it.

use super::Bench;
use crate::table::ratio;
use anyhow::{Context, Result, ensure};
use manypass_testkit::growth::GrowthAxis;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How many things there are, each ten times the one before.
const COUNTS: [usize; 3] = [10_000, 100_000, 1_000_000];
/// The same of items: a stage has 65,535 at the most.
const ITEM_COUNTS: [usize; 3] = [600, 6_000, 60_000];
/// What is expected to take longer than this is left out: ten times what a tenth of the things takes.
const CELL_MAX_SECS: f64 = 12.0;
/// No file is begun after this, so that the table takes two minutes at the most.
const TABLE_MAX_SECS: f64 = 100.0;
/// Ten times as many things may take so many times as long.
const RATIO_MAX: f64 = 20.0;
/// What takes less is mostly what a file without things takes, too, and says nothing of how it grows.
const TIME_MIN_SECS: f64 = 0.05;
/// So few things that what they add cannot be measured: what a still of them takes is taken off.
const FEW: usize = 4;

/// What a run took.
#[derive(Clone, Copy, Debug)]
struct RunCost {
    secs: f64,
    peak_mib: f64,
}

/// Prints the table. What grows as the square of the number of things is a failure.
///
/// # Errors
/// The folder cannot be made or removed.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let columns = [
        ("with so many", 22),
        ("number", 8),
        ("read, s", 8),
        ("ratio", 6),
        ("MiB", 6),
        ("drawn, s", 8),
        ("ratio", 6),
        ("MiB", 6),
    ];
    bench.report.begin("Ten times as many things: `info`, and a still of 64x64", &columns);
    let start = Instant::now();
    let folder = bench.measurements.folder.join("growth");
    for many in GrowthAxis::ALL {
        // Of a run that was interrupted.
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
        if let Err(error) = print_rows(bench, many, &folder, start) {
            bench.failures.push(format!("Growth: {}: {error:#}", many.name()));
        }
    }
    std::fs::remove_dir_all(&folder).with_context(|| format!("removing {}", folder.display()))?;
    bench.report.note(&format!(
        "What stills take is beside one of {FEW} things. A ratio is that to the row above; more than {RATIO_MAX} is a failure. \
         A dash is what would take longer than {CELL_MAX_SECS} s, or what nothing was left of {TABLE_MAX_SECS} s for."
    ));
    Ok(())
}

/// The rows of one kind of things.
fn print_rows(bench: &mut Bench, many: GrowthAxis, folder: &Path, start: Instant) -> Result<()> {
    let program = bench.measurements.program.clone();
    let bare = still(&program, folder, &write(folder, many, FEW)?)?;
    let mut last: [Option<RunCost>; 2] = [None; 2];
    let counts = if many == GrowthAxis::Items { ITEM_COUNTS } else { COUNTS };
    for count in counts {
        let has_time = start.elapsed().as_secs_f64() < TABLE_MAX_SECS;
        let [is_read, is_drawn] = last.map(|last| has_time && is_expected_soon(last));
        if !is_read && !is_drawn {
            break;
        }
        let file = write(folder, many, count)?;
        let read = if is_read { Some(info(&program, folder, &file)?) } else { None };
        let drawn = if is_drawn { Some(still(&program, folder, &file)?.beside(bare)) } else { None };
        let mut cells = vec![many.name().to_owned(), count.to_string()];
        for ((found, last), what) in [read, drawn].into_iter().zip(last).zip(["reading", "drawing"]) {
            let grown = found.zip(last).map(|(found, last)| found.ratio_to(last));
            let cell = |text: Option<String>| text.unwrap_or_else(|| "-".into());
            cells.push(cell(found.map(|found| format!("{:.2}", found.secs))));
            cells.push(cell(grown.map(ratio)));
            cells.push(cell(found.map(|found| format!("{:.0}", found.peak_mib))));
            if let Some(grown) = grown.filter(|grown| *grown > RATIO_MAX) {
                let name = many.name();
                bench.failures.push(format!("Growth: {what} {count} {name} takes {grown:.0} times a tenth of them"));
            }
        }
        bench.report.row(cells);
        // A size that is left out leaves out the larger ones.
        last = [read, drawn].map(|found| Some(found.unwrap_or(RunCost { secs: f64::INFINITY, peak_mib: 0.0 })));
    }
    Ok(())
}

/// Whether ten times as many things as took so long will not take too long; the fewest always are.
fn is_expected_soon(tenth: Option<RunCost>) -> bool {
    tenth.is_none_or(|tenth| 10.0 * tenth.secs < CELL_MAX_SECS)
}

impl RunCost {
    fn beside(self, bare: Self) -> Self {
        Self { secs: (self.secs - bare.secs).max(0.0), peak_mib: (self.peak_mib - bare.peak_mib).max(0.0) }
    }

    /// How many times as long it took as a tenth of it.
    fn ratio_to(self, tenth: Self) -> f64 {
        self.secs / tenth.secs.max(TIME_MIN_SECS)
    }
}

/// Writes the file, and whatever it names; its name.
fn write(folder: &Path, many: GrowthAxis, count: usize) -> Result<String> {
    let mut files = vec![many];
    if many == GrowthAxis::Items {
        files.push(GrowthAxis::Nodes);
    }
    for many in files {
        let path = folder.join(many.file_name(count));
        std::fs::write(&path, many.text(count)).with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(many.file_name(count))
}

fn info(program: &Path, folder: &Path, file: &str) -> Result<RunCost> {
    run(Command::new(program).args(["info", file]).current_dir(folder))
}

fn still(program: &Path, folder: &Path, file: &str) -> Result<RunCost> {
    let still = ["--size", "64x64", "--samples", "1", "--quiet", "-o", "still.png"];
    run(Command::new(program).args(["render", file]).args(still).current_dir(folder))
}

/// Runs a program to its end.
fn run(command: &mut Command) -> Result<RunCost> {
    let start = Instant::now();
    let mut child = command
        .env("RUST_LOG", "off")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| format!("starting {command:?}"))?;
    let mut peak_mib = 0.0_f64;
    let status = loop {
        peak_mib = peak_mib.max(peak_of(child.id()).unwrap_or(0.0));
        if let Some(status) = child.try_wait().with_context(|| format!("waiting for {command:?}"))? {
            break status;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    ensure!(status.success(), "{command:?} ended with {status}");
    Ok(RunCost { secs: start.elapsed().as_secs_f64(), peak_mib })
}

/// The most memory that a process has had until now; none where the system does not say it.
fn peak_of(process: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<f64>().ok()? / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(secs: f64) -> RunCost {
        RunCost { secs, peak_mib: 0.0 }
    }

    #[test]
    fn what_would_take_too_long_is_left_out() {
        assert!(is_expected_soon(None));
        assert!(is_expected_soon(Some(taken(1.0))));
        assert!(!is_expected_soon(Some(taken(2.0))));
        assert!(!is_expected_soon(Some(taken(f64::INFINITY))));
    }

    #[test]
    fn the_square_is_more_than_ten_times_as_many_may_take() {
        assert!(taken(10.0).ratio_to(taken(1.0)) < RATIO_MAX);
        assert!(taken(100.0).ratio_to(taken(1.0)) > RATIO_MAX);
        // A hundred times nothing is nothing.
        assert!(taken(0.1).ratio_to(taken(0.001)) < RATIO_MAX);
        assert_eq!(taken(1.0).beside(taken(3.0)).secs, 0.0);
    }
}
