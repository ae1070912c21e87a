//! Which tiles the lights of a frame want, and how large.

use super::cascades;
use super::casters::{Caster, Casters, OfLight};
use super::dealing::is_wide;
use super::projection::{BORDER_TEXELS, TileProjection, cube_faces, looking_along};
use super::room::{GRANTED_SCALE, Need};
use super::{Dealing, LightKey, SIDE_MIN, ShadowFilter, ShadowSettings, Shadows};
use crate::constants::PENUMBRA_MAX;
use crate::draws::WorldDraws;
use crate::lights::{LightTable, TableLight};
use crate::view::{DepthRange, View};
use glam::{Quat, Vec2, Vec3};
use manypass_scene::LightKind;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f32::consts::FRAC_PI_3;

/// A view that shows shadows.
#[derive(Clone, Copy, Debug)]
pub struct Viewer<'v> {
    /// Its name.
    pub name: &'v str,
    /// Its camera.
    pub view: &'v View,
    /// What its depth is fitted to.
    pub range: DepthRange,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Whether shadows are seen in the air, before what stands nearest, too.
    pub sees_air: bool,
    /// How far samples see beyond the picture: metres everywhere, and beside them metres a metre.
    pub beyond: [f32; 2],
    /// Whether it sees a side of what is around one of many places, small and for no picture. Maps are then as fine wherever
    /// that is, and those of directional lights show the whole scene, so that they are drawn once for all places.
    pub is_around: bool,
}

/// A light with the tiles that it wants.
pub(super) struct TileDemand {
    pub key: LightKey,
    pub is_directional: bool,
    pub aims: Vec<Aim>,
    /// The demanded side.
    pub side: f32,
    /// The same where all maps have room for it.
    with_room: WithRoom,
    pub of_light: OfLight,
    /// Of each tile, if anything casts a shadow into it.
    pub has_casters: Vec<bool>,
}

impl TileDemand {
    /// How many tiles it wants: those that anything casts a shadow into.
    pub fn tile_count(&self) -> u64 {
        self.has_casters.iter().filter(|has| **has).count() as u64
    }

    /// The texels of its tiles, if they have such a side.
    fn texels(&self, side: f32) -> u64 {
        let side = (side as u32).max(SIDE_MIN).next_power_of_two();
        self.tile_count() * u64::from(side).pow(2)
    }
}

/// The side of a map that is as fine as there may be room for.
#[derive(Clone, Copy, Debug)]
struct WithRoom {
    side: f32,
    /// The side if the light wanted [`GRANTED_SCALE`] times as many texels.
    side_with_margin: f32,
}

impl WithRoom {
    /// Of a map that has the same side however much room there is.
    fn fixed(side: f32) -> Self {
        Self { side, side_with_margin: side }
    }

    /// The greater one of each side.
    fn max(self, other: Self) -> Self {
        Self { side: self.side.max(other.side), side_with_margin: self.side_with_margin.max(other.side_with_margin) }
    }
}

/// What a tile is to see, before it is known how large it is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Aim {
    Rays { position: Vec3, rotation: Quat, tangent: f32, near_m: f32, shift_texels: Vec2 },
    Parallel { rotation: Quat, center: Vec3, half_m: f32, depth: [f32; 2] },
}

/// Wider spots, by half their angle, have the faces of a cube; a single tile would be blurred in its middle.
const SPOT_MAX_RAD: f32 = FRAC_PI_3;
/// The nearest caster as a share of the range, in metres at most and at least.
const NEAR_SHARE: f32 = 1.0 / 512.0;
const NEAR_M: [f32; 2] = [1e-4, 0.02];
/// The texels of smaller tiles are not moved: the surface's plane, which is found as if they were not, would be off by
/// more than the bias allows for.
const SHIFTED_SIDE_MIN: u32 = 128;
/// The sides in texels of maps for what is around places: of lights at a place, as fine over a right angle as the views
/// around probes are, and of directional ones, over the whole scene.
const AROUND_PX: f32 = 64.0;
pub(crate) const AROUND_DIRECTIONAL_PX: u32 = 512;

impl Aim {
    pub fn projection(&self, side: u32) -> TileProjection {
        match *self {
            Self::Rays { position, rotation, tangent, near_m, shift_texels } => {
                let shift_texels = if side < SHIFTED_SIDE_MIN { Vec2::ZERO } else { shift_texels };
                TileProjection::perspective(position, rotation, [tangent, near_m], shift_texels, side)
            }
            Self::Parallel { rotation, center, half_m, depth } => {
                // The grid of texels stays where it is in the world, so that a moving camera moves no shadow's edge.
                let texel_m = TileProjection::parallel(rotation, Vec2::ZERO, half_m, depth, side).texel_m;
                let center = (rotation.inverse() * center).truncate();
                let snapped = (center / texel_m).round() * texel_m;
                TileProjection::parallel(rotation, snapped, half_m, depth, side)
            }
        }
    }

