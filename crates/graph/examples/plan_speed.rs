//! Prints how long a frame of 60 passes takes to declare and to plan.
//! `cargo run --release -p manypass-graph --example plan_speed`

use std::time::{Duration, Instant};

use manypass_graph::{ColorLoad, Graph, Limits, TextureDesc};

const PASSES: u32 = 60;
const RUNS: u32 = 2000;

fn main() {
    let desc = TextureDesc::new_2d(1280, 720, wgpu::TextureFormat::Rgba16Float);
    let (mut declare, mut plan) = (Duration::ZERO, Duration::ZERO);
    for _ in 0..RUNS {
        let start = Instant::now();
        let mut graph = Graph::new(Limits::WEBGL2);
        let mut previous = Vec::new();
        for _ in 0..PASSES {
            let target = graph.texture("effect.target", desc);
            let mut pass = graph.pass("effect.step");
            let target = pass.color(target, ColorLoad::Discard);
            for earlier in previous.iter().rev().take(4) {
                pass.read(earlier);
            }
            pass.draw(|_| {});
            previous.push(target);
        }
        if let Some(last) = previous.pop() {
            graph.export(last);
        }
        let declared = Instant::now();
        std::hint::black_box(graph.plan().is_ok());
        plan += declared.elapsed();
        declare += declared - start;
    }
    let each = |total: Duration| total.as_secs_f64() * 1e6 / f64::from(RUNS);
    println!("{PASSES} passes: declare {:.1} us, plan {:.1} us", each(declare), each(plan));
}
