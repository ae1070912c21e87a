//! From what a frame is asked for to views that can be recorded.

use super::Renderer;
use super::ask::ViewRequest;
use super::constants::constants_of;
use super::drawing::DrawResources;
use super::ground::{FrameGround, light_in_environment};
use super::output::{Output, UnsettledRegion, ViewState};
use super::purpose::Purpose;
use super::shadows::{Atlas, contact_uniform, filter_uniform};
use super::surroundings::FrameSurroundings;
use super::view_kind::CapturedLight;
use super::visible::{FrameScene, VisibleSet};
use crate::aov::AovPasses;
use crate::draws::{DecalDraws, DrawList, VisibleClouds, WorldDraws};
use crate::effect;
use crate::environment::picture::EnvironmentTiles;
use crate::environment::{Environment, EnvironmentUniform};
use crate::frame::Variables;
use crate::gpu::Gpu;
use crate::ground::{GroundLight, ViewGround, keeps_border};
use crate::lens::SampleView;
use crate::levels::LevelCount;
use crate::lights::{CachedLists, ClusterUniform, LightTable, Rectangle};
use crate::outline::Outline;
use crate::passes::adaptive;
use crate::passes::taa::TemporalFrame;
use crate::record::{InstanceTable, PreparedView, ViewDescription, ViewTables};
use crate::render_settings::Path;
use crate::request::FrameStats;
use crate::resources::filtering::{Sampling, TextureFiltering};
use crate::shadows::ViewShadows;
use crate::view::{self, CameraStep, DepthRange, ViewUniform};
use bytemuck::Zeroable;
use glam::Vec2;
use std::borrow::Cow;
use std::sync::Arc;

/// The prepared views of one camera, which can be recorded.
pub(super) struct ViewSetup {
    pub view: PreparedView,
    /// The view of its variables, where the picture is shaded at another size than its own, or is one of several
    /// samples: variables are of rays through the middles of the picture's pixels, and textures are filtered for them
    /// alone.
    pub variables_view: Option<PreparedView>,
    pub variables: Variables,
    /// What effects on the picture read of the same.
    pub of_effects: Variables,
    /// The view of effects on a picture that is larger than its frames.
    pub enlarged_view: Option<PreparedView>,
    /// What anti-aliasing over time needs, if there is any.
    pub temporal: Option<TemporalFrame>,
    /// Whether tiles that are settled are left out once some are.
    pub is_adaptive: bool,
    /// The uniform of the picture's own size.
    pub variables_uniform: ViewUniform,
}

impl ViewSetup {
    /// What the view does after this sample.
    pub fn adaptive_step(&self, asked: &ViewRequest) -> adaptive::Step {
        if self.is_adaptive { asked.adaptive_step() } else { adaptive::Step::None }
    }
}

/// What a view is prepared from that others have, too.
pub(super) struct SharedInputs<'f> {
    pub shadows: Option<(&'f ViewShadows, &'f Atlas)>,
    pub ground: Option<&'f FrameGround>,
    pub surroundings: Option<&'f FrameSurroundings>,
}

/// What the views of one camera are prepared from: that of its picture, those of its variables and of what is enlarged.
struct ViewInputs<'a> {
    asked: &'a ViewRequest,
    world: &'a WorldDraws,
    draws: Arc<DrawList>,
    lists: &'a CachedLists,
    tables: &'a ViewTables,
    cluster_grid: ClusterUniform,
    environment: EnvironmentUniform,
    shadows: Option<(&'a ViewShadows, &'a Atlas)>,
    ground: Option<ViewGround>,
    tiles: Option<&'a EnvironmentTiles>,
    surroundings: Option<&'a FrameSurroundings>,
    /// How samplers filter for the picture, and for variables.
    sampling: [Sampling; 2],
    display_goes_on: bool,
    is_adaptive: bool,
    settled: Option<wgpu::TextureView>,
    unsettled: Option<UnsettledRegion>,
    outline: Option<(Outline, Rectangle)>,
}