    /// The same with no more depth than what casts a shadow into it takes, in steps, so that it stays while casters
    /// move a little; and so wide that `shadows.wgsl` finds penumbrae of a light with that `penumbra_tan`, half the angle that it
    /// takes in the sky.
    fn fitted(self, casters: &Casters<'_>, items: &[Caster], penumbra_tan: f32) -> Self {
        let Self::Parallel { rotation, center, half_m, depth } = self else { return self };
        let at = (rotation.inverse() * center).truncate();
        let range = |half_m: f32| {
            // The smallest tile has the widest border, and the grid of texels moves it by half a texel.
            let column_m = half_m * (1.0 + 1.0 / SIDE_MIN as f32) / (1.0 - 2.0 * BORDER_TEXELS / SIDE_MIN as f32);
            casters.depth_range(items, rotation, at, column_m)
        };
        let Some((nearest, farthest)) = range(half_m) else { return self };
        let widest_m = penumbra_tan * (nearest - farthest) / PENUMBRA_MAX;
        let half_m = if widest_m > half_m { widest_m.log2().ceil().exp2() } else { half_m };
        let Some((nearest, farthest)) = range(half_m) else { return self };
        let step_m = 0.5 * half_m.log2().floor().exp2();
        let nearest = ((nearest / step_m).floor() + 1.0) * step_m;
        let farthest = ((farthest / step_m).ceil() - 1.0) * step_m;
        Self::Parallel { rotation, center, half_m, depth: [nearest.min(depth[0]), farthest.max(depth[1])] }
    }

    /// The tiles of a light at a place, whose texels are moved by `shift_texels`.
    pub fn of_local(light: &TableLight, shift_texels: Vec2) -> Vec<Self> {
        let near_m = (light.range_m.unwrap_or(f32::INFINITY) * NEAR_SHARE).clamp(NEAR_M[0], NEAR_M[1]);
        let position = light.position;
        match light.kind {
            LightKind::Spot { outer_cone_rad, .. } if outer_cone_rad < SPOT_MAX_RAD => {
                let (rotation, tangent) = (looking_along(light.direction), outer_cone_rad.max(0.01).tan());
                vec![Self::Rays { position, rotation, tangent, near_m, shift_texels }]
            }
            _ => cube_faces()
                .map(|rotation| Self::Rays { position, rotation, tangent: 1.0, near_m, shift_texels })
                .to_vec(),
        }
    }
}

/// The side in texels at which a local light's shadow is as fine as the picture, half way to the end of its range; none
/// if the view does not see what the light reaches.
pub(super) fn demand(light: &TableLight, viewer: &Viewer<'_>) -> Option<f32> {
    let view = viewer.view;
    let (width, height) = (viewer.size.0 as f32, viewer.size.1 as f32);
    let half_extent = view.half_extent(width / height.max(1.0));
    let Some(range_m) = light.range_m else { return Some(f32::MAX) };
    let reach = crate::lights::Reach::of_light(light.kind, light.position, light.direction, range_m);
    let center = view.world_from_view.inverse().transform_point3(reach.center);
    let distance_m = -center.z;
    if distance_m + reach.radius_m < 0.0 || distance_m - reach.radius_m > viewer.range.far_m {
        return None;
    }
    let [beyond_m, slope] = viewer.beyond;
    let beyond = |along: f32, half: f32| {
        let half = half + slope;
        // The distance to the plane through the eye at the edge of the picture.
        let length = (1.0 + half * half).sqrt();
        let plane =
            if view.is_orthographic() { along.abs() - half } else { (along.abs() - half * distance_m) / length };
        plane > reach.radius_m + beyond_m
    };
    if beyond(center.x, half_extent.x) || beyond(center.y, half_extent.y) {
        return None;
    }
    if viewer.is_around {
        return Some(AROUND_PX);
    }
    let tangent = match light.kind {
        LightKind::Spot { outer_cone_rad, .. } if outer_cone_rad < SPOT_MAX_RAD => outer_cone_rad.tan(),
        _ => 1.0,
    };
    // In whichever direction it lies, so that a turning camera changes nothing.
    let eye_m = (center.length() - 0.5 * range_m).max(0.25 * range_m);
    Some(tangent * range_m * view.pixels_per_m(viewer.size, eye_m))
}

