//! Which ends of portals a view shows.

use super::ask::ViewRequest;
use super::view_kind::Reflector;
use crate::passes::portals::PortalDraw;
use glam::Vec3;
use manypass_graph::Handle;
use manypass_scene::portal::{PORTALS_MAX, Portal};
use manypass_scene::{NodeId, Scene};
use std::collections::BTreeMap;

/// The outlines of the ends of a scene's portals, by their indices and which end it is.
#[derive(Default)]
pub(super) struct Doors(BTreeMap<(usize, usize), Vec<Vec3>>);

impl Doors {
    pub fn of(scene: &Scene) -> Self {
        let ends = scene.portals.iter().take(PORTALS_MAX).enumerate().flat_map(|(index, portal)| {
            let of_end = move |end: usize| {
                let node: NodeId = portal.nodes[end];
                Some(((index, end), scene.outline(node, &scene.panel(node).ok()?)))
            };
            (0..2).filter_map(of_end)
        });
        Self(ends.collect())
    }

    /// Those that a view shows; `seen` has what views through them left, by the views' names.
    pub fn shown(&self, asked: &ViewRequest, seen: &mut BTreeMap<String, Handle>) -> Vec<PortalDraw> {
        let shown = asked.mirrors.iter().filter_map(|mirror| {
            let Reflector::Portal(index, end) = mirror.of else { return None };
            let corners_world = self.0.get(&(index, end))?.clone();
            Some(PortalDraw { corners_world, radiance: seen.remove(&mirror.view)? })
        });
        shown.collect()
    }
}

/// What is wrong with portals of a scene, which are not drawn then.
pub(super) fn faults(scene: &Scene) -> Vec<String> {
    let fault = |portal: &Portal| {
        let what = portal.nodes.iter().find_map(|node| scene.panel(*node).err());
        let what = what.or((portal.nodes[0] == portal.nodes[1]).then_some("is both of them"))?;
        Some(format!("portal `{}` leads nowhere: its ends are flat, and one of its nodes {what}", portal.name))
    };
    let mut faults: Vec<String> = scene.portals.iter().take(PORTALS_MAX).filter_map(fault).collect();
    if scene.portals.len() > PORTALS_MAX {
        faults.push(format!("only the first {PORTALS_MAX} of {} portals are drawn", scene.portals.len()));
    }
    faults
}