impl ViewInputs<'_> {
    /// A view of this name, shaded at a size with this uniform.
    fn view(
        &self,
        renderer: &Renderer,
        name: String,
        (size, uniform): ((u32, u32), ViewUniform),
        is_of_variables: bool,
    ) -> PreparedView {
        let Self { asked, draws, lists, tables, shadows, tiles, surroundings, .. } = self;
        let request = &asked.request;
        let settings = &request.settings;
        let (sample_index, sample_count) = request.sample();
        let shows_first_surface = settings.aov.first_surface && is_of_variables;
        let draws_picture = !is_of_variables && !asked.counts_pairs;
        let is_adaptive = self.is_adaptive && draws_picture;
        let whole_samples = if is_adaptive { adaptive::whole_samples(sample_count) } else { None };
        // What is found in the picture is found by the first sample, and for all.
        let looks = sample_index == 0 && (settings.occlusion.enabled.is_on() || settings.reflections.enabled.is_on());
        let samples_depth = renderer.gpu.capabilities.samples_attached_depth;
        let unsettled = self.unsettled.as_ref().filter(|_| draws_picture && self.settled.is_some());
        let tiles_left = unsettled.filter(|_| size == asked.output_size).map(|unsettled| &*unsettled.tiles);
        let viewed = ViewDescription {
            name: name.into(),
            size,
            goes_on: request.goes_on || request.sample_index > 0,
            effects_go_on: request.goes_on || request.effects_go_on || request.sample_index > 0,
            display_goes_on: self.display_goes_on,
            display_exposure: request.display_exposure(),
            sample_count,
            pixel_samples: if draws_picture { settings.msaa.samples.count() } else { 1 },
            uniform,
            draws: if shows_first_surface { draws.first_surfaces().into() } else { draws.clone() },
            clouds: VisibleClouds::new(self.world, draws, &uniform, None),
            clouds_left: tiles_left.map(|tiles| VisibleClouds::new(self.world, draws, &uniform, Some(tiles))),
            shows_first_surface,
            sampling: self.sampling[usize::from(is_of_variables)],
            light_count: lists.table.len(),
            cluster_grid: &self.cluster_grid,
            constants: constants_of(
                (asked, self.world),
                &lists.table,
                shadows.map(|(shadows, _)| shadows),
                (*tiles, *surroundings),
                lists.decals.parts,
            ),
            lit_rectangles: lists.lit_rectangles.clone(),
            volume_draws: lists.volume_draws.clone(),
            object_lights: lists.object_lights.clone(),
            environment: &self.environment,
            instances: renderer.instances.buffer().clone(),
            shadows: shadows.map(|(_, atlas)| &atlas.view),
            ground: self.ground.clone(),
            whole_samples,
            reads_attached_depth: samples_depth && whole_samples.is_some() && !looks,
            settled: self.settled.clone().filter(|_| draws_picture),
            unsettled: match &self.outline {
                Some((_, rectangle)) => Some([*rectangle].into()),
                None => unsettled.map(|unsettled| unsettled.rectangles.clone()),
            },
            outline: self.outline.map(|(outline, _)| outline),
            environment_tiles: surroundings.map(|of| &of.view).or(tiles.map(|tiles| &tiles.view)),
            decals: renderer.resources.decals.view(),
            decal_draws: DecalDraws::new(&lists.decals.boxes, &uniform.clip_from_world),
        };
        renderer.bind(viewed, tables)
    }

    /// The views of a camera whose own one has this uniform, and whose textures are filtered so for the picture and for
    /// variables.
    fn setup(
        &self,
        renderer: &Renderer,
        scene: &FrameScene<'_>,
        seen: (&SampleView, DepthRange),
        uniform: ViewUniform,
        [filtering, filtering_of_variables]: [TextureFiltering; 2],
    ) -> ViewSetup {
        let Self { asked, is_adaptive, .. } = *self;
        let ViewRequest { request, size, output_size, .. } = asked;
        let passes = if asked.wants_variables { AovPasses::of(&request.want_aovs) } else { AovPasses::default() };
        let has_own_view = asked.wants_variables
            && (size != output_size
                || request.settings.aov.first_surface
                || filtering != filtering_of_variables
                || asked.temporal.is_some())
            && request.settings.render.path == Path::Deferred;
        let camera_step = if scene.has_previous { camera_step_of(asked, seen.1) } else { None };
        let of_effects = read_by_effects(asked, camera_step);
        let in_middle = (*output_size, Vec2::ZERO);
        let shown = (scene.scene, renderer.shadows.scene_version);
        let variables_uniform = renderer.view_uniform(asked, seen, in_middle, filtering_of_variables);
        let enlarged = asked.upscaled_to().map(|_| renderer.view_uniform(asked, seen, in_middle, filtering));
        let of_variables = if asked.name.is_empty() { "aov".into() } else { format!("{}/aov", asked.name) };
        let temporal = asked.temporal.as_ref();
        let prepare = |name: String, size: (u32, u32), uniform: ViewUniform, is_of_variables: bool| {
            self.view(renderer, name, (size, uniform), is_of_variables)
        };
        ViewSetup {
            view: prepare(asked.name.clone(), *size, uniform, false),
            variables_view: has_own_view.then(|| prepare(of_variables, *output_size, variables_uniform, true)),
            enlarged_view: enlarged.map(|uniform| prepare(asked.name.clone(), *output_size, uniform, false)),
            variables: Variables { passes, ..of_effects },
            of_effects,
            temporal: temporal.map(|temporal| temporal.frame(request, shown, camera_step, asked.upscaled_to())),
            is_adaptive,
            variables_uniform,
        }
    }
}

