//! The renderer: keeps what lasts from frame to frame, and runs the frame.

mod metering;
mod output;

use crate::aov::{AovExports, AovPasses, AovTextures};
use crate::draws::{Deformation, DrawList};
use crate::frame::{self, Shared};
use crate::frame_buffers::FrameBuffers;
use crate::gpu::{Gpu, readback};
use crate::passes::lights::{self, LightTable};
use crate::passes::motion::MotionUniform;
use crate::passes::present::{PresentUniform, Target};
use crate::passes::{direct, meter};
use crate::request::{FrameRequest, FrameStats, PairCounts, PassPicture, RenderError};
use crate::resources::SceneResources;
use crate::resources::filtering::TextureFiltering;
use crate::shader::Shaders;
use crate::surfaces::SurfacePipelines;
use crate::view::{self, ViewUniform};
use manypass_graph::{Executor, Limits, PassTime, Plan, RunOptions, Taps, Timing};
use manypass_scene::Scene;
use output::{Output, RadianceMean};
use std::cell::RefCell;
use std::sync::atomic::AtomicU64;

/// The format of the finished picture: display colours, encoded in the shader.
pub const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Draws scenes.
pub struct Renderer {
    gpu: Gpu,
    shaders: Shaders,
    surface_pipelines: SurfacePipelines,
    executor: Executor,
    buffers: FrameBuffers,
    resources: Option<SceneResources>,
    output: Option<Output>,
    /// Which of the two sums holds the last frame's.
    latest_sum: usize,
    /// Where the last frame left the mean of radiance, and what it is multiplied by.
    radiance_mean: RadianceMean,
    pre_exposure: f32,
    /// What radiance is laid over where it is read: the background colour as radiance.
    background_radiance: Option<[f32; 3]>,
    /// Pixels that half floats clamped, as of the last time radiance was read.
    clamped_pixels: AtomicU64,
    /// What variables are made of, of the last frame that began a picture.
    aovs: Option<AovTextures>,
    stats: FrameStats,
    memory_budget_bytes: Option<u64>,
}

/// What a frame is rendered for. All but the picture itself are for machines with files and a clock of their own.
#[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser cannot wait for what the others read"))]
enum Purpose<'t> {
    Picture,
    /// A frame that is added to the picture, which nobody looks at yet.
    Sample,
    Target(&'t Target),
    Pictures(Vec<PassPicture>),
    Pairs(PairCounts),
    Times(Vec<PassTime>),
    /// Pre-exposed radiance of the frame.
    Meter(Vec<f32>),
}

impl Purpose<'_> {
    /// Whether the frame is one of those that make the picture, whose variables can be read afterwards.
    fn is_picture(&self) -> bool {
        matches!(self, Self::Picture | Self::Sample | Self::Target(_))
    }
}

