//! Which surfaces of water a view shows.

use super::ask::ViewRequest;
use super::prepare_view::ViewSetup;
use super::view_kind::Reflector;
use crate::mirror_picture::MirrorPicture;
use crate::outline::is_seen;
use crate::passes::water::WaterDraw;
use crate::resources::Textures;
use crate::waves::SIMULATED;
use glam::Vec3;
use manypass_scene::Scene;
use manypass_scene::capture::Panel;
use manypass_scene::water::{WATER_MAX, Water};
use std::collections::BTreeMap;

/// The surfaces of water that a scene shows, by their indices.
#[derive(Default)]
pub(super) struct Surfaces(Vec<(usize, Panel, Vec<Vec3>)>);

impl Surfaces {
    pub fn of(scene: &Scene) -> Self {
        if scene.water.is_empty() {
            return Self::default();
        }
        let known = scene.water.iter().take(WATER_MAX).enumerate();
        let shown = known.filter(|(_, water)| scene.shows(water.node));
        let with_outline = |(index, water): (usize, &Water)| {
            let panel = scene.panel(water.node).ok()?;
            Some((index, panel, scene.outline(water.node, &panel)))
        };
        Self(shown.filter_map(with_outline).collect())
    }

    /// Those that a view shows, the farthest first; `behind` has what views behind them left, by the views' names.
    pub fn shown(
        &self,
        (scene, textures): (&Scene, &Textures),
        (asked, ready): (&ViewRequest, &ViewSetup),
        behind: &mut BTreeMap<String, MirrorPicture>,
    ) -> Vec<WaterDraw> {
        let uniform = &ready.view.uniform;
        let column = if asked.request.camera.is_orthographic() { 2 } else { 3 };
        let eye = uniform.world_from_view.col(column);
        let shown = |(index, panel, outline): &(usize, Panel, Vec<Vec3>)| {
            let water = scene.water.get(*index)?;
            let corners = panel.corners_world();
            let is_cut = asked
                .request
                .clip_plane_world
                .is_some_and(|plane| corners.iter().all(|corner| plane.dot(corner.extend(1.0)) < 0.0));
            let in_layers = scene.nodes.get(water.node.0 as usize)?.layers & asked.request.layers != 0;
            let is_from_below = panel.plane_world().dot(eye) < 0.0;
            // The eye of a view that is cut by a plane is none of this side.
            let has_eye = column == 3 && asked.request.clip_plane_world.is_none();
            let holds_eye = has_eye && is_from_below && is_below(outline, panel.normal_world, eye.truncate());
            let is_shown = !is_cut && is_seen(&uniform.clip_from_world, &corners);
            if !in_layers || !is_shown && !holds_eye {
                return None;
            }
            let view = asked.mirrors.iter().find(|seen| seen.of == Reflector::Water(*index));
            let picture = view.and_then(|seen| behind.remove(&seen.view));
            let map = water.normal_map.and_then(|texture| textures.linear(scene, texture)).cloned();
            let simulated = water.simulation.and_then(|simulation| {
                let waves = textures.simulated(simulation, SIMULATED)?.clone();
                Some((waves, scene.place_of_simulation(simulation)))
            });
            let away_m = eye.truncate().distance(panel.center_world);
            let water = WaterDraw {
                water: water.clone(),
                panel: *panel,
                corners_world: outline.clone(),
                time_secs: scene.time_secs,
                is_from_below,
                holds_eye,
                normal_map: map,
                simulated,
                picture,
            };
            Some((away_m, water))
        };
        let mut all: Vec<(f32, WaterDraw)> = self.0.iter().filter_map(shown).collect();
        all.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        all.into_iter().map(|(_, water)| water).collect()
    }
}

/// Whether a point lies within a convex outline, along its normal; the outline goes around counterclockwise.
fn is_below(outline: &[Vec3], normal: Vec3, point: Vec3) -> bool {
    let next = outline.iter().cycle().skip(1);
    outline.len() > 2 && outline.iter().zip(next).all(|(a, b)| (*b - *a).cross(point - *a).dot(normal) >= 0.0)
}

/// What is wrong with water of a scene, which is not drawn then.
pub(super) fn faults(scene: &Scene) -> Vec<String> {
    let fault = |water: &Water| {
        let what = scene.panel(water.node).err()?;
        Some(format!("water `{}` is not drawn: its surface is flat, and its node {what}", water.name))
    };
    let mut faults: Vec<String> = scene.water.iter().take(WATER_MAX).filter_map(fault).collect();
    if scene.water.len() > WATER_MAX {
        faults.push(format!("only the first {WATER_MAX} of {} surfaces of water are drawn", scene.water.len()));
    }
    faults
}
