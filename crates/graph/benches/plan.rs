//! The time and the allocations of declaring and planning a frame of 60 passes: `cargo bench -p manypass-graph`.

use manypass_graph::{ColorLoad, Graph, Handle, Limits, TextureDesc};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

const PASSES: usize = 60;
static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

struct Counting;

#[allow(unsafe_code, reason = "a global allocator cannot be written without")]
// SAFETY: every call is handed to the system's allocator as it is; counting touches no memory that is handed out.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`, which is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: `memory` came from `alloc` above, that is from the system's allocator, with this layout.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const NAMES: [&str; 6] = ["blur.x", "blur.y", "light", "reflect", "combine", "filter"];

/// Every pass reads its two predecessors and writes a target of one of three sizes.
fn frame() -> Graph<'static> {
    let mut graph = Graph::new(Limits::WEBGL2);
    let mut last: [Option<Handle>; 2] = [None, None];
    for index in 0..PASSES {
        let size = 512 << (index % 3);
        let name = NAMES[index % NAMES.len()];
        let target = graph.texture(name, TextureDesc::new_2d(size, size, wgpu::TextureFormat::Rgba16Float));
        let mut pass = graph.pass(name);
        let target = pass.color(target, ColorLoad::Discard);
        for read in last.iter().flatten() {
            pass.read(read);
        }
        pass.draw(|_| {});
        last = [last[1].take(), Some(target)];
    }
    if let [_, Some(target)] = last {
        graph.export(target);
    }
    graph
}

fn main() {
    let mut rows = [("declare", Vec::new()), ("plan", Vec::new())];
    for _ in 0..2000 {
        let (started, before) = (Instant::now(), ALLOCATIONS.load(Ordering::Relaxed));
        let graph = frame();
        let (declared, between) = (started.elapsed(), ALLOCATIONS.load(Ordering::Relaxed));
        let plan = graph.plan();
        let (planned, after) = (started.elapsed(), ALLOCATIONS.load(Ordering::Relaxed));
        assert_eq!(plan.map(|plan| plan.passes.len()), Ok(PASSES), "all passes are planned");
        rows[0].1.push((declared.as_secs_f64() * 1e6, between - before));
        rows[1].1.push(((planned - declared).as_secs_f64() * 1e6, after - between));
    }
    for (name, mut samples) in rows {
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median_us, allocations) = samples[samples.len() / 2];
        let least_us = samples[0].0;
        println!(
            "{name} {PASSES} passes: median {median_us:.1} us, least {least_us:.1} us, {allocations} allocations \
             ({:.1} a pass)",
            allocations as f64 / PASSES as f64
        );
    }
}
