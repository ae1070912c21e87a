//! What a pass draws frame after frame is encoded once, in render bundles: the device's own lists of commands.
//!
//! A list of draws is cut into chunks of the world's items, so that what comes into sight or leaves it changes its own
//! chunk alone. A chunk that was drawn alike in the last frame becomes a bundle; any other is drawn command by command.

use super::encode::encode;
use super::pipelines::Targets;
use super::prepared::{Chunk, Command};
use crate::record::bind_groups::KEPT_FRAMES;
use crate::record::{Frame, PreparedView};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;

/// Fewer commands are not worth a bundle of their own.
const COMMANDS_MIN: usize = 16;

/// A pass of a view.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct PassKey {
    pub view: Cow<'static, str>,
    pub pass: Cow<'static, str>,
}

/// What all draws of a pass have in common, beside what their commands say.
#[derive(Debug, PartialEq)]
struct SharedBindings {
    targets: Targets,
    view: wgpu::BindGroup,
    instances: wgpu::Buffer,
}

#[derive(Debug, Default)]
struct PassBundles {
    common: Option<SharedBindings>,
    /// By the index of the chunk.
    chunks: HashMap<u32, KeptChunk>,
    last_frame: u64,
}

#[derive(Debug)]
struct KeptChunk {
    chunk: Chunk,
    bundle: Option<wgpu::RenderBundle>,
}

/// The bundles of all passes that draw surfaces.
#[derive(Debug, Default)]
pub(crate) struct Bundles {
    passes: RefCell<HashMap<PassKey, PassBundles>>,
    frame: Cell<u64>,
    executed: Cell<u64>,
    changes: Cell<u64>,
}

impl Bundles {
    /// Begins a frame: forgets the passes that the last ones did without.
    pub fn begin(&self) {
        let frame = self.frame.get() + 1;
        self.frame.set(frame);
        self.executed.set(0);
        self.changes.set(0);
        self.passes.borrow_mut().retain(|_, pass| pass.last_frame + KEPT_FRAMES >= frame);
    }

    /// How many were executed since the frame began.
    pub fn executed(&self) -> u64 {
        self.executed.get()
    }

    /// Counts what a chunk binds.
    pub(super) fn count(&self, chunk: &Chunk) {
        let binds = |command: &&Command| matches!(command, Command::Bound(_) | Command::Material(_));
        self.changes.set(self.changes.get() + chunk.commands.iter().filter(binds).count() as u64);
    }

    /// How often pipelines and materials were bound since the frame began.
    pub fn changes(&self) -> u64 {
        self.changes.get()
    }

    /// Forgets all, with the buffers and textures that they hold.
    pub fn clear(&self) {
        self.passes.borrow_mut().clear();
    }

    /// Draws `chunks` in a pass, those that it drew before from their bundles.
    pub(super) fn draw(
        &self,
        render_pass: &mut wgpu::RenderPass<'_>,
        (frame, view): (&Frame<'_>, &PreparedView),
        (key, targets): (PassKey, Targets),
        chunks: Vec<Chunk>,
    ) {
        let common = SharedBindings { targets, view: view.group.clone(), instances: view.instances.clone() };
        let mut passes = self.passes.borrow_mut();
        let pass = passes.entry(key).or_default();
        pass.last_frame = self.frame.get();
        let common = match &mut pass.common {
            Some(known) if *known == common => known,
            known => {
                pass.chunks.clear();
                known.insert(common)
            }
        };
        for chunk in chunks {
            let index = chunk.index;
            self.count(&chunk);
            match pass.chunks.get_mut(&index).filter(|known| known.chunk == chunk) {
                Some(known) => {
                    let make = || bundle(&known.chunk, common, frame, view);
                    self.executed.set(self.executed.get() + 1);
                    render_pass.execute_bundles([&*known.bundle.get_or_insert_with(make)]);
                }
                None => {
                    encode(&chunk, render_pass, frame, view);
                    if chunk.commands.len() >= COMMANDS_MIN {
                        pass.chunks.insert(index, KeptChunk { chunk, bundle: None });
                    }
                }
            }
        }
    }
}

fn bundle(chunk: &Chunk, common: &SharedBindings, frame: &Frame<'_>, view: &PreparedView) -> wgpu::RenderBundle {
    let Targets { colors, depth, samples, depth_write, .. } = &common.targets;
    let color_formats: Vec<_> = colors.iter().copied().map(Some).collect();
    let mut encoder = frame.gpu.device.create_render_bundle_encoder(&wgpu::RenderBundleEncoderDescriptor {
        label: Some("surfaces"),
        color_formats: &color_formats,
        depth_stencil: Some(wgpu::RenderBundleDepthStencil {
            format: *depth,
            depth_read_only: !depth_write,
            stencil_read_only: true,
        }),
        sample_count: *samples,
        multiview: None,
    });
    encode(chunk, &mut encoder, frame, view);
    encoder.finish(&wgpu::RenderBundleDescriptor { label: Some("surfaces") })
}
