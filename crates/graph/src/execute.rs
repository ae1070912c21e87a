//! Recording a plan into a command encoder.

use std::borrow::Cow;

use crate::TextureDesc;
use crate::graph::{ColorLoad, DepthLoad, Graph, Read, RunFn, UseKind};
use crate::plan::{Plan, PlannedAttachment, PlannedPass, Target};
use crate::pool::{Histories, Pool, ViewKey, create_view};
use crate::report::{Run, Tap, Timestamps, copied_format};

/// What to measure and keep while running. Both turn off the merging of passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunOptions {
    /// Copy what every pass writes ([`Run::taps`]). Left out are multisampled
    /// attachments, formats that cannot be copied, imported textures without
    /// `COPY_SRC`, and depth on OpenGL.
    pub tap: bool,
    /// Measure GPU time of every pass, if the device has `TIMESTAMP_QUERY`.
    pub time: bool,
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
    views: &'a [Option<wgpu::TextureView>],
}

impl PassContext<'_, '_> {
    /// The view behind a declared read.
    ///
    /// # Panics
    /// If the token was declared by a pass of another graph or by a pass that was
    /// culled.
    pub fn view(&self, read: Read) -> &wgpu::TextureView {
        let view = self.views.get(read.use_index as usize);
        match view.and_then(Option::as_ref) {
            Some(view) if read.graph == self.graph => view,
            _ => panic!("pass `{}` uses a read that it has not declared; call `Pass::read` in it", self.name),
        }
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
    device: wgpu::Device,
    queue: wgpu::Queue,
    pool: Pool,
    histories: Histories,
    has_timestamps: bool,
    can_copy_depth: bool,
    queries: Option<wgpu::QuerySet>,
}

/// What the textures behind the slots of a plan have to be.
fn slot_shapes(plan: &Plan, options: &RunOptions) -> Vec<(TextureDesc, wgpu::TextureUsages)> {
    let mut shapes: Vec<_> = plan.slots.iter().map(|desc| (*desc, wgpu::TextureUsages::RENDER_ATTACHMENT)).collect();
    for texture in &plan.textures {
        let Some((_, usage)) = texture.slot.and_then(|slot| shapes.get_mut(slot as usize)) else { continue };
        if texture.sampled || texture.exported {
            *usage |= wgpu::TextureUsages::TEXTURE_BINDING;
        }
        if texture.exported || options.tap {
            *usage |= wgpu::TextureUsages::COPY_SRC;
        }
    }
    shapes
}

/// The textures and views of one run.
struct Resources {
    /// Per planned texture; `None` never occurs for what a plan uses.
    textures: Vec<wgpu::Texture>,
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
            has_timestamps: device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
            can_copy_depth: device.adapter_info().backend != wgpu::Backend::Gl,
            queries: None,
        }
    }

    /// Textures that pass from frame to frame: what was written as `current` at the
    /// last call with this name and view, and what to write now. Call it once a
    /// frame and import both. `is_first` says that `previous` holds zeros, because
    /// there was no earlier frame or its descriptor differed.
    ///
    /// `view` tells several cameras of one frame apart.
    pub fn history(
        &mut self,
        name: impl Into<Cow<'static, str>>,
        view: u32,
        desc: TextureDesc,
    ) -> (wgpu::TextureView, wgpu::TextureView, bool) {
        self.histories.swap(&self.device, name.into(), view, desc)
    }

    /// Drops textures and histories that were not used since the last call.
    pub fn forget_unused(&mut self) {
        self.pool.forget_unused();
        self.histories.forget_unused();
    }

    /// Takes the exported textures of `run` out of the pool, so that they keep what they hold after the next run too.
    pub fn release_exports(&mut self, run: &Run) {
        self.pool.remove(|texture| run.exports.iter().any(|(_, export)| export == texture));
    }

    /// Memory of all textures that the executor holds.
    pub fn pool_bytes(&self) -> u64 {
        self.pool.bytes() + self.histories.bytes()
    }

    /// Memory that [`Executor::run`] would allocate for textures, beyond what it holds already.
    pub fn missing_bytes(&self, plan: &Plan, options: &RunOptions) -> u64 {
        self.pool.missing_bytes(&slot_shapes(plan, options))
    }

    /// Records a frame. Submit the encoder afterwards.
    ///
    /// # Panics
    /// If `plan` is not the plan of `graph`.
    pub fn run(
        &mut self,
        graph: Graph<'_>,
        plan: &Plan,
        encoder: &mut wgpu::CommandEncoder,
        options: &RunOptions,
    ) -> Run {
        assert!(
            plan.graph == graph.id,
            "the plan belongs to another graph; call `Graph::plan` on the graph that is run"
        );
        let resources = self.prepare(&graph, plan, options);
        let split = options.tap || options.time;
        let timed = if options.time && self.has_timestamps {
            // One set holds begin and end of this many passes.
            let most = wgpu::QUERY_SET_MAX_QUERIES as usize / 2;
            let count = plan.passes.len().min(most);
            self.ensure_queries(count);
            count
        } else {
            0
        };
        let mut closures: Vec<Option<RunFn<'_>>> = Vec::with_capacity(graph.passes.len());
        let (uses, id) = (graph.uses, graph.id);
        closures.extend(graph.passes.into_iter().map(|pass| pass.run));
        let mut run = Run {
            taps: Vec::new(),
            passes: Vec::with_capacity(plan.passes.len()),
            exports: Vec::new(),
            timestamps: None,
        };
        let recorder =
            Recorder { executor: self, plan, resources: &resources, uses: &uses, graph: id, store_all: options.tap };
        let mut first = 0;
        while first < plan.passes.len() {
            let group = plan.passes[first].group;
            let rest = &plan.passes[first..];
            let length = if split { 1 } else { rest.iter().take_while(|pass| pass.group == group).count() };
            let queries = (first < timed).then_some(first as u32);
            recorder.group(encoder, &rest[..length], queries, &mut closures, &mut run);
            if options.tap {
                recorder.tap(encoder, &rest[0], &mut run.taps);
            }
            first += length;
        }
        for (texture, planned) in resources.textures.into_iter().zip(&plan.textures) {
            if planned.exported && !planned.imported {
                run.exports.push((planned.name.clone(), texture));
            }
        }
        run.timestamps = self.resolve_queries(encoder, timed);
        self.pool.release_all();
        run
    }

    fn prepare(&mut self, graph: &Graph<'_>, plan: &Plan, options: &RunOptions) -> Resources {
        let mut labels = vec![""; plan.slots.len()];
        for texture in &plan.textures {
            let Some(slot) = texture.slot else { continue };
            if labels[slot as usize].is_empty() {
                labels[slot as usize] = &texture.name;
            }
        }
        let slots = slot_shapes(plan, options).into_iter().zip(labels);
        let slots: Vec<usize> =
            slots.map(|((desc, usage), label)| self.pool.take(&self.device, label, &desc, usage)).collect();
        let mut views = vec![None; graph.uses.len()];
        let mut view = |use_index: u32, texture: u32, part, executor: &mut Self| {
            let planned = &plan.textures[texture as usize];
            let kind = graph.uses[use_index as usize].kind;
            let (dimension, aspect) = match kind {
                UseKind::Sampled { dimension, .. } if planned.desc.has_depth() => {
                    (dimension, wgpu::TextureAspect::DepthOnly)
                }
                UseKind::Sampled { dimension, .. } => (dimension, wgpu::TextureAspect::All),
                _ => (None, wgpu::TextureAspect::All),
            };
            let key = ViewKey { part, dimension, aspect };
            let imported = graph.textures[planned.declared as usize].import.as_ref();
            views[use_index as usize] = match (planned.slot, imported) {
                (Some(slot), _) => Some(executor.pool.view(slots[slot as usize], key)),
                // The imported view itself serves wherever it can, because it may
                // have another format than its texture.
                (None, Some(view)) => {
                    let whole = planned.desc.subresources() == 1 || (part.is_none() && dimension.is_none());
                    let as_given = whole && aspect == wgpu::TextureAspect::All;
                    Some(if as_given { view.clone() } else { create_view(view.texture(), key) })
                }
                (None, None) => None,
            };
        };
        for pass in &plan.passes {
            for attachment in &pass.attachments {
                let part = Some((attachment.mip, attachment.layer));
                view(attachment.use_index, attachment.texture, part, self);
            }
            for read in &pass.reads {
                view(read.use_index, read.texture, read.view, self);
            }
        }
        let textures = plan.textures.iter().filter_map(|texture| {
            let imported = graph.textures[texture.declared as usize].import.as_ref();
            match texture.slot {
                Some(slot) => Some(self.pool.texture(slots[slot as usize]).clone()),
                None => imported.map(|view| view.texture().clone()),
            }
        });
        Resources { textures: textures.collect(), views }
    }

    fn ensure_queries(&mut self, passes: usize) {
        let needed = (passes as u32 * 2).max(2);
        let enough = self.queries.as_ref().is_some_and(|queries| queries.count() >= needed);
        if !enough {
            self.queries = Some(self.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass times"),
                ty: wgpu::QueryType::Timestamp,
                count: needed,
            }));
        }
    }

    fn resolve_queries(&self, encoder: &mut wgpu::CommandEncoder, passes: usize) -> Option<Timestamps> {
        let queries = self.queries.as_ref().filter(|_| passes > 0)?;
        let size = passes as u64 * 16;
        let buffer = |usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass times"),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readable = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        encoder.resolve_query_set(queries, 0..passes as u32 * 2, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &readable, 0, size);
        Some(Timestamps {
            buffer: readable,
            count: passes,
            ms_per_tick: f64::from(self.queue.get_timestamp_period()) * 1e-6,
        })
    }
}

