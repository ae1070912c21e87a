//! Runs the program under watch: how long it takes, how much memory, and that nothing but errors ends it.

use super::Run;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A run, and what it took.
#[derive(Debug)]
pub struct Watched {
    /// What it gave; standard output is not kept.
    pub run: Run,
    /// The most memory that it held; 0 where the system does not tell.
    pub peak_mib: u64,
    /// Its wall time.
    pub time: Duration,
}

/// The most memory that the process held so far, in MiB; none where the system does not tell.
pub fn peak_mib(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? >> 10)
}

/// Starts the program in `folder`, its standard error piped.
pub fn start(folder: &Path, args: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(args).current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// Runs the program in `folder`; fails the test where it takes longer than `limit`.
#[track_caller]
pub fn watch(folder: &Path, args: &[&str], limit: Duration) -> Watched {
    wait(start(folder, args), limit)
}

/// Waits for a program that was started; fails the test where that takes longer than `limit`.
#[track_caller]
pub fn wait(mut child: Child, limit: Duration) -> Watched {
    let mut pipe = child.stderr.take().expect("piped");
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    });
    let start = Instant::now();
    let mut peak = 0;
    let status = loop {
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
    Watched { run: Run { code, stdout: Vec::new(), stderr }, peak_mib: peak, time }
}