impl Renderer {
    /// How the textures of a frame of the view are filtered. The first frame of a live view is shown before the others
    /// are there, and filtered like a picture of its own.
    pub(super) fn filtering(&self, asked: &ViewRequest) -> TextureFiltering {
        let (sample_index, sample_count) = asked.request.sample();
        let is_alone = asked.request.goes_on && sample_index == 0;
        let sample_count = if is_alone { 1 } else { sample_count };
        // Those before make up for what is too fine.
        let sample_count = if asked.temporal.is_some() { asked.temporal_samples() } else { sample_count };
        TextureFiltering::new(sample_count, &self.gpu.capabilities)
    }

    /// What shaders know of a view that is shaded at a size, moved by so many of its pixels beside what samples are,
    /// and whose textures are filtered so.
    pub(super) fn view_uniform(
        &self,
        asked: &ViewRequest,
        (seen, range): (&SampleView, DepthRange),
        (size, temporal_jitter_px): ((u32, u32), Vec2),
        filtering: TextureFiltering,
    ) -> ViewUniform {
        let ViewRequest { request, output_size, .. } = asked;
        let (sample_index, sample_count) = request.sample();
        let jitter = view::jitter_px(sample_index, sample_count) + seen.shift_px(size) + temporal_jitter_px;
        let pre_exposure = request.pre_exposure();
        let uniform = seen.camera.uniform_shaded(range, *output_size, size, jitter, pre_exposure, request.sample_index);
        let uniform = request.clip_plane_world.map_or(uniform, |plane_world| uniform.cut_by(plane_world, range));
        ViewUniform {
            mip_gain: filtering.mip_gain,
            anisotropy: filtering.sampling.anisotropy.into(),
            glow_exposure: if request.averages_parts() { request.display_exposure() } else { 0.0 },
            ..uniform
        }
    }

