//! Recording a plan into a command encoder.

use crate::graph::{ColorLoad, DepthLoad, Graph, ReadKey, RunFn, Source, UseKind};
use crate::plan::{Plan, PlannedAttachment, PlannedPass, PlannedRead, Target, is_mean, is_stored};
use crate::pool::{Histories, MEMORYLESS, Pool, imported_view, view_key};
use crate::report::{PassTime, Run};
use crate::subresource::SubresourceRange;
use crate::tap::{self, Taps};
use crate::times::Times;
use crate::{Limits, PlanError, TextureDesc};
use std::cell::Cell;

/// What to measure and keep while running.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions<'a> {
    /// What to copy of what passes write. To copy everything turns off the merging of passes.
    pub taps: Taps<'a>,
    /// Whether to measure GPU time of every pass, if the device has `TIMESTAMP_QUERY`. It turns off the merging of
    /// passes.
    pub time: Timing,
    /// Whether the next frame finds histories as this one did: of a frame that is looked at beside those that follow
    /// each other.
    pub leaves_histories: bool,
}

/// Whether passes are timed, and who reads the times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// They are not.
    #[default]
    Off,
    /// [`Run::read`] waits for them.
    Once,
    /// [`Executor::latest_times`] has them some frames later, and nobody waits. While all buffers of the ring are under
    /// way, frames are not timed.
    Live,
}

/// What a pass is given to draw with.
pub struct PassContext<'a, 'pass> {
    /// Where to record draws. Viewport and scissor cover the target; pipeline and
    /// bind groups are undefined.
    pub render_pass: &'a mut wgpu::RenderPass<'pass>,
    /// The device.
    pub device: &'a wgpu::Device,
    /// The queue.
    pub queue: &'a wgpu::Queue,
    name: &'a str,
    size: (u32, u32),
    graph: u32,
    reads: &'a [PlannedRead],
    views: &'a [Option<wgpu::TextureView>],
    /// Whether it asked for what it has not declared.
    is_misused: &'a Cell<bool>,
}

impl PassContext<'_, '_> {
    /// The view behind a read that the pass has declared. Of another pass's there is none: draw nothing then, because
    /// [`Executor::run`] gives an error.
    pub fn view(&self, read: ReadKey) -> Option<&wgpu::TextureView> {
        let is_declared =
            read.graph == self.graph && self.reads.iter().any(|declared| declared.use_index == read.use_index);
        let view = self.views.get(read.use_index as usize).and_then(Option::as_ref).filter(|_| is_declared);
        if view.is_none() {
            self.is_misused.set(true);
        }
        view
    }

    /// Width and height of the attachments in texels.
    pub fn target_size(&self) -> (u32, u32) {
        self.size
    }

    /// Name of the pass.
    pub fn name(&self) -> &str {
        self.name
    }
}

/// Runs plans. Owns the textures behind transient handles and keeps them between
/// frames.
pub struct Executor {
    pub(crate) device: wgpu::Device,
    queue: wgpu::Queue,
    pool: Pool,
    histories: Histories,
    times: Times,
    pub(crate) can_copy_depth: bool,
    /// Whether it costs time to clear targets, and none to keep what they hold: on adapters that draw in memory.
    clears_cost: bool,
    /// Whether attachments that need no memory are made without ([`Executor::set_memoryless`]).
    memoryless: bool,
}

/// A texture of fewer texels takes no memory that would have to be given back at once: 16 KiB of four bytes each.
const SMALL_TEXELS: u32 = 64 * 64;