/// The sides in texels that the maps of a light are to have for a view, in an atlas that may grow to `side_max`: among
/// many lights, and where all maps have room; none if the view needs none of them.
fn sides_of(
    light: &TableLight,
    viewer: &Viewer<'_>,
    settings: &ShadowSettings,
    side_max: u32,
) -> Option<(f32, WithRoom)> {
    let given = (settings.map_px > 0).then(|| settings.map_px.next_power_of_two());
    if light.kind == LightKind::Directional {
        if let Some(side) = given {
            let side = side.min(side_max / 2) as f32;
            return Some((side, WithRoom::fixed(side)));
        }
        // Cascades are as fine as the picture if they have twice its pixels.
        let side = if viewer.is_around {
            AROUND_DIRECTIONAL_PX
        } else {
            2 * viewer.size.0.max(viewer.size.1).next_power_of_two()
        };
        let side = side.min(side_max / 2) as f32;
        // Edges of wide ones are never sharp.
        let side = if is_wide(light) { 0.5 * side } else { side };
        return Some((side, WithRoom::fixed(side)));
    }
    let demanded = demand(light, viewer).filter(|side| *side >= settings.min_px)?;
    // The six of a point light take less than half of the atlas, so that turns have room for them.
    let most = match (given, is_single(light)) {
        (Some(_), true) => side_max / 2,
        (Some(_), false) | (None, true) => side_max / 4,
        (None, false) => side_max / 8,
    };
    // Edges of lights with a radius are not sharp, and their maps are drawn anew in every sample.
    let most_with_room = if given.is_none() && light.radius_m == 0.0 { 2 * most } else { most };
    let most_with_room = most_with_room as f32;
    let with_room = match given {
        Some(side) => WithRoom::fixed((side as f32).min(most_with_room)),
        None => WithRoom {
            side: demanded.min(most_with_room),
            side_with_margin: (GRANTED_SCALE * demanded).min(most_with_room),
        },
    };
    let wanted = given.map_or(demanded, |side| side as f32);
    Some((wanted.min(most as f32), with_room))
}

impl Shadows {
    /// The lights that want tiles.
    pub(super) fn demands(
        &mut self,
        casters: &Casters<'_>,
        world: &WorldDraws,
        views: &[(Viewer<'_>, &LightTable)],
        settings: &ShadowSettings,
        dealing: Dealing,
    ) -> Vec<TileDemand> {
        let mut demands: BTreeMap<LightKey, TileDemand> = BTreeMap::new();
        let mut everywhere = None;
        let is_lamp = |light: &&TableLight| light.casts_shadows && light.kind != LightKind::Directional;
        let lamps = views.iter().map(|(_, table)| table.lights.iter().filter(is_lamp).count()).max().unwrap_or(0);
        for (viewer, table) in views {
            for source in table.lights.iter().filter(|light| light.casts_shadows) {
                let light = &dealing.moved(source);
                let sides = sides_of(light, viewer, settings, self.side_max);
                let Some((side, with_room)) = sides else { continue };
                let key = LightKey::of(viewer, light);
                match demands.entry(key) {
                    Entry::Occupied(mut known) => {
                        let known = known.get_mut();
                        known.side = known.side.max(side);
                        known.with_room = known.with_room.max(with_room);
                    }
                    Entry::Vacant(place) => {
                        let is_directional = light.kind == LightKind::Directional;
                        let (aims, of_light) = if is_directional {
                            let items = everywhere.get_or_insert_with(|| casters.everywhere().items).clone();
                            let aims = cascades::of_directional(light, viewer, world, settings);
                            // A width that is given stays.
                            let of_blockers = settings.filter == ShadowFilter::Pcss && settings.extent_m == 0.0;
                            let penumbra_tan = if of_blockers { light.radius_m } else { 0.0 };
                            let fitted = |aim: Aim| aim.fitted(casters, &items, penumbra_tan);
                            let aims = aims.into_iter().map(fitted).collect();
                            (aims, OfLight { items, is_in_emitter: false })
                        } else {
                            let range_m = light.range_m.unwrap_or(f32::INFINITY);
                            (
                                Aim::of_local(light, dealing.shift_texels(light, lamps)),
                                casters.around(light.position, source.position, range_m),
                            )
                        };
                        // The smallest tile has the widest border.
                        let shows = |aim: &Aim| {
                            let projection = aim.projection(SIDE_MIN);
                            casters.in_tile(&of_light.items, &projection).next().is_some()
                        };
                        let has_casters = aims.iter().map(shows).collect();
                        place.insert(TileDemand { key, is_directional, aims, side, with_room, of_light, has_casters });
                    }
                }
            }
        }
        let mut demands: Vec<TileDemand> = demands.into_values().collect();
        let need = Need {
            texels: demands.iter().map(|light| light.texels(light.with_room.side)).sum(),
            texels_with_margin: demands.iter().map(|light| light.texels(light.with_room.side_with_margin)).sum(),
        };
        // Stills depend on no frame before. What is around places needs little, and says nothing of the picture's needs.
        let is_live = dealing.goes_on && views.iter().any(|(viewer, _)| !viewer.is_around);
        if self.room.grants(need, u64::from(self.side_max).pow(2), is_live) {
            demands.iter_mut().for_each(|light| light.side = light.with_room.side);
        }
        demands
    }
}

/// Whether one tile shows all that the light reaches.
fn is_single(light: &TableLight) -> bool {
    matches!(light.kind, LightKind::Spot { .. }) && Aim::of_local(light, Vec2::ZERO).len() == 1
}
