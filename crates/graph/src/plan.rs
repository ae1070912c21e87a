//! The plan of a frame as plain data, and how it follows from the declarations.

use std::borrow::Cow;
use std::ops::Range;

use serde::Serialize;

use crate::TextureDesc;
use crate::check::{desc_of, subresource_bases};
use crate::graph::{ColorLoad, DepthLoad, Graph, PassNode, Source, Use, UseKind};
use crate::subresource::SubresourceRange;

/// How a frame will be executed. Plain data: print it with [`Plan::to_text`],
/// [`Plan::to_json`] or [`Plan::to_mermaid`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The passes that run, in order.
    pub passes: Vec<PlannedPass>,
    /// Names of the passes that nothing needs.
    pub culled: Vec<Cow<'static, str>>,
    /// The textures that the passes use.
    pub textures: Vec<PlannedTexture>,
    /// Descriptors of the physical textures that transient ones share.
    pub slots: Vec<TextureDesc>,
    /// Number of render passes when neighbours are merged.
    pub render_passes: u32,
    #[serde(skip)]
    pub(crate) graph: u32,
}

/// A pass that runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedPass {
    /// Debug label, timer and report key.
    pub name: Cow<'static, str>,
    /// Place in the order of declaration, counting culled passes.
    pub declared: u32,
    /// Passes with equal groups are recorded as one render pass.
    pub group: u32,
    /// Size of the attachments in texels.
    pub size: (u32, u32),
    /// Draw calls, of passes that count them ([`crate::Pass::count_draws`]) or draw nothing.
    pub draws: Option<u32>,
    /// What the pass draws to, colour targets in slot order.
    pub attachments: Vec<PlannedAttachment>,
    /// What the pass samples.
    pub reads: Vec<PlannedRead>,
}

/// Which kind of attachment a view is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Target {
    /// Colour target at this slot.
    Color(u32),
    /// Depth-stencil target, written.
    DepthStencil,
    /// Depth-stencil target, tested only.
    DepthReadOnly,
    /// The mean of the samples of the colour target at this slot.
    Resolve(u32),
}

/// What happens to an attachment when its pass begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Load {
    /// It is set to the pass's clear value.
    Clear,
    /// It keeps its contents.
    Keep,
    /// Its contents do not matter.
    Discard,
}

/// A view that a pass draws to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PlannedAttachment {
    /// Where it is attached.
    pub target: Target,
    /// Index into [`Plan::textures`].
    pub texture: u32,
    /// Mip level.
    pub mip: u32,
    /// Array layer.
    pub layer: u32,
    /// What it holds at first.
    pub load: Load,
    /// Whether the result is stored; otherwise it is discarded. Passes of one group keep it between each other: the last
    /// of them that attaches it counts.
    pub store: bool,
    #[serde(skip)]
    pub(crate) use_index: u32,
}

/// A texture or view that a pass samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PlannedRead {
    /// Index into [`Plan::textures`].
    pub texture: u32,
    /// Mips and layers of a view; `None` is the whole texture.
    pub view: Option<SubresourceRange>,
    #[serde(skip)]
    pub(crate) use_index: u32,
}

/// A texture that the frame uses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedTexture {
    /// Debug label.
    pub name: Cow<'static, str>,
    /// Its shape.
    pub desc: TextureDesc,
    /// Whether it outlives the frame.
    pub imported: bool,
    /// Whether it is a result of the frame.
    pub exported: bool,
    /// Whether a pass samples it.
    pub sampled: bool,
    /// Whether it needs no memory on adapters that draw tile by tile, each in memory of the chip: it is cleared, drawn
    /// to and dropped within one render pass, and so is all that it shares its slot with.
    pub memoryless: bool,
    /// Index into [`Plan::slots`]; `None` if imported.
    pub slot: Option<u32>,
    /// First use, an index into [`Plan::passes`]; of means the first pass of their render pass.
    pub first: u32,
    /// Last use, an index into [`Plan::passes`]; the last pass if exported.
    pub last: u32,
    #[serde(skip)]
    pub(crate) declared: u32,
}

