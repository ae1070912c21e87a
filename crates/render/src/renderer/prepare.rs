//! From what a frame is asked for to views that can be recorded.

use super::captures::{MonitorView, Part};
use super::constants::constants_of;
use super::ground::FrameGround;
use super::live_probes::ProbeSide;
use super::mirrors::{MirrorSeen, MirrorView, ROUGH_MARGIN};
use super::output::{MeansOf, Output, ViewState};
use super::shadows::{Atlas, contact_uniform, filter_uniform};
use super::surroundings::{FrameSurroundings, SideView};
use super::temporal::TemporalAsked;
use super::{Purpose, Renderer};
use crate::aov::AovPasses;
use crate::constants::DECAL_EMISSION;
use crate::decals::{DecalDraws, DecalTable, SharedDecals, find_touched};
use crate::draws::{DrawList, WorldDraws};
use crate::effect;
use crate::environment::{Environment, studio};
use crate::fisheye::{Face, FisheyeFaces};
use crate::frame::Variables;
use crate::gpu::{Capabilities, Gpu};
use crate::ground::ViewGround;
use crate::lens::SampleView;
use crate::levels::{Chooser, LevelCount};
use crate::lights::{
    self, ClusterLists, ClusterUniform, KeptLists, LeastLights, LightCulling, LightReaches, LightTable, ListsOf,
    Rectangle, TableOf,
};
use crate::outline::{Outline, rectangle_of};
use crate::passes::adaptive;
use crate::passes::debug::DebugView;
use crate::passes::taa::TemporalFrame;
use crate::record::{InstanceTable, PreparedView, Viewed};
use crate::render_settings::Path;
use crate::request::{FrameRequest, FrameStats, RenderError};
use crate::resources::SceneResources;
use crate::resources::environment::EnvironmentTiles;
use crate::resources::filtering::TextureFiltering;
use crate::shadows::ViewShadows;
use crate::view::{self, CameraStep, DepthRange, ViewUniform};
use bytemuck::Zeroable;
use glam::{Vec2, Vec4};
use manypass_scene::{EnvironmentLight, EnvironmentMap, Scene};
use std::sync::Arc;

/// For how many samples textures are filtered where frames before add theirs.
const TEMPORAL_SAMPLES: u32 = 4;

/// One view of the frame, as it was asked for.
pub(super) struct Asked {
    pub name: String,
    pub request: FrameRequest,
    /// The picture of its environment, if that is one.
    pub environment: Option<Arc<EnvironmentMap>>,
    /// The light that the environment brings, turned and scaled.
    pub environment_light: Option<EnvironmentLight>,
    /// The size at which it is shaded; the picture itself is as large as the request says.
    pub size: (u32, u32),
    pub output_size: (u32, u32),
    pub means_of: MeansOf,
    /// The passes that its variables need, and whether any variable is wanted.
    pub wants_variables: bool,
    /// Whether pairs of light and what it may reach are counted in place of light.
    pub counts_pairs: bool,
    /// What of a picture it is.
    pub part: ViewPart,
    /// The mirrors that it shows.
    pub mirrors: Vec<MirrorSeen>,
    /// In how many other pictures the monitor is seen for whose sake it is drawn.
    pub level: Option<u32>,
    /// What is known of the frames before, if it is anti-aliased by them.
    pub temporal: Option<TemporalAsked>,
    /// By how many of its pixels a view behind a mirror is moved with the view that shows it, for the sake of the latter's
    /// other frames.
    pub viewer_jitter_px: Vec2,
}

/// What of a picture a view is.
#[derive(Clone, Debug)]
pub(super) enum ViewPart {
    /// All of it.
    Whole,
    /// A view that the picture is put together from, which follows it.
    Face(Face),
    /// A picture that is put together from the views before it: it draws no surfaces itself.
    Fisheye(FisheyeFaces),
    /// What a monitor's camera sees, which views after it show.
    Monitor(MonitorView),
    /// What is behind a mirror, which the view after it shows.
    Mirror(MirrorView),
    /// A side of the pictures around a place, which views after it have as their environment.
    Side(SideView),
    /// A side of what is around a probe, which views after it have the light of.
    Probe(ProbeSide),
}

