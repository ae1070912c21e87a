//! The shadows of a frame: the atlas on the device, and which of its tiles are drawn.

use super::Renderer;
use super::ask::ViewRequest;
use super::next::NextState;
use super::purpose::Purpose;
use super::visible::{FrameScene, VisibleSet};
use crate::draws::WorldDraws;
use crate::gpu::{Gpu, destroy};
use crate::lights::LightTable;
use crate::record::{InstanceTable, depth_texture};
use crate::request::FrameRequest;
use crate::shadows::{AROUND_DIRECTIONAL_PX, FrameShadows, ShadowFilter, ShadowSettings, Shadows, Viewer};
use crate::transparency::Masks;
use manypass_graph::TextureDesc;
use manypass_scene::{NodeId, Scene};
use std::hash::{DefaultHasher, Hash, Hasher};

/// From more lights on, four comparisons of each a sample cost more than the grain of one is worth: a tenth of the demo's
/// hall, which has 1,184.
const GRAINY_LIGHTS: u32 = 8;

/// What the renderer keeps of shadows.
#[derive(Debug)]
pub(super) struct ShadowState {
    pub tiles: Shadows,
    pub atlas: Option<Atlas>,
    pub instances: InstanceTable,
    /// Rises whenever a mesh or a material of the scene changed.
    pub scene_version: u64,
    /// Of the last frame the lights for whose maps there was no room, and those whose maps are too coarse.
    pub beyond: Vec<NodeId>,
    pub starved: Vec<NodeId>,
}

/// The texture of all shadow maps.
#[derive(Clone, Debug)]
pub(super) struct Atlas {
    pub side: u32,
    pub view: wgpu::TextureView,
}

impl Atlas {
    /// The shape of an atlas.
    pub fn desc(side: u32) -> TextureDesc {
        TextureDesc::new_2d(side, side, wgpu::TextureFormat::Depth32Float)
    }

    fn new(gpu: &Gpu, side: u32) -> Self {
        let texture = depth_texture(gpu, "shadows", side);
        Self { side, view: texture.create_view(&Default::default()) }
    }
}

impl ShadowState {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            tiles: Shadows::default(),
            atlas: None,
            instances: InstanceTable::new(gpu),
            scene_version: 0,
            beyond: Vec::new(),
            starved: Vec::new(),
        }
    }

    /// Another number whenever what casts shadows may be another: with the scene, and with the masks and the relief of
    /// the first view, whose constants the views that draw maps have.
    pub fn version(&self, asked: &[ViewRequest]) -> u64 {
        let settings = asked.first().map(|asked| &asked.request.settings);
        let masks = settings.map(|settings| settings.transparency.masks);
        let relief = settings.map(|settings| (settings.relief.steps_min, settings.relief.steps_max));
        let mut hasher = DefaultHasher::new();
        (self.scene_version, masks == Some(Masks::Hashed), relief).hash(&mut hasher);
        hasher.finish()
    }
}

/// The settings of the shadows of a frame, and the largest side of their atlas: those of the first of its views that
/// has some. None if no light casts any.
fn settings_of<'a>(asked: &'a [ViewRequest], scene: &Scene, limit: u32) -> Option<(&'a ShadowSettings, u32)> {
    let casts = |light: &usize| scene.lights.get(*light).is_some_and(|light| light.casts_shadows);
    let of_environment = usize::from(asked.iter().any(|asked| asked.environment_light.is_some()));
    let lights = scene.light_indices().iter().filter(|light| casts(light)).count() + of_environment;
    if lights == 0 {
        return None;
    }
    let settings = asked.iter().map(|asked| &asked.request.settings.shadows).find(|settings| settings.enabled)?;
    let of_view = |asked: &ViewRequest| {
        if asked.kind.is_around { AROUND_DIRECTIONAL_PX } else { asked.size.0.max(asked.size.1) }
    };
    let longest_px = asked.iter().map(of_view).max()?;
    Some((settings, Shadows::side_allowed(settings, limit, longest_px, lights)))
}

/// Whether a sample of a still compares but once with a map, by turns at the four places of a filter: in their mean
/// that is the filter. With few samples, each place would meet too few parts of a pixel; and one that is shown before
/// the others are there is filtered like a picture of its own. Surfaces that let light through are in maps by chance,
/// and one comparison of few texels would show that as grain; of many lights no one's grain is seen.
pub(super) fn takes_one_tap(request: &FrameRequest, world: &WorldDraws, lights: &LightTable) -> bool {
    let (settings, (sample_index, sample_count)) = (&request.settings.shadows, request.sample());
    let is_shown = request.goes_on && sample_index == 0;
    let has_four = settings.filter == ShadowFilter::Pcf && settings.kernel == 2;
    let is_whole = world.opaque_count == world.items.len() || lights.len() > GRAINY_LIGHTS;
    settings.enabled && has_four && sample_count >= 16 && !is_shown && is_whole
}

/// The uniform's part that says how shadows are filtered in a sample: see `light_table.wgsl`.
pub(super) fn filter_uniform(settings: &ShadowSettings, sample_index: u32) -> [f32; 4] {
    let [spread, hard] = match settings.filter {
        ShadowFilter::Hard => [0.0, 1.0],
        ShadowFilter::Pcf | ShadowFilter::Pcss => [0.5, 0.0],
    };
    // Sums, because successive samples lie in a fixed order across a pixel, and each place shall meet every part of it.
    let turn = (sample_index + sample_index / 4) % 4;
    [spread, hard, turn as f32, settings.bias_texels]
}