    /// Prepares a view: uploads what changed of its tables. Adds to the numbers of the frame.
    pub(super) fn setup(
        &self,
        scene: &FrameScene<'_>,
        asked: &ViewRequest,
        (state, visible): (&mut ViewState, VisibleSet),
        shared: &SharedInputs<'_>,
        stats: &mut FrameStats,
    ) -> ViewSetup {
        let ViewRequest { request, size, .. } = asked;
        let settings = &request.settings;
        let VisibleSet { range, seen, lists, made, draws, is_adaptive, .. } = visible;
        let shadows = shared.shadows.filter(|_| settings.shadows.enabled);
        let filtering = self.filtering(asked);
        let filtering_of_variables = TextureFiltering::new(1, &self.gpu.capabilities);
        let uniform = self.view_uniform(asked, (&seen, range), (*size, asked.temporal_jitter_px()), filtering);
        let settled = state.settled(request.sample_index).filter(|_| is_adaptive);
        let effects_go_on = request.goes_on || request.effects_go_on;
        let display_goes_on = effects_go_on || request.sample_index > 0 && state.was_shown;
        let ViewState { tables, lists: held, unsettled, .. } = state;
        add_draws(stats, &draws);
        let texels = shadows.map(|(shadows, _)| shadows.texels(&lists.table));
        let texels = texels.as_ref().unwrap_or(&lists.table.texels);
        stats.uploaded_bytes += tables.write(&self.gpu, texels, made.as_ref());
        let lists = &*held.insert(lists);
        let filter = |_| filter_uniform(&settings.shadows, request.sample().0);
        let cluster_grid = ClusterUniform {
            shadow_filter: shadows.map_or([0.0; 4], filter),
            contact: contact_uniform(&settings.shadows, settled.is_some()),
            ..lists.uniform
        };
        let tiles = self.tiles_of(asked);
        let mut environment = request.environment_uniform(tiles);
        let surroundings = surroundings_of(asked, shared.surroundings, tiles);
        if let Some(surroundings) = &surroundings {
            surroundings.place(&mut environment, request.pre_exposure());
        }
        let inputs = ViewInputs {
            asked,
            world: &scene.draws,
            draws,
            lists,
            tables,
            cluster_grid,
            environment,
            shadows,
            ground: shared.ground.and_then(|ground| ground_of(asked, ground, &lists.table)),
            tiles,
            surroundings: surroundings.as_deref(),
            sampling: [filtering.sampling, filtering_of_variables.sampling],
            display_goes_on,
            is_adaptive,
            settled,
            unsettled: unsettled.clone(),
            outline: asked.outline(&uniform),
        };
        let setup = inputs.setup(self, scene, (&seen, range), uniform, [filtering, filtering_of_variables]);
        stats.points += setup.view.point_count();
        setup
    }

    /// The tiles of a view's environment, if that is a picture or the studio.
    pub(super) fn tiles_of(&self, asked: &ViewRequest) -> Option<&EnvironmentTiles> {
        if matches!(asked.request.settings.environment.source, Environment::Studio | Environment::Fill) {
            return Some(self.drawing.tables.studio(&self.gpu));
        }
        let map = asked.environment.as_ref()?;
        self.resources.environment(map)
    }

    /// What draws what all views share, shadow maps and levels of the environment: of no camera, and with neither
    /// itself.
    pub(super) fn shared_view(
        &self,
        asked: &ViewRequest,
        setup: &ViewSetup,
        state: &ViewState,
        instances: &InstanceTable,
    ) -> PreparedView {
        let lists = state.lists.as_ref();
        let viewed = ViewDescription {
            name: "".into(),
            size: asked.size,
            goes_on: false,
            effects_go_on: false,
            display_goes_on: false,
            display_exposure: 1.0,
            sample_count: 1,
            pixel_samples: 1,
            uniform: ViewUniform { sample_index: asked.request.dealing().pattern(), ..setup.view.uniform },
            draws: Arc::default(),
            clouds: VisibleClouds::default(),
            clouds_left: None,
            shows_first_surface: false,
            sampling: setup.view.sampling,
            light_count: 0,
            constants: asked.request.settings.transparency.masks.constants(),
            lit_rectangles: Arc::default(),
            volume_draws: Arc::default(),
            object_lights: Arc::default(),
            cluster_grid: &lists.map_or_else(ClusterUniform::zeroed, |lists| lists.uniform),
            environment: &asked.request.environment_uniform(None),
            instances: instances.buffer().clone(),
            shadows: None,
            ground: None,
            whole_samples: None,
            reads_attached_depth: false,
            settled: None,
            unsettled: None,
            outline: None,
            environment_tiles: None,
            decals: None,
            decal_draws: DecalDraws::default(),
        };
        self.bind(viewed, &state.tables)
    }

