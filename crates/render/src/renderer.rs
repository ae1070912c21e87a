//! The renderer: keeps what lasts from frame to frame, and runs the frame.

mod ask;
mod captures;
mod constants;
mod counts;
mod drawing;
mod effects;
mod faults;

mod fisheye;
mod ground;

mod live_probes;
mod loading;
#[cfg(not(target_arch = "wasm32"))]
mod measuring;
mod metering;
mod mirrors;
mod monitors;
mod next;
mod output;
mod part;
mod portals;
mod prepare;
mod prepare_view;
mod probe_lighting;
mod probes;
mod purpose;
mod read;
mod reading;
mod record;
mod record_inputs;
mod record_mirrors;
mod record_view;
mod resolve;
mod run;
mod shadows;
mod shared;
mod simulations;
mod submit;
mod surroundings;
mod temporal;
mod variables;
mod view_kind;
mod views;
mod visible;
mod water;

pub use reading::RenderedView;
#[cfg(target_arch = "wasm32")]
pub use shared::Pipelines;

use crate::aov::AovTextures;
use crate::draws::WorldDraws;
use crate::effect::WgslEffect;
use crate::environment::ComputedEnvironments;
use crate::gpu::Gpu;
use crate::passes::present::Target;
use crate::record::InstanceTable;
use crate::request::{FrameRequest, FrameStats, RenderError};
use crate::resources::SceneResources;
use drawing::DrawResources;
use faults::SceneFaults;
use ground::GroundState;
use manypass_graph::Executor;
use manypass_scene::Cache;
use manypass_scene::{NodeId, Scene};
use output::ViewState;
use purpose::Purpose;
use shadows::ShadowState;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The format of the finished picture: display colours, encoded in the shader.
pub const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Draws scenes. It may be moved to another thread.
pub struct Renderer {
    gpu: Gpu,
    drawing: DrawResources,
    executor: Executor,
    faults: SceneFaults,
    resources: SceneResources,
    computed: ComputedEnvironments,
    world_draws: WorldDraws,
    instances: InstanceTable,
    shadows: ShadowState,
    ground: GroundState,
    captures: captures::CaptureState,
    surroundings: surroundings::SurroundingsState,
    simulations: simulations::SimulationState,
    /// What every view keeps, by name; the only view of a frame has the empty name.
    views: BTreeMap<String, ViewState>,
    /// What of the last frame's scene has views of its own within pictures.
    captured: Vec<views::CapturedName>,
    stats: FrameStats,
    memory_budget_bytes: Option<u64>,
    cache: Option<Arc<dyn Cache>>,
    /// Effects of all pictures, after those of their requests.
    added: Vec<Arc<WgslEffect>>,
}

