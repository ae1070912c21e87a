//! What lights probes whose light frames find: another one tells that they are to be looked around again.

use crate::environment::{Environment, EnvironmentSettings};
use crate::fog::FogSettings;
use crate::request::FrameRequest;
use crate::settings::Settings;
use crate::shading_settings::ShadingSettings;
use crate::shadows::ShadowSettings;
use manypass_scene::decal::Decal;
use manypass_scene::{Light, NodeId, Scene};
use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

/// What probes have as their environment: the studio that lets one see what lamps light is no light.
pub(super) fn environment_of(settings: &Settings) -> EnvironmentSettings {
    let mut environment = settings.environment.clone();
    if environment.source == Environment::Fill {
        environment.source = Environment::None;
    }
    environment
}

/// What lights probes: another one whenever their light is another.
#[derive(Debug, PartialEq)]
pub(super) struct ProbeLighting {
    /// Of what stands where.
    nodes: u64,
    lights: Vec<Light>,
    decals: Vec<Decal>,
    environment: EnvironmentSettings,
    shadows: ShadowSettings,
    fog: FogSettings,
    shading: ShadingSettings,
    light_subset: Option<(u32, u32)>,
    /// What lights of the scene are multiplied by.
    lamp_scale: f32,
}

impl ProbeLighting {
    pub fn new(scene: &Scene, scene_version: u64, request: &FrameRequest) -> Self {
        let settings = &request.settings;
        Self {
            nodes: hash_of_nodes(scene, scene_version),
            lights: scene.lights.clone(),
            decals: scene.decals.clone(),
            environment: environment_of(settings),
            shadows: settings.shadows.clone(),
            fog: settings.fog.clone(),
            shading: settings.shading.clone(),
            light_subset: request.light_subset,
            lamp_scale: request.lamp_scale(),
        }
    }
}

/// Another number whenever what probes see, and what casts shadows or light there, is another or stands elsewhere.
fn hash_of_nodes(scene: &Scene, scene_version: u64) -> u64 {
    let mut hasher = DefaultHasher::new();
    (scene_version, scene.variant, &scene.roots).hash(&mut hasher);
    let layers = scene.probes.iter().filter_map(|grid| grid.live).fold(0, |all, live| all | live.layers);
    let joints: BTreeSet<NodeId> = scene.skins.iter().flat_map(|skin| skin.joints.iter().copied()).collect();
    // Cameras and what moves them light nothing, nor does what no probe sees and what casts no shadow.
    for (id, _) in scene.visible_levels() {
        let node = scene.node(id);
        let is_seen = node.mesh.is_some() && (node.layers & layers != 0 || node.casts_shadow);
        if is_seen || node.light.is_some() || joints.contains(&id) {
            (id, node.mesh, node.light, node.layers, node.casts_shadow).hash(&mut hasher);
            node.world_from_object.to_cols_array().map(f32::to_bits).hash(&mut hasher);
            node.morph_weights.iter().for_each(|weight| weight.to_bits().hash(&mut hasher));
        }
    }
    hasher.finish()
}
