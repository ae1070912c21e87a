//! The frame graph on a device: what it keeps from frame to frame, and what it gives back.

use crate::common;
use glam::Vec3;
use manypass::gpu::Floor;
use manypass::graph::{
    ColorLoad, DepthLoad, Executor, Export, Graph, Limits, Plan, Run, RunOptions, Taps, TextureDesc, Timing,
};
use manypass::scene::material::{TexturedFactor, Volume};
use manypass::{
    Aov, DebugView, Environment, FogMode, FrameRequest, Gpu, Path, PixelSamples, Renderer, TransparencyMode, scene,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::collections::BTreeSet;
use wgpu::TextureFormat as F;

/// What the tests draw: one colour over everything.
fn fill(value: f64) -> ColorLoad {
    ColorLoad::Clear(wgpu::Color { r: value, g: 0.0, b: 0.0, a: 1.0 })
}

struct Bench {
    gpu: manypass::Gpu,
    executor: Executor,
}

impl Bench {
    fn new() -> Self {
        let gpu = manypass::Gpu::headless(None).expect("an adapter");
        let executor = Executor::new(&gpu.device, &gpu.queue);
        Self { gpu, executor }
    }

    fn graph(&self) -> Graph<'static> {
        self.executor.graph(Limits::WEBGL2)
    }

    fn run(&mut self, graph: Graph<'_>, options: &RunOptions<'_>) -> (Plan, Run) {
        let plan = graph.plan().expect("plans");
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let run = self.executor.run(graph, &plan, &mut encoder, options).expect("runs");
        self.gpu.queue.submit([encoder.finish()]);
        self.executor.end_frame(&run);
        (plan, run)
    }

    /// The red of the first texel of an rgba8 texture.
    fn red(&self, texture: &wgpu::Texture) -> u8 {
        let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 256,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(256), rows_per_image: None },
            },
            wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        );
        self.gpu.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        self.gpu.wait();
        buffer.get_mapped_range(..).expect("mapped")[0]
    }

    /// Draws one frame in which each view of `views` (its name, side and value) has a history; gives the value that
    /// each found there, or none if it was the first.
    fn frame_of_histories(&mut self, views: &[(&'static str, u32, f64)]) -> Vec<Option<u8>> {
        let mut graph = self.graph();
        let declare = |&(name, side, value): &(&'static str, u32, f64)| {
            graph.set_view(name);
            let history = graph.history("fog", TextureDesc::new_2d(side, side, F::Rgba8Unorm));
            graph.pass("fog").color(history.next, fill(value));
            // A pass that keeps all and draws nothing, so that there is something to export.
            let previous = graph.pass("look").color(history.previous, ColorLoad::Keep);
            (history.is_first, graph.export(previous))
        };
        let found: Vec<(bool, Export)> = views.iter().map(declare).collect();
        let (_, run) = self.run(graph, &RunOptions::default());
        let value = |(is_first, export): (bool, Export)| {
            let red = self.red(run.exported(export).expect("exported"));
            assert!(!is_first || red == 0, "a new history holds zeros");
            (!is_first).then_some(red)
        };
        found.into_iter().map(value).collect()
    }
}

#[test]
fn a_view_keeps_its_history_while_another_changes_its_size() {
    let mut bench = Bench::new();
    assert_eq!(bench.frame_of_histories(&[("", 8, 0.2), ("mirror", 16, 0.4)]), [None, None]);
    assert_eq!(bench.frame_of_histories(&[("", 8, 0.6), ("mirror", 16, 0.8)]), [Some(51), Some(102)]);
    assert_eq!(bench.frame_of_histories(&[("", 32, 1.0), ("mirror", 16, 0.2)]), [None, Some(204)]);
    assert_eq!(bench.frame_of_histories(&[("", 32, 0.4)]), [Some(255)]);
    assert_eq!(bench.frame_of_histories(&[("mirror", 16, 0.0), ("", 32, 0.0)]), [Some(51), Some(102)]);
}

#[test]
fn to_plan_a_frame_disturbs_no_history() {
    let mut bench = Bench::new();
    bench.frame_of_histories(&[("", 8, 0.2)]);
    for _ in 0..3 {
        let mut graph = bench.graph();
        let history = graph.history("fog", TextureDesc::new_2d(8, 8, F::Rgba8Unorm));
        assert!(!history.is_first);
        graph.pass("fog").color(history.next, fill(1.0));
        assert_eq!(graph.plan().expect("plans").passes.len(), 1);
    }
    // A frame that writes nothing leaves it as it is, too.
    let mut graph = bench.graph();
    graph.history("fog", TextureDesc::new_2d(8, 8, F::Rgba8Unorm));
    bench.run(graph, &RunOptions::default());
    assert_eq!(bench.frame_of_histories(&[("", 8, 0.4)]), [Some(51)]);
}

#[test]
fn after_fifty_sizes_the_pool_holds_at_most_twice_the_plan() {
    let mut bench = Bench::new();
    for side in (64..114).chain((64..114).rev()) {
        let mut graph = bench.graph();
        let mut targets =
            ["a", "b", "c"].map(|name| graph.texture(name, TextureDesc::new_2d(side, side, F::Rgba16Float)));
        for target in &mut targets {
            let handle = std::mem::replace(target, graph.texture("unused", TextureDesc::new_2d(1, 1, F::R8Unorm)));
            *target = graph.pass("fill").color(handle, fill(0.5));
        }
        for target in targets {
            graph.export(target);
        }
        let (plan, _) = bench.run(graph, &RunOptions::default());
        let (held, planned) = (bench.executor.pool_bytes(), plan.bytes().aliased);
        assert!(held <= 2 * planned, "{held} bytes are held, {planned} are planned");
    }
}

#[test]
fn textures_age_once_a_frame_and_not_once_a_run() {
    let mut bench = Bench::new();
    let mut made = Vec::new();
    for _ in 0..4 {
        let mut last = None;
        // The large one is more than twice what the small one takes, so that runs that age would give it back.
        for side in [256, 8] {
            let mut graph = bench.graph();
            let target = graph.texture("target", TextureDesc::new_2d(side, side, F::Rgba8Unorm));
            let target = graph.pass("fill").color(target, fill(0.5));
            graph.export(target);
            let plan = graph.plan().expect("plans");
            let mut encoder = bench.gpu.device.create_command_encoder(&Default::default());
            last = bench.executor.run(graph, &plan, &mut encoder, &RunOptions::default()).ok();
            bench.gpu.queue.submit([encoder.finish()]);
        }
        bench.executor.end_frame(&last.expect("a run"));
        made.push(bench.executor.textures_made());
    }
    assert_eq!(made, [2, 2, 2, 2]);
}

#[test]
fn a_frame_that_is_not_submitted_leaves_histories_as_they_are() {
    let mut bench = Bench::new();
    assert_eq!(bench.frame_of_histories(&[("", 8, 0.2)]), [None]);
    let mut graph = bench.graph();
    let history = graph.history("fog", TextureDesc::new_2d(8, 8, F::Rgba8Unorm));
    graph.pass("fog").color(history.next, fill(1.0));
    let plan = graph.plan().expect("plans");
    let mut encoder = bench.gpu.device.create_command_encoder(&Default::default());
    bench.executor.run(graph, &plan, &mut encoder, &RunOptions::default()).expect("runs");
    drop(encoder);
    assert_eq!(bench.frame_of_histories(&[("", 8, 0.4)]), [Some(51)]);
}

#[test]
fn after_fifty_sizes_a_renderer_holds_at_most_twice_the_plan() {
    let scene = manypass_testkit::scenes::one_light_on_one_plane().scene;
    let mut renderer = common::renderer();
    renderer.load(&scene).expect("loads");
    let mut largest = 0;
    for side in (16..66).chain((16..66).rev().step_by(5)) {
        let mut request = common::plain_request(&scene, (side, side));
        // Variables, another shaded size and metering have textures of their own.
        request.want_aovs = if side % 2 == 0 { vec![manypass::Aov::Motion, manypass::Aov::ObjectId] } else { vec![] };
        request.settings.render.scale = if side % 3 == 0 { 0.5 } else { 1.0 };
        if side % 10 == 0 {
            renderer.meter(&scene, &request).expect("meters");
        }
        renderer.render(&scene, &request).expect("renders");
        let (held, planned) = (renderer.pool_bytes(), renderer.stats().texture_bytes);
        assert!(planned > 0 && held <= 2 * planned, "{side}: {held} bytes are held, {planned} are planned");
        largest = largest.max(held);
    }
    assert!(renderer.pool_bytes() < largest / 4, "the pool grows and shrinks");
}

#[test]
fn one_target_is_copied_into_a_texture_while_passes_stay_merged() {
    let mut bench = Bench::new();
    let desc = TextureDesc::new_2d(8, 8, F::Rgba8Unorm);
    let texture = |format| {
        bench.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    };
    let (good, wrong) = (texture(F::Rgba8Unorm), texture(F::Rgba16Float));
    let frame = |bench: &Bench| {
        let mut graph = bench.graph();
        let target = graph.texture("radiance", desc);
        let target = graph.pass("first").color(target, fill(0.2));
        let target = graph.pass("second").color(target, ColorLoad::Keep);
        let other = graph.texture("display", desc);
        let other = graph.pass("third").color(other, fill(0.6));
        graph.export(target);
        graph.export(other);
        graph
    };
    let options = |into| RunOptions {
        taps: Taps::One { pass: "first", texture: "radiance", into },
        time: Timing::Live,
        ..Default::default()
    };
    let (_, run) = bench.run(frame(&bench), &options(&good));
    assert!(run.taps.is_empty() && run.untapped.is_empty(), "{:?}", run.untapped);
    assert_eq!(bench.red(&good), 51);
    let (_, run) = bench.run(frame(&bench), &options(&wrong));
    let [untapped] = &run.untapped[..] else { panic!("{:?}", run.untapped) };
    assert_eq!((untapped.pass.as_str(), untapped.texture.as_str()), ("first", "radiance"));
}

/// Four samples of a texel, which become one, and a target that nobody looks at.
fn resolved(bench: &Bench) -> (Graph<'static>, Export) {
    let mut graph = bench.graph();
    let one = |format| TextureDesc::new_2d(8, 8, format);
    let four = |format| TextureDesc { samples: 4, ..one(format) };
    let color = graph.texture("color", four(F::Rgba8Unorm));
    let depth = graph.texture("depth", four(F::Depth32Float));
    let mean = graph.texture("mean", one(F::Rgba8Unorm));
    let spare = graph.texture("spare", one(F::Rgba8Unorm));
    let mut pass = graph.pass("opaque");
    let color = pass.color(color, fill(0.2));
    let depth = pass.depth_stencil(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
    let mut pass = graph.pass("background");
    let color = pass.color(color, ColorLoad::Keep);
    pass.depth_stencil_read_only(&depth);
    let mut pass = graph.pass("resolve");
    pass.color(color, ColorLoad::Keep);
    let mean = pass.resolve(mean);
    let mut pass = graph.pass("spare");
    pass.color(spare, ColorLoad::Discard);
    pass.side_effect();
    let export = graph.export(mean);
    (graph, export)
}

/// Where the driver saves no memory the usage changes nothing; wgpu holds passes to its rules everywhere.
#[test]
fn attachments_without_memory_show_the_same() {
    let mut bench = Bench::new();
    let scope = bench.gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let plain = RunOptions::default();
    let timed = RunOptions { time: Timing::Once, ..plain };
    let tapped = RunOptions { taps: Taps::All, ..plain };
    let mean_bytes = 8 * 8 * 4;
    for (memoryless, options, held_bytes) in [
        (false, plain, 10 * mean_bytes),
        (true, plain, mean_bytes),
        (true, plain, mean_bytes),
        (true, timed, 10 * mean_bytes),
        // One that can be copied takes the place of the spare target, which is kept for a while.
        (true, tapped, 11 * mean_bytes),
        (true, plain, mean_bytes),
    ] {
        bench.executor.set_memoryless(memoryless);
        let (graph, export) = resolved(&bench);
        let (plan, run) = bench.run(graph, &options);
        let bytes = plan.bytes();
        assert_eq!((bytes.aliased, bytes.memoryless), (10 * mean_bytes, 9 * mean_bytes), "{}", plan.to_text());
        assert_eq!(bench.red(run.exported(export).expect("exported")), 51);
        assert_eq!(bench.executor.pool_bytes(), held_bytes, "{memoryless} {options:?}");
    }
    let refused = pollster::block_on(scope.pop());
    assert!(refused.is_none(), "{refused:?}");
}

#[test]
fn live_times_come_without_waiting() {
    let mut bench = Bench::new();
    if !bench.gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        manypass_testkit::needs::skip("this adapter has no timestamps");
        return;
    }
    let options = RunOptions { time: Timing::Live, ..Default::default() };
    let mut arrived = 0;
    for frame in 0..20 {
        let mut graph = bench.graph();
        let target = graph.texture("radiance", TextureDesc::new_2d(64, 64, F::Rgba8Unorm));
        let target = graph.pass(if frame < 10 { "early" } else { "late" }).color(target, fill(0.5));
        graph.export(target);
        bench.run(graph, &options);
        if let Some(times) = bench.executor.latest_times() {
            assert!(matches!(times, [time] if time.gpu_ms.is_some()), "{times:?}");
            arrived += 1;
        }
        bench.gpu.wait();
    }
    let latest = bench.executor.latest_times().expect("times");
    assert_eq!(latest[0].name, "late");
    assert!(arrived > 10, "{arrived}");
}

/// Balls of glass in a row, and what is blended before them.
fn three_of_glass() -> scene::Scene {
    let projection = scene::Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::Z * 5.0, Vec3::ZERO, projection);
    let volume = Some(Volume { thickness: TexturedFactor::new(1.0), ..Volume::default() });
    let glass = scene::Material { transmission: Some(TexturedFactor::new(1.0)), volume, ..grey(1.0) };
    for z_m in [0.0, -1.5, -3.0] {
        builder.put(scene::primitives::uv_sphere(0.5, 8, 4), glass.clone(), at(Vec3::Z * z_m));
    }
    let blended = scene::Material { alpha_mode: scene::AlphaMode::Blend, ..grey(0.5) };
    builder.put(scene::primitives::cube(Vec3::ONE), blended, at(Vec3::Z * 2.0));
    builder.finish()
}

