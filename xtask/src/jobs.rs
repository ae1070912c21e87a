//! Runs jobs of tests: two at a time, the longest first, and those that measure alone at the end.

use crate::programs::{Program, build, examples_of_docs};
use anyhow::{Context, Result, anyhow};
use std::{
    collections::{BTreeMap, VecDeque},
    io::Write,
    path::Path,
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
    time::Instant,
};
use xtask::step::{Tally, root};

/// Most of what tests do has one thread.
const WORKERS: usize = 2;
/// How many of the slowest jobs are named at the end.
const SLOWEST: usize = 10;
/// Seconds a test, of a job of which nothing is known.
const SECS_PER_TEST: f64 = 0.5;
/// Where the times of the last run are kept, in the repository.
const TIMES: &str = "target/test-times.json";

/// Jobs that bound the time or the processors' time of what they start, or wait for a time that it takes. Beside others
/// they could fail on a busy machine.
const ALONE: [(&str, &str); 5] = [
    ("crates/cli broken", "each file ends within 10 s, and 5 s of processors"),
    ("crates/cli cpu", "ratios of processors' time"),
    ("crates/cli hostile", "each input ends within 20 s, and 5 s of processors"),
    ("crates/cli outputs", "interrupts are noticed within 1.3 s"),
    ("crates/cli signals", "signals are sent at given times, and end a run within 2 s"),
];

/// Jobs of more than 20 s on two cores, with those seconds, and why `--quick` leaves them out; empty where it does not.
const LONG: [(&str, u32, &str); 36] = [
    ("crates/cli docs", 93, "runs each command of the pages"),
    ("crates/cli baking", 58, "bakes by the program; crates/bake judges the light"),
    ("crates/cli outputs", 55, "interrupts programs, and waits for them"),
    ("crates/cli broken", 54, "goes through all broken files"),
    ("crates/cli environment", 53, "many pictures; the renderer's tests judge environments"),
    ("crates/render surroundings", 45, "captures of many places"),
    ("crates/render frames_commit", 44, "fails each kind of frame at each step"),
    ("crates/render environment_lobes", 43, "integrals over all texels"),
    ("crates/render live", 39, "each edit against a scene that is loaded anew"),
    ("crates/render environments", 34, "integrals over all texels"),
    ("crates/render goldens", 34, ""),
    ("crates/cli pictures", 32, "many pictures; the renderer's tests judge them"),
    ("crates/cli batches", 31, "kills batches, and runs them again"),
    ("crates/cli exposure", 30, "many pictures; the renderer's tests judge exposure"),
    ("crates/render surface_detail", 29, "relief against the mesh that it stands for"),
    ("crates/render reflections", 26, ""),
    ("crates/render adaptive", 25, "stills of many samples"),
    ("crates/render live_probes", 25, "frames of many probes"),
    ("crates/cli camera", 24, "many pictures; the renderer's tests judge them"),
    ("crates/cli settings", 24, ""),
    ("crates/render layers", 24, ""),
    ("crates/cli hostile", 23, "goes through all hostile inputs"),
    ("crates/cli quality", 21, ""),
    ("crates/render mirrors", 20, ""),
    ("crates/render models", 20, "draws every sample model in three ways"),
    ("crates/render exposure_environment", 20, ""),
    ("crates/render glass_backgrounds", 19, "closed forms for each background"),
    ("crates/cli far", 18, ""),
    ("crates/cli aovs", 17, ""),
    ("crates/render tangents", 17, "each map against a mesh with other coordinates"),
    ("crates/render transparency", 17, ""),
    ("crates/render every_file", 17, "draws every model that is shared"),
    ("crates/render shaders", 15, ""),
    ("crates/render exposure", 15, ""),
    ("crates/render occlusion", 15, ""),
    ("crates/cli memory", 15, "fills memory"),
];

/// Which tests are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extent {
    /// All.
    Whole,
    /// All but those that [`LONG`] gives a reason for.
    Quick,
}

/// A process that runs tests.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// The package's folder, and the module or the program: `crates/render fog`.
    pub(crate) name: String,
    pub(crate) program: Program,
    /// How many tests it has.
    pub(crate) count: usize,
    /// The tests of the program that it runs; all if there are none.
    pub(crate) only: Vec<String>,
}

impl Job {
    /// Runs it to its end, and says what it printed and whether it ended well.
    fn run(&self) -> Result<(String, bool)> {
        let (mut reader, writer) = std::io::pipe()?;
        let Program { package, executable, .. } = &self.program;
        let mut command = Command::new(executable);
        if !self.only.is_empty() {
            command.arg("--exact").args(&self.only);
        }
        command.current_dir(package).env("CARGO_MANIFEST_DIR", package);
        command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
        let mut child = command.spawn().with_context(|| format!("starting {}", executable.display()))?;
        // The command holds the pipe's other end, which would never close.
        drop(command);
        let mut printed = Vec::new();
        std::io::Read::read_to_end(&mut reader, &mut printed)?;
        Ok((String::from_utf8_lossy(&printed).into_owned(), child.wait()?.success()))
    }

