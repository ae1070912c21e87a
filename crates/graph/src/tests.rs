//! Plans without a GPU: snapshots, every error, properties.

use wgpu::TextureFormat as F;

use crate::graph::Source;
use crate::*;

mod memoryless;
mod properties;

const CLEAR: ColorLoad = ColorLoad::Clear(wgpu::Color::BLACK);
const CLEAR_DEPTH: DepthLoad = DepthLoad::Clear { depth: 0.0, stencil: 0 };

fn desc(size: u32, format: F) -> TextureDesc {
    TextureDesc::new_2d(size, size, format)
}

fn graph() -> Graph<'static> {
    Graph::new(Limits::WEBGL2)
}

/// Writes one target and reads the others.
fn step(graph: &mut Graph<'_>, name: &'static str, reads: &[&Handle]) -> Handle {
    let target = graph.texture(name, desc(8, F::R32Float));
    let mut pass = graph.pass(name);
    let target = pass.color(target, CLEAR);
    for read in reads {
        pass.read(read);
    }
    pass.draw(|_| {});
    target
}

#[test]
fn text_of_a_small_frame() {
    let mut graph = graph();
    let depth = graph.texture("depth", desc(8, F::Depth32Float));
    let radiance = graph.texture("radiance", desc(8, F::Rgba16Float));
    let screen = graph.add_texture("screen".into(), desc(8, F::Rgba8Unorm), Source::Fake);
    let mut pass = graph.pass("opaque");
    let radiance = pass.color(radiance, CLEAR);
    let depth = pass.depth_stencil(depth, CLEAR_DEPTH);
    pass.draw(|_| {});
    let mut pass = graph.pass("sky");
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil(depth, DepthLoad::Keep);
    pass.draw(|_| {});
    let unused = step(&mut graph, "unused", &[&radiance]);
    drop(unused);
    let mut pass = graph.pass("tonemap");
    let screen = pass.color(screen, ColorLoad::Discard);
    pass.read(&radiance);
    pass.draw(|_| {});
    graph.export(screen);
    let plan = graph.plan().expect("plans");
    assert_eq!(
        plan.to_text(),
        "3 passes in 2 render passes
  opaque  8x8
    color 0: radiance, clear, store
    depth: depth, clear, store
  sky  8x8 (merged)
    color 0: radiance, keep, store
    depth: depth, keep, drop
  tonemap  8x8
    color 0: screen, discard, store
    read: radiance
3 textures
  radiance  8x8 Rgba16Float, slot 0, 0..=2
  depth  8x8 Depth32Float, slot 1, 0..=1, memoryless
  screen  8x8 Rgba8Unorm, imported, 2..=2, exported
bytes: 768 aliased of 768, 256 imported, 256 of the aliased memoryless
culled: unused
"
    );
    assert!(plan.to_json().contains("\"format\": \"Rgba16Float\""));
    assert!(plan.to_mermaid().contains("p0[\"opaque\"]"));
}

#[test]
fn textures_share_memory_after_their_last_use() {
    let mut graph = graph();
    let a = step(&mut graph, "a", &[]);
    let b = step(&mut graph, "b", &[&a]);
    let c = step(&mut graph, "c", &[&b]);
    graph.export(c);
    let plan = graph.plan().expect("plans");
    assert_eq!(plan.slots.len(), 2);
    assert_eq!(plan.bytes().aliased, 512);
    assert_eq!(plan.bytes().unaliased, 768);
}

#[test]
fn mips_are_written_and_read_one_by_one() {
    let mut graph = graph();
    let shape = TextureDesc { mips: 2, ..desc(8, F::R32Float) };
    let pyramid = graph.texture("pyramid", shape);
    let (top, next) = (graph.subview(&pyramid, 0, 0), graph.subview(&pyramid, 1, 0));
    assert_eq!((next.name(), next.desc().width), ("pyramid.mip1", 4));
    let mut pass = graph.pass("top");
    let top = pass.color(top, CLEAR);
    pass.draw(|_| {});
    let mut pass = graph.pass("next");
    pass.color(next, CLEAR);
    pass.read(&top);
    pass.draw(|_| {});
    let result = step(&mut graph, "result", &[&pyramid]);
    graph.export(result);
    let plan = graph.plan().expect("plans");
    assert_eq!(plan.passes.len(), 3);
    assert!(plan.passes.iter().all(|pass| pass.attachments[0].store));
}

