//! The program `manypass`: args (raw) → job (validated) → run.

mod args;
mod camera;
mod failure;
mod input;
mod job;
mod run;

use clap::Parser;
use std::process::ExitCode;

/// Mesa's device-selection layer writes to standard error on machines without a desktop session; there it has nothing
/// to select by.
#[allow(unsafe_code, reason = "the environment can only be changed by an unsafe call")]
fn quiet_device_selection() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this is the first thing that `main` does, so no other thread reads the environment meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

fn main() -> ExitCode {
    quiet_device_selection();
    let cli = match args::Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if !error.use_stderr() => error.exit(),
        Err(error) => {
            let text = error.to_string();
            let line = text.lines().next().unwrap_or_default();
            let failure = failure::Failure::usage(line.trim_start_matches("error: "), "see `manypass --help`");
            failure.print();
            return ExitCode::from(failure.code());
        }
    };
    match run::run(&cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}