/// Reports, timers and pictures of passes find them by name.
#[test]
fn passes_of_a_frame_have_names_of_their_own() {
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).expect("needs none")).expect("a renderer");
    let panes = manypass_scene::load_path("../../docs/examples/panes.gltf".as_ref()).expect("loads").scene;
    let demo = |name| manypass::scene::demo::named(name).expect("a demo");
    let mut names = BTreeSet::new();
    for scene in [demo("materials"), demo("relief"), panes, three_of_glass()] {
        renderer.load(&scene).expect("loads");
        for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
            for (layers, mode, fog) in [
                (1, TransparencyMode::Sorted, FogMode::None),
                (4, TransparencyMode::Sorted, FogMode::None),
                (2, TransparencyMode::Stochastic, FogMode::Exponential),
                (2, TransparencyMode::Weighted, FogMode::ExponentialSquared),
            ] {
                let mut request = FrameRequest::of_scene(&scene, 64, 48).with(|settings| {
                    settings.render.path = path;
                    (settings.transparency.refractive_layers, settings.transparency.mode) = (layers, mode);
                    (settings.fog.mode, settings.fog.density_per_m, settings.fog.scattering) = (fog, 0.1, 1.0);
                    if path == Path::Forward && layers == 2 {
                        settings.msaa.samples = PixelSamples::Four;
                    }
                    settings.debug.view = if layers == 1 { DebugView::Overdraw } else { DebugView::Off };
                });
                request.want_aovs = vec![Aov::Depth, Aov::Emission, Aov::Motion, Aov::ObjectId];
                let plan = renderer.plan(&scene, &request).expect("plans");
                let own: BTreeSet<_> = plan.passes.iter().map(|pass| pass.name.clone()).collect();
                let all: Vec<_> = plan.passes.iter().map(|pass| &pass.name).collect();
                assert_eq!(own.len(), plan.passes.len(), "{path:?} {layers} {mode:?} {fog:?}: {all:?}");
                names.extend(own);
            }
        }
    }
    for name in [
        "resolve",
        "behind.resolve",
        "resolve.sum",
        "transmissive.far",
        "transmissive.linear_depth",
        "transmissive.far.2",
        "behind.far.halve.1",
        "behind.halve.1",
        "glass.far.distances",
        "glass.backs",
        "glass.middles",
        "fog.light",
    ] {
        assert!(names.contains(name), "{name} is none of {names:?}");
    }
}