#[test]
fn draws_are_what_passes_count_and_none_is_drawn_without() {
    let mut graph = graph();
    let mut result = graph.texture("result", desc(8, F::R32Float));
    let keep = ColorLoad::Keep;
    for (name, load, draws, is_drawn) in
        [("counted", CLEAR, Some(3), true), ("uncounted", keep, None, true), ("cleared", keep, None, false)]
    {
        let mut pass = graph.pass(name);
        result = pass.color(result, load);
        if let Some(draws) = draws {
            pass.count_draws(draws);
        }
        if is_drawn {
            pass.draw(|_| {});
        }
    }
    graph.export(result);
    let plan = graph.plan().expect("plans");
    let draws: Vec<_> = plan.pass_work().iter().map(|work| work.draws).collect();
    assert_eq!(draws, [Some(3), None, Some(0)]);
    assert!(plan.to_json().contains("\"draws\": 3"));
}

#[test]
fn a_side_effect_keeps_a_pass() {
    let mut graph = graph();
    let target = graph.texture("target", desc(8, F::R32Float));
    let mut pass = graph.pass("probe");
    pass.color(target, CLEAR);
    pass.side_effect();
    pass.draw(|_| {});
    let plan = graph.plan().expect("plans");
    assert_eq!(plan.passes.len(), 1);
    assert!(!plan.passes[0].attachments[0].store);
}

/// Two colour targets in one pass.
fn pair(a: TextureDesc, b: TextureDesc) -> PlanError {
    let mut graph = graph();
    let (a, b) = (graph.texture("a", a), graph.texture("b", b));
    let mut pass = graph.pass("pass");
    pass.color(a, CLEAR);
    pass.color(b, CLEAR);
    pass.draw(|_| {});
    graph.plan().expect_err("contradicts")
}

#[test]
fn contradicting_attachments() {
    let good = desc(8, F::Rgba8Unorm);
    let error = pair(good, desc(4, F::Rgba8Unorm));
    assert!(matches!(error, PlanError::SizeMismatch { .. }), "{error}");
    let error = pair(good, TextureDesc { samples: 4, ..good });
    assert!(matches!(error, PlanError::SampleMismatch { .. }), "{error}");
    let error = pair(good, desc(8, F::Depth32Float));
    assert!(matches!(error, PlanError::FormatMismatch { .. }), "{error}");
    let error = pair(good, TextureDesc { mips: 2, ..good });
    assert!(matches!(error, PlanError::NotOneView { .. }), "{error}");
    for bad in [desc(0, F::R8Unorm), desc(4096, F::R8Unorm)] {
        let error = pair(good, bad);
        assert!(matches!(error, PlanError::BadSize { .. }), "{error}");
    }
    let wide = desc(8, F::Rgba32Float);
    let mut graph = graph();
    let mut handles: Vec<_> = (0..3).map(|_| graph.texture("wide", wide)).collect();
    let mut pass = graph.pass("pass");
    for handle in handles.drain(..) {
        pass.color(handle, CLEAR);
    }
    let error = graph.plan().expect_err("48 bytes");
    assert!(matches!(error, PlanError::ColorBytesExceeded { bytes: 48, .. }));
}

/// Two passes that draw to `color`, of which the second leaves the mean of its samples in `mean`.
fn resolving(color: TextureDesc, mean: TextureDesc, read: bool) -> Result<Plan, PlanError> {
    let mut graph = graph();
    let (color, mean) = (graph.texture("color", color), graph.texture("mean", mean));
    let depth = graph.texture("depth", TextureDesc { samples: color.desc().samples, ..desc(8, F::Depth32Float) });
    let mut pass = graph.pass("opaque");
    let color = pass.color(color, CLEAR);
    pass.depth_stencil(depth, CLEAR_DEPTH);
    let mut pass = graph.pass("resolve");
    let color = pass.color(color, ColorLoad::Keep);
    let mean = pass.resolve(mean);
    let shown = step(&mut graph, "shown", &[if read { &color } else { &mean }]);
    graph.export(shown);
    graph.plan()
}

