//! What is wrong with a scene, of which something is left out or drawn otherwise.

use super::Renderer;
use super::simulations::{self, SimulationState};
use super::{mirrors, portals, surroundings, water};
use crate::{decals, lights, probes};
use manypass_scene::capture::MONITORS_MAX;
use manypass_scene::{NodeId, Scene};

/// What is wrong with the scene that was loaded or drawn last.
#[derive(Debug, Default)]
pub(super) struct SceneFaults {
    /// Lights of visible nodes, be they drawn or too many.
    pub light_count: usize,
    /// Faults of mirrors, water, portals, probes, decals and simulations, when the scene was loaded.
    of_features: Vec<String>,
}

impl SceneFaults {
    pub fn of(scene: &Scene, simulated: &SimulationState) -> Self {
        let is_lit = |id: &NodeId| scene.node(*id).light.is_some();
        let light_count = scene.visible_nodes().into_iter().filter(is_lit).count();
        let of_features = [
            mirrors::faults(scene),
            water::faults(scene),
            portals::faults(scene),
            surroundings::faults(scene),
            probes::faults(scene),
            decals::faults(scene),
            simulations::faults(scene, simulated),
        ];
        Self { light_count, of_features: of_features.into_iter().flatten().collect() }
    }
}

impl Renderer {
    /// What of the scene was left out, or replaced, on the device.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.resources.warnings();
        warnings.extend(self.faults.of_features.iter().cloned());
        if self.surroundings.lacks_probes {
            let side = self.gpu.capabilities.max_texture_size;
            warnings.push(format!(
                "probes are left out: textures of the adapter, {side} texels a side, have no room for them"
            ));
        }
        let monitors = self.resources.textures.monitor_count();
        if monitors > MONITORS_MAX {
            warnings
                .push(format!("only the first {MONITORS_MAX} of {monitors} monitors are drawn; the others are dark"));
        }
        if self.faults.light_count > lights::LIGHTS_MAX as usize {
            let (drawn, count) = (lights::LIGHTS_MAX, self.faults.light_count);
            warnings.push(format!("only the first {drawn} of {count} lights are drawn"));
        }
        warnings
    }
}
