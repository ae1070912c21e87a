//! Simulations of a scene: made ready, brought to the scene's time, and given to materials and water.

use super::Renderer;
use crate::gpu::Gpu;
use crate::passes::particles::ParticlesDraw;
use crate::request::RenderError;
use crate::simulation::{RunningSimulation, SimulationInputs, SimulationProgress, SimulationReport};
use manypass_scene::Scene;
use manypass_scene::particles::{Particles, SYSTEMS_MAX};
use manypass_scene::simulation::{Place, SIMULATIONS_MAX, SimulatedImage, Simulation};
use manypass_scene::turns::{Turns, at_once};
use std::collections::BTreeMap;

/// What the renderer keeps of simulations, in the order of the scene.
#[derive(Debug, Default)]
pub(super) struct SimulationState {
    running: Vec<RunningSimulation>,
    /// How many of them are the scene's own; the others move its particles.
    own: usize,
}

impl SimulationState {
    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.running.clear();
    }

    /// Bytes of all states and pictures.
    pub fn bytes(&self) -> u64 {
        self.running.iter().map(RunningSimulation::bytes).sum()
    }

    /// Makes what the scene has and is not there yet, and drops what it no longer has. True if pictures are others now.
    fn follow(&mut self, gpu: &Gpu, scene: &Scene) -> Result<bool, RenderError> {
        let known = std::mem::take(&mut self.running);
        let mut known = known.into_iter().map(Some).collect::<Vec<_>>();
        let mut is_new = known.len() != all(scene).count();
        self.own = scene.simulations.len().min(SIMULATIONS_MAX);
        for (index, (simulation, _)) in all(scene).enumerate() {
            let size_m = scene.place_of_simulation(index).size_m;
            let same = known.get_mut(index).and_then(|slot| slot.take_if(|running| running.is(simulation, size_m)));
            is_new |= same.is_none();
            self.running.push(match same {
                Some(running) => running,
                None => RunningSimulation::new(gpu, simulation, size_m, self.bytes())?,
            });
        }
        Ok(is_new)
    }

    fn pictures(&self) -> BTreeMap<SimulatedImage, wgpu::TextureView> {
        let of = |(simulation, running): (usize, &RunningSimulation)| {
            let pictures = running.pictures().map(|(name, view)| (name.clone(), view.clone()));
            pictures.map(|(picture, view)| (SimulatedImage { simulation, picture }, view)).collect::<Vec<_>>()
        };
        self.running.iter().take(self.own).enumerate().flat_map(of).collect()
    }

    /// The systems of particles that views show.
    pub fn particles(&self, scene: &Scene) -> Vec<ParticlesDraw> {
        let shown = |(system, particles): (usize, &Particles)| {
            let state = |name: &str| self.state_of_particles(system, name).cloned();
            let states = [state("place")?, state("velocity")?];
            Some(ParticlesDraw { name: particles.name.clone(), look: particles.look.clone(), states })
        };
        scene.particles.iter().take(SYSTEMS_MAX).enumerate().filter_map(shown).collect()
    }

    /// The textures of a state of what moves a system of particles.
    pub fn state_of_particles(&self, system: usize, state: &str) -> Option<&wgpu::TextureView> {
        self.running.get(self.own + system)?.state(state)
    }
}

/// The simulations of a scene that are run: its own, and those that move its particles.
fn all(scene: &Scene) -> impl Iterator<Item = (&Simulation, Option<&Particles>)> {
    let own = scene.simulations.iter().take(SIMULATIONS_MAX).map(|simulation| (simulation, None));
    let of_particles = scene.particles.iter().take(SYSTEMS_MAX);
    own.chain(of_particles.map(|particles| (&particles.simulation, Some(particles))))
}

/// What is wrong with simulations of a scene, or with who shows them.
pub(super) fn faults(scene: &Scene, state: &SimulationState) -> Vec<String> {
    let mut faults = Vec::new();
    for (system, particles) in scene.particles.iter().enumerate().take(SYSTEMS_MAX) {
        let lacks = ["place", "velocity"].iter().any(|name| state.state_of_particles(system, name).is_none());
        if lacks {
            let name = &particles.name;
            faults.push(format!(
                "the particles `{name}` are not drawn: their program lacks a state `place` or `velocity`"
            ));
        }
    }
    if scene.particles.len() > SYSTEMS_MAX {
        faults
            .push(format!("only the first {SYSTEMS_MAX} of {} systems of particles are drawn", scene.particles.len()));
    }
    if scene.simulations.len() > SIMULATIONS_MAX {
        faults.push(format!("only the first {SIMULATIONS_MAX} of {} simulations are run", scene.simulations.len()));
    }
    for (simulation, running) in scene.simulations.iter().zip(&state.running) {
        if simulation.sees.is_some() && !running.reads_surfaces() {
            let name = &simulation.name;
            faults.push(format!(
                "the simulation `{name}` looks at nothing: its program lacks the line `//! reads: surfaces`"
            ));
        }
    }
    let mut check = |simulation: usize, picture: &str, who: String| {
        let name = scene.simulations.get(simulation).map_or("", |simulation| &simulation.name);
        let Some(running) = state.running.get(simulation) else {
            faults.push(format!("{who} shows the simulation {simulation}, which does not exist"));
            return;
        };
        if running.pictures().all(|(known, _)| known != picture) {
            let known: Vec<&str> = running.pictures().map(|(known, _)| known.as_str()).collect();
            let known = known.join(", ");
            faults.push(format!("{who} shows the picture `{picture}` of `{name}`, which has: {known}"));
        }
    };
    for water in &scene.water {
        if let Some(simulation) = water.simulation {
            check(simulation, crate::waves::SIMULATED, format!("the water `{}`", water.name));
        }
    }
    for image in &scene.images {
        if let manypass_scene::ImageSource::Simulation(shown) = &image.source {
            check(shown.simulation, &shown.picture, format!("the image `{}`", image.name));
        }
    }
    faults
}