struct Recorder<'a> {
    executor: &'a Executor,
    plan: &'a Plan,
    resources: &'a Resources,
    uses: &'a [crate::graph::Use],
    graph: u32,
    store_all: bool,
}

impl Recorder<'_> {
    /// Records passes that share their attachments as one render pass.
    fn group(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        passes: &[PlannedPass],
        timed_pass: Option<u32>,
        closures: &mut [Option<RunFn<'_>>],
        run: &mut Run,
    ) {
        let (Some(first), Some(last)) = (passes.first(), passes.last()) else {
            return;
        };
        let begun = web_time::Instant::now();
        let mut colors = Vec::with_capacity(first.attachments.len());
        let mut depth = None;
        for (attachment, end) in first.attachments.iter().zip(&last.attachments) {
            let Some(view) = self.view(attachment.use_index) else {
                continue;
            };
            let store = if end.store || self.store_all { wgpu::StoreOp::Store } else { wgpu::StoreOp::Discard };
            match attachment.target {
                Target::Color(_) => colors.push(Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: self.color_load(attachment), store },
                })),
                _ => depth = Some(self.depth_attachment(attachment, view, store)),
            }
        }
        let timestamp_writes = timed_pass.zip(self.executor.queries.as_ref());
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
                closure(&mut PassContext {
                    render_pass: &mut render_pass,
                    device: &self.executor.device,
                    queue: &self.executor.queue,
                    name: &pass.name,
                    size: pass.size,
                    graph: self.graph,
                    views: &self.resources.views,
                });
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

    fn color_load(&self, attachment: &PlannedAttachment) -> wgpu::LoadOp<wgpu::Color> {
        match self.uses[attachment.use_index as usize].kind {
            UseKind::Color(ColorLoad::Clear(color)) => wgpu::LoadOp::Clear(color),
            UseKind::Color(ColorLoad::Keep) => wgpu::LoadOp::Load,
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

    /// Copies what a pass has written.
    fn tap(&self, encoder: &mut wgpu::CommandEncoder, pass: &PlannedPass, taps: &mut Vec<Tap>) {
        for attachment in &pass.attachments {
            let planned = &self.plan.textures[attachment.texture as usize];
            let texture = &self.resources.textures[attachment.texture as usize];
            let is_depth = planned.desc.format.is_depth_stencil_format();
            let copyable = attachment.target != Target::DepthReadOnly
                && planned.desc.samples == 1
                && texture.usage().contains(wgpu::TextureUsages::COPY_SRC)
                && (!is_depth || self.executor.can_copy_depth);
            let Some((_, texel_bytes)) = copied_format(planned.desc.format).filter(|_| copyable) else {
                continue;
            };
            let desc = planned.desc.of_mip(attachment.mip);
            let bytes_per_row = (desc.width * texel_bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
            let name = self.plan.attachment_name(attachment);
            let buffer = self.executor.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&name),
                size: u64::from(bytes_per_row) * u64::from(desc.height),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: attachment.mip,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: attachment.layer },
                    aspect: if is_depth { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All },
                },
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(bytes_per_row),
                        rows_per_image: None,
                    },
                },
                wgpu::Extent3d { width: desc.width, height: desc.height, depth_or_array_layers: 1 },
            );
            taps.push(Tap { pass: pass.name.to_string(), texture: name, desc, buffer, bytes_per_row });
        }
    }
}