/// What the textures behind the slots of a plan have to be; `memoryless` says whether they may lack memory. What is copied
/// or timed pass by pass has its render passes cut, between which only memory keeps anything.
fn slot_shapes(plan: &Plan, options: &RunOptions<'_>, memoryless: bool) -> Vec<(TextureDesc, wgpu::TextureUsages)> {
    let memoryless = memoryless && matches!(options.taps, Taps::None) && options.time == Timing::Off;
    let usage = |lacks_memory: bool| {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
        if memoryless && lacks_memory { usage | MEMORYLESS } else { usage }
    };
    let slots = plan.slots.iter().zip(plan.memoryless_slots());
    let mut shapes: Vec<_> = slots.map(|(desc, lacks_memory)| (*desc, usage(lacks_memory))).collect();
    for texture in &plan.textures {
        let Some((_, usage)) = texture.slot.and_then(|slot| shapes.get_mut(slot as usize)) else { continue };
        if texture.sampled || texture.exported {
            *usage |= wgpu::TextureUsages::TEXTURE_BINDING;
        }
        // WebGL 2 has no textures of several samples, but what is only drawn to.
        if texture.desc.samples > 1 {
            continue;
        }
        if texture.exported || options.taps.may_copy(&texture.name) {
            *usage |= wgpu::TextureUsages::COPY_SRC;
        }
    }
    shapes
}

/// The textures and views of one run.
pub(crate) struct Resources {
    /// Per planned texture.
    pub(crate) textures: Vec<wgpu::Texture>,
    /// Per use of the graph.
    views: Vec<Option<wgpu::TextureView>>,
}

