//! Brings the simulations of a scene to the time of a picture, and says how far that is.

use super::batch::{Batch, counting_bar, failed};
use crate::failure::{Failure, shown};
use crate::interrupt;
use manypass::{SimulationProgress, SimulationReport};
use manypass_scene::Scene;
use std::io::IsTerminal;
use std::sync::atomic::Ordering;

/// So few steps are over before a bar is read.
const FEW_STEPS: u64 = 240;

impl Batch<'_> {
    /// Brings the simulations of a scene to its time. Gives what became of them.
    ///
    /// # Errors
    /// One cannot be shown, or the user said stop.
    pub(super) fn simulate(&mut self, scene: &Scene) -> Result<Vec<SimulationReport>, Failure> {
        if !scene.has_simulations() {
            return Ok(Vec::new());
        }
        let is_shown = !self.args.quiet && std::io::stderr().is_terminal();
        let mut bar = None;
        let mut progress = |SimulationProgress { name, done, total }: SimulationProgress<'_>| {
            if is_shown && total > FEW_STEPS {
                let bar = bar.get_or_insert_with(|| counting_bar(total));
                bar.set_message(shown(&format!("steps of {name}")).into_owned());
                bar.set_length(total);
                bar.set_position(done);
            }
            !interrupt::STOP.load(Ordering::SeqCst)
        };
        let result = self.renderer.simulate(scene, &mut progress);
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        interrupt::check()?;
        result.map_err(failed)?;
        self.renderer.simulation_reports().map_err(failed)
    }
}

/// What is said of a simulation that exploded.
pub(super) fn warning(report: &SimulationReport) -> Option<String> {
    let SimulationReport { name, steps, held_numbers, .. } = report;
    (*held_numbers > 0).then(|| {
        format!(
            "the simulation `{name}` exploded: {held_numbers} of its numbers are held at 1000000 after {steps} steps; give it more \
             steps a second (rate_hz), or gentler parameters"
        )
    })
}
