//! The programs of `cargo test`, those of the renderer two at a time.
//!
//! Most of what they do has one thread, and `cargo test` runs one after the other.

use anyhow::{Context, Result, anyhow, ensure};
use serde_json::Value;
use std::{
    collections::VecDeque,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
};
use xtask::step::{Tally, cargo};

/// The package whose programs run two at a time. Others measure how long the program takes and what it holds.
const BESIDE_EACH_OTHER: &str = "crates/render/";
const WORKERS: usize = 2;

/// A program with tests.
struct Program {
    /// Where its package lies, which is where it runs.
    package: PathBuf,
    /// The file of its `main`, in the package.
    source: PathBuf,
    executable: PathBuf,
}

impl Program {
    /// One of those that a line of cargo's messages tells of.
    fn read(line: &str) -> Option<Self> {
        let message: Value = serde_json::from_str(line).ok()?;
        if message["profile"]["test"] != true {
            return None;
        }
        let text = |value: &Value| value.as_str().map(PathBuf::from);
        let package = text(&message["manifest_path"])?.parent()?.to_owned();
        let source = text(&message["target"]["src_path"])?;
        let source = source.strip_prefix(&package).map(Path::to_owned).unwrap_or(source);
        Some(Self { package, source, executable: text(&message["executable"])? })
    }

    /// Runs it to its end, and says what it printed and whether it ended well.
    fn run(&self) -> Result<(String, bool)> {
        let (mut reader, writer) = std::io::pipe()?;
        let mut command = Command::new(&self.executable);
        command.current_dir(&self.package).env("CARGO_MANIFEST_DIR", &self.package);
        command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
        let mut child = command.spawn().with_context(|| format!("starting {}", self.executable.display()))?;
        // The command holds the pipe's other end, which would never close.
        drop(command);
        let mut printed = Vec::new();
        std::io::Read::read_to_end(&mut reader, &mut printed)?;
        Ok((String::from_utf8_lossy(&printed).into_owned(), child.wait()?.success()))
    }
}

/// Builds all tests and runs them; says what passed, failed and was skipped.
pub(crate) fn test() -> Result<Tally> {
    let programs = build()?;
    ensure!(!programs.is_empty(), "cargo built no test programs");
    let (pairs, alone): (Vec<_>, Vec<_>) =
        programs.into_iter().partition(|program| program.package.ends_with(BESIDE_EACH_OTHER));
    let sum = Mutex::new(Tally::default());
    run_all(alone, 1, &sum)?;
    run_all(pairs, WORKERS, &sum)?;
    let mut sum = sum.into_inner().unwrap_or_else(PoisonError::into_inner);
    sum.add(examples_of_docs()?);
    Ok(sum)
}

fn build() -> Result<Vec<Program>> {
    let arguments = ["test", "--workspace", "--no-run", "--message-format=json-render-diagnostics"];
    let mut child = cargo(arguments).stdout(Stdio::piped()).spawn().context("starting cargo")?;
    let mut programs = Vec::new();
    for line in BufReader::new(child.stdout.take().context("no output to read")?).lines() {
        programs.extend(Program::read(&line?));
    }
    ensure!(child.wait()?.success(), "the tests do not compile");
    Ok(programs)
}

fn run_all(programs: Vec<Program>, workers: usize, sum: &Mutex<Tally>) -> Result<()> {
    let queue = Mutex::new(VecDeque::from(programs));
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
    let work = || -> Result<()> {
        while let Some(program) = next() {
            let (printed, is_well) = program.run()?;
            let mut tally = Tally::default();
            printed.lines().for_each(|line| tally.read(line));
            if !is_well && tally.failed == 0 {
                tally.failed = 1;
            }
            // What one printed stays together.
            let mut sum = sum.lock().unwrap_or_else(PoisonError::into_inner);
            let verdict = if is_well { "" } else { "error: a test failed\n" };
            let name = program.package.join(&program.source);
            write!(std::io::stdout().lock(), "     Running {}\n{printed}{verdict}", name.display())?;
            sum.add(tally);
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().map_err(|_| anyhow!("a worker panicked"))?)
    })
}

/// The examples in the docs, which cargo compiles and runs itself.
fn examples_of_docs() -> Result<Tally> {
    let mut tally = Tally::default();
    let mut command = cargo(["test", "--workspace", "--no-fail-fast", "--doc"]);
    let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| format!("starting {command:?}"))?;
    for line in BufReader::new(child.stdout.take().context("no output to read")?).lines() {
        let line = line?;
        println!("{line}");
        tally.read(&line);
    }
    let status = child.wait()?;
    ensure!(status.success() || tally.failed > 0, "{command:?} ended with {status}");
    Ok(tally)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_programs_with_tests_are_run_and_failures_count() {
        let line = |profile: &str, executable: &str| {
            format!(
                r#"{{"manifest_path":"/a/crates/b/Cargo.toml","target":{{"src_path":"/a/crates/b/tests/c.rs"}},
                "profile":{{"test":{profile}}},"executable":{executable}}}"#
            )
        };
        let program = Program::read(&line("true", "\"/a/target/c\"")).expect("a program");
        assert_eq!((program.package, program.source), ("/a/crates/b".into(), "tests/c.rs".into()));
        assert!(Program::read(&line("false", "\"/a/target/c\"")).is_none());
        assert!(Program::read(&line("true", "null")).is_none());
        assert!(Program::read("   Compiling b").is_none());

        let run = |executable: &str| Program {
            package: "/".into(),
            source: "tests/c.rs".into(),
            executable: executable.into(),
        };
        let sum = Mutex::new(Tally::default());
        run_all(vec![run("/bin/true"), run("/bin/false"), run("/bin/true")], WORKERS, &sum).expect("they start");
        assert_eq!(sum.into_inner().expect("no panic"), Tally { failed: 1, ..Tally::default() });
        assert!(run_all(vec![run("/no/such/program")], 1, &Mutex::default()).is_err());
    }
}