impl Renderer {
    /// Makes simulations ready, as they begin.
    ///
    /// # Errors
    /// One that cannot be run.
    pub(super) fn follow_simulations(&mut self, scene: &Scene) -> Result<(), RenderError> {
        if all(scene).next().is_none() && self.simulations.running.is_empty() {
            return Ok(());
        }
        if self.simulations.follow(&self.gpu, scene)? {
            self.resources.textures.show_simulations(self.simulations.pictures());
        }
        Ok(())
    }

    /// Brings the simulations of `scene` to its time ([`Scene::time_secs`]). A frame does so by itself; whoever shows how far
    /// that is, or lets it be stopped, does it before. `progress` is called for every step, and says whether to go on.
    ///
    /// Bodies are where the animation that was last posed has them at each step.
    ///
    /// # Errors
    /// One that cannot be run, takes more than [`crate::SIMULATION_STEPS_MAX`] steps to that time, or was stopped.
    pub fn simulate(
        &mut self,
        scene: &Scene,
        progress: &mut dyn FnMut(SimulationProgress<'_>) -> bool,
    ) -> Result<(), RenderError> {
        at_once(self.simulate_in_turns(scene, progress, &mut || None))
    }

    /// As [`Self::simulate`]; after every step `turns` is asked whether others are to have the thread. Frames of `scene`
    /// then make no steps. Who stops it, or drops it during a turn, loses no step: the next call goes on from there.
    ///
    /// # Errors
    /// As [`Self::simulate`].
    pub async fn simulate_in_turns(
        &mut self,
        scene: &Scene,
        progress: &mut dyn FnMut(SimulationProgress<'_>) -> bool,
        turns: &mut Turns<'_>,
    ) -> Result<(), RenderError> {
        self.follow_simulations(scene)?;
        for (index, (running, (simulation, particles))) in
            self.simulations.running.iter_mut().zip(all(scene)).enumerate()
        {
            let seen = particles.map_or((simulation.sees, simulation.layers), |of| (of.meets, of.layers));
            let surfaces = |time_secs: f32| scene.surfaces_seen(seen.0?, seen.1, time_secs);
            let (place, bodies) = match particles {
                Some(_) => (Place::default(), Vec::new()),
                None => (scene.place_of_simulation(index), scene.bodies_of_simulation(index)),
            };
            let moving = SimulationInputs {
                place,
                bodies,
                posed: scene.posed,
                surfaces: &surfaces,
                surfaces_move: simulation.sees.is_some(),
            };
            running.advance(&self.gpu, &moving, scene.time_secs, progress, turns).await?;
        }
        Ok(())
    }

    /// Lets simulations begin anew: for another scene, or where bodies were moved otherwise than by an animation.
    pub fn forget_simulations(&mut self) {
        self.simulations.clear();
        self.resources.textures.show_simulations(BTreeMap::new());
    }

    /// What became of the simulations of the last frame.
    ///
    /// # Errors
    /// The device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn simulation_reports(&self) -> Result<Vec<SimulationReport>, RenderError> {
        pollster::block_on(self.simulation_reports_async())
    }

    /// As [`Self::simulation_reports`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::simulation_reports`].
    pub async fn simulation_reports_async(&self) -> Result<Vec<SimulationReport>, RenderError> {
        let mut reports = Vec::new();
        for running in &self.simulations.running {
            reports.push(running.report(&self.gpu).await?);
        }
        Ok(reports)
    }

    /// The numbers of a state of a simulation, four a cell, row by row from the top; none where there is no such state.
    /// Those that move particles follow the scene's own.
    ///
    /// # Errors
    /// The device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_simulation(&self, simulation: usize, state: &str) -> Result<Option<Vec<[f32; 4]>>, RenderError> {
        pollster::block_on(self.read_simulation_async(simulation, state))
    }

    /// As [`Self::read_simulation`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::read_simulation`].
    pub async fn read_simulation_async(
        &self,
        simulation: usize,
        state: &str,
    ) -> Result<Option<Vec<[f32; 4]>>, RenderError> {
        let Some(running) = self.simulations.running.get(simulation) else { return Ok(None) };
        Ok(running.read(&self.gpu, state).await?)
    }
}
