//! Threads and their stacks: what the system allows, and an error where that is too little. A driver that gets some of
//! its threads and not all waits for the others for ever; one whose threads have hardly a stack ends the process.

use crate::failure::{Failure, Kind};
use std::process::ExitCode;
use std::thread::Builder;
use std::time::Instant;

/// What the compilers of shaders and readers of nested files may take: what Linux gives the first thread by default.
const STACK_BYTES: u64 = 8 << 20;
/// The least stack of a driver's thread. A shader's variables are 16 KiB at most, eight pixels at a time; Mesa 22.3.6
/// drew the hall with this.
const DRIVER_STACK_BYTES: u64 = 256 << 10;
/// The driver starts a thread a core, and no more than these.
const DRIVER_THREADS_MAX: usize = 16;
/// Threads beside those that divide work: for signals, for reading ahead, for compiling, and some to spare.
const THREADS: usize = 8;

/// The limit for the stack of the first thread (`ulimit -s`), which the driver's threads take as theirs; none where
/// there is none, or the system does not tell.
fn stack_limit_bytes() -> Option<u64> {
    stack_limit_in(&std::fs::read_to_string("/proc/self/limits").ok()?)
}

fn stack_limit_in(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max stack size"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Runs the program where it has a stack: on a thread of its own if that of the first thread is small.
#[inline(never)]
pub fn on_stack(started: Instant, program: fn(Instant) -> ExitCode) -> ExitCode {
    if stack_limit_bytes().is_none_or(|bytes| bytes >= STACK_BYTES) {
        return program(started);
    }
    let thread = Builder::new().name("main".into()).stack_size(STACK_BYTES as usize);
    match thread.spawn(move || program(started)) {
        // One that panicked has said so.
        Ok(thread) => thread.join().unwrap_or(ExitCode::from(101)),
        Err(_) => {
            let failure = too_few(1);
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}

/// Fails where a driver, or what divides its work among threads, would hang or end the process.
///
/// # Errors
/// The stack of threads, or their number, is limited to too little.
pub fn check() -> Result<(), Failure> {
    stack_fits(stack_limit_bytes())?;
    check_count()
}

fn stack_fits(limit_bytes: Option<u64>) -> Result<(), Failure> {
    let Some(bytes) = limit_bytes.filter(|bytes| *bytes < DRIVER_STACK_BYTES) else { return Ok(()) };
    let (kib, least_kib) = (bytes >> 10, DRIVER_STACK_BYTES >> 10);
    let message = format!("no graphics driver works with a stack of {kib} KiB: its threads take {least_kib} KiB");
    Err(Failure::new(Kind::NoAdapter, message, format!("raise the limit (`ulimit -s`) to {least_kib} KiB or more")))
}

/// Fails where the system allows fewer threads than a picture takes.
fn check_count() -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let count = 2 * cores.min(DRIVER_THREADS_MAX) + THREADS;
    // Each waits until all were tried.
    let started: Vec<_> =
        (0..count).map_while(|_| Builder::new().stack_size(64 << 10).spawn(std::thread::park).ok()).collect();
    let is_enough = started.len() == count;
    for thread in started {
        thread.thread().unpark();
        let _ = thread.join();
    }
    if is_enough { Ok(()) } else { Err(too_few(count)) }
}

fn too_few(count: usize) -> Failure {
    let noun = if count == 1 { "thread" } else { "threads" };
    Failure::new(
        Kind::NoAdapter,
        format!("the system refuses {count} {noun} more, which drawing may take on this machine"),
        "raise the limit of threads (`ulimit -u`, or the container's limit of processes), or end other programs",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_of_the_stack_is_read_and_one_too_low_is_named() {
        let limits = |size: &str| {
            format!("Limit       Soft Limit    Hard Limit    Units\nMax stack size     {size}     unlimited    bytes\n")
        };
        assert_eq!(stack_limit_in(&limits("65536")), Some(65_536));
        assert_eq!(stack_limit_in(&limits("unlimited")), None);
        assert_eq!(stack_limit_in(""), None);
        assert!(stack_fits(None).is_ok() && stack_fits(Some(DRIVER_STACK_BYTES)).is_ok());
        let failure = stack_fits(Some(65_536)).expect_err("too small");
        assert!(failure.message.contains("64 KiB") && failure.hint.contains("ulimit -s"), "{failure:?}");
    }

    #[test]
    fn this_machine_has_threads() {
        assert!(check_count().is_ok());
    }
}
