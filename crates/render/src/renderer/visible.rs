//! What views draw, and which lights reach it.

use super::Renderer;
use super::ask::ViewRequest;
use super::output::ViewState;
use crate::constants::{DECAL_EMISSION, SHARP_ROUGHNESS};
use crate::decals::{DecalTable, SharedDecals};
use crate::draws::{DrawList, ListOf, WorldDraws};
use crate::lens::SampleView;
use crate::levels::Chooser;
use crate::lights::{
    self, CachedLists, ClusterLists, LeastLights, LightCulling, LightListInputs, LightReaches, LightTable, TableOf,
};
use crate::passes::debug::DebugView;
use crate::render_settings::Path;
use crate::request::FrameStats;
use crate::resources::SceneResources;
use crate::view::DepthRange;
use glam::{Vec2, Vec4};
use manypass_scene::Scene;
use std::sync::Arc;

/// The scene as a frame draws it: what all of its views are prepared from.
pub(super) struct FrameScene<'s> {
    pub scene: &'s Scene,
    pub draws: WorldDraws,
    /// Whether the device knows where everything was before.
    pub has_previous: bool,
    /// Those that are shown.
    decals: SharedDecals,
    /// Most views share one.
    tables: Vec<(TableOf, Arc<LightTable>)>,
}

impl<'s> FrameScene<'s> {
    /// Of `scene`, from what the last frame drew.
    pub fn new(scene: &'s Scene, resources: &SceneResources, mut draws: WorldDraws) -> Self {
        draws.update(scene, resources);
        let table = DecalTable::new(scene, &resources.decals);
        draws.glows |= table.parts & DECAL_EMISSION != 0;
        draws.may_be_smooth |= scene.decals.iter().any(|decal| decal.look.may_be_smooth(SHARP_ROUGHNESS));
        if table != *draws.decals.0 {
            draws.decals = SharedDecals(Arc::new(table));
        }
        Self { scene, has_previous: false, decals: draws.decals.clone(), draws, tables: Vec::new() }
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

/// What a view draws, and the lights that reach it.
pub(super) struct VisibleSet {
    pub range: DepthRange,
    /// From where its sample sees it.
    pub seen: SampleView,
    /// Chooses levels of detail.
    pub chooser: Chooser,
    pub draws: Arc<DrawList>,
    /// Whether tiles that are settled are left out once some are.
    pub is_adaptive: bool,
    /// Its lists of lights, and what of them had to be made.
    pub lists: CachedLists,
    pub made: Option<(ClusterLists, LightReaches)>,
}

impl Renderer {
    /// Finds what a view draws, its lights, and their lists. Its state has none until its tables hold them.
    pub(super) fn visible_set(
        &self,
        asked: &ViewRequest,
        world: &mut FrameScene<'_>,
        state: &mut ViewState,
        stats: &mut FrameStats,
    ) -> VisibleSet {
        let range = asked.request.camera.depth_range(&world.draws.bounds_world);
        let ViewRequest { request, size, output_size, .. } = asked;
        let aspect = output_size.0 as f32 / output_size.1 as f32;
        let seen = SampleView::of(request, aspect, &world.draws.bounds_world);
        let (shift_ndc, beyond) = asked.kind.shear;
        let seen = seen.sheared(shift_ndc, beyond);
        let (lists, made) = self.lists_of(asked, (&seen, range), world, state.lists.take(), stats);
        let chooser = Chooser::new(&request.camera, *output_size, &request.settings.lod, &world.draws.groups);
        let jitter_px = asked.temporal_jitter_px();
        let uniform = self.view_uniform(asked, (&seen, range), (*size, jitter_px), self.filtering(asked));
        let draws = if asked.kind.draws_surfaces {
            let (uniform, room_px) = match asked.outline(&uniform) {
                Some((_, rectangle)) => (uniform.cropped(rectangle), 0.0),
                None if jitter_px == Vec2::ZERO => (uniform, 0.0),
                // One list is right for frames that are moved against each other.
                None => {
                    let in_middle = (*size, Vec2::ZERO);
                    let room_px = jitter_px.abs().max_element().ceil();
                    (self.view_uniform(asked, (&seen, range), in_middle, self.filtering(asked)), room_px)
                }
            };
            let (view, layers, shows_backs) = (&uniform, request.layers, asked.kind.shows_backs);
            world.draws.list(&ListOf { view, room_px, layers, chooser: &chooser, shows_backs })
        } else {
            Arc::default()
        };
        // What is settled is no picture to look through.
        let looks_through = world.draws.has_transmissive || !world.scene.water.is_empty();
        let is_adaptive = request.is_adaptive() && !looks_through;
        VisibleSet { range, seen, chooser, draws, is_adaptive, lists, made }
    }

    /// The lists of lights of a view: those that it has from its last frame if they are still right; else new ones,
    /// which are given, too.
    fn lists_of(
        &self,
        asked: &ViewRequest,
        (seen, range): (&SampleView, DepthRange),
        world: &mut FrameScene<'_>,
        kept: Option<CachedLists>,
        stats: &mut FrameStats,
    ) -> (CachedLists, Option<(ClusterLists, LightReaches)>) {
        let started = web_time::Instant::now();
        let ViewRequest { request, size, output_size, .. } = asked;
        let settings = &request.settings;
        let culling = settings.lights.culling;
        let has_volumes = matches!(culling, LightCulling::Volumes | LightCulling::VolumesStencil);
        let has_objects = matches!(settings.render.path, Path::ForwardBatched | Path::Gouraud);
        let has_blended = world.draws.opaque_count < world.draws.items.len();
        let has_water = !world.scene.water.is_empty();
        let is_drawn = asked.kind.draws_surfaces;
        let reads_lists = has_water
            || match settings.render.path {
                Path::Deferred => !has_volumes || has_blended || world.draws.is_shaded_where_drawn,
                Path::Forward => true,
                Path::ForwardBatched => has_blended,
                Path::Gouraud => world.draws.has_layers,
            };
        let of = LightListInputs {
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
            lamp_scale: request.lamp_scale(),
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
                (CachedLists::new(table, of, &made, &reaches), Some((made, reaches)))
            }
        };
        stats.lights = stats.lights.max(lists.table.scene_lights());
        stats.lights_too_small = stats.lights_too_small.max(lists.table.left_out);
        stats.list_entries += lists.entries;
        stats.culling_ms += started.elapsed().as_secs_f64() * 1e3;
        (lists, made)
    }
}