impl Executor {
    /// An executor without textures.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            pool: Pool::default(),
            histories: Histories::default(),
            times: Times::new(device, queue),
            can_copy_depth: device.adapter_info().backend != wgpu::Backend::Gl,
            clears_cost: device.adapter_info().device_type == wgpu::DeviceType::Cpu,
            memoryless: device.adapter_info().transient_saves_memory == Some(true),
        }
    }

    /// Whether textures of which [`Plan`] says so ([`crate::PlannedTexture::memoryless`]) are made without memory
    /// (`TRANSIENT_ATTACHMENT`). At first they are where the adapter says that it saves memory: on GPUs of phones and of
    /// Apple's. In browsers they are not: those that do not know the usage refuse it.
    pub fn set_memoryless(&mut self, memoryless: bool) {
        self.memoryless = memoryless;
    }

    /// An empty frame that knows what earlier frames have left in histories. To declare and plan it disturbs nothing.
    pub fn graph<'frame>(&self, limits: Limits) -> Graph<'frame> {
        Graph::with_histories(limits, self.histories.book())
    }

    /// The times of the passes of the last frame that was run with [`Timing::Live`] and is done; `None` until there is
    /// one, and where the device has no timestamps. Call it after a frame was submitted. It does not wait.
    pub fn latest_times(&mut self) -> Option<&[PassTime]> {
        self.times.latest()
    }

    /// Takes the exported textures of `run` out of the pool, so that they keep what they hold after the next run too.
    pub fn release_exports(&mut self, run: &Run) {
        self.pool.remove(|texture| run.exports.iter().flatten().any(|export| export == texture));
    }

    /// Destroys exported textures that [`Self::release_exports`] took out of the pool, for the reason that
    /// [`Self::end_frame`] gives; those of histories stay. No commands that are yet to be submitted may hold them.
    pub fn destroy_released<'t>(&self, textures: impl Iterator<Item = &'t wgpu::Texture>) {
        textures.filter(|texture| !self.histories.hold(texture)).for_each(wgpu::Texture::destroy);
    }

    /// Gives back the histories whose names, with those of their views, `is_gone` names: no frame asks for them any more.
    /// [`Self::end_frame`] destroys their textures.
    pub fn forget_histories(&mut self, is_gone: impl Fn(&str) -> bool) {
        self.histories.forget(is_gone);
    }

    /// Ends a frame, once the encoders of all of its runs are submitted: histories go on from what `run` wrote, and
    /// textures age by one frame. A frame that is not submitted does not end, and leaves histories as they are.
    ///
    /// Textures that no frame asks for any more are destroyed, but for those that `run` exports: browsers free what is
    /// only dropped when they collect garbage, which textures do not hasten. Those of a few texels are only dropped: they
    /// take no memory, and who exported one may hold it for long.
    pub fn end_frame(&mut self, run: &Run) {
        run.written.iter().for_each(|history| self.histories.written(history));
        self.pool.end_frame();
        self.histories.end_frame();
        for texture in self.pool.take_given_back().into_iter().chain(self.histories.take_given_back()) {
            let is_small = texture.width() * texture.height() < SMALL_TEXELS;
            if !is_small && !run.exports.iter().flatten().any(|export| *export == texture) {
                texture.destroy();
            }
        }
    }

    /// Frees all textures at once, where the device goes on without the executor.
    pub fn destroy(self) {
        self.pool.destroy();
        self.histories.destroy();
    }

    /// Memory of all textures that the executor holds.
    pub fn pool_bytes(&self) -> u64 {
        self.pool.bytes() + self.histories.bytes()
    }

    /// How many textures were made so far, for passes and for histories.
    pub fn textures_made(&self) -> u64 {
        self.pool.made() + self.histories.made()
    }

    /// Memory that [`Executor::run`] would allocate for textures, beyond what it holds already.
    pub fn missing_bytes(&self, plan: &Plan, options: &RunOptions<'_>) -> u64 {
        self.pool.missing_bytes(&slot_shapes(plan, options, self.memoryless))
    }

    /// Records a frame, or a part of one. Submit the encoder afterwards, and call [`Self::end_frame`] once a frame.
    ///
    /// # Errors
    /// `plan` is not the plan of `graph`, or a pass asks for a read that it has not declared. What was recorded by then
    /// shall not be submitted.
    pub fn run(
        &mut self,
        graph: Graph<'_>,
        plan: &Plan,
        encoder: &mut wgpu::CommandEncoder,
        options: &RunOptions,
    ) -> Result<Run, PlanError> {
        if plan.graph != graph.id {
            return Err(PlanError::ForeignPlan);
        }
        let resources = self.prepare(&graph, plan, options);
        let split = matches!(options.taps, Taps::All) || options.time != Timing::Off;
        let timed = self.times.begin(options.time, plan.passes.len());
        let Graph { uses, id, exports, histories, textures, passes, .. } = graph;
        let mut closures: Vec<Option<RunFn<'_>>> = passes.into_iter().map(|pass| pass.run).collect();
        let mut run = Run::new(id, plan.passes.len());
        let recorder = Recorder { executor: self, plan, resources: &resources, uses: &uses, graph: id, options };
        let mut first = 0;
        while first < plan.passes.len() {
            let group = plan.passes[first].group;
            let rest = &plan.passes[first..];
            // A pass that is tapped is the last of its render pass.
            let tapped =
                rest.iter().position(|pass| options.taps.ends_with(&pass.name)).map_or(rest.len(), |at| at + 1);
            let merged = rest.iter().take_while(|pass| pass.group == group).count();
            let length = if split { 1 } else { merged.min(tapped) };
            let queries = (first < timed).then_some(first as u32);
            let cut = length < merged;
            recorder.group(encoder, &rest[..length], queries, cut, &mut closures, &mut run);
            tap::record(&recorder, encoder, &rest[length - 1], &mut run);
            first += length;
        }
        for &(texture, _) in &exports {
            let planned = plan.textures.iter().position(|planned| planned.declared == texture);
            run.exports.push(planned.map(|index| resources.textures[index].clone()));
        }
        let mut written = Vec::new();
        for attachment in plan.passes.iter().flat_map(|pass| &pass.attachments) {
            let declared = plan.textures[attachment.texture as usize].declared;
            if let Source::History { index, is_next: true } = textures[declared as usize].source
                && attachment.target != Target::DepthReadOnly
            {
                written.push(index);
            }
        }
        written.sort_unstable();
        written.dedup();
        if !options.leaves_histories {
            run.written = written.iter().map(|index| histories[*index as usize].name.clone()).collect();
        }
        run.timestamps = self.times.end(encoder, options.time, timed, &run.passes);
        self.pool.end_run();
        run.misuse.take().map_or(Ok(run), Err)
    }

    fn prepare(&mut self, graph: &Graph<'_>, plan: &Plan, options: &RunOptions) -> Resources {
        let mut labels = vec![""; plan.slots.len()];
        for texture in &plan.textures {
            let Some(slot) = texture.slot else { continue };
            if labels[slot as usize].is_empty() {
                labels[slot as usize] = &texture.name;
            }
        }
        let slots = slot_shapes(plan, options, self.memoryless).into_iter().zip(labels);
        let slots: Vec<usize> =
            slots.map(|((desc, usage), label)| self.pool.take(&self.device, label, &desc, usage)).collect();
        let mut textures: Vec<Option<wgpu::Texture>> = plan
            .textures
            .iter()
            .map(|texture| Some(self.pool.texture(slots[texture.slot? as usize]).clone()))
            .collect();
        let mut views = vec![None; graph.uses.len()];
        let mut view = |use_index: u32, texture: u32, part: Option<SubresourceRange>, executor: &mut Self| {
            let planned = &plan.textures[texture as usize];
            let key = view_key(graph.uses[use_index as usize].kind, &planned.desc, part);
            let (taken, view) = match (planned.slot, &graph.textures[planned.declared as usize].source) {
                (Some(slot), _) => (None, Some(executor.pool.view(slots[slot as usize], key))),
                (None, Source::Import(view)) => {
                    (Some(view.texture().clone()), Some(imported_view(view, &planned.desc, key)))
                }
                (None, Source::History { index, is_next }) => {
                    let history = &graph.histories[*index as usize];
                    let (texture, view) = executor.histories.take(&executor.device, history, *is_next, key);
                    (Some(texture.clone()), Some(view))
                }
                (None, _) => (None, None),
            };
            views[use_index as usize] = view;
            if taken.is_some() {
                textures[texture as usize] = taken;
            }
        };
        for pass in &plan.passes {
            for attachment in &pass.attachments {
                let whole = plan.textures[attachment.texture as usize].desc.subresources() == 1;
                let part = SubresourceRange { mip: attachment.mip, mips: 1, layer: attachment.layer, layers: 1 };
                view(attachment.use_index, attachment.texture, (!whole).then_some(part), self);
            }
            for read in &pass.reads {
                view(read.use_index, read.texture, read.view, self);
            }
        }
        // Each has a slot, or comes from a view or a history that a pass of the plan uses, so none is left out.
        Resources { textures: textures.into_iter().flatten().collect(), views }
    }
}

