//! A simulation that runs: its states, and how they become the next ones.

use super::compiled::{CompiledPass, CompiledSimulation, PICTURE, STATE, compiled};
use super::uniforms::{BodyUniform, CameraView, SimulationUniform, uniform_buffer};
use super::{CELLS_WRITTEN_MAX, NUMBER_MAX, STEPS_MAX, SimulationFile, SimulationProgress, SimulationReport};
use crate::gpu::{Gpu, GpuError, readback};
use crate::shader::program::ProgramError;
use glam::{IVec2, Vec2};
use manypass_scene::simulation::{BODIES_MAX, Body, Place, RATE_HZ_MAX, SeenSurfaces, Simulation};
use manypass_scene::turns::{Turns, give_turn};
use std::collections::{BTreeMap, HashMap};

/// After so many steps the device is waited for, so that it is never far behind.
const STEPS_AT_ONCE: u64 = 32;

/// The most that all simulations of a scene take: 2 GiB.
const BYTES_MAX: u64 = 2 << 30;

/// By how much of a step, and of all of them, a time may be too early, because it is a number of 32 bits.
const ROUNDING_STEPS: f64 = 1e-3;
const ROUNDING: f64 = 1e-7;

/// Where a simulation is, and what moves through it.
pub(crate) struct SimulationInputs<'s> {
    pub place: Place,
    pub bodies: Vec<Body<'s>>,
    /// The animation that moves them.
    pub posed: Option<usize>,
    /// Gives the surfaces that it meets at a time.
    pub surfaces: &'s dyn Fn(f32) -> Option<SeenSurfaces>,
    /// Whether they are looked for at each step, not at the beginning alone.
    pub surfaces_move: bool,
}

/// A simulation on a device.
#[derive(Debug)]
pub(crate) struct RunningSimulation {
    simulation: Simulation,
    size_m: Vec2,
    compiled: CompiledSimulation,
    cells: (u32, u32),
    rate_hz: f64,
    states: BTreeMap<String, State>,
    pictures: BTreeMap<String, wgpu::TextureView>,
    uniform: wgpu::Buffer,
    /// The surfaces that it reads; none before it has begun.
    seen: Option<CameraView>,
    reads_surfaces: bool,
    /// Which round a pass is in, of how many.
    turns: HashMap<(u32, u32), wgpu::Buffer>,
    groups: HashMap<(Phase, usize, u32, u32), wgpu::BindGroup>,
    /// How many steps led to what the states hold; none before it has begun.
    steps: Option<u64>,
    /// Whether pictures show what the states hold.
    is_shown: bool,
    /// The animation that moved its bodies.
    posed: Option<usize>,
}

/// Two textures, of which one is read while the other is written.
#[derive(Debug)]
struct State {
    views: [wgpu::TextureView; 2],
    /// Which one holds what there is.
    current: usize,
}

/// Which list of passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Phase {
    Start,
    Step,
    Shows,
}

