//! What lies far from the origin for its size is drawn near it: floats are coarse far away.

use crate::{Aabb, Placed, Scene};

impl Scene {
    /// Moves the origin of world space into the middle of what is drawn, if that lies away from it for its size
    /// ([`Aabb::is_away`]), as georeferenced models do; [`Scene::origin_m`] says by how much. Nodes keep their numbers;
    /// whoever places cameras by the file's coordinates subtracts it. A scene with mirrors, portals, decals or others
    /// that are placed in world space stays. Gives whether it has moved. Brings transforms up to date.
    pub fn bring_near(&mut self) -> bool {
        let has_captures = !self.mirrors.is_empty() || !self.portals.is_empty() || !self.surroundings.is_empty();
        let has_light = !self.probes.is_empty() || !self.decals.is_empty() || !self.water.is_empty();
        let has_places = has_captures || has_light || !self.simulations.is_empty() || !self.particles.is_empty();
        let bounds = self.posed_bounds_world();
        if has_places || !bounds.is_away() {
            return false;
        }
        self.origin_m += bounds.center();
        self.nodes.iter_mut().for_each(|node| node.placed = Placed::default());
        self.update_transforms();
        true
    }

    /// The box around the positions of all meshes, as these hold them.
    pub fn bounds_of_meshes(&self) -> Aabb {
        let primitives = self.meshes.iter().flat_map(|mesh| &mesh.primitives);
        primitives.fold(Aabb::EMPTY, |bounds, primitive| bounds.union(&primitive.bounds))
    }
}

#[cfg(test)]
mod tests {
    use crate::{Mesh, Node, Scene, primitives};
    use glam::Vec3;

    #[test]
    fn only_what_lies_away_is_moved_and_its_children_come_with_it() {
        let at = |translation: Vec3| {
            let mesh = Mesh { primitives: vec![primitives::cube(Vec3::ONE)], ..Mesh::default() };
            let mut scene = Scene { meshes: vec![mesh.into()], ..Scene::default() };
            let parent = scene.add_node(None, Node { mesh: Some(0), translation, ..Node::default() });
            let child = scene.add_node(Some(parent), Node { mesh: Some(0), translation: Vec3::X, ..Node::default() });
            scene.update_transforms();
            (scene.bring_near(), scene.origin_m, scene.node(child).world_from_object.w_axis.truncate(), scene)
        };
        let (has_moved, origin_m, child, _) = at(Vec3::new(20.0, 0.0, 0.0));
        assert_eq!((has_moved, origin_m, child), (false, Vec3::ZERO, Vec3::new(21.0, 0.0, 0.0)));
        let far = Vec3::new(500_000.0, 120.0, -5_400_000.0);
        let (has_moved, origin_m, child, mut scene) = at(far);
        assert!(has_moved && origin_m.distance(far) < 1.0, "{origin_m}");
        assert_eq!(child, far - origin_m + Vec3::X);
        assert!(scene.bounds_world().center().length() < 1.0 && !scene.bring_near());
    }
}
