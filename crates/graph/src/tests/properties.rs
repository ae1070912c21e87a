//! What holds for every frame, on random ones.

use proptest::prelude::*;
use wgpu::TextureFormat as F;

use super::{CLEAR, CLEAR_DEPTH, desc, graph, step};
use crate::graph::Source;
use crate::*;

const MIPS: u32 = 3;
const LAYERS: u32 = 2;

/// What a step does to a depth target of the size of its colour target.
#[derive(Clone, Copy, Debug, PartialEq)]
enum DepthUse {
    None,
    Clear,
    Keep,
    Test,
}

/// One step of a random frame: which view of which texture it draws to, how, and what it samples.
#[derive(Clone, Copy, Debug)]
struct Action {
    target: usize,
    mip: u32,
    layer: u32,
    keeps: bool,
    depth: DepthUse,
    /// Textures, each with whether all mips of it are sampled.
    reads: [Option<(usize, bool)>; 2],
    /// Whether it samples the depth target of the next smaller size.
    reads_depth: bool,
}

fn action() -> impl Strategy<Value = Action> {
    let read = || prop::option::of((0..4usize, any::<bool>()));
    let depth = prop::sample::select(vec![DepthUse::None, DepthUse::Clear, DepthUse::Keep, DepthUse::Test]);
    let view = (0..4usize, 0..MIPS, 0..LAYERS);
    (view, any::<bool>(), depth, read(), read(), any::<bool>()).prop_map(
        |((target, mip, layer), keeps, depth, a, b, reads_depth)| Action {
            target,
            mip,
            layer,
            keeps,
            depth,
            reads: [a, b],
            reads_depth,
        },
    )
}

/// A frame that is being declared, and what of it has been written. What nobody has written is neither read nor kept,
/// so that every frame is accepted.
struct Frame {
    graph: Graph<'static>,
    /// Arrays with mips; the first is imported.
    colors: Vec<Handle>,
    is_written: [[[bool; LAYERS as usize]; MIPS as usize]; 4],
    /// Depth targets of the sizes of the mips.
    depths: Vec<Option<Handle>>,
    is_depth_written: [bool; MIPS as usize],
}

impl Frame {
    fn new() -> Self {
        let mut graph = graph();
        let shape = TextureDesc { mips: MIPS, layers: LAYERS, ..desc(8, F::R32Float) };
        let colors = ["a", "b", "c", "d"].map(|name| {
            let source = if name == "a" { Source::Fake } else { Source::Transient };
            graph.add_texture(name.into(), shape, source)
        });
        let depths = (0..MIPS).map(|mip| Some(graph.texture("depth", desc(8 >> mip, F::Depth32Float)))).collect();
        let mut is_written = [Default::default(); 4];
        is_written[0] = [[true; LAYERS as usize]; MIPS as usize];
        Self { graph, colors: colors.into(), is_written, depths, is_depth_written: Default::default() }
    }

    fn declare(&mut self, action: &Action) {
        let target = self.graph.subview(&self.colors[action.target], action.mip, action.layer);
        let next = (action.mip + 1) % MIPS;
        let mips = |is_whole| if is_whole { 0..MIPS } else { next..next + 1 };
        let can_read = |&&(texture, is_whole): &&(usize, bool)| {
            let is_there = mips(is_whole).all(|mip| self.is_written[texture][mip as usize] == [true; LAYERS as usize]);
            is_there && !(texture == action.target && is_whole)
        };
        let wanted: Vec<(usize, bool)> = action.reads.iter().flatten().filter(can_read).copied().collect();
        let reads: Vec<Handle> = wanted
            .iter()
            .map(|&(texture, is_whole)| self.graph.subresources(&self.colors[texture], mips(is_whole), 0..LAYERS))
            .collect();
        let written = &mut self.is_written[action.target][action.mip as usize][action.layer as usize];
        let has_contents = std::mem::replace(written, true);
        let mut pass = self.graph.pass("step");
        pass.color(target, if action.keeps && has_contents { ColorLoad::Keep } else { CLEAR });
        if action.reads_depth && self.is_depth_written[next as usize] {
            pass.read_depth(self.depths[next as usize].as_ref().expect("there"));
        }
        let depth = self.depths[action.mip as usize].take().expect("there");
        let has_depth = self.is_depth_written[action.mip as usize];
        self.is_depth_written[action.mip as usize] |= action.depth != DepthUse::None;
        self.depths[action.mip as usize] = Some(match action.depth {
            DepthUse::None => depth,
            DepthUse::Keep if has_depth => pass.depth_stencil(depth, DepthLoad::Keep),
            DepthUse::Test if has_depth => {
                pass.depth_stencil_read_only(&depth);
                depth
            }
            _ => pass.depth_stencil(depth, CLEAR_DEPTH),
        });
        for read in &reads {
            pass.read(read);
        }
    }