impl Renderer {
    /// A renderer on `gpu`.
    ///
    /// # Errors
    /// None today; a renderer may refuse a device.
    pub fn new(gpu: Gpu) -> Result<Self, RenderError> {
        Ok(Self {
            drawing: DrawResources::new(&gpu),
            executor: Executor::new(&gpu.device, &gpu.queue),
            faults: SceneFaults::default(),
            resources: SceneResources::new(&gpu),
            computed: ComputedEnvironments::default(),
            world_draws: WorldDraws::default(),
            instances: InstanceTable::new(&gpu),
            shadows: ShadowState::new(&gpu),
            ground: GroundState::new(&gpu),
            captures: captures::CaptureState::default(),
            surroundings: surroundings::SurroundingsState::default(),
            simulations: simulations::SimulationState::default(),
            views: BTreeMap::new(),
            captured: Vec::new(),
            stats: FrameStats::default(),
            memory_budget_bytes: None,
            cache: None,
            added: Vec::new(),
            gpu,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Uploads new resources of `scene`, and frees those that it no longer has. Every frame does this first. Call it
    /// before a frame to measure it, or to learn what was left out ([`Self::warnings`]).
    ///
    /// # Errors
    /// The scene does not fit the device's memory, or the device was lost.
    pub fn load(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.follow_simulations(scene)?;
        self.follow(scene);
        self.faults = SceneFaults::of(scene, &self.simulations);
        Ok(self.gpu.check()?)
    }

    /// Sets `textures.max_px` before [`Self::load`], which has no settings: larger textures are halved during the upload.
    /// Frames bring their own value; a different one uploads all textures again.
    pub fn limit_textures(&mut self, max_px: u32) {
        self.resources.limit_textures(max_px);
    }

    /// As [`Self::load`], and says how many bytes were uploaded.
    fn follow(&mut self, scene: &Scene) -> u64 {
        let followed = self.resources.follow(&self.gpu, scene, self.computed.maps(), self.cache.as_deref());
        if followed.has_moved {
            self.drawing.clear();
        }
        self.shadows.scene_version +=
            u64::from(followed.has_moved || followed.has_changed || followed.written_bytes > 0);
        followed.written_bytes
    }

    /// Frees all resources of the scene on the device, such as before the next scene is read.
    pub fn unload(&mut self) {
        self.forget_variables();
        self.cut();
        self.resources = SceneResources::new(&self.gpu);
        self.instances = InstanceTable::new(&self.gpu);
        self.shadows = ShadowState::new(&self.gpu);
        self.ground = GroundState::new(&self.gpu);
        self.captures.clear();
        self.surroundings.clear();
        self.simulations.clear();
        self.world_draws = WorldDraws::default();
        self.drawing.clear();
        // The memory is free only once the device has noticed.
        self.gpu.wait();
    }

    /// Frees the textures from which AOVs of the last picture are read; they cannot be read any more.
    pub fn forget_variables(&mut self) {
        self.forget_variables_of(|_| true);
    }

    fn forget_variables_of(&mut self, is_wanted: impl Fn(&str) -> bool) {
        let of_views = self.views.iter_mut().filter(|(name, _)| is_wanted(name));
        let forgotten: Vec<_> = of_views.filter_map(|(_, view)| view.aovs.take()).collect();
        if !forgotten.is_empty() {
            self.drawing.bind_groups.clear();
            self.executor.destroy_released(forgotten.iter().flat_map(AovTextures::all));
            self.gpu.wait();
        }
    }

    /// Bytes of the scene's meshes, textures and simulations on the device.
    pub fn scene_bytes(&self) -> u64 {
        self.resources.bytes() + self.simulations.bytes()
    }

    /// The nodes of lights without room for their shadow maps in the last frame, which cast no shadow. None in stills,
    /// where shadow maps are spread over samples.
    pub fn lights_without_shadows(&self) -> &[NodeId] {
        &self.shadows.beyond
    }

    /// The nodes of lights whose shadow maps in the last frame had less than half of the picture's resolution, because
    /// the atlas was full.
    pub fn starved_lights(&self) -> &[NodeId] {
        &self.shadows.starved
    }

    /// Milliseconds for which the upload of the scene waited for images to be decoded.
    pub fn decode_ms(&self) -> f64 {
        self.resources.textures.decode_ms
    }

    /// Milliseconds spent on shaders and pipelines so far. A driver may do more of it when it first draws.
    pub fn compile_ms(&self) -> f64 {
        self.drawing.shaders.compile_ms()
    }

    /// Statistics of the last frame.
    pub fn stats(&self) -> FrameStats {
        self.stats.clone()
    }

    /// Sets the memory budget: a frame whose textures would take more additional bytes than this is refused with
    /// [`RenderError::Memory`] before it is drawn. `None` refuses no frame.
    pub fn set_memory_budget(&mut self, bytes: Option<u64>) {
        self.memory_budget_bytes = bytes;
    }

    /// Sets the cache for costly results, such as prefiltered environment maps.
    pub fn set_cache(&mut self, cache: Option<Arc<dyn Cache>>) {
        self.cache = cache;
    }

    /// Bytes of the textures that the renderer keeps for the frame's passes between frames: at most twice what the last
    /// frame's plan takes, whatever sizes came before.
    pub fn pool_bytes(&self) -> u64 {
        self.executor.pool_bytes()
    }

    /// Waits until everything submitted is done.
    pub fn wait(&self) {
        self.gpu.wait();
    }

    /// Renders one frame and adds it to those since `sample_index` 0.
    ///
    /// # Errors
    /// No scene was loaded, the size does not fit, or the device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), RenderError> {
        pollster::block_on(self.render_async(scene, request))
    }

    /// Renders one frame and adds it to those since `sample_index` 0.
    ///
    /// # Errors
    /// No scene was loaded, the size does not fit, or the device failed.
    pub async fn render_async(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), RenderError> {
        self.run(scene, &[("", request)], &Purpose::PICTURE).await.map(drop)
    }

    /// Renders one frame of several cameras, each with a name, a size, samples and outputs of its own: innermost first,
    /// so that a picture exists before whoever shows it. What the views share is prepared once. [`Self::rendered`]
    /// reads them; the view with the empty name is that which the other functions read. Names are unique.
    ///
    /// # Errors
    /// As [`Self::render`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render_views(&mut self, scene: &Scene, views: &[(&str, &FrameRequest)]) -> Result<(), RenderError> {
        pollster::block_on(self.render_views_async(scene, views))
    }

    /// As [`Self::render_views`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub async fn render_views_async(
        &mut self,
        scene: &Scene,
        views: &[(&str, &FrameRequest)],
    ) -> Result<(), RenderError> {
        self.run(scene, views, &Purpose::PICTURE).await.map(drop)
    }

    /// As [`Self::render`], for all frames of a still but the last: the picture that [`Self::read_display`] gives is
    /// that of the last frame rendered otherwise.
    ///
    /// # Errors
    /// As [`Self::render`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn accumulate(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), RenderError> {
        pollster::block_on(self.run(scene, &[("", request)], &Purpose { shows_picture: false, ..Purpose::PICTURE }))
            .map(drop)
    }

    /// Renders one frame, adds it to those since `sample_index` 0, and draws the picture so far over what `target`
    /// holds.
    ///
    /// It submits to the device's queue: what the caller submitted before is done before, and what it submits
    /// afterwards sees the picture. With [`crate::Background::Transparent`] the target shows through where there is no
    /// surface.
    ///
    /// # Errors
    /// As [`Self::render_async`], and if the target cannot be drawn to.
    ///
    /// ```no_run
    /// # fn show(renderer: &mut manypass::Renderer, scene: &manypass::scene::Scene, frame: &wgpu::SurfaceTexture)
    /// #     -> Result<(), manypass::RenderError> {
    /// # use manypass::{FrameRequest, Target};
    /// let target = Target::whole(&frame.texture);
    /// renderer.render_to(scene, &FrameRequest::of_scene(scene, target.width, target.height), &target)?;
    /// # Ok(()) }
    /// ```
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render_to(&mut self, scene: &Scene, request: &FrameRequest, target: &Target) -> Result<(), RenderError> {
        pollster::block_on(self.render_to_async(scene, request, target))
    }

    /// As [`Self::render_to`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::render_to`].
    pub async fn render_to_async(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        target: &Target,
    ) -> Result<(), RenderError> {
        if let Some(fault) = target.fault() {
            return Err(RenderError::Target(fault));
        }
        self.run(scene, &[("", request)], &Purpose { target: Some(target), ..Purpose::PICTURE }).await.map(drop)
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::Renderer;

    #[test]
    fn a_renderer_may_be_moved_to_another_thread() {
        fn check<T: Send>() {}
        check::<Renderer>();
    }
}
