//! Steps with a name, an estimate and a time; and running programs.

use anyhow::{Context, Result, bail, ensure};
use manypass_testkit::compare::Picture;
use std::{
    ffi::OsStr,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

/// Counts what passed and what failed.
#[derive(Default)]
pub(crate) struct Steps {
    passed: u64,
    failed: u64,
    skipped: u64,
    failures: Vec<String>,
}

impl Steps {
    pub fn run(&mut self, name: &str, estimate: &str, action: impl FnOnce() -> Result<()>) {
        self.timed(name, estimate, || action().map(|()| (1, 0)));
    }

    /// Runs `cargo test`, shows its output, adds up its `test result:` lines, and counts the lines of tests that say they
    /// were skipped.
    pub fn run_tests(&mut self, name: &str, estimate: &str, mut command: Command) {
        let mut skipped = 0;
        self.timed(name, estimate, || {
            let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| format!("starting {command:?}"))?;
            let mut sum = (0, 0);
            for line in BufReader::new(child.stdout.take().context("no output to read")?).lines() {
                let line = line?;
                println!("{line}");
                skipped += u64::from(line.contains("SKIPPED"));
                let (passed, failed) = counts(&line);
                sum = (sum.0 + passed, sum.1 + failed);
            }
            let status = child.wait()?;
            ensure!(status.success() || sum.1 > 0, "{command:?} ended with {status}");
            Ok(sum)
        });
        // A test that says so counts as passed where it runs.
        self.passed = self.passed.saturating_sub(skipped);
        self.skipped += skipped;
    }

    fn timed(&mut self, name: &str, estimate: &str, action: impl FnOnce() -> Result<(u64, u64)>) {
        println!("\n==> {name} (about {estimate})");
        let start = Instant::now();
        let (passed, failed) = action().unwrap_or_else(|error| {
            eprintln!("error: {name}: {error:#}");
            (0, 1)
        });
        if failed > 0 {
            self.failures.push(name.to_owned());
        }
        self.passed += passed;
        self.failed += failed;
        let verdict = if failed == 0 { "done" } else { "FAILED" };
        println!("<== {name}: {verdict} in {:.1} s", start.elapsed().as_secs_f64());
    }

    /// Prints the summary; exits with 1 if anything failed.
    pub fn finish(self) -> Result<()> {
        if !self.failures.is_empty() {
            println!("\nfailed: {}", self.failures.join(", "));
        }
        println!("\n{} passed, {} failed, {} skipped", self.passed, self.failed, self.skipped);
        if self.failed > 0 {
            std::process::exit(1);
        }
        Ok(())
    }
}

/// Passed and failed of one line of `cargo test`.
fn counts(line: &str) -> (u64, u64) {
    let Some((_, rest)) = line.split_once("test result: ") else { return (0, 0) };
    let number_before = |word| {
        let mut words = rest.split_whitespace().rev().skip_while(|w| w.trim_end_matches(';') != word);
        words.nth(1).and_then(|number| number.parse().ok()).unwrap_or(0)
    };
    (number_before("passed"), number_before("failed"))
}

/// The repository's root.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// Models that are not in the repository: `MANYPASS_ASSETS`, or else the folder beside it.
pub(crate) fn assets() -> PathBuf {
    let named = std::env::var_os("MANYPASS_ASSETS").map(PathBuf::from);
    named.unwrap_or_else(|| root().parent().map(|parent| parent.join("shared/assets")).unwrap_or_default())
}

/// A picture file in memory.
pub(crate) fn open_picture(path: &Path) -> Result<Picture> {
    let image = image::open(path).with_context(|| format!("reading {}", path.display()))?.to_rgba8();
    Ok(Picture::from_rgba8(image.width() as usize, image.height() as usize, image.as_raw()))
}

/// `cargo` in the repository's root.
pub(crate) fn cargo<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    command
}

/// Runs a program to its end.
pub(crate) fn check(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("starting {command:?}"))?;
    if !status.success() {
        bail!("{command:?} ended with {status}");
    }
    Ok(())
}

/// What a program writes to standard output, if it ran and succeeded.
pub(crate) fn output_of(command: &mut Command) -> Option<String> {
    let output = command.stderr(Stdio::null()).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_result_line_is_counted() {
        let line = "test result: FAILED. 12 passed; 3 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.02s";
        assert_eq!(super::counts(line), (12, 3));
        assert_eq!(super::counts("running 12 tests"), (0, 0));
    }
}
