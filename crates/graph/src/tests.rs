//! Plans without a GPU: snapshots, every error, properties.

use proptest::prelude::*;
use wgpu::TextureFormat as F;

use crate::*;

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
    let screen = graph.add_texture("screen".into(), desc(8, F::Rgba8Unorm), None, true);
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
  depth  8x8 Depth32Float, slot 1, 0..=1
  screen  8x8 Rgba8Unorm, imported, 2..=2, exported
bytes: 768 aliased of 768, 256 imported
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
}

proptest! {
    /// Each number picks which of the earlier results a pass reads.
    #[test]
    fn plans_are_sound(picks in prop::collection::vec(any::<u16>(), 1..40)) {
        let mut graph = graph();
        let mut handles: Vec<Handle> = Vec::new();
        for pick in &picks {
            let reads: Vec<&Handle> = handles
                .iter()
                .rev()
                .enumerate()
                .filter(|(back, _)| *back < 16 && pick >> back & 1 == 1)
                .map(|(_, handle)| handle)
                .collect();
            let handle = step(&mut graph, "step", &reads);
            handles.push(handle);
        }
        if let Some(last) = handles.pop() {
            graph.export(last);
        }
        let plan = graph.plan().expect("plans");
        prop_assert_eq!(plan.passes.len() + plan.culled.len(), picks.len());
        for (index, a) in plan.textures.iter().enumerate() {
            for b in &plan.textures[..index] {
                let overlap = a.first <= b.last && b.first <= a.last;
                prop_assert!(!(overlap && a.slot == b.slot));
            }
        }
        let mut written = vec![false; plan.textures.len()];
        let mut read = vec![false; plan.textures.len()];
        for pass in &plan.passes {
            for texture in &pass.reads {
                prop_assert!(written[texture.texture as usize]);
                read[texture.texture as usize] = true;
            }
            written[pass.attachments[0].texture as usize] = true;
        }
        // A pass runs only if somebody needs its result.
        for (texture, read) in plan.textures.iter().zip(read) {
            prop_assert!(read || texture.exported);
        }
    }
}
