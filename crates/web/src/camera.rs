//! Where the camera stands: the same places as `--orbit` and the default of the command line.

use glam::{Mat4, Quat, Vec3};
use manypass_scene::{Aabb, Projection, Scene};

const FOV_Y_RAD: f32 = std::f32::consts::FRAC_PI_4;

/// Around the middle of the model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Orbit {
    /// Counter-clockwise seen from above; 0 is at +Z.
    pub yaw_deg: f32,
    /// Positive looks down from above.
    pub pitch_deg: f32,
    /// 0 shows the whole model; negative or not a number takes the file's first camera, if it has one.
    pub radius_m: f32,
}

/// `world_from_view` and the projection for a picture of width / height `aspect`.
pub(crate) fn resolve(orbit: Orbit, scene: &Scene, aspect: f32) -> (Mat4, Projection) {
    let wants_own = orbit.radius_m.is_nan() || orbit.radius_m < 0.0;
    if let Some(camera) = wants_own.then(|| file_camera(scene)).flatten() {
        return camera;
    }
    let bounds = scene.bounds_world();
    let target = bounds.center();
    let model_radius_m = radius_around_m(&bounds, target);
    let distance_m = if orbit.radius_m > 0.0 { orbit.radius_m } else { framing_distance_m(model_radius_m, aspect) };
    let rotation =
        Quat::from_rotation_y(orbit.yaw_deg.to_radians()) * Quat::from_rotation_x(-orbit.pitch_deg.to_radians());
    let eye = target + rotation * Vec3::Z * distance_m;
    // Half of the way to the model, so that nothing is cut; inside the model a thousandth of its radius.
    let near_m = (0.5 * (distance_m - model_radius_m)).max(1e-3 * model_radius_m);
    let projection = Projection::Perspective { fov_y_rad: FOV_Y_RAD, near_m, far_m: None };
    (Mat4::from_rotation_translation(rotation, eye), projection)
}

/// The distance that frames the whole model.
pub(crate) fn framing_radius_m(scene: &Scene, aspect: f32) -> f32 {
    let bounds = scene.bounds_world();
    framing_distance_m(radius_around_m(&bounds, bounds.center()), aspect)
}

fn radius_around_m(bounds: &Aabb, center: Vec3) -> f32 {
    if bounds.is_empty() {
        return 1.0;
    }
    bounds.corners().iter().map(|corner| corner.distance(center)).fold(1e-4, f32::max)
}

/// How far away a sphere just fits into the narrower field of view.
fn framing_distance_m(radius_m: f32, aspect: f32) -> f32 {
    let half_y = 0.5 * FOV_Y_RAD;
    let half_x = (half_y.tan() * aspect).atan();
    radius_m / half_y.min(half_x).sin().max(1e-3)
}

/// The first camera that stands in the scene, without the scale of its node.
fn file_camera(scene: &Scene) -> Option<(Mat4, Projection)> {
    let visible = scene.visible_nodes();
    (0..scene.cameras.len()).find_map(|index| {
        let id = visible.iter().find(|id| scene.node(**id).camera == Some(index))?;
        let (_, rotation, translation) = scene.node(*id).world_from_object.to_scale_rotation_translation();
        Some((Mat4::from_rotation_translation(rotation, translation), scene.cameras[index].projection))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::{Camera, Mesh, Node, Primitive};

    fn unit_scene() -> Scene {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
        let mesh = Mesh { primitives: vec![Primitive { bounds, ..Primitive::default() }], ..Mesh::default() };
        let mut scene = Scene { meshes: vec![mesh], ..Scene::default() };
        scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
        scene.update_transforms();
        scene
    }

    #[test]
    fn orbits_turn_as_the_command_line_does() {
        for (yaw_deg, pitch_deg, eye) in
            [(0.0, 0.0, Vec3::Z), (90.0, 0.0, Vec3::X), (-90.0, 0.0, -Vec3::X), (0.0, 90.0, Vec3::Y)]
        {
            let (view, _) = resolve(Orbit { yaw_deg, pitch_deg, radius_m: 5.0 }, &unit_scene(), 1.5);
            assert!(view.w_axis.truncate().abs_diff_eq(5.0 * eye, 1e-4), "{yaw_deg} {pitch_deg}: {view}");
            assert!((-view.z_axis.truncate()).abs_diff_eq(-eye, 1e-5), "{yaw_deg} {pitch_deg}: {view}");
        }
    }

    #[test]
    fn radius_zero_frames_and_a_negative_one_takes_the_files_camera() {
        let mut scene = unit_scene();
        let orbit = |radius_m| Orbit { yaw_deg: 0.0, pitch_deg: 0.0, radius_m };
        let framed = resolve(orbit(0.0), &scene, 1.0);
        assert!((framed.0.w_axis.z - framing_radius_m(&scene, 1.0)).abs() < 1e-5);
        assert_eq!(resolve(orbit(-1.0), &scene, 1.0), framed);
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        scene.cameras.push(Camera { name: String::new(), projection });
        let place = Vec3::new(0.0, 0.0, 7.0);
        scene.add_node(None, Node { camera: Some(0), translation: place, scale: Vec3::splat(3.0), ..Node::default() });
        scene.update_transforms();
        for radius_m in [-1.0, f32::NAN] {
            assert_eq!(resolve(orbit(radius_m), &scene, 1.0), (Mat4::from_translation(place), projection));
        }
        assert_eq!(resolve(orbit(0.0), &scene, 1.0), framed);
    }
}