impl Renderer {
    /// A renderer on `gpu`.
    ///
    /// # Errors
    /// None today; a renderer may refuse a device.
    pub fn new(gpu: Gpu) -> Result<Self, RenderError> {
        Ok(Self {
            shaders: Shaders::new(&gpu.device),
            surface_pipelines: SurfacePipelines::default(),
            executor: Executor::new(&gpu.device, &gpu.queue),
            buffers: FrameBuffers::new(&gpu),
            resources: None,
            output: None,
            latest_sum: 0,
            radiance_mean: RadianceMean::None,
            pre_exposure: 1.0,
            background_radiance: None,
            clamped_pixels: AtomicU64::new(0),
            aovs: None,
            stats: FrameStats::default(),
            memory_budget_bytes: None,
            gpu,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Uploads `scene` in place of the former one.
    ///
    /// # Errors
    /// The scene does not fit the device's memory, or the device was lost.
    pub fn load(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.resources = None;
        let mut resources = SceneResources::new(&self.gpu, scene);
        let light_count = lights::visible_count(scene);
        if light_count > lights::LIGHTS_MAX as usize {
            resources.warnings.push(format!("only the first {} of {light_count} lights are drawn", lights::LIGHTS_MAX));
        }
        self.resources = Some(resources);
        Ok(self.gpu.check()?)
    }

    /// Gives back what [`Self::load`] took, for whoever has to read the next scene first.
    pub fn unload(&mut self) {
        self.forget_variables();
        if self.resources.take().is_some() {
            // The memory is free only once the device has noticed.
            self.gpu.wait();
        }
    }

    /// Gives back what the variables of the last picture were read from; they cannot be read any more.
    pub fn forget_variables(&mut self) {
        if self.aovs.take().is_some() {
            self.gpu.wait();
        }
    }

    /// What was left out, or replaced, when the scene was uploaded.
    pub fn warnings(&self) -> Vec<String> {
        self.resources.as_ref().map(|resources| resources.warnings.clone()).unwrap_or_default()
    }

    /// Milliseconds in which decoding images held up the upload of the scene.
    pub fn decode_ms(&self) -> f64 {
        self.resources.as_ref().map_or(0.0, |resources| resources.textures.decode_ms)
    }

    /// Milliseconds spent on shaders and pipelines so far. A driver may do more of it when it first draws.
    pub fn compile_ms(&self) -> f64 {
        self.shaders.compile_ms()
    }

    /// Numbers of the last frame.
    pub fn stats(&self) -> FrameStats {
        self.stats.clone()
    }

    /// From now on a frame whose textures would take more than so many bytes beyond those that the renderer holds
    /// already is refused with [`RenderError::Memory`] before it is drawn; without a number none is.
    pub fn set_memory_budget(&mut self, bytes: Option<u64>) {
        self.memory_budget_bytes = bytes;
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
        self.run(scene, request, &mut Purpose::Picture).await.map(drop)
    }

    /// As [`Self::render`], for all frames of a still but the last: the picture that [`Self::read_display`] gives is that
    /// of the last frame rendered otherwise.
    ///
    /// # Errors
    /// As [`Self::render`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn accumulate(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), RenderError> {
        pollster::block_on(self.run(scene, request, &mut Purpose::Sample)).map(drop)
    }

    /// Renders one frame, adds it to those since `sample_index` 0, and draws the picture so far over what `target` holds.
    ///
    /// It submits to the device's queue: what the caller submitted before is done before, and what it submits afterwards
    /// sees the picture. With [`crate::Background::Transparent`] the target shows through where there is no surface.
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
        self.gpu.queue.write_buffer(&self.buffers.present, 0, bytemuck::bytes_of(&PresentUniform::new(target)));
        self.run(scene, request, &mut Purpose::Target(target)).await.map(drop)
    }

    /// Renders one frame and returns the picture of every target of every pass.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn passes(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Vec<PassPicture>, RenderError> {
        let mut purpose = Purpose::Pictures(Vec::new());
        pollster::block_on(self.run(scene, request, &mut purpose))?;
        Ok(if let Purpose::Pictures(pictures) = purpose { pictures } else { Vec::new() })
    }

