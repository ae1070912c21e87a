//! Which attachments need no memory on adapters that draw tile by tile.

use wgpu::TextureFormat as F;

use super::{CLEAR, CLEAR_DEPTH, desc, graph, step};
use crate::*;

/// What becomes of a depth buffer after the pass that cleared it.
#[derive(Clone, Copy)]
enum NextUse {
    Nothing,
    /// The next pass on the same targets tests against it.
    Tested,
    /// A pass on another target tests against it.
    TestedElsewhere,
    Sampled,
    Exported,
}

/// A frame that draws to `radiance` and `depth`.
fn of_depth(then: NextUse) -> Plan {
    let mut graph = graph();
    let depth = graph.texture("depth", desc(8, F::Depth32Float));
    let radiance = graph.texture("radiance", desc(8, F::Rgba16Float));
    let other = graph.texture("other", desc(8, F::Rgba16Float));
    let mut pass = graph.pass("opaque");
    let mut radiance = pass.color(radiance, CLEAR);
    let depth = pass.depth_stencil(depth, CLEAR_DEPTH);
    pass.draw(|_| {});
    match then {
        NextUse::Nothing => {}
        NextUse::Tested => {
            let mut pass = graph.pass("background");
            pass.depth_stencil_read_only(&depth);
            radiance = pass.color(radiance, ColorLoad::Keep);
            pass.draw(|_| {});
        }
        NextUse::TestedElsewhere => {
            let mut pass = graph.pass("elsewhere");
            pass.depth_stencil_read_only(&depth);
            let other = pass.color(other, CLEAR);
            pass.draw(|_| {});
            graph.export(other);
        }
        NextUse::Sampled => {
            let mut pass = graph.pass("fog");
            pass.read_depth(&depth);
            let other = pass.color(other, CLEAR);
            pass.draw(|_| {});
            graph.export(other);
        }
        NextUse::Exported => {
            graph.export(depth);
        }
    }
    graph.export(radiance);
    graph.plan().expect("plans")
}

fn is_memoryless(plan: &Plan, name: &str) -> bool {
    plan.textures.iter().find(|texture| texture.name == name).expect("in the plan").memoryless
}

#[test]
fn depth_of_one_render_pass_needs_no_memory() {
    for (then, memoryless, render_passes) in [
        (NextUse::Nothing, true, 1),
        (NextUse::Tested, true, 1),
        (NextUse::TestedElsewhere, false, 2),
        (NextUse::Sampled, false, 2),
        (NextUse::Exported, false, 1),
    ] {
        let plan = of_depth(then);
        assert_eq!(is_memoryless(&plan, "depth"), memoryless, "{}", plan.to_text());
        assert_eq!(plan.bytes().memoryless, if memoryless { 256 } else { 0 });
        assert_eq!(plan.render_passes, render_passes, "{}", plan.to_text());
        assert!(!is_memoryless(&plan, "radiance"), "it is exported");
    }
}

/// Two passes draw to four samples of a texel, and a third takes their mean: `draws` says that it draws something itself,
/// `again` that the samples are drawn over afterwards.
fn of_samples(draws: bool, again: bool) -> Plan {
    let mut graph = graph();
    let four = |format| TextureDesc { samples: 4, ..desc(8, format) };
    let (color, depth) = (graph.texture("color", four(F::Rgba16Float)), graph.texture("depth", four(F::Depth32Float)));
    let mean = graph.texture("mean", desc(8, F::Rgba16Float));
    let mut pass = graph.pass("opaque");
    let color = pass.color(color, CLEAR);
    let depth = pass.depth_stencil(depth, CLEAR_DEPTH);
    pass.draw(|_| {});
    let mut pass = graph.pass("background");
    let color = pass.color(color, ColorLoad::Keep);
    pass.depth_stencil_read_only(&depth);
    pass.draw(|_| {});
    let mut pass = graph.pass("resolve");
    let color = pass.color(color, ColorLoad::Keep);
    let mean = pass.resolve(mean);
    if draws {
        pass.draw(|_| {});
    }
    if again {
        let last = graph.texture("last", desc(8, F::Rgba16Float));
        let mut pass = graph.pass("glass");
        pass.read(&mean);
        pass.color(color, ColorLoad::Keep);
        let last = pass.resolve(last);
        pass.draw(|_| {});
        graph.export(last);
    }
    graph.export(mean);
    graph.plan().expect("plans")
}