/// Texture memory of a plan. Taps are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PlanBytes {
    /// Physical memory of transient textures.
    pub aliased: u64,
    /// What transient textures would take if none shared memory.
    pub unaliased: u64,
    /// What of `aliased` needs no memory on adapters that draw tile by tile ([`PlannedTexture::memoryless`]).
    pub memoryless: u64,
    /// Memory of imported textures that the frame uses.
    pub imported: u64,
}

impl Plan {
    /// Texture memory of this plan.
    pub fn bytes(&self) -> PlanBytes {
        let sum = |imported: bool| {
            let textures = self.textures.iter();
            let wanted = textures.filter(|texture| texture.imported == imported);
            wanted.map(|texture| texture.desc.bytes()).sum()
        };
        let memoryless = self.slots.iter().zip(self.memoryless_slots()).filter(|(_, memoryless)| *memoryless);
        PlanBytes {
            aliased: self.slots.iter().map(TextureDesc::bytes).sum(),
            unaliased: sum(false),
            memoryless: memoryless.map(|(desc, _)| desc.bytes()).sum(),
            imported: sum(true),
        }
    }

    /// Whether each slot serves textures alone that need no memory.
    pub(crate) fn memoryless_slots(&self) -> Vec<bool> {
        let mut slots = vec![false; self.slots.len()];
        for texture in self.textures.iter().filter(|texture| texture.memoryless) {
            if let Some(slot) = texture.slot.and_then(|slot| slots.get_mut(slot as usize)) {
                *slot = true;
            }
        }
        slots
    }
}

/// What a pass draws and moves.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PassWork {
    /// Name of the pass.
    pub name: Cow<'static, str>,
    /// [`PlannedPass::draws`].
    pub draws: Option<u32>,
    /// Bytes of what it samples, each texture or view once.
    pub read: u64,
    /// Bytes of what it draws to, each target once.
    pub written: u64,
}

impl Plan {
    /// Bytes that the passes write if each covers its targets once, as full-screen passes do and as surfaces do without
    /// overdraw.
    pub fn written_bytes(&self) -> u64 {
        self.passes.iter().map(|pass| self.written_by(pass)).sum()
    }

    /// Bytes that the passes read if each looks at all that it samples once: caches give it what it looks at again, and
    /// what it leaves out is counted all the same. Attachments that are tested or blended with are not counted.
    pub fn read_bytes(&self) -> u64 {
        self.passes.iter().map(|pass| self.read_by(pass)).sum()
    }

    /// What each pass draws and moves, in their order: the parts of [`Self::read_bytes`] and [`Self::written_bytes`].
    pub fn pass_work(&self) -> Vec<PassWork> {
        let of_pass = |pass: &PlannedPass| PassWork {
            name: pass.name.clone(),
            draws: pass.draws,
            read: self.read_by(pass),
            written: self.written_by(pass),
        };
        self.passes.iter().map(of_pass).collect()
    }

    fn written_by(&self, pass: &PlannedPass) -> u64 {
        let written = pass.attachments.iter().filter(|attachment| attachment.target != Target::DepthReadOnly);
        let bytes = written.filter_map(|attachment| {
            let desc = self.textures.get(attachment.texture as usize)?.desc;
            Some(
                TextureDesc { samples: desc.samples, ..TextureDesc::new_2d(pass.size.0, pass.size.1, desc.format) }
                    .bytes(),
            )
        });
        bytes.sum()
    }

    fn read_by(&self, pass: &PlannedPass) -> u64 {
        let bytes = pass.reads.iter().enumerate().filter_map(|(at, read)| {
            // A pass that samples one view twice, by two samplers, finds it in the caches.
            let is_again =
                pass.reads[..at].iter().any(|earlier| (earlier.texture, earlier.view) == (read.texture, read.view));
            let desc = self.textures.get(read.texture as usize).filter(|_| !is_again)?.desc;
            Some(read.view.map_or(desc, |view| view.desc(&desc)).bytes())
        });
        bytes.sum()
    }
}