    /// Counts pairs of pixel and light in a frame of its own (deferred path).
    ///
    /// # Errors
    /// As [`Self::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn count_pairs(&mut self, scene: &Scene, request: &FrameRequest) -> Result<PairCounts, RenderError> {
        let mut purpose = Purpose::Pairs(PairCounts::default());
        let request = request.with(|settings| settings.render.path = frame::Path::Deferred);
        pollster::block_on(self.run(scene, &request, &mut purpose))?;
        Ok(if let Purpose::Pairs(pairs) = purpose { pairs } else { PairCounts::default() })
    }

    /// Renders one frame and measures its passes: the time to record each, and where the adapter has timestamps the
    /// time to execute it. No passes are merged for it.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn pass_times(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Vec<PassTime>, RenderError> {
        let mut purpose = Purpose::Times(Vec::new());
        pollster::block_on(self.run(scene, request, &mut purpose))?;
        Ok(if let Purpose::Times(times) = purpose { times } else { Vec::new() })
    }

    /// Renders the frame that `request` asks for, and gives its plan.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn plan(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Plan, RenderError> {
        pollster::block_on(self.run(scene, request, &mut Purpose::Picture))
    }

    /// The size at which the view is shaded; the picture itself is as large as the request says.
    fn shaded_size(&self, request: &FrameRequest) -> Result<(u32, u32), RenderError> {
        let limit = self.gpu.capabilities.max_texture_size;
        let scale = request.settings.render.scale;
        let shaded = |side: u32| ((side as f32 * scale).round() as u32).max(1);
        let size = (shaded(request.width), shaded(request.height));
        let fits = |side: u32| (1..=limit).contains(&side);
        if [request.width, request.height, size.0, size.1].into_iter().all(fits) {
            Ok(size)
        } else {
            Err(RenderError::Size { width: request.width, height: request.height, limit })
        }
    }

    async fn run(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        purpose: &mut Purpose<'_>,
    ) -> Result<Plan, RenderError> {
        let request = &request.resolved(scene);
        let settings = &request.settings;
        let size = self.shaded_size(request)?;
        let output_size = (request.width, request.height);
        let begins_picture = request.sample_index == 0 && purpose.is_picture();
        if begins_picture {
            self.forget_variables();
        }
        let resources = self.resources.as_mut().ok_or(RenderError::Missing("no scene was loaded"))?;
        let radiance_mean = RadianceMean::of(request);
        let is_metering = matches!(purpose, Purpose::Meter(_));
        let output_bytes =
            if is_metering { 0 } else { Output::missing_bytes(self.output.as_ref(), output_size, radiance_mean) };
        check_budget(self.memory_budget_bytes, output_bytes)?;
        let output = (!is_metering).then(|| Output::of(&self.gpu, &mut self.output, output_size, radiance_mean));
        let pre_exposure = request.pre_exposure();

        // What the view sees.
        let range = request.camera.depth_range(&scene.posed_bounds_world());
        let jitter = view::jitter_px(request.sample_index, request.sample_count);
        let filtering = TextureFiltering::new(request.sample_index, request.sample_count, &self.gpu.capabilities);
        let uniform_at = |size: (u32, u32)| {
            let camera = &request.camera;
            let uniform = camera.uniform_shaded(range, output_size, size, jitter, pre_exposure, request.sample_index);
            ViewUniform { mip_gain: filtering.mip_gain, anisotropy: filtering.sampling.anisotropy.into(), ..uniform }
        };
        let uniform = uniform_at(size);
        let mut deformation = Deformation::default();
        let draws = DrawList::new(scene, resources, &uniform, &mut deformation);
        let started = web_time::Instant::now();
        let table = LightTable::new(scene, pre_exposure, request.light_subset);
        let aspect = output_size.0 as f32 / output_size.1 as f32;
        let target = lights::Target { size, aspect, jitter_px: jitter };
        let limits = lights::ListLimits::of(self.gpu.capabilities.max_texture_size);
        let (culling, clusters) = (settings.lights.culling, &settings.clusters);
        let lists = table.cluster(&request.camera, range, &target, culling, clusters, limits);
        self.stats = FrameStats {
            draws: (draws.opaque.len() + draws.blended.len()) as u32,
            triangles: draws.triangles,
            lights: table.len(),
            list_entries: lists.lights.len() as u64,
            culling_ms: started.elapsed().as_secs_f64() * 1e3,
            ..Default::default()
        };
        let environment = request.environment_uniform();
        self.buffers.write(&self.gpu, request, &uniform, &environment, &table, &lists, &draws);
        let wants_aovs = request.sample_index == 0 && !request.want_aovs.is_empty();
        let aov_passes = if wants_aovs { AovPasses::of(&request.want_aovs) } else { AovPasses::default() };
        // Variables are of rays through the middles of the picture's pixels, which are not those of the shaded ones.
        let has_own_view = wants_aovs && size != output_size && settings.render.path == frame::Path::Deferred;
        let variables_uniform = uniform_at(output_size);
        if has_own_view {
            self.gpu.queue.write_buffer(&self.buffers.variables_view, 0, bytemuck::bytes_of(&variables_uniform));
        }
        let previous = request.previous.as_deref().filter(|_| aov_passes.motion);
        let has_previous = previous.is_some_and(|previous| {
            let motion = MotionUniform::new(&request.camera, Some(&previous.camera), range, output_size);
            self.gpu.queue.write_buffer(&self.buffers.motion, 0, bytemuck::bytes_of(&motion));
            let texels = previous.append_to(scene, &mut deformation);
            resources.write_previous_nodes(&self.gpu, &texels)
        });
        resources.write_deformation(&self.gpu, &deformation);

        // The frame.
        let errors = RefCell::default();
        let buffers = &self.buffers;
        let frame_resources = buffers.frame_resources(&buffers.view);
        let variables_resources = buffers.frame_resources(&buffers.variables_view);
        let shared = Shared {
            gpu: &self.gpu,
            device: &self.gpu.device,
            shaders: &self.shaders,
            surface_pipelines: &self.surface_pipelines,
            resources,
            draws: &draws,
            sampling: filtering.sampling,
            instances: &buffers.instances,
            size,
            depth_format: self.gpu.capabilities.depth_format,
            background: settings.background.source,
            tonemap: settings.tone_map.curve,
            path: settings.render.path,
            light_count: table.len(),
            environment,
            frame_resources: &frame_resources,
            accumulation: &buffers.accumulation,
            tone_map: &buffers.tone_map,
            present: &buffers.present,
            nearest_clamp: &buffers.nearest_clamp,
            is_shown: !matches!(purpose, Purpose::Sample),
            aov_passes: if has_own_view { AovPasses::default() } else { aov_passes },
            has_previous,
            errors: &errors,
        };
        let variables_shared = has_own_view.then_some(Shared {
            size: output_size,
            frame_resources: &variables_resources,
            aov_passes,
            ..shared
        });
        let previous_sum = if request.sample_index == 0 { 0 } else { self.latest_sum };
        let mut graph = self.executor.graph(Limits::from(&self.gpu.capabilities.limits));
        let variables =
            variables_shared.as_ref().map(|shared| frame::variable_passes(&mut graph, shared)).transpose()?;
        let view_outputs = frame::view_passes(&mut graph, &shared)?;
        let view_outputs = frame::effect_passes(&mut graph, &shared, &request.effects, view_outputs)?;
        // What the purpose reads of a frame that is no picture.
        let mut own_export = None;
        match (&*purpose, &view_outputs.gbuffer, output) {
            (Purpose::Pairs(_), Some(gbuffer), _) => {
                let pairs = direct::record_counting(&mut graph, &shared, gbuffer)?;
                own_export = Some(graph.export(pairs));
            }
            (_, _, None) => {
                let meter = meter::record(&mut graph, &shared, &view_outputs.radiance)?;
                own_export = Some(graph.export(meter));
            }
            (_, _, Some(output)) => {
                let means = output.means(&mut graph, radiance_mean, previous_sum);
                let display = output.display(&mut graph);
                let target = if let Purpose::Target(target) = &*purpose { Some(*target) } else { None };
                frame::output_passes(&mut graph, &shared, &view_outputs.radiance, means, display, target)?;
            }
        }
        let exports = if wants_aovs {
            AovExports::new(&mut graph, variables.unwrap_or(view_outputs))
        } else {
            AovExports::default()
        };
        let plan = graph.plan()?;
        let bytes = plan.bytes();
        self.stats.texture_bytes = bytes.aliased;
        self.stats.texture_bytes_unaliased = bytes.unaliased;
        let options = RunOptions {
            taps: if matches!(purpose, Purpose::Pictures(_)) { Taps::All } else { Taps::None },
            time: if matches!(purpose, Purpose::Times(_)) { Timing::Once } else { Timing::Off },
        };
        check_budget(self.memory_budget_bytes, output_bytes + self.executor.missing_bytes(&plan, &options))?;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let run = self.executor.run(graph, &plan, &mut encoder, &options);
        self.gpu.queue.submit([encoder.finish()]);
        if !matches!(purpose, Purpose::Pairs(_) | Purpose::Meter(_)) {
            self.latest_sum = 1 - previous_sum;
            (self.radiance_mean, self.pre_exposure) = (radiance_mean, pre_exposure);
            self.background_radiance = request.background_radiance();
        }
        if let Some(error) = errors.borrow_mut().pop() {
            return Err(error.into());
        }
        self.gpu.check()?;

        // What comes back.
        if wants_aovs && purpose.is_picture() {
            self.aovs = exports.textures(&run, variables_uniform)?;
            self.executor.release_exports(&run);
        }
        if let Some(export) = own_export {
            let texture = run.exported(export).ok_or(RenderError::Missing("an exported texture is missing"))?;
            let bytes = readback::read_texture(&self.gpu, texture).await?;
            match &mut *purpose {
                Purpose::Pairs(counts) => *counts = sum_pairs(&bytes),
                Purpose::Meter(pixels) => {
                    *pixels = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
                }
                _ => (),
            }
        }
        #[cfg(not(target_arch = "wasm32"))]
        match purpose {
            Purpose::Pictures(pictures) => {
                let report = run.read(&self.gpu.device);
                *pictures = report.taps.iter().filter_map(crate::aov::tap_picture).collect();
            }
            Purpose::Times(times) => *times = run.read(&self.gpu.device).passes,
            Purpose::Picture | Purpose::Sample | Purpose::Target(_) | Purpose::Pairs(_) | Purpose::Meter(_) => (),
        }
        Ok(plan)
    }
}

/// Fails if a frame may not allocate `needed_bytes`.
fn check_budget(budget_bytes: Option<u64>, needed_bytes: u64) -> Result<(), RenderError> {
    match budget_bytes {
        Some(budget_bytes) if needed_bytes > budget_bytes => Err(RenderError::Memory { needed_bytes, budget_bytes }),
        _ => Ok(()),
    }
}

fn sum_pairs(bytes: &[u8]) -> PairCounts {
    let mut counts = [0f64; 3];
    for texel in bytes.chunks_exact(16) {
        for (channel, count) in counts.iter_mut().enumerate() {
            let b = &texel[channel * 4..channel * 4 + 4];
            *count += f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        }
    }
    PairCounts { pairs_visited: counts[0] as u64, pairs_shaded: counts[1] as u64, pairs_in_range: counts[2] as u64 }
}