#[test]
fn samples_become_one() {
    let (one, four) = (desc(8, F::Rgba16Float), TextureDesc { samples: 4, ..desc(8, F::Rgba16Float) });
    let plan = resolving(four, one, false).expect("plans");
    assert_eq!(
        plan.to_text(),
        "3 passes in 2 render passes
  opaque  8x8
    color 0: color, clear, store
    depth: depth, clear, drop
  resolve  8x8 (merged)
    color 0: color, keep, drop
    mean of color 0: mean, discard, store
  shown  8x8
    color 0: shown, clear, store
    read: mean
4 textures
  color  8x8 Rgba16Float 4 samples, slot 0, 0..=1, memoryless
  depth  8x8 Depth32Float 4 samples, slot 1, 0..=0, memoryless
  mean  8x8 Rgba16Float, slot 2, 0..=2
  shown  8x8 R32Float, slot 3, 2..=2, exported
bytes: 3840 aliased of 3840, 0 imported, 3072 of the aliased memoryless
"
    );
    // Four samples of 8 bytes and of depth, the same again with the mean, and 4 bytes.
    assert_eq!(plan.written_bytes(), 64 * (4 * (8 + 4) + (4 * 8 + 8) + 4));
    // Only the mean is sampled.
    assert_eq!(plan.read_bytes(), 64 * 8);
    let moved: Vec<_> = plan.pass_work().into_iter().map(|pass| (pass.name, pass.read, pass.written)).collect();
    let opaque = 64 * 4 * (8 + 4);
    assert_eq!(
        moved,
        [("opaque".into(), 0, opaque), ("resolve".into(), 0, 64 * (4 * 8 + 8)), ("shown".into(), 64 * 8, 64 * 4)]
    );
    let error = resolving(four, one, true).expect_err("WebGL 2 reads no samples");
    assert!(matches!(error, PlanError::SampledSamples { samples: 4, .. }), "{error}");
    for (color, mean) in [(one, one), (four, four), (four, desc(8, F::Rgba8Unorm))] {
        let error = resolving(color, mean, false).expect_err("no mean");
        assert!(matches!(error, PlanError::ResolveMismatch { .. }), "{error}");
        assert!(error.to_string().contains("of `color`"), "{error}");
    }
    assert!(matches!(resolving(four, desc(4, F::Rgba16Float), false), Err(PlanError::SizeMismatch { .. })));
}

#[test]
fn too_many_targets() {
    let mut graph = graph();
    let handles: Vec<_> = (0..5).map(|_| graph.texture("t", desc(8, F::R8Unorm))).collect();
    let mut pass = graph.pass("pass");
    for handle in handles {
        pass.color(handle, CLEAR);
    }
    let error = graph.plan().expect_err("5 targets");
    assert!(matches!(error, PlanError::TooManyColorTargets { count: 5, .. }));
}

#[test]
fn contents_that_do_not_exist() {
    let mut first = graph();
    let late = first.texture("late", desc(8, F::R32Float));
    step(&mut first, "reader", &[&late]);
    let mut pass = first.pass("writer");
    pass.color(late, CLEAR);
    let error = first.plan().expect_err("read first");
    assert!(matches!(error, PlanError::ReadBeforeWrite { .. }));
    let message = error.to_string();
    assert!(message.contains("reader") && message.contains("writer"), "{message}");

    let mut second = graph();
    let target = second.texture("target", desc(8, F::R32Float));
    let mut pass = second.pass("pass");
    pass.color(target, ColorLoad::Keep);
    assert!(matches!(second.plan(), Err(PlanError::KeepUndefined { .. })));

    let mut third = graph();
    let target = third.texture("target", desc(8, F::R32Float));
    third.export(target);
    assert!(matches!(third.plan(), Err(PlanError::ExportUnwritten { .. })));
}

#[test]
fn one_view_used_twice() {
    let mut first = graph();
    let target = step(&mut first, "a", &[]);
    let mut pass = first.pass("b");
    let target = pass.color(target, ColorLoad::Keep);
    pass.read(&target);
    let error = first.plan().expect_err("feedback");
    assert!(matches!(error, PlanError::Feedback { .. }));
    assert!(error.to_string().contains("written by `a`"), "{error}");

    let mut second = graph();
    let target = second.texture("target", desc(8, F::R32Float));
    let again = second.subview(&target, 0, 0);
    let mut pass = second.pass("pass");
    pass.color(target, CLEAR);
    pass.color(again, CLEAR);
    assert!(matches!(second.plan(), Err(PlanError::AttachedTwice { .. })));
}