/// Plans a graph that has passed [`crate::check::check`].
///
/// Allocates two lists a pass, because they are part of the plan.
pub(crate) fn plan(graph: &Graph<'_>) -> Plan {
    let (live, stored) = cull(graph);
    let mut plan = Plan {
        passes: Vec::with_capacity(graph.passes.len()),
        culled: Vec::new(),
        textures: Vec::with_capacity(graph.textures.len()),
        slots: Vec::new(),
        render_passes: 0,
        graph: graph.id,
    };
    // From the graph's textures to the plan's.
    let mut planned = vec![None; graph.textures.len()];
    for (index, pass) in graph.passes.iter().enumerate() {
        if live[index] {
            let pass = plan_pass(graph, index, pass, &stored, &mut plan, &mut planned);
            plan.passes.push(pass);
        } else {
            plan.culled.push(pass.name.clone());
        }
    }
    let last_pass = plan.passes.len().saturating_sub(1) as u32;
    for &(texture, _) in &graph.exports {
        if let Some(index) = planned[texture as usize] {
            let texture: &mut PlannedTexture = &mut plan.textures[index as usize];
            texture.exported = true;
            texture.last = last_pass;
        }
    }
    merge(graph, &mut plan);
    mark_memoryless(&mut plan);
    share_slots(&mut plan);
    plan
}

fn uses_of(pass: &PassNode<'_>) -> Range<usize> {
    pass.uses.start as usize..pass.uses.end as usize
}

/// Walks backwards from the results. Returns which passes run, and for each attachment
/// whether what it holds after its pass is needed.
fn cull(graph: &Graph<'_>) -> (Vec<bool>, Vec<bool>) {
    let (bases, total) = subresource_bases(graph);
    let subresources = |texture: u32, part: SubresourceRange| {
        let base = bases[texture as usize];
        part.subresources(&graph.textures[texture as usize].desc).map(move |place| (base + place) as usize)
    };
    let mut wanted = vec![false; total as usize];
    for &(texture, part) in &graph.exports {
        subresources(texture, part).for_each(|subresource| wanted[subresource] = true);
    }
    // What the next frame will read is a result of this one.
    for (texture, node) in (0..).zip(&graph.textures) {
        if matches!(node.source, Source::History { is_next: true, .. }) {
            subresources(texture, SubresourceRange::whole(&node.desc))
                .for_each(|subresource| wanted[subresource] = true);
        }
    }
    let mut live = vec![false; graph.passes.len()];
    let mut stored = vec![false; graph.uses.len()];
    for (index, pass) in graph.passes.iter().enumerate().rev() {
        let uses = &graph.uses[uses_of(pass)];
        let is_wanted = |used: &Use| subresources(used.texture, used.part).any(|subresource| wanted[subresource]);
        let needed = uses.iter().any(|used| used.kind.is_write() && is_wanted(used));
        if !needed && !pass.side_effect {
            continue;
        }
        live[index] = true;
        for (offset, used) in uses.iter().enumerate() {
            let persistent = graph.textures[used.texture as usize].is_persistent();
            stored[pass.uses.start as usize + offset] = used.kind.is_attachment() && (persistent || is_wanted(used));
        }
        // An attachment is one subresource and a load that ignores its contents
        // replaces all of it, so that earlier writers are not needed for it.
        for used in uses {
            let needs = used.kind.needs_contents();
            subresources(used.texture, used.part).for_each(|subresource| wanted[subresource] = needs);
        }
    }
    (live, stored)
}