    /// Plans the frame with a result: `export` if all of it is written, else the imported texture.
    fn plan(mut self, export: usize) -> Plan {
        let is_whole = self.is_written[export].as_flattened().iter().all(|is_written| *is_written);
        self.graph.export(self.colors.swap_remove(if is_whole { export } else { 0 }));
        self.graph.plan().expect("plans")
    }
}

proptest! {
    /// Frames of arrays with mips, depth, kept contents, imports and views: a plan never reads what is not there, drops
    /// nothing that is read later, runs nothing in vain, and gives no memory to two textures at once.
    #[test]
    fn plans_of_any_frame_are_sound(actions in prop::collection::vec(action(), 1..32), export in 0..4usize) {
        let mut frame = Frame::new();
        actions.iter().for_each(|action| frame.declare(action));
        check_plan(&frame.plan(export))?;
    }
}

/// Replays a plan on the contents of every view: whether they are there, and whether they were stored.
fn check_plan(plan: &Plan) -> Result<(), TestCaseError> {
    #[derive(Clone, Copy, PartialEq)]
    enum Contents {
        None,
        Stored,
        Dropped,
    }
    let mut contents: Vec<Vec<Contents>> = plan
        .textures
        .iter()
        .map(|texture| {
            let imported = if texture.imported { Contents::Stored } else { Contents::None };
            vec![imported; texture.desc.subresources() as usize]
        })
        .collect();
    for (index, pass) in plan.passes.iter().enumerate() {
        let at = index as u32;
        for read in &pass.reads {
            let texture = &plan.textures[read.texture as usize];
            prop_assert!(texture.first <= at && at <= texture.last);
            for place in read.view.unwrap_or(SubresourceRange::whole(&texture.desc)).subresources(&texture.desc) {
                let found = contents[read.texture as usize][place as usize];
                prop_assert!(found == Contents::Stored, "{}", plan.to_text());
            }
        }
        let is_merged = index > 0 && plan.passes[index - 1].group == pass.group;
        for attachment in &pass.attachments {
            let texture = &plan.textures[attachment.texture as usize];
            prop_assert!(texture.first <= at && at <= texture.last);
            let place = attachment.layer * texture.desc.mips + attachment.mip;
            let slot = &mut contents[attachment.texture as usize][place as usize];
            // Within a render pass contents stay; between two they must have been stored.
            prop_assert!(attachment.load != Load::Keep || is_merged || *slot == Contents::Stored, "{}", plan.to_text());
            let mut alike =
                plan.passes.iter().filter(|other| other.group == pass.group).flat_map(|pass| &pass.attachments);
            // Depth that is tested in the render pass that writes it is stored or dropped with it.
            let is_written = attachment.target != Target::DepthReadOnly
                || alike.any(|other| other.target == Target::DepthStencil && other.texture == attachment.texture);
            if is_written {
                *slot = if attachment.store { Contents::Stored } else { Contents::Dropped };
            }
        }
        let mut written = pass.attachments.iter().filter(|attachment| attachment.target != Target::DepthReadOnly);
        prop_assert!(written.any(|attachment| attachment.store), "{}", plan.to_text());
    }
    for (index, a) in plan.textures.iter().enumerate() {
        for b in &plan.textures[..index] {
            let overlap = a.first <= b.last && b.first <= a.last;
            let is_shared = a.slot.is_some() && a.slot == b.slot;
            prop_assert!(!(overlap && is_shared), "{}", plan.to_text());
            prop_assert!(!is_shared || a.memoryless == b.memoryless, "{}", plan.to_text());
        }
        prop_assert!(!a.memoryless || needs_no_memory(plan, index as u32), "{}", plan.to_text());
        if a.exported {
            prop_assert!(contents[index].iter().all(|found| *found == Contents::Stored), "{}", plan.to_text());
        }
    }
    Ok(())
}