impl RunningSimulation {
    /// It has not begun. `others_bytes` is what those of the scene before it take.
    ///
    /// # Errors
    /// Its program is none, or has no such parameter; it does not fit the adapter, or takes too much memory.
    pub fn new(gpu: &Gpu, simulation: &Simulation, size_m: Vec2, others_bytes: u64) -> Result<Self, ProgramError> {
        let fault = |message: String| ProgramError::Simulation { simulation: simulation.name.clone(), message };
        let mut file = SimulationFile::of_program(&simulation.program)?;
        for (parameter, value) in &simulation.parameters {
            file.set(parameter, value).map_err(|error| fault(error.to_string()))?;
        }
        let cells = simulation.cells.unwrap_or(file.cells());
        let most = gpu.capabilities.max_texture_size.min(manypass_scene::simulation::CELLS_SIDE_MAX);
        if cells.0.min(cells.1) == 0 || cells.0.max(cells.1) > most {
            return Err(fault(format!("{} by {} cells are not possible: each side is 1 to {most}", cells.0, cells.1)));
        }
        let rate_hz = simulation.rate_hz.unwrap_or(file.rate_hz());
        if !(rate_hz > 0.0 && rate_hz <= RATE_HZ_MAX) {
            let message = format!(
                "{rate_hz} steps a second are not possible; give rate_hz a number above 0, at most {RATE_HZ_MAX}"
            );
            return Err(fault(message));
        }
        if !(size_m.is_finite() && size_m.min_element() > 0.0) {
            return Err(fault("the place that it lies over has no size".into()));
        }
        let bytes = others_bytes + bytes_of(cells, file.states().len(), file.pictures().count());
        if bytes > BYTES_MAX {
            let (bytes, most) = (bytes >> 20, BYTES_MAX >> 20);
            return Err(fault(format!(
                "the simulations of the scene up to it would take {bytes} MiB, and {most} at most; give it fewer cells"
            )));
        }
        let texture = |label: &str, format, mips| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: cells.0, height: cells.1, depth_or_array_layers: 1 },
                mip_level_count: mips,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let state =
            |name: &String| (name.clone(), State { views: [(); 2].map(|()| texture(name, STATE, 1)), current: 0 });
        let states = file.states().iter().map(state).collect();
        let mips = cells.0.max(cells.1).ilog2() + 1;
        let pictures = file.pictures().map(|name| (name.to_owned(), texture(name, PICTURE, mips))).collect();
        let reads_surfaces = file.reads_surfaces();
        let compiled = compiled(gpu, file)?;
        Ok(Self {
            simulation: simulation.clone(),
            size_m,
            compiled,
            cells,
            rate_hz: f64::from(rate_hz),
            states,
            pictures,
            uniform: uniform_buffer(gpu, &SimulationUniform::default()),
            seen: None,
            reads_surfaces,
            turns: HashMap::new(),
            groups: HashMap::new(),
            steps: None,
            is_shown: false,
            posed: None,
        })
    }

    /// Whether it is what a scene says.
    pub fn is(&self, simulation: &Simulation, size_m: Vec2) -> bool {
        self.simulation == *simulation && self.size_m == size_m
    }

    /// The pictures that it makes, by their names.
    pub fn pictures(&self) -> impl Iterator<Item = (&String, &wgpu::TextureView)> {
        self.pictures.iter()
    }

    /// Whether its program reads what a camera sees.
    pub fn reads_surfaces(&self) -> bool {
        self.reads_surfaces
    }

    /// How many steps lead to a time.
    fn steps_to(&self, time_secs: f32) -> u64 {
        let time_secs = if time_secs.is_finite() { f64::from(time_secs) } else { 0.0 };
        let steps = time_secs * self.rate_hz;
        (steps + ROUNDING_STEPS + ROUNDING * steps.abs()).max(0.0) as u64
    }

    /// Goes on to a time, or begins anew where that lies before what the states hold. `progress` is told of it before
    /// each step, and says whether to go on. After each step `turns` is asked whether others are to have the thread.
    /// Who stops it, or drops it during a turn, leaves the states of the last step that was made.
    ///
    /// # Errors
    /// The time lies too many steps ahead, or `progress` says no.
    pub async fn advance(
        &mut self,
        gpu: &Gpu,
        moving: &SimulationInputs<'_>,
        time_secs: f32,
        progress: &mut dyn FnMut(SimulationProgress<'_>) -> bool,
        turns: &mut Turns<'_>,
    ) -> Result<(), ProgramError> {
        let until = self.steps_to(time_secs);
        // In another animation bodies have come another way.
        if self.posed != moving.posed && (self.reads_surfaces || !moving.bodies.is_empty()) {
            self.steps = None;
        }
        self.posed = moving.posed;
        if self.steps == Some(until) && self.is_shown {
            return Ok(());
        }
        let from = self.steps.filter(|steps| *steps <= until);
        let total = until - from.unwrap_or(0);
        let name = self.simulation.name.clone();
        if total > STEPS_MAX {
            let message = format!(
                "{total} steps lead to {time_secs} s, and {STEPS_MAX} are made at most; show an earlier time, or give it a \
                 smaller rate_hz than {}",
                self.rate_hz
            );
            return Err(ProgramError::Simulation { simulation: name, message });
        }
        self.check_work(total, time_secs)?;
        self.is_shown = false;
        if from.is_none() {
            self.begin(gpu, moving);
            self.steps = Some(0);
        }
        let stopped = || ProgramError::Simulation { simulation: name.clone(), message: "it was interrupted".into() };
        for done in 0..total {
            if !progress(SimulationProgress { name: &name, done, total }) {
                return Err(stopped());
            }
            let step = from.unwrap_or(0) + done;
            self.write_uniform(gpu, moving, Some(step));
            if let Some(seen) = self.seen.as_ref().filter(|_| moving.surfaces_move) {
                seen.write(gpu, (moving.surfaces)(self.secs_at(step + 1)).as_ref());
            }
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            self.record(gpu, Phase::Step, &mut encoder);
            gpu.queue.submit([encoder.finish()]);
            self.steps = Some(step + 1);
            if done % STEPS_AT_ONCE == STEPS_AT_ONCE - 1 {
                gpu.wait();
            }
            give_turn(turns).await;
        }
        progress(SimulationProgress { name: &name, done: total, total });
        self.is_shown = true;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.record(gpu, Phase::Shows, &mut encoder);
        self.record_mips(gpu, &mut encoder);
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Whether so many steps write no more cells than are written for one picture.
    fn check_work(&self, steps: u64, time_secs: f32) -> Result<(), ProgramError> {
        let rounds: u64 = self.compiled.step.iter().map(|pass| u64::from(pass.rounds)).sum();
        let cells = u64::from(self.cells.0) * u64::from(self.cells.1);
        let written = steps.saturating_mul(rounds).saturating_mul(cells);
        if written <= CELLS_WRITTEN_MAX {
            return Ok(());
        }
        let (width, height) = self.cells;
        let message = format!(
            "{steps} steps lead to {time_secs} s; with {rounds} passes each over {width} by {height} cells they write {written} \
             cells, and {CELLS_WRITTEN_MAX} at most; show an earlier time, or give it fewer cells, fewer particles or a smaller \
             rate_hz"
        );
        Err(ProgramError::Simulation { simulation: self.simulation.name.clone(), message })
    }

    /// Makes the states as they are at first.
    fn begin(&mut self, gpu: &Gpu, moving: &SimulationInputs<'_>) {
        if self.reads_surfaces {
            self.seen = Some(CameraView::new(gpu, (moving.surfaces)(0.0).as_ref()));
            self.groups.clear();
        }
        self.write_uniform(gpu, moving, None);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for state in self.states.values() {
            for view in &state.views {
                drop(begin_pass(&mut encoder, view, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT)));
            }
        }
        self.record(gpu, Phase::Start, &mut encoder);
        gpu.queue.submit([encoder.finish()]);
    }

    /// The time after so many steps.
    fn secs_at(&self, steps: u64) -> f32 {
        (steps as f64 / self.rate_hz) as f32
    }

    /// Writes what the passes of a step know, or of the beginning.
    fn write_uniform(&self, gpu: &Gpu, moving: &SimulationInputs<'_>, step: Option<u64>) {
        let before = step.unwrap_or(0);
        let (before_secs, time_secs) = (self.secs_at(before), step.map_or(0.0, |step| self.secs_at(step + 1)));
        let mut uniform = SimulationUniform {
            cells: IVec2::new(self.cells.0 as i32, self.cells.1 as i32),
            cell_m: self.size_m / Vec2::new(self.cells.0 as f32, self.cells.1 as f32),
            step: before as u32,
            step_secs: self.rate_hz.recip() as f32,
            time_secs,
            seed: self.simulation.seed,
            body_count: moving.bodies.len().min(BODIES_MAX) as u32,
            world_from_place: moving.place.world_from_place,
            ..SimulationUniform::default()
        };
        for (slot, body) in uniform.bodies.iter_mut().zip(&moving.bodies) {
            let (middle_m, radius_m) = body.sphere_in(&moving.place, time_secs);
            let (before_m, _) = body.sphere_in(&moving.place, before_secs);
            let bounds = body.bounds_in(&moving.place, time_secs);
            let is_wall = if body.is_wall { 1.0 } else { 0.0 };
            let half_m = 0.5 * (bounds.max - bounds.min);
            *slot = BodyUniform { middle_m, radius_m, half_m, is_wall, before_m, padding: 0.0 };
        }
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
    }

    /// Records a list of passes.
    fn record(&mut self, gpu: &Gpu, phase: Phase, encoder: &mut wgpu::CommandEncoder) {
        let Self { compiled, states, pictures, groups, uniform, turns, seen, .. } = self;
        let passes = match phase {
            Phase::Start => &compiled.start,
            Phase::Step => &compiled.step,
            Phase::Shows => &compiled.shows,
        };
        for (at, pass) in passes.iter().enumerate() {
            for round in 0..pass.rounds {
                let read: u32 = states.values().zip(0u32..).map(|(state, bit)| (state.current as u32) << bit).sum();
                let round = if pass.slots.iter().any(|slot| slot.name == "turn") { round } else { 0 };
                let turn = turns.entry((round, pass.rounds));
                let turn = turn.or_insert_with(|| uniform_buffer(gpu, &[round, pass.rounds, 0, 0]));
                let group = groups
                    .entry((phase, at, read, round))
                    .or_insert_with(|| bind(gpu, pass, states, (uniform, turn, seen.as_ref())));
                let first_level = wgpu::TextureViewDescriptor { mip_level_count: Some(1), ..Default::default() };
                let target = match phase {
                    Phase::Shows => pictures.get(&pass.target).map(|view| view.texture().create_view(&first_level)),
                    _ => states.get_mut(&pass.target).and_then(|state| {
                        state.current = 1 - state.current;
                        state.views.get(state.current).cloned()
                    }),
                };
                let Some(target) = target else { continue };
                let mut drawn = begin_pass(encoder, &target, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT));
                drawn.set_pipeline(&pass.pipeline);
                drawn.set_bind_group(1, &*group, &[]);
                if let Some(own) = &pass.own {
                    drawn.set_bind_group(2, own, &[]);
                }
                drawn.draw(0..3, 0..1);
            }
        }
    }

    /// Draws the smaller levels of all pictures.
    fn record_mips(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        let mips = &self.compiled.mips;
        for texture in self.pictures.values().map(wgpu::TextureView::texture) {
            let level = |level: u32| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    base_mip_level: level,
                    mip_level_count: Some(1),
                    ..Default::default()
                })
            };
            for at in 1..texture.mip_level_count() {
                let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("mips"),
                    layout: &mips.layout,
                    entries: &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::TextureView(&level(at - 1)),
                    }],
                });
                let mut drawn = begin_pass(encoder, &level(at), wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT));
                drawn.set_pipeline(&mips.pipeline);
                drawn.set_bind_group(0, &group, &[]);
                drawn.draw(0..3, 0..1);
            }
        }
    }

    /// What holds a state now.
    pub fn state(&self, name: &str) -> Option<&wgpu::TextureView> {
        self.states.get(name).and_then(|state| state.views.get(state.current))
    }

    /// The numbers of a state, four a cell, row by row from the top.
    ///
    /// # Errors
    /// The device failed.
    pub async fn read(&self, gpu: &Gpu, state: &str) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let Some(view) = self.state(state) else { return Ok(None) };
        let bytes = readback::read_texture(gpu, view.texture()).await?;
        Ok(Some(bytemuck::pod_collect_to_vec(&bytes)))
    }

    /// What became of it.
    ///
    /// # Errors
    /// The device failed.
    pub async fn report(&self, gpu: &Gpu) -> Result<SimulationReport, GpuError> {
        let mut held_numbers = 0;
        for name in self.states.keys() {
            let numbers = self.read(gpu, name).await?.unwrap_or_default();
            let is_held = |number: &&f32| number.is_nan() || number.abs() >= NUMBER_MAX;
            held_numbers += numbers.as_flattened().iter().filter(is_held).count() as u64;
        }
        Ok(SimulationReport {
            name: self.simulation.name.clone(),
            cells: self.cells,
            steps: self.steps.unwrap_or(0),
            passes: self.compiled.step.iter().map(|pass| pass.rounds).sum(),
            bytes: self.bytes(),
            held_numbers,
        })
    }

    /// Bytes of its states and pictures.
    pub fn bytes(&self) -> u64 {
        bytes_of(self.cells, self.states.len(), self.pictures.len())
    }
}