/// The uniform's part that says how far rays in the picture look for more shadows, and whether the sample skips
/// converged tiles: see `light_table.wgsl`.
pub(super) fn contact_uniform(settings: &ShadowSettings, leaves_out: bool) -> [f32; 4] {
    let thickness_m =
        if settings.contact_thickness_m > 0.0 { settings.contact_thickness_m } else { 0.5 * settings.contact_m };
    [settings.contact_m, thickness_m.max(1e-6).recip(), f32::from(u8::from(leaves_out)), 0.0]
}

impl Renderer {
    /// Bytes that the atlas may take beyond what it does, in this frame or a later one.
    pub(super) fn missing_shadow_bytes(&self, asked: &[ViewRequest], scene: &Scene) -> u64 {
        let settings = settings_of(asked, scene, self.gpu.capabilities.max_texture_size);
        let known = self.shadows.atlas.as_ref().map_or(0, |atlas| Atlas::desc(atlas.side).bytes());
        settings.map_or(0, |(_, side_max)| Atlas::desc(side_max).bytes().saturating_sub(known))
    }

    /// An atlas in the place of the former one, of which nothing is known any more.
    fn create_atlas(&mut self, side: u32) -> Atlas {
        if let Some(former) = self.shadows.atlas.take() {
            destroy(&former.view);
        }
        self.shadows.tiles = Shadows::default();
        self.drawing.clear();
        self.shadows.atlas.insert(Atlas::new(&self.gpu, side)).clone()
    }

    /// The shadows of the views of a frame, of which some have any; and the atlas that holds them.
    pub(super) fn prepare_shadows(
        &mut self,
        asked: &[ViewRequest],
        lit: &[VisibleSet],
        world: &FrameScene<'_>,
        next: &mut NextState,
        purpose: &Purpose<'_>,
    ) -> Option<(FrameShadows, Atlas)> {
        let (settings, side_max) = settings_of(asked, world.scene, self.gpu.capabilities.max_texture_size)?;
        let of_view = |(asked, lit): (&'_ ViewRequest, &'_ VisibleSet)| {
            let is_drawn = asked.request.settings.shadows.enabled && asked.kind.draws_surfaces;
            is_drawn.then_some((
                asked.name.clone(),
                asked.request.camera,
                asked.size,
                (lit.range, lit.seen.beyond),
                asked.request.settings.fog.scatters(),
                asked.kind.is_around,
                lit.lists.table.clone(),
            ))
        };
        let views: Vec<_> = asked.iter().zip(lit).map(of_view).collect();
        let viewers: Vec<_> = views
            .iter()
            .flatten()
            .map(|(name, view, size, (range, beyond), sees_air, is_around, table)| {
                let (range, beyond) = (*range, *beyond);
                let (sees_air, is_around) = (*sees_air, *is_around);
                (Viewer { name, view, range, size: *size, sees_air, beyond, is_around }, &**table)
            })
            .collect();
        let version = self.shadows.version(asked);
        // All views share the maps; the last, which is the outermost, says which levels cast.
        let chooser = lit.last().map(|lit| &lit.chooser);
        let dealing = asked.first().map(|asked| asked.request.dealing())?;
        let tiles = &mut next.shadows;
        tiles.allow(side_max);
        if purpose.reads_passes {
            // Whoever wants the pictures of all passes wants those of shadow maps, too.
            tiles.redraw();
        }
        let mut frame = tiles.prepare((&world.draws, chooser), version, &viewers, settings, dealing);
        let mut of_viewers = std::mem::take(&mut frame.views).into_iter();
        let in_order = views.iter().map(|view| view.as_ref().and_then(|_| of_viewers.next()).unwrap_or_default());
        frame.views = in_order.collect();
        let side = tiles.atlas_side();
        let atlas = match self.shadows.atlas.clone().filter(|atlas| atlas.side == side) {
            Some(atlas) => atlas,
            None if !next.is_run => Atlas { side, view: self.drawing.tables.no_shadows.clone() },
            None => self.create_atlas(side),
        };
        let stats = &mut next.stats;
        stats.lights_starved = frame.starved.len() as u32;
        stats.lights_beyond_atlas = frame.beyond.len() as u32;
        let named = |lights: &[Option<NodeId>]| lights.iter().copied().flatten().collect();
        next.unshadowed = Some([named(&frame.beyond), named(&frame.starved)]);
        if next.is_run {
            stats.uploaded_bytes += self.shadows.instances.write(&self.gpu, &frame.instances);
        }
        stats.shadowed_lights = frame.counts.lights;
        stats.shadow_tiles_drawn = frame.counts.tiles_drawn;
        stats.shadow_tiles_kept = frame.counts.tiles_kept;
        stats.lights_dealt = frame.counts.dealt;
        stats.light_rounds = frame.counts.rounds;
        stats.lights_in_emitters = frame.counts.in_emitters;
        stats.draws += frame.tiles.iter().map(|tile| tile.draws.len() as u32).sum::<u32>();
        stats.texture_bytes_of_shadows = Atlas::desc(side).bytes();
        Some((frame, atlas))
    }
}
