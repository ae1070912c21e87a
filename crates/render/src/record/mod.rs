//! The vocabulary of passes: what a pass, and a user's effect, is given to record itself with. Nothing here knows a
//! pass.

mod bind_groups;
mod decal_marks;
mod fullscreen;
mod instances;
mod legend;
mod scrubbed;
mod surfaces;
mod tables;
mod texels;
mod uniforms;
mod view;
mod volumes;

pub use fullscreen::{ADD, Fullscreen, PicturePart};
pub use legend::LegendEntry;
pub use surfaces::{DecalUse, DrawSelection, SurfacePass, TilePass};
pub use texels::Texels;
pub use view::PreparedView;

pub(crate) use bind_groups::BindGroups;
pub(crate) use decal_marks::DecalMarks;
pub(crate) use instances::InstanceTable;
pub(crate) use legend::Legends;
pub(crate) use scrubbed::ScrubMasks;
pub(crate) use surfaces::{Bundles, SurfacePipelines};
pub(crate) use tables::{FrameTables, depth_texture};
pub(crate) use texels::TargetTexels;
pub(crate) use uniforms::UniformArena;
pub(crate) use view::{COUNTS_PAIRS, UNFILTERED_SAMPLES, ViewDescription, ViewTables};
pub(crate) use volumes::Volumes;

use crate::draws::WorldDraws;
use crate::gpu::Gpu;
use crate::resources::SceneResources;
use crate::shader::Shaders;
use crate::shader::cache::FullscreenPipeline;
use fullscreen::Shading;
use manypass_graph::{Graph, Handle, History, TextureDesc};
use std::borrow::Cow;
use std::sync::Arc;

/// The part of a frame that all views share: the device and the loaded scene.
#[derive(Debug)]
pub struct Frame<'f> {
    /// The device and what it can do.
    pub gpu: &'f Gpu,
    pub(crate) shaders: &'f Shaders,
    pub(crate) surface_pipelines: &'f SurfacePipelines,
    pub(crate) resources: &'f SceneResources,
    pub(crate) world: &'f WorldDraws,
    pub(crate) tables: &'f FrameTables,
    pub(crate) uniforms: &'f UniformArena,
    pub(crate) bind_groups: &'f BindGroups,
    pub(crate) bundles: &'f Bundles,
    pub(crate) volumes: &'f Volumes,
    pub(crate) decal_marks: &'f DecalMarks,
    pub(crate) legends: &'f Legends,
    pub(crate) scrubbed: &'f ScrubMasks,
}

/// The recorder of one view's passes: the graph, the shared frame, and the view.
pub struct Recorder<'r, 'f> {
    /// The graph of the frame.
    pub graph: &'r mut Graph<'f>,
    /// What all views share.
    pub frame: &'f Frame<'f>,
    /// The view whose passes are recorded.
    pub view: &'f PreparedView,
}

impl<'r, 'f> Recorder<'r, 'f> {
    /// Records passes of `view` from here on; its name precedes theirs.
    pub fn new(graph: &'r mut Graph<'f>, frame: &'f Frame<'f>, view: &'f PreparedView) -> Self {
        graph.set_view(view.name.clone());
        Self { graph, frame, view }
    }

    /// A texture of the view's size that lives within the frame.
    pub fn texture(&mut self, name: impl Into<Cow<'static, str>>, format: wgpu::TextureFormat) -> Handle {
        let desc = self.view.desc(format);
        self.graph.texture(name, desc)
    }

    /// A texture of the view's size, with as many samples a pixel as its surfaces cover.
    pub fn multisampled(&mut self, name: impl Into<Cow<'static, str>>, format: wgpu::TextureFormat) -> Handle {
        let desc = TextureDesc { samples: self.view.pixel_samples, ..self.view.desc(format) };
        self.graph.texture(name, desc)
    }

    /// A texture of any shape that lives within the frame.
    pub fn texture_of(&mut self, name: impl Into<Cow<'static, str>>, desc: TextureDesc) -> Handle {
        self.graph.texture(name, desc)
    }

    /// What the view's last frame left under this name, and what this frame leaves for the next. It begins anew where
    /// the view does not go on from its last frame, and at another size.
    pub fn history(&mut self, name: impl Into<Cow<'static, str>>, desc: TextureDesc) -> History {
        let history = self.graph.history(name, desc);
        History { is_first: history.is_first || !self.view.goes_on, ..history }
    }

    /// Says what the colours mean that the pass `pass` draws. Whoever shows its picture shows the legend with it.
    pub fn legend(&mut self, pass: &str, entries: Vec<LegendEntry>) {
        self.frame.legends.add(&self.view.name, pass, entries);
    }

    /// Says what the texels of `target` hold. Whoever shows its picture unpacks them by that, and not by their format.
    pub fn declare_texels(&mut self, target: &Handle, texels: Texels) {
        self.frame.legends.texels.add(target.name(), texels);
    }

    /// Says that `target` holds what `source` does.
    pub fn declare_texels_of(&mut self, target: &Handle, source: &Handle) {
        if let Some(texels) = self.frame.legends.texels.of(source.name()) {
            self.declare_texels(target, texels);
        }
    }

    /// The extent of what the view sees, in metres, which lengths follow that settings leave open. It need not be
    /// finite.
    pub fn extent_m(&self) -> f32 {
        *self.view.extent_m.get_or_init(|| self.frame.world.extent_m(&self.view.uniform))
    }

    /// Whether the view shows opaque surfaces whose materials have more than the G-buffer holds.
    pub fn shows_shaded_where_drawn(&self) -> bool {
        surfaces::shows_shaded_where_drawn(self.view, self.frame.world)
    }

    /// A full-screen pass of the program `program` with the axes `axes` on. Its name is its folder's, then the step's.
    pub fn fullscreen(
        &mut self,
        name: impl Into<Cow<'static, str>>,
        program: &'static str,
        axes: &[&'static str],
    ) -> Fullscreen<'_, 'f> {
        let pass = self.graph.pass(name);
        Fullscreen::new(pass, self.frame, self.view, Shading::Program(program, axes.to_vec()))
    }

    /// A full-screen pass with a pipeline from elsewhere, and a bind group of its own as group 2.
    pub fn own_fullscreen(
        &mut self,
        name: impl Into<Cow<'static, str>>,
        pipeline: Arc<FullscreenPipeline>,
        own: Option<wgpu::BindGroup>,
    ) -> Fullscreen<'_, 'f> {
        let pass = self.graph.pass(name);
        Fullscreen::new(pass, self.frame, self.view, Shading::Own(pipeline, own))
    }

    /// A pass that draws many small pictures of what casts shadows, with the program `program`.
    pub(crate) fn tiles(&mut self, name: impl Into<Cow<'static, str>>, program: &'static str) -> TilePass<'_, 'f> {
        let pass = self.graph.pass(name);
        TilePass::new(pass, self.frame, self.view, program)
    }

    /// A pass that draws surfaces of the view with the program `program`.
    pub fn surfaces(&mut self, name: impl Into<Cow<'static, str>>, program: &'static str) -> SurfacePass<'_, 'f> {
        let name = name.into();
        let pass = self.graph.pass(name.clone());
        SurfacePass::new((name, pass), self.frame, self.view, program)
    }
}
