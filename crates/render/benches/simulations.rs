//! What a step of simulations costs, beside a plain copy of the same states: `cargo bench -p manypass --bench simulations`, with
//! `-- --json` for one line of JSON.

use manypass::{Gpu, Renderer};
use manypass_scene::Scene;
use manypass_scene::particles::{Particles, Preset};
use manypass_scene::simulation::Simulation;
use serde_json::{Value, json};
use std::error::Error;
use std::time::Instant;

/// Steps of a run, and how many runs take turns; the least counts.
const STEPS: u32 = 60;
const RUNS: usize = 5;
const PARTICLES: u32 = 100_000;

/// A row: its name, what is run, and how many states it has, each of which a copy reads and writes.
struct Row {
    name: &'static str,
    scene: Scene,
    copy: Scene,
}

fn own(simulation: Simulation) -> Scene {
    Scene { simulations: vec![simulation], ..Scene::default() }
}

/// A program that makes its states what they are.
fn copy_of(states: &[&str], cells: (u32, u32)) -> Scene {
    let passes: Vec<String> = states.iter().map(|state| format!("copy_{state} -> {state}")).collect();
    let functions =
        states.iter().map(|state| format!("fn copy_{state}(cell: vec2i) -> vec4f {{ return {state}_at(cell); }}\n"));
    let text = format!(
        "//! step: {}\n//! shows: color\n\n{}fn color(cell: vec2i) -> vec4f {{ return vec4f(0.0); }}\n",
        passes.join(", "),
        functions.collect::<String>()
    );
    own(Simulation { cells: Some(cells), rate_hz: Some(60.0), ..Simulation::of_text("copy", "copy.wgsl", &text) })
}

fn rows() -> Vec<Row> {
    let grid = |name: &'static str, program: &str, states: &[&str]| {
        let cells = (256, 256);
        let simulation = Simulation { cells: Some(cells), rate_hz: Some(60.0), ..Simulation::built_in(name, program) };
        Row {
            name,
            scene: own(simulation.with(if program == "ripples" { "speed_m_s" } else { "" }, "0.1")),
            copy: copy_of(states, cells),
        }
    };
    let particles = |name: &'static str, set: &[(&str, &str)]| {
        let mut particles = Particles::new(name, Preset::Smoke, PARTICLES);
        particles.emit_from(Default::default(), glam::Vec3::splat(4.0));
        for (key, value) in [("life_s", "1,1"), ("gravity_m_s2", "1"), ("drag_per_s", "0.5"), ("wind_m_s", "1,0,0")] {
            particles.set(key, value);
        }
        for (key, value) in set {
            particles.set(key, value);
        }
        let cells = particles.simulation.cells.unwrap_or((1, 1));
        Row {
            name,
            scene: Scene { particles: vec![particles], ..Scene::default() },
            copy: copy_of(&["place", "velocity"], cells),
        }
    };
    let mut rows = vec![
        grid("ripples, 256x256", "ripples", &["water"]),
        grid("gray_scott, 256x256", "gray_scott", &["field"]),
        grid("fluid, 256x256, 24 iterations", "fluid", &["flow", "pressure", "smoke"]),
        particles("100,000 particles: gravity, drag, wind", &[("swirl_m_s", "0")]),
        particles("the same with swirls", &[("swirl_m_s", "0.5")]),
    ];
    for row in &mut rows {
        for simulation in &mut row.scene.simulations {
            simulation.parameters.retain(|(key, _)| !key.is_empty());
        }
    }
    rows
}

/// Milliseconds of a step.
fn step_ms(renderer: &mut Renderer, scene: &mut Scene) -> Result<f64, Box<dyn Error>> {
    scene.time_secs += 1.0 / 60.0;
    renderer.simulate(scene, &mut |_| true)?;
    renderer.wait();
    let started = Instant::now();
    scene.time_secs += STEPS as f32 / 60.0;
    renderer.simulate(scene, &mut |_| true)?;
    renderer.wait();
    Ok(started.elapsed().as_secs_f64() * 1e3 / f64::from(STEPS))
}

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::headless(None)?;
    let (mut one, mut other) = (Renderer::new(gpu.clone())?, Renderer::new(gpu)?);
    let mut measured: Vec<Value> = Vec::new();
    for mut row in rows() {
        let (mut ms, mut copy_ms) = (f64::INFINITY, f64::INFINITY);
        // What is born in the first second costs less than what moves.
        row.scene.time_secs = 1.5;
        for _ in 0..RUNS {
            ms = ms.min(step_ms(&mut one, &mut row.scene)?);
            copy_ms = copy_ms.min(step_ms(&mut other, &mut row.copy)?);
        }
        let report = one.simulation_reports()?.pop().ok_or("no simulation was run")?;
        measured.push(json!({
            "name": row.name, "ms": ms, "copy_ms": copy_ms, "ratio": ms / copy_ms, "passes": report.passes,
            "bytes": report.bytes, "held": report.held_numbers,
        }));
    }
    if std::env::args().any(|argument| argument == "--json") {
        println!("{}", json!({ "adapter": one.gpu().adapter.name, "rows": measured }));
    } else {
        measured.iter().for_each(|row| println!("    {row}"));
    }
    Ok(())
}