/// Occlusion and reflections at half the size beside the same frame without effects. At full size reflections hold two
/// textures of radiance of their own, which are alive beside each other.
#[test]
fn effects_of_half_the_size_hold_few_textures_of_radiance() {
    let (width, height) = (1920, 1080);
    // Surfaces with layers are shown what was found at the size of the picture, and smooth ones have rays of each pixel.
    for (name, mut scene, most) in [("hall", scene::demo::hall(), 3.5), ("materials", scene::demo::materials(), 5.0)] {
        scene.update_transforms();
        let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).expect("a floor")).expect("a renderer");
        renderer.load(&scene).expect("loads");
        let mut request = FrameRequest::of_scene(&scene, width, height);
        request.settings.environment.source = Environment::Studio;
        let half = [("occlusion.resolution", "half"), ("reflections.resolution", "half")];
        for (key, value) in [("occlusion.enabled", "true"), ("reflections.enabled", "true")].into_iter().chain(half) {
            request.settings.set(key, value).expect("a setting");
        }
        let plan = renderer.plan(&scene, &request).expect("plans");
        for pass in ["occlusion", "reflections"] {
            assert!(plan.passes.iter().any(|found| found.name == pass), "{name}: {}", plan.to_text());
        }
        request.settings.effects.enabled = false;
        let bare = renderer.plan(&scene, &request).expect("plans");
        assert!(bare.passes.len() < plan.passes.len());
        let (with, without) = (plan.bytes(), bare.bytes());
        let more = (with.aliased + with.imported) - (without.aliased + without.imported);
        let texture = TextureDesc::new_2d(width, height, F::Rgba16Float).bytes();
        let share = more as f64 / texture as f64;
        println!("{name}: {more} bytes, {share:.2} textures of radiance");
        assert!(share > 0.0 && share < most, "{name}: {share:.2} textures of radiance");
    }
}