/// Bytes of so many states and pictures.
fn bytes_of((width, height): (u32, u32), states: usize, pictures: usize) -> u64 {
    let cells = u64::from(width) * u64::from(height);
    2 * 16 * cells * states as u64 + 8 * cells * 4 / 3 * pictures as u64
}

fn begin_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("simulation"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    })
}

fn bind(
    gpu: &Gpu,
    pass: &CompiledPass,
    states: &BTreeMap<String, State>,
    (uniform, turn, seen): (&wgpu::Buffer, &wgpu::Buffer, Option<&CameraView>),
) -> wgpu::BindGroup {
    let entry = |slot: &crate::shader::program::Slot| {
        let resource = match slot.name.as_str() {
            "simulation" => uniform.as_entire_binding(),
            "turn" => turn.as_entire_binding(),
            "seen" => seen?.uniform.as_entire_binding(),
            "seen_surfaces" => wgpu::BindingResource::TextureView(&seen?.surfaces),
            name => {
                let state = states.get(name)?;
                wgpu::BindingResource::TextureView(state.views.get(state.current)?)
            }
        };
        Some(wgpu::BindGroupEntry { binding: slot.entry.binding, resource })
    };
    let entries: Vec<_> = pass.slots.iter().filter_map(entry).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("simulation"),
        layout: &pass.layout,
        entries: &entries,
    })
}