#[test]
fn depth_that_is_tested_against_is_sampled_only_where_that_is_no_feedback() {
    let lit = |limits: Limits, writes: bool| {
        let mut graph = Graph::new(limits);
        let depth = graph.texture("depth", desc(8, F::Depth32Float));
        let radiance = graph.texture("radiance", desc(8, F::Rgba16Float));
        let mut pass = graph.pass("opaque");
        let depth = pass.depth_stencil(depth, CLEAR_DEPTH);
        pass.draw(|_| {});
        let mut pass = graph.pass("light");
        pass.read_depth(&depth);
        let radiance = pass.color(radiance, CLEAR);
        if writes {
            pass.depth_stencil(depth, DepthLoad::Keep);
        } else {
            pass.depth_stencil_read_only(&depth);
        }
        pass.draw(|_| {});
        graph.export(radiance);
        graph.plan().map(|plan| plan.passes.len())
    };
    let allowed = Limits { samples_attached_depth: true, ..Limits::WEBGL2 };
    assert!(matches!(lit(allowed, false), Ok(2)));
    assert!(matches!(lit(Limits::WEBGL2, false), Err(PlanError::Feedback { .. })));
    assert!(matches!(lit(allowed, true), Err(PlanError::Feedback { .. })));
}

#[test]
fn misuse_while_declaring() {
    let mut other = graph();
    let foreign = step(&mut other, "foreign", &[]);
    let mut first = graph();
    step(&mut first, "reader", &[&foreign]);
    assert!(matches!(first.plan(), Err(PlanError::ForeignHandle { .. })));

    let mut second = graph();
    let target = second.texture("target", desc(8, F::R32Float));
    second.subview(&target, 1, 0);
    assert!(matches!(second.plan(), Err(PlanError::NoSuchView { .. })));

    let mut third = graph();
    third.pass("nothing").draw(|_| {});
    assert!(matches!(third.plan(), Err(PlanError::NoAttachment { .. })));

    // Of a shape that is impossible, too, and has no number of bytes.
    let shape = TextureDesc { layers: 0, mips: u32::MAX, ..desc(u32::MAX, F::Rgba32Float) };
    assert_eq!((shape.bytes(), TextureDesc { layers: 9, ..shape }.bytes()), (0, u64::MAX));
    let foreign = other.texture("foreign", shape);
    let mut fourth = graph();
    fourth.texture("own", desc(8, F::R32Float));
    fourth.subview(&foreign, 0, u32::MAX);
    assert!(fourth.plan().is_err());
}

#[test]
fn depth_is_attached_once_and_cubes_have_six_square_sides() {
    use wgpu::TextureViewDimension as D;
    let mut first = graph();
    let depths = ["near", "far"].map(|name| first.texture(name, desc(8, F::Depth32Float)));
    let mut pass = first.pass("pass");
    for depth in depths {
        pass.depth_stencil(depth, CLEAR_DEPTH);
    }
    pass.draw(|_| {});
    assert!(matches!(first.plan(), Err(PlanError::DepthTwice { .. })));

    let flat = desc(8, F::R32Float);
    let cases = [
        (flat, D::Cube),
        (flat, D::D3),
        (TextureDesc { layers: 6, height: 4, ..flat }, D::Cube),
        (TextureDesc { layers: 12, ..flat }, D::Cube),
        (TextureDesc { layers: 4, ..flat }, D::CubeArray),
    ];
    for (shape, dimension) in cases {
        let mut graph = graph();
        let texture = graph.add_texture("texture".into(), shape, Source::Fake);
        let target = graph.texture("target", flat);
        let mut pass = graph.pass("pass");
        pass.color(target, CLEAR);
        pass.read_as(&texture, dimension);
        let error = graph.plan().expect_err("no such view");
        assert!(matches!(error, PlanError::WrongDimension { .. }), "{dimension:?} of {shape:?}: {error}");
    }
    let mut last = graph();
    last.texture("samples", TextureDesc { samples: 4, mips: 2, ..flat });
    assert!(matches!(last.plan(), Err(PlanError::BadSize { .. })));
}

