//! The program `manypass`: args (raw) → job (validated) → run.

mod args;
mod camera;
mod failure;
mod input;
mod job;
mod run;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
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
