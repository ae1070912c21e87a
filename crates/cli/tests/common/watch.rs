//! Runs the program under watch: how long it takes, how much memory, and that nothing but errors ends it.

use super::Run;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A run, and what it took.
#[derive(Debug)]
pub struct WatchedRun {
    /// What it gave; standard output is not kept.
    pub run: Run,
    /// The most memory that it held; 0 where the system does not tell.
    pub peak_mib: u64,
    /// Its wall time.
    pub time: Duration,
    /// The time that processors spent on it, whatever else the machine does; 0 where the system does not tell.
    pub cpu: Duration,
}

/// The most memory that the process held so far, in MiB; none where the system does not tell.
pub fn peak_mib(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? >> 10)
}

/// The time that processors spent on the process so far, to a hundredth of a second; none where the system does not
/// tell.
fn cpu(process: u32) -> Option<Duration> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may hold anything. Of the 52 fields the 14th and 15th are those of the process and of
    // the system for it; its first two go with the name.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks = fields.split_whitespace().skip(11).take(2).map(|field| field.parse::<u64>().ok());
    // A tick is a hundredth of a second for all programs.
    Some(Duration::from_millis(10 * ticks.sum::<Option<u64>>()?))
}

/// Starts the program in `folder`, its standard error piped.
pub fn start(folder: &Path, args: &[&str]) -> Child {
    start_with(folder, args, &[])
}

/// The same with some variables of the environment.
pub fn start_with(folder: &Path, args: &[&str], variables: &[(&str, &str)]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(args).current_dir(folder).envs(variables.iter().copied());
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// Runs the program in `folder`; fails the test where it takes longer than `limit`.
#[track_caller]
pub fn watch(folder: &Path, args: &[&str], limit: Duration) -> WatchedRun {
    wait(start(folder, args), limit)
}

/// Waits for a program that was started; fails the test where that takes longer than `limit`.
#[track_caller]
pub fn wait(mut child: Child, limit: Duration) -> WatchedRun {
    let mut pipe = child.stderr.take().expect("piped");
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    });
    let start = Instant::now();
    let (mut peak, mut spent) = (0, Duration::ZERO);
    let status = loop {
        spent = cpu(child.id()).unwrap_or_default().max(spent);
        peak = peak_mib(child.id()).unwrap_or(0).max(peak);
        if let Some(status) = child.try_wait().expect("waited for") {
            break status;
        }
        if start.elapsed() > limit {
            let _ = child.kill();
            let _ = child.wait();
            panic!("it takes longer than {limit:?}: {}", reader.join().expect("read"));
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let time = start.elapsed();
    let stderr = reader.join().expect("read");
    assert!(!stderr.contains("panicked") && !stderr.contains("overflowed its stack"), "{stderr}");
    let code = status.code().unwrap_or_else(|| panic!("it ended with {status}: {stderr}"));
    WatchedRun { run: Run { code, stdout: Vec::new(), stderr }, peak_mib: peak, time, cpu: spent }
}