impl ViewPart {
    /// Whether it is within a picture, over which nothing is laid.
    pub fn is_within(&self) -> bool {
        matches!(self, Self::Face(_) | Self::Monitor(_) | Self::Mirror(_) | Self::Side(_) | Self::Probe(_))
    }

    /// Whether it is a picture of a fisheye, or a side of one, whose frustum is sheared; or what is behind a mirror in that.
    pub fn is_of_fisheye(&self) -> bool {
        match self {
            Self::Face(_) | Self::Fisheye(_) => true,
            Self::Mirror(view) => view.shear != (Vec2::ZERO, 0.0),
            Self::Whole | Self::Monitor(_) | Self::Side(_) | Self::Probe(_) => false,
        }
    }

    /// By how much its picture is moved, and how far it then reaches beyond its frustum, in metres a metre.
    pub fn shear(&self) -> (Vec2, f32) {
        match self {
            Self::Face(face) => (face.shift_ndc(), face.beyond()),
            Self::Mirror(view) => view.shear,
            Self::Whole | Self::Fisheye(_) | Self::Monitor(_) | Self::Side(_) | Self::Probe(_) => (Vec2::ZERO, 0.0),
        }
    }

    pub fn is_fisheye(&self) -> bool {
        matches!(self, Self::Fisheye(_))
    }
}

impl Asked {
    pub fn new(
        Part { name, request, part, mirrors, level }: Part,
        environment: Option<Arc<EnvironmentMap>>,
        purpose: &Purpose<'_>,
        capabilities: &Capabilities,
    ) -> Result<Self, RenderError> {
        request.settings.check()?;
        if request.settings.camera.f_stop > 0.0 && request.samples_lens_or_shutter() && request.camera.is_orthographic()
        {
            return Err(RenderError::ParallelLens);
        }
        if part.is_fisheye() && request.camera.is_orthographic() {
            return Err(RenderError::Fisheye("needs a camera with perspective, and this one has parallel rays"));
        }
        if part.is_fisheye() && (!request.want_aovs.is_empty() || matches!(purpose, Purpose::Variables)) {
            return Err(RenderError::Fisheye("has no variables (AOVs)"));
        }
        let limit = capabilities.max_texture_size;
        // The views are shaded at that scale.
        let scale = if part.is_fisheye() { 1.0 } else { request.settings.render.scale };
        let shaded = |side: u32| ((side as f32 * scale).round() as u32).max(1);
        let (width, height) = (request.width, request.height);
        let size = (shaded(width), shaded(height));
        let fits = |side: u32| (1..=limit).contains(&side);
        if ![width, height].into_iter().all(fits) {
            return Err(RenderError::Size { width, height, limit });
        }
        if ![size.0, size.1].into_iter().all(fits) {
            return Err(RenderError::ShadedSize { width, height, shaded: size, limit });
        }
        let light = match request.settings.environment.source {
            Environment::Studio => Some(studio::key_light()),
            _ => environment.as_ref().and_then(|map| map.light),
        };
        Ok(Self {
            name,
            mirrors,
            level,
            environment_light: light.and_then(|light| request.environment_light(&light)),
            environment,
            size,
            output_size: (width, height),
            means_of: match part {
                ViewPart::Face(_) | ViewPart::Mirror(_) | ViewPart::Side(_) | ViewPart::Probe(_) => MeansOf::Nothing,
                // Those of a live view are not drawn in all of its frames.
                ViewPart::Monitor(_) if request.goes_on || request.sample_count <= 1 => MeansOf::Nothing,
                ViewPart::Whole | ViewPart::Fisheye(_) | ViewPart::Monitor(_) => MeansOf::request(&request),
            },
            wants_variables: request.sample_index == 0 && !request.want_aovs.is_empty(),
            counts_pairs: matches!(purpose, Purpose::Pairs(_)),
            part,
            temporal: None,
            viewer_jitter_px: Vec2::ZERO,
            request,
        })
    }

    /// The row of the projection that gives depth before the division by w. Jitter does not change it.
    fn depth_row(&self, seen: &SampleView, range: DepthRange) -> Vec4 {
        let Self { request, size, output_size, .. } = self;
        let uniform = seen.camera.uniform_shaded(range, *output_size, *size, Vec2::ZERO, 1.0, 0);
        let uniform = request.clip_plane_world.map_or(uniform, |plane_world| uniform.cut_by(plane_world, range));
        uniform.clip_from_world.row(2)
    }

