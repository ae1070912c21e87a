//! Steps with a name, an estimate and a time; and running programs.

use anyhow::{Context, Result, bail};
use manypass_testkit::{compare::Picture, needs};
use serde_json::Value;
use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
    time::Instant,
};

/// What became of tests and steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub passed: i64,
    pub failed: i64,
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
        } else if line.contains(needs::SKIPPED) {
            self.passed -= 1;
            self.skipped += 1;
        }
    }
}

/// Counts what passed, what failed and what was skipped.
#[derive(Default)]
pub(crate) struct Steps {
    sum: Tally,
    failures: Vec<String>,
}

impl Steps {
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

    /// Prints the summary; exits with 1 if anything failed.
    pub fn finish(self) -> Result<()> {
        if !self.failures.is_empty() {
            println!("\nfailed: {}", self.failures.join(", "));
        }
        let Tally { passed, failed, skipped } = self.sum;
        println!("\n{passed} passed, {failed} failed, {skipped} skipped");
        if failed > 0 {
            std::process::exit(1);
        }
        Ok(())
    }
}

/// The repository's root.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
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

/// The program as the tests have it, in the repository's root. Built for itself it would have other features of its
/// dependencies, and compile them once more.
pub(crate) fn program() -> Result<Command> {
    static IS_BUILT: Mutex<bool> = Mutex::new(false);
    let mut is_built = IS_BUILT.lock().unwrap_or_else(PoisonError::into_inner);
    if !*is_built {
        check(&mut cargo(["test", "--quiet", "--workspace", "--no-run", "--test", "usage"]))?;
        *is_built = true;
    }
    let mut command = Command::new(root().join("target/debug/manypass"));
    command.current_dir(root());
    Ok(command)
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

/// The last line of a program's output that is a JSON object.
pub(crate) fn last_json(command: &mut Command) -> Result<Value> {
    let output = command.env("RUST_LOG", "off").output().with_context(|| format!("starting {command:?}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        // A hint may follow the error, and the driver's words may come before it.
        let error = said.lines().rfind(|line| line.starts_with("error")).unwrap_or(&said);
        bail!("{command:?} ended with {}: {}", output.status, error.trim());
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().rev().find(|line| line.starts_with('{'));
    let line = line.with_context(|| format!("{command:?} printed no JSON"))?;
    serde_json::from_str(line).with_context(|| format!("{command:?} printed no JSON"))
}

#[cfg(test)]
mod tests {
    use super::Tally;

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
