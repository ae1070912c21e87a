//! The program `manypass`: args (raw) → job (validated) → run.

// A report has more keys than `json!` takes by default.
#![recursion_limit = "256"]

mod ahead;
mod args;
#[cfg(feature = "bake")]
mod bake;
mod bench;
mod camera;
mod chosen;
mod coverage;
mod deliver;
mod diff;
#[cfg(target_os = "linux")]
mod driver_cache;
mod exposure;
mod failure;
mod gather;
mod graph;
mod identity;
mod input;
mod inspect;
mod interrupt;
mod job;
mod listing;
mod looks;
mod memory;
mod model_files;
mod older;
mod one_tone;
mod output;
mod pattern;
mod places;
mod preset;
mod provenance;
mod render;
mod report;
mod request;
mod run;
mod scenes;
mod session;
mod settings;
mod shot;
mod size;
#[cfg(test)]
mod snippets;
mod stage;
mod stream;
mod surroundings;
mod table;
mod tally;
mod threads;
mod views;
mod words;

use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;
use std::time::Instant;

/// Mesa's device-selection layer writes to standard error on machines without a desktop session; there it has nothing
/// to select by.
#[allow(unsafe_code, reason = "the environment can only be changed by an unsafe call")]
fn quiet_device_selection() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this is done before anything that starts a thread, so no other thread reads the environment
        // meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// The C library gives every large piece of memory back at once, and the system clears each page of the next one: of
/// images, their mips and what is uploaded of them that is more work than to fill them. Pieces of up to 32 MiB, the most
/// that the library allows, are kept instead, in one place for all threads, so that what one has freed is the next one's;
/// half a GiB at the most stays when nobody has it.
#[allow(unsafe_code, reason = "the parameters of the C library can only be set by an unsafe call")]
fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: this is done before anything that starts a thread, and sets numbers of the allocator alone.
        unsafe {
            libc::mallopt(libc::M_ARENA_MAX, 1);
            libc::mallopt(libc::M_MMAP_THRESHOLD, 32 << 20);
            libc::mallopt(libc::M_TRIM_THRESHOLD, 512 << 20);
        }
    }
}

fn main() -> ExitCode {
    let started = Instant::now();
    quiet_device_selection();
    #[cfg(target_os = "linux")]
    driver_cache::spare_full_disk();
    keep_freed_memory();
    interrupt::ignore_file_size_signal();
    threads::on_stack(started, program)
}

/// The program itself; `started` is when the process started. Its frame is larger than the least stack.
#[inline(never)]
fn program(started: Instant) -> ExitCode {
    let result = match args::Cli::try_parse_from(words::joined(std::env::args_os())) {
        Ok(cli) => run::run(&cli.command, started),
        Err(error) if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand || !error.use_stderr() => {
            error.exit()
        }
        Err(error) => Err(words::usage_failure(&error)),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if failure.kind != failure::Kind::Interrupted || interrupt::says_the_end() {
                failure.print();
            }
            ExitCode::from(failure.code())
        }
    }
}