    /// What an adaptive still does after this sample.
    pub fn adaptive_step(&self) -> adaptive::Step {
        let (sample_index, sample_count) = self.request.sample();
        adaptive::Step::after(sample_index, sample_count)
    }

    /// For how many samples textures are filtered where frames before add theirs: more for pixels of the picture that
    /// are smaller than those of the frame.
    fn temporal_samples(&self) -> u32 {
        let area = |size: (u32, u32)| f64::from(size.0) * f64::from(size.1);
        let pixels = self.upscaled_to().map_or(1.0, |size| area(size) / area(self.size));
        (f64::from(TEMPORAL_SAMPLES) * pixels).round() as u32
    }

    /// Which of the two sums holds the mean so far.
    pub fn previous_sum(&self, state: &ViewState) -> usize {
        if self.request.sample_index == 0 { 1 } else { state.latest_sum }
    }

    /// The outline that it draws within, and the rectangle around it, if it is behind a mirror whose pixels show one
    /// direction each: others show what is beside.
    fn outline(&self, uniform: &ViewUniform) -> Option<(Outline, Rectangle)> {
        let ViewPart::Mirror(MirrorView { is_smooth: true, corners_world, .. }) = self.part else { return None };
        let of_view = (uniform, corners_world, self.size);
        Some((Outline::new(of_view.0, of_view.1, of_view.2), rectangle_of(of_view.0, of_view.1, of_view.2)))
    }

    /// How many times as wide what it draws is as what the view shows that it is drawn for.
    pub fn margin(&self) -> f32 {
        if let ViewPart::Mirror(MirrorView { is_smooth: false, .. }) = self.part {
            1.0 + 2.0 * ROUGH_MARGIN
        } else {
            1.0
        }
    }

    /// Whether it has textures that samples are added to, or shown in.
    pub fn has_output(&self) -> bool {
        !self.part.is_within() || self.means_of.go_on()
    }

    /// Whether a sample that adds to those before it finds what they left.
    pub fn finds_means(&self, state: &ViewState) -> bool {
        let is_first = self.request.sample_index == 0;
        is_first
            || !self.has_output()
            || self.means_of == state.means_of
                && state.output.as_ref().is_some_and(|output| output.is_of(self.output_size))
    }
}

/// What all views of a frame are prepared from.
pub(super) struct World<'s> {
    pub scene: &'s Scene,
    pub draws: WorldDraws,
    /// Those that are shown.
    decals: SharedDecals,
    /// Most views share one.
    tables: Vec<(TableOf, Arc<LightTable>)>,
}

impl<'s> World<'s> {
    /// Of `scene`, from what the last frame drew.
    pub fn new(scene: &'s Scene, resources: &SceneResources, mut draws: WorldDraws) -> Self {
        draws.update(scene, resources);
        let table = DecalTable::new(scene, &resources.decals);
        draws.glows |= table.parts & DECAL_EMISSION != 0;
        if table != *draws.decals.0 {
            draws.decals = SharedDecals(Arc::new(table));
        }
        Self { scene, decals: draws.decals.clone(), draws, tables: Vec::new() }
    }

    /// The table of lights; that which the view has from its last frame if it is still right.
    fn light_table(&mut self, of: TableOf, kept: Option<&Arc<LightTable>>) -> Arc<LightTable> {
        if let Some((_, table)) = self.tables.iter().find(|(known, _)| *known == of) {
            return table.clone();
        }
        let kept = kept.filter(|table| table.is_of(self.scene, &self.draws.lit, &of));
        let make = || Arc::new(LightTable::new(self.scene, &self.draws.lit, of));
        let table = kept.cloned().unwrap_or_else(make);
        self.tables.push((of, table.clone()));
        table
    }
}

/// A view whose lights are known.
pub(super) struct Lit {
    pub range: DepthRange,
    /// From where its sample sees it.
    pub seen: SampleView,
    /// Chooses levels of detail.
    pub chooser: Chooser,
    draws: Arc<DrawList>,
    /// Whether tiles that are settled are left out once some are.
    pub is_adaptive: bool,
    /// Its lists of lights, if they had to be made.
    made: Option<(ClusterLists, LightReaches)>,
}

