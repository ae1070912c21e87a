//! Does what the command line asks for.

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::{bench, diff, graph, inspect, render, session, settings};
use clap::CommandFactory;
use std::time::Instant;

/// Runs `command`; `started` is when the process started.
///
/// # Errors
/// The first failure; a batch finishes the rest before.
pub fn run(command: &Command, started: Instant) -> Result<(), Failure> {
    match command {
        Command::Render(args) => render::render(args, started),
        Command::Info { input, scene, json } => inspect::info(input, scene.as_deref(), *json),
        Command::Graph(args) => graph::graph(args),
        Command::Diff(args) => diff::diff(args),
        #[cfg(feature = "bake")]
        Command::Bake(args) => crate::bake::bake(args, started),
        Command::Bench(args) => bench::bench(args, started),
        Command::Adapters { json } => inspect::adapters(*json),
        Command::Settings { stage_schema: true, .. } => settings::stage_schema(),
        Command::Settings { quality, set, effects, .. } if quality.is_some() || !set.is_empty() => {
            settings::chosen(quality.as_deref().and_then(manypass::Quality::named), set, effects)
        }
        Command::Settings { effects, json, schema, .. } => settings::settings(effects, *json, *schema),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "manypass", &mut script);
            session::print(&String::from_utf8_lossy(&script))
        }
    }
}
