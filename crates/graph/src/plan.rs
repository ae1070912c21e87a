//! The plan of a frame as plain data, and how it follows from the declarations.

use std::borrow::Cow;
use std::ops::Range;

use serde::Serialize;

use crate::TextureDesc;
use crate::check::{desc_of, subresource_bases};
use crate::graph::{ColorLoad, DepthLoad, Graph, PassNode, Source, Use, UseKind};
use crate::part::Part;

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
    /// Whether the result is stored; otherwise it is discarded.
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
    pub view: Option<Part>,
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
    /// Index into [`Plan::slots`]; `None` if imported.
    pub slot: Option<u32>,
    /// First use, an index into [`Plan::passes`].
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
        PlanBytes {
            aliased: self.slots.iter().map(TextureDesc::bytes).sum(),
            unaliased: sum(false),
            imported: sum(true),
        }
    }
}

/// What a pass moves.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PassBytes {
    /// Name of the pass.
    pub name: Cow<'static, str>,
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

    /// What each pass moves, in their order: the parts of [`Self::read_bytes`] and [`Self::written_bytes`].
    pub fn pass_bytes(&self) -> Vec<PassBytes> {
        let of_pass = |pass: &PlannedPass| PassBytes {
            name: pass.name.clone(),
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
    merge(&mut plan);
    share_slots(&mut plan);
    plan
}

fn uses_of(pass: &PassNode<'_>) -> Range<usize> {
    pass.uses.start as usize..pass.uses.end as usize
}

/// Walks backwards from the results. Returns which passes run, and for each use
/// that writes whether what it writes is needed afterwards.
fn cull(graph: &Graph<'_>) -> (Vec<bool>, Vec<bool>) {
    let (bases, total) = subresource_bases(graph);
    let subresources = |texture: u32, part: Part| {
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
            subresources(texture, Part::whole(&node.desc)).for_each(|subresource| wanted[subresource] = true);
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
            stored[pass.uses.start as usize + offset] = used.kind.is_write() && (persistent || is_wanted(used));
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
                let whole = Part::whole(&graph.textures[used.texture as usize].desc);
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

/// Gives neighbours on the same attachments one group. No pass of a group can sample what the group writes: all attach
/// the same views in the same way, and to sample an attached view that is written is feedback, which the check refuses.
fn merge(plan: &mut Plan) {
    let mut group = 0;
    for index in 1..plan.passes.len() {
        let (before, rest) = plan.passes.split_at_mut(index);
        let (previous, pass) = (&before[index - 1], &mut rest[0]);
        let same = previous.attachments.len() == pass.attachments.len()
            && previous.attachments.iter().zip(&pass.attachments).all(|(a, b)| {
                let same_view = (a.texture, a.mip, a.layer) == (b.texture, b.mip, b.layer);
                same_view && a.target == b.target && b.load == Load::Keep
            });
        group += u32::from(!same);
        pass.group = group;
    }
    plan.render_passes = if plan.passes.is_empty() { 0 } else { group + 1 };
}

/// Assigns transient textures to slots: a slot is free again after the pass of
/// the last use.
fn share_slots(plan: &mut Plan) {
    // The pass until which each slot is taken.
    let mut taken_until: Vec<u32> = Vec::new();
    // Textures lie in the order of their first use already.
    for texture in plan.textures.iter_mut().filter(|texture| !texture.imported) {
        let free =
            (0..plan.slots.len()).find(|&slot| plan.slots[slot] == texture.desc && taken_until[slot] < texture.first);
        let slot = free.unwrap_or_else(|| {
            plan.slots.push(texture.desc);
            taken_until.push(0);
            plan.slots.len() - 1
        });
        taken_until[slot] = texture.last;
        texture.slot = Some(slot as u32);
    }
}