/// A view that can be recorded.
pub(super) struct Ready {
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

impl Renderer {
    /// Finds what a view draws, its lights, and their lists, which its state has from then on.
    pub(super) fn light(
        &self,
        asked: &Asked,
        world: &mut World<'_>,
        state: &mut ViewState,
        stats: &mut FrameStats,
    ) -> Lit {
        let range = asked.request.camera.depth_range(&world.draws.bounds_world);
        let Asked { request, size, output_size, .. } = asked;
        let aspect = output_size.0 as f32 / output_size.1 as f32;
        let seen = SampleView::of(request, aspect, &world.draws.bounds_world);
        let (shift_ndc, beyond) = asked.part.shear();
        let seen = seen.sheared(shift_ndc, beyond);
        let (lists, made) = self.lists_of(asked, (&seen, range), world, state.lists.take(), stats);
        state.lists = Some(lists);
        let chooser = Chooser::new(&request.camera, *output_size, &request.settings.lod, &world.draws.groups);
        let jitter_px = asked.temporal_jitter_px();
        let uniform = self.view_uniform(asked, (&seen, range), (*size, jitter_px), self.filtering(asked));
        let draws = match asked.part {
            ViewPart::Fisheye(_) => Arc::default(),
            _ => {
                let uniform = match asked.outline(&uniform) {
                    Some((_, rectangle)) => uniform.cropped(rectangle),
                    None => uniform,
                };
                let mut list = DrawList::new(&mut world.draws, &uniform, request.layers, &chooser);
                if let ViewPart::Probe(_) = asked.part {
                    list.show_backs();
                }
                if !world.decals.0.boxes.is_empty() {
                    find_touched(&mut list, &world.draws, &world.decals.0.boxes);
                }
                Arc::new(list)
            }
        };
        // What is settled is no picture to look through.
        let looks_through = world.draws.has_transmissive || !world.scene.water.is_empty();
        let is_adaptive = request.is_adaptive() && !looks_through;
        Lit { range, seen, chooser, draws, is_adaptive, made }
    }

    /// How the textures of a frame of the view are filtered. The first frame of a live view is shown before the others
    /// are there, and filtered like a picture of its own.
    fn filtering(&self, asked: &Asked) -> TextureFiltering {
        let (sample_index, sample_count) = asked.request.sample();
        let is_alone = asked.request.goes_on && sample_index == 0;
        let sample_count = if is_alone { 1 } else { sample_count };
        // Those before make up for what is too fine.
        let sample_count = if asked.temporal.is_some() { asked.temporal_samples() } else { sample_count };
        TextureFiltering::new(sample_count, &self.gpu.capabilities)
    }