    /// About how many seconds it takes.
    fn expected_secs(&self, times: &Times) -> f64 {
        let known = times.get(&self.name).copied();
        let listed = || LONG.iter().find(|(name, ..)| *name == self.name).map(|(_, secs, _)| f64::from(*secs));
        known.or_else(listed).unwrap_or(SECS_PER_TEST * self.count as f64)
    }

    /// Why `--quick` leaves it out, if it does.
    fn reason_to_leave_out(&self) -> Option<&'static str> {
        let (.., reason) = LONG.iter().find(|(name, ..)| *name == self.name)?;
        (!reason.is_empty()).then_some(*reason)
    }

    fn is_alone(&self) -> bool {
        ALONE.iter().any(|(name, _)| *name == self.name)
    }
}

/// Seconds by the name of a job.
type Times = BTreeMap<String, f64>;

/// What became of the jobs so far.
#[derive(Debug, Default)]
struct Outcome {
    tally: Tally,
    times: Times,
}

/// Builds tests and runs them; says what passed, failed and was skipped.
pub(crate) fn test(extent: Extent) -> Result<Tally> {
    let jobs = build()?;
    let (left_out, jobs): (Vec<_>, Vec<_>) =
        jobs.into_iter().partition(|job| extent == Extent::Quick && job.reason_to_leave_out().is_some());
    let times = read_times(&root().join(TIMES));
    let (alone, mut pairs): (Vec<_>, Vec<_>) = jobs.into_iter().partition(Job::is_alone);
    sort_longest_first(&mut pairs, &times);
    let outcome = Mutex::new(Outcome::default());
    run_all(pairs, WORKERS, &outcome)?;
    run_all(alone, 1, &outcome)?;
    let Outcome { mut tally, times: new } = outcome.into_inner().unwrap_or_else(PoisonError::into_inner);
    tally.add(examples_of_docs()?);
    for job in &left_out {
        println!("SKIPPED {} ({} tests): {}", job.name, job.count, job.reason_to_leave_out().unwrap_or_default());
        tally.skipped += job.count as i64;
    }
    println!("\nThe slowest:");
    for (name, secs) in slowest(&new) {
        println!("{secs:>7.1} s  {name}");
    }
    write_times(&root().join(TIMES), times, new)?;
    Ok(tally)
}

fn sort_longest_first(jobs: &mut [Job], times: &Times) {
    jobs.sort_by(|a, b| b.expected_secs(times).total_cmp(&a.expected_secs(times)));
}

fn slowest(times: &Times) -> Vec<(&str, f64)> {
    let mut sorted: Vec<(&str, f64)> = times.iter().map(|(name, secs)| (name.as_str(), *secs)).collect();
    sorted.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    sorted.truncate(SLOWEST);
    sorted
}

/// The times of earlier runs; none where the file is not there or is something else.
fn read_times(file: &Path) -> Times {
    let text = std::fs::read(file).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    let times = value.as_object().into_iter().flatten();
    times.filter_map(|(name, secs)| Some((name.clone(), secs.as_f64()?))).collect()
}

/// Keeps the times; those of jobs that did not run stay.
fn write_times(file: &Path, mut times: Times, new: Times) -> Result<()> {
    times.extend(new);
    let text = serde_json::to_string_pretty(&times)?;
    std::fs::write(file, text).with_context(|| format!("writing {}", file.display()))
}

