//! Which views the renderer keeps from frame to frame, and when it forgets them.

use super::Renderer;
use super::ask::ViewRequest;
use super::output::{Output, ViewState};
use crate::aov::AovTextures;
use manypass_scene::Scene;
use std::collections::BTreeMap;

/// The kind and the name of what has views within pictures.
pub(super) type CapturedName = (&'static str, String);

/// What of a scene has views of its own within pictures, seen or not. Names of those views are made of it.
fn captured(scene: &Scene) -> impl Iterator<Item = (&'static str, &str)> {
    let monitors = scene.monitors().map(|(_, image, _)| ("monitor", image.name.as_str()));
    let mirrors = scene.mirrors.iter().map(|mirror| ("mirror", mirror.name.as_str()));
    let water = scene.water.iter().map(|water| ("water", water.name.as_str()));
    let portals = scene.portals.iter().map(|portal| ("portal", portal.name.as_str()));
    let surroundings = scene.surroundings.iter().map(|of| ("surroundings", of.name.as_str()));
    let probes = scene.probes.iter().map(|grid| ("probes", grid.name.as_str()));
    monitors.chain(mirrors).chain(water).chain(portals).chain(surroundings).chain(probes)
}

impl Renderer {
    /// How many views the renderer keeps something of: those that it was asked for, by their names, and those of
    /// monitors, mirrors, portals, water, reflection probes and irradiance probes of the scene, once they were drawn. A
    /// renderer that draws two scenes by turns keeps none of these views from one to the other.
    pub fn view_count(&self) -> usize {
        self.views.len()
    }

    /// Bytes of the textures that it keeps of them: pictures, means, variables, lists of lights. Those that passes keep
    /// from frame to frame are in [`Self::pool_bytes`].
    pub fn view_bytes(&self) -> u64 {
        self.views.values().map(ViewState::bytes).sum()
    }

    /// After a frame: if the scene has other monitors, mirrors and the like than that of the frame before, forgets the
    /// views within pictures that the frame did not draw. As long as it has the same, those are kept that are out of
    /// sight, or wait for their turn.
    pub(super) fn forget_gone_views(&mut self, scene: &Scene, asked: &[ViewRequest]) {
        if captured(scene).eq(self.captured.iter().map(|(kind, name)| (*kind, name.as_str()))) {
            return;
        }
        self.captured = captured(scene).map(|(kind, name)| (kind, name.to_owned())).collect();
        let is_drawn = |name: &str| asked.iter().any(|asked| asked.name == name);
        let (gone, kept): (BTreeMap<String, ViewState>, BTreeMap<String, ViewState>) =
            std::mem::take(&mut self.views).into_iter().partition(|(name, view)| view.is_within && !is_drawn(name));
        self.views = kept;
        if gone.is_empty() {
            return;
        }
        // The name of a view precedes those of its histories, and may precede those of other views.
        let view_of = |history: &str| {
            let is_of = |name: &&String| history.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('/'));
            gone.keys().chain(self.views.keys()).filter(is_of).max_by_key(|name| name.len())
        };
        self.executor.forget_histories(|history| view_of(history).is_some_and(|name| gone.contains_key(name)));
        // They hold textures of those views.
        self.drawing.bind_groups.forget_unused();
        let variables = gone.values().filter_map(|view| view.aovs.as_ref());
        self.executor.destroy_released(variables.flat_map(AovTextures::all));
        gone.into_values().filter_map(|view| view.output).for_each(Output::destroy);
    }
}