/// Whether a texture is cleared, drawn to and dropped within one render pass.
fn needs_no_memory(plan: &Plan, texture: u32) -> bool {
    let uses = plan.passes.iter().flat_map(|pass| pass.attachments.iter().map(move |used| (pass.group, used)));
    let uses: Vec<_> = uses.filter(|(_, used)| used.texture == texture).collect();
    let is_sampled = plan.passes.iter().flat_map(|pass| &pass.reads).any(|read| read.texture == texture);
    let outlives = plan.textures[texture as usize].exported || plan.textures[texture as usize].imported;
    let is_in_one = uses.windows(2).all(|pair| pair[0].0 == pair[1].0);
    let is_new = uses.first().is_some_and(|(_, first)| first.load != Load::Keep);
    let is_dropped = uses.last().is_some_and(|(_, last)| !last.store);
    !is_sampled && !outlives && is_in_one && is_new && is_dropped
}

/// A frame in which every kind of use occurs.
fn sound_plan() -> Plan {
    let mut frame = Frame::new();
    let plain = Action {
        target: 1,
        mip: 0,
        layer: 0,
        keeps: false,
        depth: DepthUse::None,
        reads: [None; 2],
        reads_depth: false,
    };
    for view in 0..MIPS * LAYERS {
        frame.declare(&Action { mip: view / LAYERS, layer: view % LAYERS, depth: DepthUse::Clear, ..plain });
    }
    frame.declare(&Action { keeps: true, depth: DepthUse::Keep, ..plain });
    frame.declare(&Action { keeps: true, depth: DepthUse::Test, ..plain });
    frame.declare(&Action { target: 0, mip: 2, reads: [Some((1, true)), None], reads_depth: true, ..plain });
    frame.plan(0)
}

#[test]
fn the_replay_refuses_plans_that_are_spoilt() {
    let plan = sound_plan();
    check_plan(&plan).expect("sound");
    let is_refused = |spoil: &dyn Fn(&mut Plan)| {
        let mut spoilt = plan.clone();
        spoil(&mut spoilt);
        assert_ne!(spoilt, plan, "nothing was spoilt");
        check_plan(&spoilt).is_err()
    };
    let stored = |plan: &Plan| {
        let each = plan.passes.iter().enumerate();
        each.flat_map(|(pass, planned)| (0..planned.attachments.len()).map(move |at| (pass, at)))
            .filter(|(pass, at)| plan.passes[*pass].attachments[*at].store)
            .collect::<Vec<_>>()
    };
    let is_merged = |pass: usize| plan.passes.get(pass + 1).is_some_and(|next| next.group == plan.passes[pass].group);
    // Within a render pass nothing is stored between its parts.
    for (pass, at) in stored(&plan).into_iter().filter(|(pass, _)| !is_merged(*pass)) {
        assert!(is_refused(&|plan| plan.passes[pass].attachments[at].store = false), "{pass} {at}\n{}", plan.to_text());
    }
    for pass in 0..MIPS as usize * LAYERS as usize {
        assert!(is_refused(&|plan| plan.passes[pass].attachments[0].load = Load::Keep), "kept although it is new");
        assert!(is_refused(&|plan| drop(plan.passes.remove(pass))), "a pass is missing");
    }
    assert!(is_refused(&|plan| plan.textures[0].last -= 1), "its life ends too early");
    let transient: Vec<usize> = (0..plan.textures.len()).filter(|at| plan.textures[*at].slot.is_some()).collect();
    for texture in transient.iter().copied().filter(|texture| !needs_no_memory(&plan, *texture as u32)) {
        assert!(is_refused(&|plan| plan.textures[texture].memoryless = true), "{texture} keeps something");
    }
    assert!(
        is_refused(&|plan| plan.textures[transient[1]].slot = plan.textures[transient[0]].slot),
        "shared too early"
    );
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
