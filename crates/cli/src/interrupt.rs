//! Signals: the user says stop, and limits that must become errors.

use crate::failure::{Failure, Kind, say};
use manypass_offline::atomic;
use manypass_offline::still::StillError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// Raised once the user has said stop.
pub static STOP: AtomicBool = AtomicBool::new(false);

/// Fails once the user has said stop.
///
/// # Errors
/// [`Kind::Interrupted`].
pub fn check() -> Result<(), Failure> {
    if STOP.load(Ordering::SeqCst) { Err(failure()) } else { Ok(()) }
}

/// How long what is being read or drawn may take to end by itself once the user has said stop.
const GRACE: Duration = Duration::from_millis(1400);

/// How much longer it may take where it has noticed: reports are still written then.
const GRACE_TO_REPORT: Duration = Duration::from_millis(400);

/// How long the last words may wait for whoever reads them.
const TIME_TO_SAY: Duration = Duration::from_millis(100);

/// All of them together, and what the system needs to end a process.
const _: () = assert!(GRACE.as_millis() + GRACE_TO_REPORT.as_millis() + TIME_TO_SAY.as_millis() < 2000);

/// Raised once the program has noticed that the user has said stop, and ends by itself.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// What the user's stop means; from now on the program ends by itself.
pub fn failure() -> Failure {
    IS_ENDING.store(true, Ordering::SeqCst);
    Failure::new(Kind::Interrupted, StillError::Stopped, "run it again with --skip-existing")
}

/// Whether somebody says already how the program ends.
static IS_SAID: AtomicBool = AtomicBool::new(false);

/// Whether the caller is the one who says how an interrupted program ends: the first who asks.
pub fn says_the_end() -> bool {
    !IS_SAID.swap(true, Ordering::SeqCst)
}

/// From now on SIGINT, SIGTERM and SIGHUP raise [`STOP`]. A second one, or one that comes while a pipe holds the
/// program up, ends it at once. What is being read or drawn may end by itself, which can take long, as in the compiler
/// of a driver: after [`GRACE`] the program ends all the same, within two seconds of the signal. Unless `quiet`, that
/// is said.
pub fn heed(quiet: bool) {
    // Without a handler an interrupt ends the program as the system does it; one whose thread cannot start would take
    // the signals all the same.
    if std::thread::Builder::new().spawn(|| {}).map(std::thread::JoinHandle::join).is_err() {
        return;
    }
    let _ = ctrlc::set_handler(move || {
        // This thread waits for a second signal, and for whoever reads what it says: another one counts the time.
        let is_second = STOP.load(Ordering::SeqCst);
        if is_second || atomic::is_waiting() || std::thread::Builder::new().spawn(stop_after_grace).is_err() {
            STOP.store(true, Ordering::SeqCst);
            stop_now();
        }
        if !quiet {
            say(format_args!("interrupting after this step, within 2 s; once more stops at once"));
        }
        STOP.store(true, Ordering::SeqCst);
    });
}

fn stop_after_grace() {
    std::thread::sleep(GRACE);
    if IS_ENDING.load(Ordering::SeqCst) {
        std::thread::sleep(GRACE_TO_REPORT);
    }
    stop_now();
}

/// Ends the program, and leaves no file half written.
fn stop_now() -> ! {
    let failure = failure();
    let code = i32::from(failure.code());
    if says_the_end() {
        // Standard error may be a pipe that is full.
        let (said, hears) = mpsc::channel();
        let say = std::thread::Builder::new().spawn(move || {
            failure.print();
            let _ = said.send(());
        });
        if say.is_ok() {
            let _ = hears.recv_timeout(TIME_TO_SAY);
        }
    }
    // Last, as other threads go on until then.
    atomic::remove_unfinished();
    end(code)
}

/// Ends the process, whatever its other threads do. Destructors do not run: those of a graphics driver would free what
/// its threads still use.
#[cfg(unix)]
#[allow(unsafe_code, reason = "the end without destructors is a function of the system")]
fn end(code: i32) -> ! {
    // SAFETY: it takes a number and does not return; what it leaves out, other code cannot see any more.
    unsafe { libc::_exit(code) }
}

/// Ends the process.
#[cfg(not(unix))]
fn end(code: i32) -> ! {
    std::process::exit(code)
}

/// Lets writing beyond the limit for a file's size (`ulimit -f`) fail, where it would end the program.
#[cfg(unix)]
#[allow(unsafe_code, reason = "the disposition of a signal can only be changed by an unsafe call")]
pub fn ignore_file_size_signal() {
    // SAFETY: to ignore a signal installs no handler, so no code runs at an unsafe time; nothing else in this program
    // sets this signal.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}

/// There is no such signal.
#[cfg(not(unix))]
pub fn ignore_file_size_signal() {}
