//! What lies far from the origin for its size is drawn near it: floats are coarse far away.

use crate::image::ImageSource;
use crate::{Aabb, LastPlace, Scene};
use glam::Vec3;
use std::sync::Arc;

impl Scene {
    /// Moves the origin of world space into the middle of what is drawn, if that lies away from it for its size
    /// ([`Aabb::is_away`]), as georeferenced models do; [`Scene::origin_m`] says by how much. Nodes keep their numbers;
    /// whoever places cameras by the file's coordinates subtracts it. A scene with mirrors, portals, probes or others
    /// that are placed in world space stays. Gives whether it has moved. Brings transforms up to date.
    pub fn bring_near(&mut self) -> bool {
        let bounds = self.posed_bounds_world();
        if !self.is_movable() || !self.is_away(&bounds) {
            return false;
        }
        self.move_origin(self.origin_m + bounds.center());
        // The box was rounded as everything was.
        self.move_origin(self.origin_m + self.posed_bounds_world().center());
        true
    }

    /// As [`Self::bring_near`], of two scenes that are compared in one space: both get one origin, so that they lie to
    /// each other as before. That is the middle of both or, where they lie so far from each other that no picture shows
    /// both ([`Aabb::is_far_from`]), that of this one. Both have the same origin before.
    pub fn bring_near_with(&mut self, other: &mut Self) -> bool {
        let (own, others) = (self.posed_bounds_world(), other.posed_bounds_world());
        let bounds = if own.is_far_from(&others) { own } else { own.union(&others) };
        if !self.is_movable() || !other.is_movable() || !self.is_away(&bounds) {
            return false;
        }
        let origin_m = self.origin_m + bounds.center();
        self.move_origin(origin_m);
        other.move_origin(origin_m);
        true
    }

    /// Moves the origin of world space to a point in the space of the file, in metres, with decals and items of the
    /// overlay that are placed in world space. Brings transforms up to date.
    fn move_origin(&mut self, origin_m: Vec3) {
        let by_m = self.origin_m - origin_m;
        self.origin_m = origin_m;
        for decal in self.decals.iter_mut().filter(|decal| decal.node.is_none()) {
            decal.parent_from_box.w_axis += by_m.extend(0.0);
        }
        if !self.overlay.items.is_empty() {
            Arc::make_mut(&mut self.overlay).move_by(by_m);
        }
        self.nodes.iter_mut().for_each(|node| node.placed = LastPlace::default());
        self.update_transforms();
    }

    /// Whether nothing of it is placed in world space that stays where it is when the origin moves.
    fn is_movable(&self) -> bool {
        let has_monitors = self.images.iter().any(|image| matches!(image.source, ImageSource::Monitor(_)));
        let has_captures = has_monitors || !self.mirrors.is_empty() || !self.portals.is_empty();
        let has_light = !self.surroundings.is_empty() || !self.probes.is_empty();
        let has_motion = !self.water.is_empty() || !self.simulations.is_empty() || !self.particles.is_empty();
        !(has_captures || has_light || has_motion)
    }

    /// Whether a box around what is drawn lies away from the origin of world space. Rounding there may have left
    /// nothing of its extent.
    pub(crate) fn is_away(&self, bounds: &Aabb) -> bool {
        let distance_m = bounds.center().length();
        let is_point = bounds.radius_m() == 0.0 && distance_m > 0.0 && distance_m.is_finite();
        bounds.is_away() || is_point && self.bounds_of_meshes().radius_m() > 0.0
    }

    /// The box around the positions of all meshes, as these hold them.
    pub fn bounds_of_meshes(&self) -> Aabb {
        let primitives = self.meshes.iter().flat_map(|mesh| &mesh.primitives);
        primitives.fold(Aabb::EMPTY, |bounds, primitive| bounds.union(&primitive.bounds))
    }
}

#[cfg(test)]
mod tests {
    use crate::decal::{Decal, DecalLook};
    use crate::overlay::{Anchor, Overlay, OverlayItem, OverlayPlace, PlaceOf};
    use crate::{Mesh, Node, Scene, primitives};
    use glam::{Vec2, Vec3};

    const FAR: Vec3 = Vec3::new(500_000.0, 120.0, -5_400_000.0);

    /// A cube of a size around a point.
    fn cube_at(translation: Vec3, size_m: f32) -> Scene {
        let mesh = Mesh { primitives: vec![primitives::cube(Vec3::splat(size_m))], ..Mesh::default() };
        let mut scene = Scene { meshes: vec![mesh.into()], ..Scene::default() };
        scene.add_node(None, Node { mesh: Some(0), translation, ..Node::default() });
        scene.update_transforms();
        scene
    }

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
        let (has_moved, origin_m, child, mut scene) = at(FAR);
        assert!(has_moved && origin_m.distance(FAR) < 1.0, "{origin_m}");
        assert_eq!(child, FAR - origin_m + Vec3::X);
        assert!(scene.bounds_world().center().length() < 1.0 && !scene.bring_near());
    }

    #[test]
    fn what_is_placed_in_the_world_comes_along() {
        let mut scene = cube_at(FAR, 1.0);
        let mut decal = Decal::new("mark", DecalLook::default());
        decal.place(FAR, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::ONE);
        scene.decals.push(decal);
        let title = OverlayItem::text("title", OverlayPlace::anchored(Anchor::Bottom, Vec2::ZERO));
        let items = vec![
            OverlayItem::text("here", OverlayPlace::at_world(FAR)),
            OverlayItem::line_world(vec![FAR, FAR + Vec3::X]),
            title,
        ];
        scene.overlay = Overlay { items }.into();
        assert!(scene.bring_near());
        let place = FAR - scene.origin_m;
        assert!(place.length() < 1.0, "{place}");
        assert_eq!(scene.decals[0].parent_from_box.w_axis, place.extend(1.0));
        assert_eq!(scene.overlay.items[0].place.of, PlaceOf::World(place));
        assert_eq!(scene.overlay.items[2].place.of, PlaceOf::Picture);
        let line = format!("{:?}", scene.overlay.items[1].shape);
        assert!(line.contains(&format!("{:?}", [place, place + Vec3::X])), "{line}");
    }

    #[test]
    fn what_rounding_left_no_extent_is_brought_near() {
        let mut scene = cube_at(Vec3::new(500_000.0, 4_649_776.0, -5_400_000.0), 0.01);
        assert_eq!(scene.posed_bounds_world().radius_m(), 0.0);
        assert!(scene.bring_near() && scene.posed_bounds_world().radius_m() > 0.008);
    }

    #[test]
    fn two_scenes_lie_to_each_other_as_before() {
        for (offset, is_near) in [(Vec3::X, true), (-FAR, false)] {
            let (mut a, mut b) = (cube_at(FAR, 1.0), cube_at(FAR + offset, 1.0));
            assert!(a.bring_near_with(&mut b));
            let [own, others] = [&a, &b].map(Scene::posed_bounds_world);
            assert_eq!((a.origin_m, own.is_far_from(&others)), (b.origin_m, !is_near));
            assert!((others.center() - own.center()).abs_diff_eq(offset, 0.5), "{offset}");
            assert!(own.center().length() <= 1.0);
        }
        let (mut a, mut b) = (cube_at(Vec3::ZERO, 1.0), cube_at(FAR, 1.0));
        assert!(!a.bring_near_with(&mut b) && b.origin_m == Vec3::ZERO);
    }
}