fn plan_pass(
    graph: &Graph<'_>,
    declared: usize,
    pass: &PassNode<'_>,
    stored: &[bool],
    plan: &mut Plan,
    planned: &mut [Option<u32>],
) -> PlannedPass {
    let at = plan.passes.len() as u32;
    let uses = &graph.uses[uses_of(pass)];
    let attachment_count = uses.iter().filter(|used| used.kind.is_attachment()).count();
    let mut result = PlannedPass {
        name: pass.name.clone(),
        declared: declared as u32,
        group: 0,
        size: (0, 0),
        draws: if pass.run.is_some() { pass.draws } else { Some(0) },
        attachments: Vec::with_capacity(attachment_count),
        reads: Vec::with_capacity(uses.len() - attachment_count),
    };
    let mut color_slot = 0;
    for (use_index, used) in (pass.uses.start..).zip(uses) {
        let texture = *planned[used.texture as usize].get_or_insert_with(|| {
            let node = &graph.textures[used.texture as usize];
            plan.textures.push(PlannedTexture {
                name: node.name.clone(),
                desc: node.desc,
                imported: node.is_persistent(),
                exported: false,
                sampled: false,
                memoryless: false,
                slot: None,
                first: at,
                last: at,
                declared: used.texture,
            });
            plan.textures.len() as u32 - 1
        });
        plan.textures[texture as usize].last = at;
        let (target, load) = match used.kind {
            UseKind::Sampled { .. } => {
                plan.textures[texture as usize].sampled = true;
                let whole = SubresourceRange::whole(&graph.textures[used.texture as usize].desc);
                let view = Some(used.part).filter(|part| *part != whole);
                result.reads.push(PlannedRead { texture, view, use_index });
                continue;
            }
            UseKind::Color(load) => {
                color_slot += 1;
                let load = match load {
                    ColorLoad::Clear(_) => Load::Clear,
                    ColorLoad::Keep => Load::Keep,
                    ColorLoad::Discard => Load::Discard,
                };
                (Target::Color(color_slot - 1), load)
            }
            UseKind::DepthStencil(DepthLoad::Clear { .. }) => (Target::DepthStencil, Load::Clear),
            UseKind::DepthStencil(DepthLoad::Keep) => (Target::DepthStencil, Load::Keep),
            UseKind::DepthReadOnly => (Target::DepthReadOnly, Load::Keep),
            // The check has found a colour target before it.
            UseKind::Resolve => (Target::Resolve(color_slot.max(1) - 1), Load::Discard),
        };
        let desc = desc_of(graph, used);
        result.size = (desc.width, desc.height);
        result.attachments.push(PlannedAttachment {
            target,
            texture,
            mip: used.part.mip,
            layer: used.part.layer,
            load,
            store: stored[use_index as usize],
            use_index,
        });
    }
    result
}

/// Gives neighbours on the same attachments one group: what is drawn over the same targets, tests the depth that is
/// there, or takes the mean of a target without drawing anything.
fn merge(graph: &Graph<'_>, plan: &mut Plan) {
    let mut group = 0;
    for index in 1..plan.passes.len() {
        let (before, rest) = plan.passes.split_at_mut(index);
        let begin = before.iter().rposition(|earlier| earlier.group != group).map_or(0, |last| last + 1);
        let pass = &mut rest[0];
        let draws = graph.passes[pass.declared as usize].run.is_some();
        if continues(&before[begin..], pass, draws) {
            // Means are attached from the beginning of the render pass: nothing that it reads may lie in their memory.
            for mean in pass.attachments.iter().filter(is_mean) {
                let texture = &mut plan.textures[mean.texture as usize];
                texture.first = texture.first.min(begin as u32);
            }
        } else {
            group += 1;
        }
        pass.group = group;
    }
    plan.render_passes = if plan.passes.is_empty() { 0 } else { group + 1 };
}

/// Whether an attachment becomes the mean of the samples of another one.
pub(crate) fn is_mean(attachment: &&PlannedAttachment) -> bool {
    matches!(attachment.target, Target::Resolve(_))
}