/// What recording a run needs to know.
pub(crate) struct Recorder<'a> {
    pub(crate) executor: &'a Executor,
    pub(crate) plan: &'a Plan,
    pub(crate) resources: &'a Resources,
    uses: &'a [crate::graph::Use],
    graph: u32,
    pub(crate) options: &'a RunOptions<'a>,
}

impl Recorder<'_> {
    /// Records passes that share their attachments as one render pass; `is_cut` says that more of them follow in
    /// another.
    fn group(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &[PlannedPass],
        timed_pass: Option<u32>,
        is_cut: bool,
        closures: &mut [Option<RunFn<'_>>],
        run: &mut Run,
    ) {
        let (Some(first), Some(last)) = (passes.first(), passes.last()) else {
            return;
        };
        let begun = web_time::Instant::now();
        let mut colors: Vec<Option<wgpu::RenderPassColorAttachment<'_>>> = Vec::with_capacity(first.attachments.len());
        let mut depth = None;
        // Only the last pass takes means, and it attaches nothing else that the first does not.
        let means = last.attachments.iter().filter(is_mean).filter(|_| passes.len() > 1);
        for attachment in first.attachments.iter().chain(means) {
            let Some(view) = self.view(attachment.use_index) else {
                continue;
            };
            // What is not stored is cleared before anything is drawn over it again.
            let is_kept = is_stored(passes, attachment)
                || is_cut
                || self.executor.clears_cost
                || self.options.taps.ends_with(&last.name);
            let is_kept = is_kept && !self.is_memoryless(attachment);
            let store = if is_kept { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
            match attachment.target {
                Target::Color(_) => colors.push(Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: self.color_load(attachment), store },
                })),
                Target::Resolve(slot) => {
                    if let Some(Some(color)) = colors.get_mut(slot as usize) {
                        color.resolve_target = Some(view);
                    }
                }
                _ => depth = Some(self.depth_attachment(attachment, view, store)),
            }
        }
        let timestamp_writes = timed_pass.zip(self.executor.times.queries());
        let render_pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&first.name),
            color_attachments: &colors,
            depth_stencil_attachment: depth,
            timestamp_writes: timestamp_writes.map(|(pass, query_set)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(pass * 2),
                end_of_pass_write_index: Some(pass * 2 + 1),
            }),
            ..Default::default()
        });
        self.draw(render_pass, passes, begun, closures, run);
    }

    fn draw(
        &self,
        mut render_pass: wgpu::RenderPass<'_>,
        passes: &[PlannedPass],
        mut begun: web_time::Instant,
        closures: &mut [Option<RunFn<'_>>],
        run: &mut Run,
    ) {
        for (index, pass) in passes.iter().enumerate() {
            let closure = closures.get_mut(pass.declared as usize).and_then(Option::take);
            if let Some(closure) = closure {
                let (width, height) = pass.size;
                if index > 0 {
                    // What the pass before has set must not reach this one.
                    render_pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
                    render_pass.set_scissor_rect(0, 0, width, height);
                    render_pass.set_blend_constant(wgpu::Color::TRANSPARENT);
                    render_pass.set_stencil_reference(0);
                }
                if passes.len() > 1 {
                    render_pass.push_debug_group(&pass.name);
                }
                let is_misused = Cell::new(false);
                closure(&mut PassContext {
                    render_pass: &mut render_pass,
                    device: &self.executor.device,
                    queue: &self.executor.queue,
                    name: &pass.name,
                    size: pass.size,
                    graph: self.graph,
                    reads: &pass.reads,
                    views: &self.resources.views,
                    is_misused: &is_misused,
                });
                if is_misused.get() {
                    run.misuse.get_or_insert(PlanError::UndeclaredRead { pass: pass.name.to_string() });
                }
                if passes.len() > 1 {
                    render_pass.pop_debug_group();
                }
            }
            let now = web_time::Instant::now();
            let cpu_ms = now.duration_since(begun).as_secs_f64() * 1e3;
            run.passes.push((pass.name.clone(), cpu_ms));
            begun = now;
        }
    }

    fn view(&self, use_index: u32) -> Option<&wgpu::TextureView> {
        self.resources.views.get(use_index as usize)?.as_ref()
    }

    /// Whether the texture behind an attachment lacks memory, so that it is cleared at first and dropped in the end.
    fn is_memoryless(&self, attachment: &PlannedAttachment) -> bool {
        let texture = self.resources.textures.get(attachment.texture as usize);
        texture.is_some_and(|texture| texture.usage().contains(MEMORYLESS))
    }

    /// Whether a target that may hold anything is not cleared. Pictures of passes show nothing of frames before.
    fn keeps_discarded(&self, attachment: &PlannedAttachment) -> bool {
        self.executor.clears_cost && matches!(self.options.taps, Taps::None) && !self.is_memoryless(attachment)
    }

    fn color_load(&self, attachment: &PlannedAttachment) -> wgpu::LoadOp<wgpu::Color> {
        match self.uses[attachment.use_index as usize].kind {
            UseKind::Color(ColorLoad::Clear(color)) => wgpu::LoadOp::Clear(color),
            UseKind::Color(ColorLoad::Keep) => wgpu::LoadOp::Load,
            UseKind::Color(ColorLoad::Discard) if self.keeps_discarded(attachment) => wgpu::LoadOp::Load,
            _ => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
        }
    }

    fn depth_attachment<'view>(
        &self,
        attachment: &PlannedAttachment,
        view: &'view wgpu::TextureView,
        store: wgpu::StoreOp,
    ) -> wgpu::RenderPassDepthStencilAttachment<'view> {
        let (depth, stencil) = match self.uses[attachment.use_index as usize].kind {
            UseKind::DepthStencil(DepthLoad::Clear { depth, stencil }) => {
                (wgpu::LoadOp::Clear(depth), wgpu::LoadOp::Clear(stencil))
            }
            _ => (wgpu::LoadOp::Load, wgpu::LoadOp::Load),
        };
        let writes = attachment.target == Target::DepthStencil;
        let format = self.plan.textures[attachment.texture as usize].desc.format;
        let depth_ops = wgpu::Operations { load: depth, store };
        let stencil_ops = wgpu::Operations { load: stencil, store };
        wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: (writes && format.has_depth_aspect()).then_some(depth_ops),
            stencil_ops: (writes && format.has_stencil_aspect()).then_some(stencil_ops),
        }
    }
}
