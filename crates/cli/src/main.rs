//! The program `manypass`: args (raw) → job (validated) → run.

mod args;
mod bench;
mod camera;
mod failure;
mod input;
mod inspect;
mod job;
mod memory;
mod output;
mod pattern;
mod render;
mod report;
mod request;
mod run;
mod session;
mod shot;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use std::process::ExitCode;
use std::time::Instant;

/// Mesa's device-selection layer writes to standard error on machines without a desktop session; there it has nothing
/// to select by.
#[allow(unsafe_code, reason = "the environment can only be changed by an unsafe call")]
fn quiet_device_selection() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this is done before anything that starts a thread, so no other thread reads the environment meanwhile.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// What clap found wrong, as one line, and its tip.
fn usage_failure(error: &clap::Error) -> failure::Failure {
    let text = error.to_string();
    let relevant = text.split("\nUsage:").next().unwrap_or_default();
    let relevant = relevant.split("\nFor more information").next().unwrap_or_default();
    let (tips, lines): (Vec<&str>, Vec<&str>) =
        relevant.lines().map(str::trim).filter(|line| !line.is_empty()).partition(|line| line.starts_with("tip: "));
    let command = std::env::args().nth(1).filter(|name| args::Cli::command().find_subcommand(name).is_some());
    let help = command.map_or("see `manypass --help`".into(), |name| format!("see `manypass {name} --help`"));
    let tips: Vec<&str> = tips.iter().map(|tip| tip.trim_start_matches("tip: ")).collect();
    let hint = if tips.is_empty() { help } else { format!("{}; {help}", tips.join("; ")) };
    failure::Failure::usage(lines.join(" ").trim_start_matches("error: "), hint)
}

fn main() -> ExitCode {
    let started = Instant::now();
    quiet_device_selection();
    let result = match args::Cli::try_parse() {
        Ok(cli) => run::run(&cli.command, started),
        Err(error) if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand || !error.use_stderr() => {
            error.exit()
        }
        Err(error) => Err(usage_failure(&error)),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}
