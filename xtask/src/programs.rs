//! The programs of `cargo test`, and the jobs that they are run as.
//!
//! A crate's tests are one program (`tests/all.rs`), because each copy of wgpu takes seconds to link. Each of its
//! modules runs as a process: what the driver keeps goes with it, and two of them share the cores.

use crate::jobs::Job;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    io::{BufRead, BufReader},
    path::{Path, PathBuf},
    process::Stdio,
};
use xtask::step::{Tally, cargo, root};

/// The program whose modules run as processes.
const MODULES: &str = "tests/all.rs";

/// A program with tests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Program {
    /// Where its package lies, which is where it runs.
    pub(crate) package: PathBuf,
    /// The file of its `main`, in the package.
    pub(crate) source: PathBuf,
    pub(crate) executable: PathBuf,
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

    /// The names of its tests, those that are ignored among them.
    fn tests(&self) -> Result<Vec<String>> {
        let mut command = std::process::Command::new(&self.executable);
        command.args(["--list", "--format", "terse"]).current_dir(&self.package).stdin(Stdio::null());
        let output = command.output().with_context(|| format!("starting {command:?}"))?;
        ensure!(output.status.success(), "{command:?} ended with {}", output.status);
        Ok(names(&String::from_utf8_lossy(&output.stdout)))
    }

    /// The package's folder and the name of the program, as the tables of `jobs.rs` have them: `crates/cli memory`.
    fn name(&self) -> String {
        let package = self.package.strip_prefix(root()).unwrap_or(&self.package).display();
        match self.source.strip_prefix("tests") {
            Ok(file) => format!("{package} {}", file.with_extension("").display()),
            Err(_) => format!("{package} {}", self.source.display()),
        }
    }

    /// What it is run as: a process for each module of tests, or one.
    fn jobs(&self, tests: Vec<String>) -> Vec<Job> {
        if self.source != Path::new(MODULES) {
            return vec![Job { name: self.name(), program: self.clone(), count: tests.len(), only: Vec::new() }];
        }
        let mut modules: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for test in tests {
            let module = test.split("::").next().unwrap_or_default().to_owned();
            modules.entry(module).or_default().push(test);
        }
        let package = self.package.strip_prefix(root()).unwrap_or(&self.package).display().to_string();
        let job = |(module, only): (String, Vec<String>)| Job {
            name: format!("{package} {module}"),
            program: self.clone(),
            count: only.len(),
            only,
        };
        modules.into_iter().map(job).collect()
    }
}

/// What `--list --format terse` says: `NAME: test`.
fn names(listed: &str) -> Vec<String> {
    listed.lines().filter_map(|line| Some(line.strip_suffix(": test")?.to_owned())).collect()
}

/// Builds all tests; gives the jobs that have any.
pub(crate) fn build() -> Result<Vec<Job>> {
    let arguments = ["test", "--workspace", "--no-run", "--message-format=json-render-diagnostics"];
    let mut child = cargo(arguments).stdout(Stdio::piped()).spawn().context("starting cargo")?;
    let mut programs = Vec::new();
    for line in BufReader::new(child.stdout.take().context("no output to read")?).lines() {
        programs.extend(Program::read(&line?));
    }
    ensure!(child.wait()?.success(), "the tests do not compile");
    ensure!(!programs.is_empty(), "cargo built no test programs");
    let mut jobs = Vec::new();
    for program in programs {
        jobs.extend(program.jobs(program.tests()?));
    }
    jobs.retain(|job| job.count > 0);
    Ok(jobs)
}

/// The examples in the docs, which cargo compiles and runs itself.
pub(crate) fn examples_of_docs() -> Result<Tally> {
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
    fn only_programs_with_tests_are_run() {
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
    }

    #[test]
    fn each_module_is_a_job_and_each_other_program() {
        let program = |source: &str| Program {
            package: root().join("crates/b"),
            source: source.into(),
            executable: "/a/target/c".into(),
        };
        let tests = names("fog::is_seen: test\nlive_fog::moves: test\nfog::inner::is_kept: test\nslow: benchmark\n");
        let jobs = |source: &str| program(source).jobs(tests.clone()).into_iter().map(|job| (job.name, job.only));
        let name = |module: &str| format!("crates/b {module}");
        let only = |tests: &[&str]| tests.iter().map(|test| (*test).to_owned()).collect::<Vec<_>>();
        let fog = (name("fog"), only(&["fog::is_seen", "fog::inner::is_kept"]));
        assert_eq!(Vec::from_iter(jobs("tests/all.rs")), [fog, (name("live_fog"), only(&["live_fog::moves"]))]);
        assert_eq!(Vec::from_iter(jobs("tests/memory.rs")), [(name("memory"), only(&[]))]);
        assert_eq!(Vec::from_iter(jobs("src/lib.rs")), [(name("src/lib.rs"), only(&[]))]);
        assert_eq!(program("src/lib.rs").jobs(tests.clone())[0].count, 3);
    }
}
