//! Steps with a name, an estimate and a time; and running programs.

use anyhow::{Context, Result, bail, ensure};
use std::{
    ffi::OsStr,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

/// What the line of a skipped test begins with: `needs::SKIPPED` of the testkit, which needs too much to depend on it.
const SKIPPED: &str = "SKIPPED";

/// How the line begins that names the steps that failed.
const FAILED: &str = "failed: ";

/// What became of tests and steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// How many passed.
    pub passed: i64,
    /// How many failed.
    pub failed: i64,
    /// How many were left out.
    pub skipped: i64,
}

impl Tally {
    /// A step that did its work, but had to leave out so many of its cases.
    pub const fn step_without(skipped: i64) -> Self {
        Self { passed: 1, failed: 0, skipped }
    }

    /// Adds another.
    pub const fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
    }

    /// Adds what a line of `cargo test` says: a result line, or that a test is skipped. The harness counts that test as
    /// passed, and one that is ignored as neither.
    pub fn read(&mut self, line: &str) {
        if let Some((_, rest)) = line.split_once("test result: ") {
            let number_before = |word| {
                let mut words = rest.split_whitespace().rev().skip_while(|w| w.trim_end_matches(';') != word);
                words.nth(1).and_then(|number| number.parse().ok()).unwrap_or(0)
            };
            self.passed += number_before("passed");
            self.failed += number_before("failed");
            self.skipped += number_before("ignored");
        } else if line.contains(SKIPPED) {
            self.passed -= 1;
            self.skipped += 1;
        }
    }

    /// The last line of [`Steps::finish`].
    fn summary(self) -> String {
        let Self { passed, failed, skipped } = self;
        format!("{passed} passed, {failed} failed, {skipped} skipped")
    }

    /// What a line such as that of [`Self::summary`] says.
    fn of_summary(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [passed, "passed,", failed, "failed,", skipped, "skipped"] = words[..] else { return None };
        Some(Self { passed: passed.parse().ok()?, failed: failed.parse().ok()?, skipped: skipped.parse().ok()? })
    }
}

/// Counts what passed, what failed and what was skipped.
#[derive(Debug, Default)]
pub struct Steps {
    sum: Tally,
    failures: Vec<String>,
}

impl Steps {
    /// Runs a step, and says its name, about how long it takes, and how long it took.
    pub fn run(&mut self, name: &str, estimate: &str, action: impl FnOnce() -> Result<()>) {
        self.run_counted(name, estimate, || action().map(|()| Tally::step_without(0)));
    }

    /// A step that is left out because nobody wants it now.
    pub fn leave_out(&mut self) {
        self.sum.skipped += 1;
    }

    /// Runs a step that says itself what passed, failed and was skipped.
    pub fn run_counted(&mut self, name: &str, estimate: &str, action: impl FnOnce() -> Result<Tally>) {
        println!("\n==> {name} (about {estimate})");
        let start = Instant::now();
        let tally = action().unwrap_or_else(|error| {
            eprintln!("error: {name}: {error:#}");
            Tally { failed: 1, ..Tally::default() }
        });
        if tally.failed > 0 {
            self.failures.push(name.to_owned());
        }
        self.sum.add(tally);
        let verdict = if tally.failed == 0 { "done" } else { "FAILED" };
        println!("<== {name}: {verdict} in {:.1} s", start.elapsed().as_secs_f64());
    }

    /// Runs a program whose steps are counted among these: it ends with [`Steps::finish`].
    pub fn run_program(&mut self, name: &str, command: &mut Command) {
        if let Err(error) = self.follow(command) {
            eprintln!("error: {name}: {error:#}");
            self.sum.failed += 1;
            self.failures.push(name.to_owned());
        }
    }

    /// Prints what a program prints but for its summary, which is added.
    fn follow(&mut self, command: &mut Command) -> Result<()> {
        let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| format!("starting {command:?}"))?;
        let mut summary = None;
        for line in BufReader::new(child.stdout.take().context("no output to read")?).lines() {
            let line = line?;
            if let Some(tally) = Tally::of_summary(&line) {
                summary = Some(tally);
            } else if let Some(names) = line.strip_prefix(FAILED) {
                self.failures.push(names.to_owned());
            } else {
                println!("{line}");
            }
        }
        let status = child.wait()?;
        let summary = summary.with_context(|| format!("{command:?} ended with {status} and no summary"))?;
        self.sum.add(summary);
        ensure!(status.success() || summary.failed > 0, "{command:?} ended with {status}");
        Ok(())
    }

    /// Prints the summary; exits with 1 if anything failed.
    ///
    /// # Errors
    /// None; it is what `main` returns.
    pub fn finish(self) -> Result<()> {
        if !self.failures.is_empty() {
            println!("\n{FAILED}{}", self.failures.join(", "));
        }
        println!("\n{}", self.sum.summary());
        if self.sum.failed > 0 {
            std::process::exit(1);
        }
        Ok(())
    }
}

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// `cargo` in the repository's root.
pub fn cargo<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments).current_dir(root());
    command
}

/// Runs a program to its end.
///
/// # Errors
/// It could not be started, or ended badly.
pub fn check(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("starting {command:?}"))?;
    if !status.success() {
        bail!("{command:?} ended with {status}");
    }
    Ok(())
}

/// What a program writes to standard output, if it ran and succeeded.
pub fn output_of(command: &mut Command) -> Option<String> {
    let output = command.stderr(Stdio::null()).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_of_skipped_tests_is_that_of_the_testkit() {
        assert_eq!(SKIPPED, manypass_testkit::needs::SKIPPED);
    }

    #[test]
    fn the_steps_of_a_program_are_counted() {
        let tally = Tally { passed: 4, failed: 1, skipped: 2 };
        assert_eq!(Tally::of_summary(&tally.summary()), Some(tally));
        assert_eq!(Tally::of_summary("4 passed, 1 failed"), None);
        let program = |script: &str| {
            let mut steps = Steps::default();
            steps.run_program("a program", Command::new("sh").args(["-c", script]));
            (steps.sum, steps.failures)
        };
        let good = program("echo; echo 4 passed, 0 failed, 2 skipped");
        assert_eq!(good, (Tally { passed: 4, failed: 0, skipped: 2 }, vec![]));
        let bad = program("echo failed: a step; echo 4 passed, 1 failed, 2 skipped; exit 1");
        assert_eq!(bad, (tally, vec!["a step".to_owned()]));
        let broken = (Tally { failed: 1, ..Tally::default() }, vec!["a program".to_owned()]);
        assert_eq!(program("exit 0"), broken);
        assert_eq!(program("exit 2"), broken);
    }

    #[test]
    fn skipped_tests_do_not_count_as_passed() {
        let mut tally = Tally::default();
        for line in [
            "running 16 tests",
            "SKIPPED every_model_loads: there is no folder shared/assets",
            "test every_model_loads ... ok",
            "test every_model_draws ... SKIPPED every_model_draws: no adapter",
            "ok",
            "test result: FAILED. 12 passed; 3 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.02s",
        ] {
            tally.read(line);
        }
        assert_eq!(tally, Tally { passed: 10, failed: 3, skipped: 3 });
    }
}