    /// What shaders know of a view that is shaded at a size, moved by so many of its pixels beside what samples are,
    /// and whose textures are filtered so.
    fn view_uniform(
        &self,
        asked: &Asked,
        (seen, range): (&SampleView, DepthRange),
        (size, temporal_jitter_px): ((u32, u32), Vec2),
        filtering: TextureFiltering,
    ) -> ViewUniform {
        let Asked { request, output_size, .. } = asked;
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

    /// Makes a view ready: uploads what changed of its tables. Adds to the numbers of the frame.
    pub(super) fn ready(
        &self,
        (scene, asked): (&Scene, &Asked),
        (state, lit): (&mut ViewState, Lit),
        (shadows, ground, surroundings): (
            Option<(&ViewShadows, &Atlas)>,
            Option<&FrameGround>,
            Option<&FrameSurroundings>,
        ),
        has_previous: bool,
        stats: &mut FrameStats,
    ) -> Result<Ready, RenderError> {
        let Asked { request, size, output_size, .. } = asked;
        let settings = &request.settings;
        let Lit { range, seen, made, draws, is_adaptive, .. } = lit;
        let shadows = shadows.filter(|_| settings.shadows.enabled);
        let (sample_index, sample_count) = request.sample();
        let filtering = self.filtering(asked);
        let filtering_of_variables = TextureFiltering::new(1, &self.gpu.capabilities);
        let uniform = self.view_uniform(asked, (&seen, range), (*size, asked.temporal_jitter_px()), filtering);
        let settled = state.settled(request.sample_index).filter(|_| is_adaptive);
        let whole_samples = if is_adaptive { adaptive::whole_samples(sample_count) } else { None };
        // What is found in the picture is found by the first sample, and for all.
        let looks = sample_index == 0 && (settings.occlusion.enabled.is_on() || settings.reflections.enabled.is_on());
        let reads_attached_depth = self.gpu.capabilities.samples_attached_depth && whole_samples.is_some() && !looks;
        let effects_go_on = request.goes_on || request.effects_go_on;
        let display_goes_on = effects_go_on || request.sample_index > 0 && state.was_shown;
        let of_outline = asked.outline(&uniform);
        let ViewState { tables, lists, unsettled, .. } = state;
        let Some(lists) = lists else { return Err(RenderError::Missing("the lights of a view were not found")) };
        stats.draws += (draws.opaque.len() + draws.transmissive.len() + draws.blended.len()) as u32;
        stats.triangles += draws.triangles;
        for (at, count) in draws.levels.iter().enumerate() {
            stats.levels.resize(stats.levels.len().max(at + 1), LevelCount::default());
            stats.levels[at].primitives += count.primitives;
            stats.levels[at].triangles += count.triangles;
        }
        let texels = shadows.map(|(shadows, _)| shadows.texels(&lists.table));
        let texels = texels.as_ref().unwrap_or(&lists.table.texels);
        stats.uploaded_bytes += tables.write(&self.gpu, texels, made.as_ref());
        let shadow_filter = if shadows.is_some() { filter_uniform(&settings.shadows, sample_index) } else { [0.0; 4] };
        let cluster_grid =
            ClusterUniform { shadow_filter, contact: contact_uniform(&settings.shadows), ..lists.uniform };
        let tiles = self.tiles_of(asked);
        let mut environment = request.environment_uniform(tiles);
        // Sides that are captured first have the environment's light alone: the texture of the others is being drawn.
        let surroundings = surroundings
            .filter(|_| !matches!(asked.part, ViewPart::Side(SideView { bounce: 0, .. })))
            .filter(|surroundings| surroundings.have(tiles.map(|tiles| &tiles.view)));
        let of_probes = surroundings.filter(|_| matches!(asked.part, ViewPart::Probe(_))).map(|of| of.of_probes());
        let surroundings = of_probes.as_ref().or(surroundings);
        if let Some(surroundings) = surroundings {
            surroundings.place(&mut environment, request.pre_exposure());
        }
        let ground = ground.and_then(|FrameGround { map, texture, .. }| {
            let is_picture = matches!(asked.part, ViewPart::Whole | ViewPart::Monitor(_));
            let picture = is_picture.then_some((&request.camera, size.0 as f32 / size.1 as f32));
            ViewGround::new(settings.ground.mode, (map, texture), &lists.table, picture)
        });
        let shows_first_surface = settings.aov.first_surface;
        let prepare = |name: String, size: (u32, u32), uniform: ViewUniform, is_of_variables: bool| {
            let shows_first_surface = shows_first_surface && is_of_variables;
            let draws_picture = !is_of_variables && !asked.counts_pairs;
            let viewed = Viewed {
                name: name.into(),
                size,
                goes_on: request.goes_on || request.sample_index > 0,
                effects_go_on: effects_go_on || request.sample_index > 0,
                display_goes_on,
                display_exposure: request.display_exposure(),
                sample_count,
                pixel_samples: if is_of_variables || asked.counts_pairs { 1 } else { settings.msaa.samples.count() },
                uniform,
                draws: if shows_first_surface { draws.first_surfaces().into() } else { draws.clone() },
                shows_first_surface,
                sampling: if is_of_variables { filtering_of_variables.sampling } else { filtering.sampling },
                light_count: lists.table.len(),
                cluster_grid: &cluster_grid,
                constants: constants_of(
                    asked,
                    &lists.table,
                    shadows.map(|(shadows, _)| shadows),
                    (tiles, surroundings),
                    lists.decals.parts,
                ),
                lit_rectangles: lists.lit_rectangles.clone(),
                volume_draws: lists.volume_draws.clone(),
                object_lights: lists.object_lights.clone(),
                environment: &environment,
                instances: self.instances.buffer().clone(),
                shadows: shadows.map(|(_, atlas)| &atlas.view),
                ground: ground.clone(),
                whole_samples: whole_samples.filter(|_| draws_picture),
                reads_attached_depth: reads_attached_depth && draws_picture,
                settled: settled.clone().filter(|_| draws_picture),
                unsettled: match &of_outline {
                    Some((_, rectangle)) => Some([*rectangle].into()),
                    None => unsettled.clone().filter(|_| draws_picture && settled.is_some()),
                },
                outline: of_outline.map(|(outline, _)| outline),
                environment_tiles: surroundings.map(|of| &of.view).or(tiles.map(|tiles| &tiles.view)),
                decals: self.resources.decals.view(),
                decal_draws: DecalDraws::new(&lists.decals.boxes, &uniform.clip_from_world),
            };
            viewed.prepare(&self.gpu, &self.shaders, (&self.tables, &self.uniforms, &self.bind_groups), tables)
        };
        let passes = if asked.wants_variables { AovPasses::of(&request.want_aovs) } else { AovPasses::default() };
        let has_own_view = asked.wants_variables
            && (size != output_size
                || shows_first_surface
                || filtering != filtering_of_variables
                || asked.temporal.is_some())
            && settings.render.path == Path::Deferred;
        let camera_step = request.previous.as_ref().filter(|_| has_previous).map(|previous| CameraStep {
            current: request.camera,
            previous: previous.camera,
            range,
            output_size: *output_size,
        });
        let reads = |texture| effect::is_read(&request.effects, texture);
        let of_effects = Variables {
            passes: AovPasses {
                motion: reads("motion") || asked.temporal.is_some(),
                ids: reads("ids"),
                ..Default::default()
            },
            camera_step,
            reads_occlusion: reads("occlusion"),
        };
        let in_middle = (*output_size, Vec2::ZERO);
        let shown = (scene, self.shadows.scene_version);
        let variables_uniform = self.view_uniform(asked, (&seen, range), in_middle, filtering_of_variables);
        let enlarged = asked.upscaled_to().map(|_| self.view_uniform(asked, (&seen, range), in_middle, filtering));
        let of_variables = if asked.name.is_empty() { "aov".into() } else { format!("{}/aov", asked.name) };
        Ok(Ready {
            view: prepare(asked.name.clone(), *size, uniform, false),
            variables_view: has_own_view.then(|| prepare(of_variables, *output_size, variables_uniform, true)),
            enlarged_view: enlarged.map(|uniform| prepare(asked.name.clone(), *output_size, uniform, false)),
            variables: Variables { passes, ..of_effects },
            of_effects,
            temporal: asked
                .temporal
                .as_ref()
                .map(|temporal| temporal.frame(request, shown, camera_step, asked.upscaled_to())),
            is_adaptive,
            variables_uniform,
        })
    }

    /// The tiles of a view's environment, if that is a picture or the studio.
    pub(super) fn tiles_of(&self, asked: &Asked) -> Option<&EnvironmentTiles> {
        if matches!(asked.request.settings.environment.source, Environment::Studio | Environment::Fill) {
            return Some(self.tables.studio(&self.gpu));
        }
        let map = asked.environment.as_ref()?;
        self.resources.environment(map)
    }

    /// What draws what all views share, shadow maps and levels of the environment: of no camera, and with neither
    /// itself.
    pub(super) fn shared_view(
        &self,
        asked: &Asked,
        ready: &Ready,
        state: &ViewState,
        instances: &InstanceTable,
    ) -> PreparedView {
        let lists = state.lists.as_ref();
        Viewed {
            name: "".into(),
            size: asked.size,
            goes_on: false,
            effects_go_on: false,
            display_goes_on: false,
            display_exposure: 1.0,
            sample_count: 1,
            pixel_samples: 1,
            uniform: ViewUniform { sample_index: asked.request.dealing().pattern(), ..ready.view.uniform },
            draws: Arc::default(),
            shows_first_surface: false,
            sampling: ready.view.sampling,
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
        }
        .prepare(&self.gpu, &self.shaders, (&self.tables, &self.uniforms, &self.bind_groups), &state.tables)
    }

    /// The lists of lights of a view: those that it has from its last frame if they are still right; else new ones,
    /// which are given, too.
    fn lists_of(
        &self,
        asked: &Asked,
        (seen, range): (&SampleView, DepthRange),
        world: &mut World<'_>,
        kept: Option<KeptLists>,
        stats: &mut FrameStats,
    ) -> (KeptLists, Option<(ClusterLists, LightReaches)>) {
        let started = web_time::Instant::now();
        let Asked { request, size, output_size, .. } = asked;
        let settings = &request.settings;
        let culling = settings.lights.culling;
        let has_volumes = matches!(culling, LightCulling::Volumes | LightCulling::VolumesStencil);
        let has_objects = matches!(settings.render.path, Path::ForwardBatched | Path::Gouraud);
        let has_blended = world.draws.opaque_count < world.draws.items.len();
        let has_water = !world.scene.water.is_empty();
        let is_drawn = !asked.part.is_fisheye();
        let reads_lists = has_water
            || match settings.render.path {
                Path::Deferred => !has_volumes || has_blended || world.draws.is_shaded_where_drawn,
                Path::Forward => true,
                Path::ForwardBatched => has_blended,
                Path::Gouraud => world.draws.has_layers,
            };
        let of = ListsOf {
            view: seen.camera,
            range,
            target: lights::Target {
                size: *size,
                aspect: output_size.0 as f32 / output_size.1 as f32,
                shift_ndc: seen.shift_ndc,
            },
            culling,
            wants_lists: is_drawn
                && (reads_lists
                    || settings.fog.scatters()
                    || matches!(settings.debug.view, DebugView::Lights | DebugView::Clusters)),
            objects: has_objects.then(|| world.draws.object_bounds()),
            decals: if is_drawn { world.decals.clone() } else { SharedDecals::default() },
            depth_row: if has_volumes { asked.depth_row(seen, range) } else { Vec4::ZERO },
            settings: request.settings.clusters.clone(),
            limits: lights::ListLimits::of(self.gpu.capabilities.max_texture_size),
        };
        let known = kept.as_ref().map(|lists| &lists.table);
        let of_table = TableOf {
            pre_exposure: request.pre_exposure(),
            subset: request.light_subset,
            environment: asked.environment_light,
            // Of the camera, not of a sample's place in its lens: all samples have the same lights.
            least: LeastLights::new(&request.camera, *size, settings.lights.min_px),
        };
        let table = world.light_table(of_table, known);
        let (lists, made) = match kept.and_then(|lists| lists.with(&table, &of)) {
            Some(lists) => (lists, None),
            None => {
                let (mut made, reaches) = (table.cluster(&of), LightReaches::new(&table, &of));
                if let Some(objects) = &of.objects {
                    made.append_objects(&table, objects, of.limits);
                }
                made.append_decals(&of);
                stats.light_lists_made += 1;
                (KeptLists::new(table, of, &made, &reaches), Some((made, reaches)))
            }
        };
        stats.lights = stats.lights.max(lists.table.scene_lights());
        stats.lights_too_small = stats.lights_too_small.max(lists.table.left_out);
        stats.list_entries += lists.entries;
        stats.culling_ms += started.elapsed().as_secs_f64() * 1e3;
        (lists, made)
    }
}

/// The textures that a view's picture goes to; none where the frame is metered.
pub(super) fn output_of<'o>(
    gpu: &Gpu,
    asked: &Asked,
    slot: &'o mut Option<Output>,
    (purpose, settles): (&Purpose<'_>, bool),
    has_tint: bool,
) -> Option<&'o Output> {
    match purpose {
        Purpose::Meter(_) | Purpose::Variables => return None,
        Purpose::Plan | Purpose::Rounds(_) => {
            *slot = Some(Output::planned(gpu, asked.output_size, asked.means_of, settles));
        }
        _ => {
            Output::of(gpu, slot, asked.output_size, asked.means_of, settles);
        }
    }
    if let Some(output) = slot.as_mut().filter(|_| has_tint) {
        output.with_tint(gpu);
    }
    slot.as_ref()
}