/// Whether a pass can be recorded in the render pass of those before it, which attaches what the first of them does.
/// No pass of a group can sample a colour target of it: all attach the same views, and to sample an attached view that is
/// written is feedback, which the check refuses. Depth that is only tested is looked at here.
fn continues(group: &[PlannedPass], pass: &PlannedPass, draws: bool) -> bool {
    let Some(previous) = group.last() else { return false };
    // The mean is taken when the render pass ends, of all that was drawn until then.
    if previous.attachments.iter().any(|attachment| is_mean(&attachment)) {
        return false;
    }
    let is_attached = |wanted: &PlannedAttachment| {
        let is_there = |there: &PlannedAttachment| {
            let same_view = (there.texture, there.mip, there.layer) == (wanted.texture, wanted.mip, wanted.layer);
            let tests_what_is_written = (there.target, wanted.target) == (Target::DepthStencil, Target::DepthReadOnly);
            same_view && (there.target == wanted.target || tests_what_is_written)
        };
        wanted.load == Load::Keep && previous.attachments.iter().any(is_there)
    };
    let drawn_to = || pass.attachments.iter().filter(|attachment| !is_mean(attachment));
    // Pipelines name all targets of a render pass; what draws nothing has none.
    let is_whole = drawn_to().count() == previous.attachments.len();
    let only_resolves = !draws && pass.attachments.iter().any(|attachment| is_mean(&attachment));
    let written_depth = group[0].attachments.iter().find(|attachment| attachment.target == Target::DepthStencil);
    let samples_it = written_depth.is_some_and(|depth| pass.reads.iter().any(|read| read.texture == depth.texture));
    let mut reads = group.iter().flat_map(|earlier| &earlier.reads);
    let replaces_what_is_read =
        reads.any(|read| pass.attachments.iter().filter(is_mean).any(|mean| mean.texture == read.texture));
    (is_whole || only_resolves) && drawn_to().all(is_attached) && !samples_it && !replaces_what_is_read
}

/// Whether the last of these passes that attaches what `attachment` does leaves something there that is needed.
pub(crate) fn is_stored(passes: &[PlannedPass], attachment: &PlannedAttachment) -> bool {
    let view = |of: &PlannedAttachment| (of.texture, of.mip, of.layer);
    let mut ends = passes.iter().rev().flat_map(|pass| &pass.attachments);
    ends.find(|end| view(end) == view(attachment)).is_some_and(|end| end.store)
}

/// Marks textures of one view that are drawn to within one render pass and whose contents nobody needs before or after
/// it.
fn mark_memoryless(plan: &mut Plan) {
    let Plan { passes, textures, .. } = plan;
    for (index, texture) in (0_u32..).zip(textures) {
        let lives = &passes[texture.first as usize..=texture.last as usize];
        let is_in_one = lives.first().map(|pass| pass.group) == lives.last().map(|pass| pass.group);
        let is_needed = texture.imported || texture.exported || texture.sampled;
        if is_needed || !is_in_one || texture.desc.subresources() != 1 {
            continue;
        }
        let uses = || lives.iter().flat_map(|pass| &pass.attachments).filter(|used| used.texture == index);
        let is_new = uses().next().is_some_and(|used| used.load != Load::Keep);
        let is_dropped = uses().next_back().is_some_and(|used| !used.store);
        texture.memoryless = is_new && is_dropped && !uses().any(|used| is_mean(&used));
    }
}

/// Assigns transient textures to slots: a slot is free again after the pass of
/// the last use. Of free slots those come first that need memory as the texture does, or need none as it.
fn share_slots(plan: &mut Plan) {
    let Plan { textures, slots, .. } = plan;
    // The pass until which each slot is taken, and whether it needs no memory.
    let mut states: Vec<(u32, bool)> = Vec::new();
    // Textures lie in the order of their first use already.
    for texture in textures.iter_mut().filter(|texture| !texture.imported) {
        let is_free = |slot: usize| slots[slot] == texture.desc && states[slot].0 < texture.first;
        let alike = (0..slots.len()).find(|&slot| is_free(slot) && states[slot].1 == texture.memoryless);
        let free = alike.or_else(|| (0..slots.len()).find(|&slot| is_free(slot)));
        let slot = free.unwrap_or_else(|| {
            slots.push(texture.desc);
            states.push((0, texture.memoryless));
            slots.len() - 1
        });
        states[slot].0 = texture.last;
        states[slot].1 &= texture.memoryless;
        texture.slot = Some(slot as u32);
    }
    for texture in textures {
        texture.memoryless &= texture.slot.is_some_and(|slot| states[slot as usize].1);
    }
}
