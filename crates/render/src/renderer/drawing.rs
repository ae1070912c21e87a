//! What passes are drawn with that lasts from frame to frame: programs, pipelines, tables, uniforms and bind groups.

use super::shared::SharedBox;
use crate::draws::WorldDraws;
use crate::gpu::Gpu;
use crate::record::{
    BindGroups, Bundles, DecalMarks, Frame, FrameTables, Legends, ScrubMasks, SurfacePipelines, UniformArena, Volumes,
};
use crate::request::FrameStats;
use crate::resources::SceneResources;
use crate::shader::Shaders;

/// What passes are drawn with.
pub(super) struct DrawResources {
    pub shaders: SharedBox<Shaders>,
    pub surface_pipelines: SharedBox<SurfacePipelines>,
    pub tables: FrameTables,
    pub uniforms: UniformArena,
    pub bind_groups: BindGroups,
    bundles: Bundles,
    volumes: Volumes,
    decal_marks: DecalMarks,
}

/// What a frame notes while its passes are recorded.
#[derive(Default)]
pub(super) struct FrameNotes {
    pub legends: Legends,
    /// What counts pixels that are no numbers.
    pub scrubbed: ScrubMasks,
}

impl DrawResources {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            shaders: Shaders::new(&gpu.device).into(),
            surface_pipelines: SurfacePipelines::default().into(),
            tables: FrameTables::new(gpu),
            uniforms: UniformArena::new(&gpu.device),
            bind_groups: BindGroups::default(),
            bundles: Bundles::default(),
            volumes: Volumes::new(&gpu.device),
            decal_marks: DecalMarks::default(),
        }
    }

    /// Begins what is made anew with each frame.
    pub fn begin_frame(&mut self) {
        self.uniforms.begin();
        self.bind_groups.begin();
        self.bundles.begin();
    }

    /// Forgets what holds buffers, textures and tables whose place others take.
    pub fn clear(&mut self) {
        self.bind_groups.clear();
        self.bundles.clear();
    }

    /// What the views of a frame share while they are recorded.
    pub fn frame<'f>(
        &'f self,
        gpu: &'f Gpu,
        resources: &'f SceneResources,
        world: &'f WorldDraws,
        notes: &'f FrameNotes,
    ) -> Frame<'f> {
        Frame {
            gpu,
            shaders: &self.shaders,
            surface_pipelines: &self.surface_pipelines,
            resources,
            world,
            tables: &self.tables,
            uniforms: &self.uniforms,
            bind_groups: &self.bind_groups,
            bundles: &self.bundles,
            volumes: &self.volumes,
            decal_marks: &self.decal_marks,
            legends: &notes.legends,
            scrubbed: &notes.scrubbed,
        }
    }

    /// Adds to the numbers of a frame that was run.
    pub fn count(&self, stats: &mut FrameStats) {
        stats.bind_groups_made = self.bind_groups.made();
        stats.bundles_executed = self.bundles.executed();
        stats.binding_changes = self.bundles.changes();
    }
}