fn run_all(jobs: Vec<Job>, workers: usize, outcome: &Mutex<Outcome>) -> Result<()> {
    let queue = Mutex::new(VecDeque::from(jobs));
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
    let work = || -> Result<()> {
        while let Some(job) = next() {
            let start = Instant::now();
            // Where one hangs, this line says which.
            println!("     Started {}", job.name);
            let (printed, is_well) = job.run()?;
            let secs = start.elapsed().as_secs_f64();
            let mut tally = Tally::default();
            printed.lines().for_each(|line| tally.read(line));
            // A program that ends in the middle, with whatever code, says nothing of the rest.
            let told = tally.passed + tally.failed + tally.skipped;
            let is_well = is_well && told == job.count as i64;
            if !is_well && tally.failed == 0 {
                tally.failed = 1;
            }
            // What one printed stays together.
            let mut outcome = outcome.lock().unwrap_or_else(PoisonError::into_inner);
            let verdict = if is_well { "" } else { "error: a test failed, or did not run\n" };
            write!(std::io::stdout().lock(), "     Running {} ({secs:.1} s)\n{printed}{verdict}", job.name)?;
            outcome.tally.add(tally);
            outcome.times.insert(job.name, secs);
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads.into_iter().try_for_each(|thread| thread.join().map_err(|_| anyhow!("a worker panicked"))?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn job(name: &str, executable: &str, only: &[&str]) -> Job {
        let program = Program { package: "/".into(), source: "tests/c.rs".into(), executable: executable.into() };
        Job { name: name.into(), program, count: 4, only: only.iter().map(|test| (*test).to_owned()).collect() }
    }

    #[test]
    fn failures_count_and_times_are_kept() {
        let jobs = vec![job("a", "/bin/true", &[]), job("b", "/bin/false", &[]), job("c", "/bin/true", &["d"])];
        let outcome = Mutex::new(Outcome::default());
        run_all(jobs, WORKERS, &outcome).expect("they start");
        let Outcome { tally, times } = outcome.into_inner().expect("no panic");
        // Those that end well say nothing of their four tests.
        assert_eq!(tally, Tally { failed: 3, ..Tally::default() });
        assert_eq!(Vec::from_iter(times.keys()), ["a", "b", "c"]);
        assert!(run_all(vec![job("a", "/no/such/program", &[])], 1, &Mutex::default()).is_err());
    }

    #[test]
    fn a_job_runs_its_tests_and_no_others() {
        let only = ["jobs::tests::only_what_is_named_is_run", "jobs::tests::no_such_test"];
        let this = std::env::current_exe().expect("this program");
        let (printed, is_well) = job("a", this.to_str().expect("UTF-8"), &only).run().expect("it starts");
        assert!(is_well && printed.contains("1 passed; 0 failed"), "{printed}");
    }

    #[test]
    fn only_what_is_named_is_run() {}

    #[test]
    fn the_longest_are_first_by_the_last_run_then_by_the_table_then_by_their_tests() {
        let mut jobs = ["crates/x short", "crates/cli docs", "crates/x other"].map(|name| job(name, "/bin/true", &[]));
        let times = Times::from([("crates/x short".to_owned(), 200.0)]);
        sort_longest_first(&mut jobs, &times);
        assert_eq!(jobs.map(|job| job.name), ["crates/x short", "crates/cli docs", "crates/x other"]);
        assert_eq!(job("crates/x other", "", &[]).expected_secs(&times), 4.0 * SECS_PER_TEST);
    }

    #[test]
    fn the_tables_name_jobs_that_are_there() {
        let names: Vec<&str> = ALONE.iter().map(|(name, _)| *name).chain(LONG.iter().map(|(name, ..)| *name)).collect();
        for name in names {
            let (package, test) = name.split_once(' ').expect("a package and a test");
            let file = root().join(package).join("tests").join(test).with_extension("rs");
            assert!(file.is_file(), "{name}: there is no {}", file.display());
        }
        let each: BTreeSet<&str> = LONG.iter().map(|(name, ..)| *name).collect();
        assert_eq!(each.len(), LONG.len(), "a job is listed twice");
    }

    #[test]
    fn quick_leaves_out_more_than_a_third_of_the_time_and_keeps_the_goldens() {
        let left_out: u32 = LONG.iter().filter(|(.., reason)| !reason.is_empty()).map(|(_, secs, _)| secs).sum();
        assert!(left_out > 700, "{left_out} s");
        assert_eq!(job("crates/render goldens", "", &[]).reason_to_leave_out(), None);
        assert!(job("crates/cli docs", "", &[]).reason_to_leave_out().is_some());
        assert_eq!(job("crates/render fog", "", &[]).reason_to_leave_out(), None);
    }

    #[test]
    fn times_of_jobs_that_did_not_run_stay() {
        let file = std::env::temp_dir().join(format!("manypass-times-{}.json", std::process::id()));
        assert!(read_times(&file).is_empty());
        let times = |pairs: &[(&str, f64)]| pairs.iter().map(|(name, secs)| ((*name).to_owned(), *secs)).collect();
        write_times(&file, times(&[("a", 1.5), ("b", 2.0)]), times(&[("b", 3.0)])).expect("written");
        assert_eq!(read_times(&file), times(&[("a", 1.5), ("b", 3.0)]));
        assert_eq!(slowest(&read_times(&file)), [("b", 3.0), ("a", 1.5)]);
        std::fs::write(&file, "[]").expect("written");
        assert!(read_times(&file).is_empty());
        std::fs::remove_file(file).expect("removed");
    }
}