    /// Gives a view its uniforms and its bind group.
    fn bind(&self, viewed: ViewDescription<'_>, tables: &ViewTables) -> PreparedView {
        let DrawResources { shaders, tables: of_frame, uniforms, bind_groups, .. } = &self.drawing;
        viewed.prepare(&self.gpu, shaders, (of_frame, uniforms, bind_groups), tables)
    }
}

/// Adds what a view draws to the numbers of the frame.
fn add_draws(stats: &mut FrameStats, draws: &DrawList) {
    stats.draws += (draws.opaque.len() + draws.transmissive.len() + draws.blended.len()) as u32;
    stats.triangles += draws.triangles;
    for (at, count) in draws.levels.iter().enumerate() {
        stats.levels.resize(stats.levels.len().max(at + 1), LevelCount::default());
        stats.levels[at].primitives += count.primitives;
        stats.levels[at].triangles += count.triangles;
    }
}

/// The pictures around places that a view has as its environment, of those of the frame.
fn surroundings_of<'f>(
    asked: &ViewRequest,
    of_frame: Option<&'f FrameSurroundings>,
    tiles: Option<&EnvironmentTiles>,
) -> Option<Cow<'f, FrameSurroundings>> {
    let of_frame = of_frame.filter(|of_frame| of_frame.have(tiles.map(|tiles| &tiles.view)))?;
    match asked.kind.captured_light {
        CapturedLight::None => None,
        CapturedLight::Irradiance => Some(Cow::Owned(of_frame.of_probes())),
        CapturedLight::All => Some(Cow::Borrowed(of_frame)),
    }
}

/// The plane under the scene as a view shows it.
fn ground_of(asked: &ViewRequest, ground: &FrameGround, table: &LightTable) -> Option<ViewGround> {
    let ViewRequest { request, size, .. } = asked;
    let FrameGround { map, broad_source, texture, .. } = ground;
    let settings = &request.settings;
    let keeps = asked.kind.keeps_border && keeps_border(settings.environment.source, settings.background.source);
    let picture = keeps.then_some((&request.camera, size.0 as f32 / size.1 as f32));
    let of_environment = || light_in_environment(broad_source.as_ref(), request);
    let light = GroundLight::of_table(table).or_else(of_environment);
    ViewGround::new(settings.ground.mode, (map, texture), light, picture)
}

/// From where to where the camera of a view moved, if there is a previous frame.
fn camera_step_of(asked: &ViewRequest, range: DepthRange) -> Option<CameraStep> {
    let ViewRequest { request, output_size, .. } = asked;
    let previous = request.previous.as_ref()?;
    Some(CameraStep { current: request.camera, previous: previous.camera, range, output_size: *output_size })
}

/// What effects of a view read of its surfaces.
fn read_by_effects(asked: &ViewRequest, camera_step: Option<CameraStep>) -> Variables {
    let reads = |texture| effect::is_read(&asked.request.effects, texture);
    Variables {
        passes: AovPasses {
            motion: reads("motion") || asked.temporal.is_some(),
            ids: reads("ids"),
            ..Default::default()
        },
        camera_step,
        reads_occlusion: reads("occlusion"),
    }
}

/// The textures that a view's picture goes to; none where the frame is metered.
pub(super) fn output_of<'o>(
    gpu: &Gpu,
    asked: &ViewRequest,
    slot: &'o mut Option<Output>,
    (purpose, settles): (&Purpose<'_>, bool),
    has_tint: bool,
) -> Option<&'o Output> {
    if !purpose.draws_picture {
        return None;
    }
    if purpose.is_run {
        Output::of(gpu, slot, asked.output_size, asked.means_of, settles);
    } else {
        *slot = Some(Output::planned(gpu, asked.output_size, asked.means_of, settles));
    }
    if let Some(output) = slot.as_mut().filter(|_| has_tint) {
        output.with_tint(gpu);
    }
    slot.as_ref()
}