#[test]
fn samples_that_become_one_in_their_render_pass_need_no_memory() {
    let plan = of_samples(false, false);
    assert_eq!(plan.render_passes, 1, "{}", plan.to_text());
    assert!(is_memoryless(&plan, "color") && is_memoryless(&plan, "depth") && !is_memoryless(&plan, "mean"));
    assert_eq!(plan.bytes().memoryless, 64 * 4 * (8 + 4));

    // Pipelines of a pass without depth draw in no render pass with depth.
    let plan = of_samples(true, false);
    assert_eq!(plan.render_passes, 2, "{}", plan.to_text());
    assert!(!is_memoryless(&plan, "color") && is_memoryless(&plan, "depth"));

    // What reads the mean comes after the render pass that takes it.
    let plan = of_samples(false, true);
    assert_eq!(plan.render_passes, 2, "{}", plan.to_text());
    assert!(!is_memoryless(&plan, "color") && is_memoryless(&plan, "depth"));
}

/// Means are attached while earlier passes of the render pass draw, so that they lie in the memory of nothing that these
/// sample, and are nothing that these sample.
#[test]
fn means_share_no_memory_with_what_their_render_pass_samples() {
    for is_same in [false, true] {
        let mut graph = graph();
        let one = desc(8, F::Rgba16Float);
        let color = graph.texture("color", TextureDesc { samples: 4, ..one });
        let sampled = graph.texture("sampled", one);
        let mean = graph.texture("mean", one);
        let mut pass = graph.pass("sampled");
        let sampled = pass.color(sampled, CLEAR);
        let mut pass = graph.pass("opaque");
        let color = pass.color(color, CLEAR);
        pass.read(&sampled);
        pass.draw(|_| {});
        let mut pass = graph.pass("resolve");
        pass.color(color, ColorLoad::Keep);
        let mean = pass.resolve(if is_same { sampled } else { mean });
        let shown = step(&mut graph, "shown", &[&mean]);
        graph.export(shown);
        let plan = graph.plan().expect("plans");
        let is_merged = plan.passes[1].group == plan.passes[2].group;
        assert_eq!(is_merged, !is_same, "{}", plan.to_text());
        let slot = |name| plan.textures.iter().find(|texture| texture.name == name).map(|texture| texture.slot);
        assert!(is_same || slot("mean") != slot("sampled"), "{}", plan.to_text());
        assert_eq!(is_memoryless(&plan, "color"), is_merged);
    }
}

/// A pass that samples depth does not draw in the render pass that writes it.
#[test]
fn depth_that_is_sampled_is_read_only_in_its_render_pass() {
    let mut graph = Graph::new(Limits { samples_attached_depth: true, ..Limits::WEBGL2 });
    let depth = graph.texture("depth", desc(8, F::Depth32Float));
    let radiance = graph.texture("radiance", desc(8, F::Rgba16Float));
    let mut pass = graph.pass("opaque");
    let radiance = pass.color(radiance, CLEAR);
    let depth = pass.depth_stencil(depth, CLEAR_DEPTH);
    pass.draw(|_| {});
    let mut pass = graph.pass("light");
    pass.read_depth(&depth);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil_read_only(&depth);
    pass.draw(|_| {});
    graph.export(radiance);
    let plan = graph.plan().expect("plans");
    assert_eq!((plan.render_passes, plan.bytes().memoryless), (2, 0), "{}", plan.to_text());
}

/// Memory that is there for another texture anyway is shared, so that nothing takes more than before.
#[test]
fn slots_are_shared_with_what_needs_memory() {
    let mut graph = graph();
    let [first, second] = ["first", "second"].map(|name| graph.texture(name, desc(8, F::Depth32Float)));
    let [a, b] = ["a", "b"].map(|name| graph.texture(name, desc(8, F::Rgba16Float)));
    let mut pass = graph.pass("a");
    let a = pass.color(a, CLEAR);
    pass.depth_stencil(first, CLEAR_DEPTH);
    let mut pass = graph.pass("b");
    let b = pass.color(b, CLEAR);
    let second = pass.depth_stencil(second, CLEAR_DEPTH);
    let mut pass = graph.pass("c");
    pass.read_depth(&second);
    let b = pass.color(b, ColorLoad::Keep);
    let shown = step(&mut graph, "shown", &[&a, &b]);
    graph.export(shown);
    let plan = graph.plan().expect("plans");
    let bytes = plan.bytes();
    // One depth, two of radiance, and what is shown.
    assert_eq!((bytes.aliased, bytes.memoryless), (64 * (4 + 8 + 8 + 4), 0), "{}", plan.to_text());
}