#[test]
fn a_face_is_drawn_while_the_mip_above_is_sampled_as_a_cube() {
    let mut graph = graph();
    let shape = TextureDesc { layers: 6, mips: 3, ..desc(8, F::Rgba16Float) };
    let cube = graph.texture("cube", shape);
    for face in 0..6 {
        let target = graph.subview(&cube, 0, face);
        let mut pass = graph.pass("sky");
        pass.color(target, CLEAR);
    }
    for mip in 1..3 {
        let above = graph.subresources(&cube, mip - 1..mip, 0..6);
        assert_eq!((above.desc().layers, above.desc().mips, above.desc().width), (6, 1, 8 >> (mip - 1)));
        for face in 0..6 {
            let target = graph.subview(&cube, mip, face);
            let mut pass = graph.pass("filter");
            pass.read_as(&above, wgpu::TextureViewDimension::Cube);
            pass.color(target, CLEAR);
        }
    }
    graph.export(cube);
    let plan = graph.plan().expect("plans");
    assert_eq!((plan.passes.len(), plan.culled.len()), (18, 0));
    assert!(plan.to_text().contains("read: cube.mip1"), "{}", plan.to_text());

    // The same with the mip that is being drawn is feedback.
    let mut graph = self::graph();
    let cube = graph.add_texture("cube".into(), shape, Source::Fake);
    let (whole_mip, face) = (graph.subresources(&cube, 0..2, 0..6), graph.subview(&cube, 1, 3));
    let mut pass = graph.pass("filter");
    pass.color(face, CLEAR);
    pass.read_as(&whole_mip, wgpu::TextureViewDimension::Cube);
    assert!(matches!(graph.plan(), Err(PlanError::Feedback { .. })));
}

#[test]
fn views_of_views_count_from_their_beginning() {
    let mut graph = graph();
    let shape = TextureDesc { mips: 4, ..desc(8, F::R32Float) };
    let pyramid = graph.texture("pyramid", shape);
    let lower = graph.subresources(&pyramid, 1..4, 0..1);
    assert_eq!((lower.name(), lower.desc().width, lower.desc().mips), ("pyramid.mips1-3", 4, 3));
    assert_eq!(graph.subview(&lower, 1, 0).name(), "pyramid.mip2");
    graph.subresources(&lower, 2..4, 0..1);
    assert!(matches!(graph.plan(), Err(PlanError::NoSuchView { mip_count: 3, .. })));
}

#[test]
fn layers_that_webgl_2_would_show_wrong_are_refused() {
    use wgpu::TextureViewDimension as D;
    let array = |layers| TextureDesc { layers, ..desc(8, F::R32Float) };
    let plan = |shape: TextureDesc, layers: std::ops::Range<u32>, dimension| {
        let mut graph = graph();
        let texture = graph.add_texture("array".into(), shape, Source::Fake);
        let part = graph.subresources(&texture, 0..1, layers);
        let target = graph.texture("target", desc(8, F::R32Float));
        let mut pass = graph.pass("pass");
        let target = pass.color(target, CLEAR);
        match dimension {
            Some(dimension) => pass.read_as(&part, dimension),
            None => pass.read(&part),
        };
        graph.export(target);
        graph.plan().map(drop)
    };
    assert_eq!(plan(array(4), 0..4, None), Ok(()));
    assert_eq!(plan(array(6), 0..6, Some(D::Cube)), Ok(()));
    assert_eq!(plan(TextureDesc { height: 4, ..array(6) }, 0..6, None), Ok(()));
    for (shape, layers, dimension) in [
        (array(4), 1..2, None),
        (array(4), 0..2, None),
        (array(4), 0..1, Some(D::D2)),
        (array(1), 0..1, Some(D::D2Array)),
        (array(6), 0..6, None),
        (array(12), 0..12, Some(D::D2Array)),
        (array(6), 2..3, Some(D::D2)),
    ] {
        let error = plan(shape, layers.clone(), dimension).expect_err("shown wrong");
        assert!(matches!(error, PlanError::SampledLayers { .. }), "{layers:?} {dimension:?}: {error}");
    }
}

#[test]
fn names_carry_their_view() {
    let mut graph = graph();
    let first = step(&mut graph, "geometry", &[]);
    graph.set_view("mirror");
    let second = step(&mut graph, "geometry", &[&first]);
    let history = graph.history("fog", desc(8, F::R32Float));
    assert_eq!((history.previous.name(), history.next.name()), ("mirror/fog.previous", "mirror/fog.next"));
    graph.set_view("");
    let third = step(&mut graph, "display", &[&second]);
    graph.export(third);
    let names: Vec<_> = graph.plan().expect("plans").passes.into_iter().map(|pass| pass.name).collect();
    assert_eq!(names, ["geometry", "mirror/geometry", "display"]);
}

#[test]
fn a_history_is_asked_for_once_a_frame() {
    let mut graph = graph();
    let history = graph.history("fog", desc(8, F::R32Float));
    assert!(history.is_first);
    graph.set_view("mirror");
    graph.history("fog", desc(8, F::R32Float));
    assert!(graph.plan().is_ok());
    graph.history("fog", desc(4, F::R32Float));
    assert_eq!(graph.plan(), Err(PlanError::HistoryTwice { history: "mirror/fog".into() }));
}
