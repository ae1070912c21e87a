//! Where a camera stands so that a model is seen whole.

use crate::{Aabb, Mesh, Node, Primitive, Projection, Scene};
use glam::{Mat4, Quat, Vec2, Vec3};

/// The part of the picture's width or height that a framed model leaves free.
const MARGIN: f32 = 0.06;

impl Scene {
    /// The smallest box in world space around everything that is drawn, posed by skins and morph targets vertex by
    /// vertex. Takes time in proportion to the number of vertices that are so posed.
    pub fn framing_bounds_world(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for id in self.visible_nodes() {
            let node = self.node(id);
            let Some(mesh) = node.mesh.and_then(|mesh| self.meshes.get(mesh)) else { continue };
            let joints = node.skin.map(|skin| self.joint_matrices(skin)).unwrap_or_default();
            for primitive in &mesh.primitives {
                bounds = bounds.union(&primitive_bounds(node, mesh, primitive, &joints));
            }
        }
        bounds
    }

    /// The cameras of visible nodes in the order of the file, each with its index, `world_from_view` without the scale
    /// of its node, and projection.
    pub fn placed_cameras(&self) -> Vec<(usize, Mat4, Projection)> {
        let visible = self.visible_nodes();
        let placed = self.cameras.iter().enumerate().filter_map(|(index, camera)| {
            let id = visible.iter().find(|id| self.node(**id).camera == Some(index))?;
            let (_, rotation, translation) = self.node(*id).world_from_object.to_scale_rotation_translation();
            Some((index, Mat4::from_rotation_translation(rotation, translation), camera.projection))
        });
        placed.collect()
    }
}

fn primitive_bounds(node: &Node, mesh: &Mesh, primitive: &Primitive, joints: &[Mat4]) -> Aabb {
    let is_skinned = !joints.is_empty() && !primitive.joints.is_empty();
    if !is_skinned && primitive.morph_targets.is_empty() {
        return primitive.bounds.transformed(&node.world_from_object);
    }
    let weights = if node.morph_weights.is_empty() { &mesh.default_morph_weights } else { &node.morph_weights };
    Aabb::from_points(primitive.positions.iter().enumerate().map(|(index, position)| {
        let mut position = Vec3::from(*position);
        for (target, weight) in primitive.morph_targets.iter().zip(weights) {
            position += target.positions.get(index).map_or(Vec3::ZERO, |delta| Vec3::from(*delta) * *weight);
        }
        match (is_skinned, primitive.joints.get(index), primitive.weights.get(index)) {
            (true, Some(indices), Some(shares)) => indices
                .iter()
                .zip(shares)
                .filter_map(|(joint, share)| Some(joints.get(usize::from(*joint))?.transform_point3(position) * *share))
                .sum(),
            _ => node.world_from_object.transform_point3(position),
        }
    }))
}

impl Aabb {
    /// The radius in metres of the sphere around `center` that holds the box; 1 m if the box is empty.
    pub fn radius_around_m(&self, center: Vec3) -> f32 {
        if self.is_empty() {
            return 1.0;
        }
        self.corners().iter().map(|corner| corner.distance(center)).fold(1e-4, f32::max)
    }

    /// How far from `target` a camera turned by `world_from_view` sees the whole box, with a little room around it.
    /// `half_extent` is half the width and height of the picture at a distance of 1 m.
    pub fn framing_distance_m(&self, target: Vec3, world_from_view: Quat, half_extent: Vec2) -> f32 {
        let around_target = Self { min: target - 1.0, max: target + 1.0 };
        let bounds = if self.is_empty() { &around_target } else { self };
        let slope = half_extent.max(Vec2::splat(1e-4)) * (1.0 - MARGIN);
        let view_from_world = world_from_view.inverse();
        let distance = |corner: Vec3| {
            let place = view_from_world * (corner - target);
            place.z + (place.x.abs() / slope.x).max(place.y.abs() / slope.y)
        };
        // A model without extent is seen from a distance too.
        bounds.corners().map(distance).into_iter().fold(1e-3 * bounds.radius_around_m(target), f32::max)
    }

    /// A near plane that cuts nothing of the box: half of the way to it, or inside its sphere a thousandth of the radius.
    pub fn fitted_near_m(&self, eye: Vec3) -> f32 {
        let center = self.center();
        let radius_m = self.radius_around_m(center);
        (0.5 * (eye.distance(center) - radius_m)).max(1e-3 * radius_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_framed_box_touches_the_margin_and_no_more() {
        let bounds = Aabb { min: Vec3::new(-3.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 5.0) };
        for (yaw, pitch, half_extent) in
            [(0.0, 0.0, Vec2::new(0.7, 0.4)), (0.6, -0.4, Vec2::new(0.2, 0.4)), (3.0, -1.2, Vec2::splat(0.5))]
        {
            let rotation = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch);
            let target = bounds.center();
            let distance = bounds.framing_distance_m(target, rotation, half_extent);
            let eye = target + rotation * Vec3::Z * distance;
            let reach = bounds.corners().map(|corner| {
                let place = rotation.inverse() * (corner - eye);
                assert!(place.z < 0.0);
                (Vec2::new(place.x, place.y).abs() / -place.z / half_extent).max_element()
            });
            let most = reach.into_iter().fold(0.0, f32::max);
            assert!((most - (1.0 - MARGIN)).abs() < 1e-3, "{most}");
        }
        let nothing = Aabb::EMPTY.framing_distance_m(Vec3::ONE, Quat::IDENTITY, Vec2::splat(0.4));
        assert!(nothing > 1.0 && nothing < 10.0, "{nothing}");
    }
}
