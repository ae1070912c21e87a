//! Where the camera stands: the same places as `--orbit` and the default of the command line.

use glam::{Mat4, Quat, Vec2, Vec3};
use manypass_scene::{Projection, Scene};

const FOV_Y_RAD: f32 = std::f32::consts::FRAC_PI_4;

/// A camera that looks at a point from a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orbit {
    /// Counter-clockwise seen from above; 0 is at +Z.
    pub yaw_deg: f32,
    /// Positive looks down from above.
    pub pitch_deg: f32,
    /// The distance, above 0.
    pub radius_m: f32,
    /// What is looked at.
    pub target_world: Vec3,
}

/// `world_from_view` and the projection for a picture of width / height `aspect`: of `orbit`, or else of the scene's
/// first camera, or else of the whole model.
pub(crate) fn resolve(orbit: Option<Orbit>, scene: &Scene, aspect: f32) -> (Mat4, Projection) {
    let own = file_camera(scene);
    let orbit = match (orbit, own) {
        (None, Some(camera)) => return camera,
        (None, None) => start(scene, aspect),
        (Some(orbit), _) => orbit,
    };
    let rotation = rotation(orbit.yaw_deg, orbit.pitch_deg);
    let eye = orbit.target_world + rotation * Vec3::Z * orbit.radius_m;
    let near_m = scene.framing_bounds_world().fitted_near_m(eye);
    let fov_y_rad = match own {
        Some((_, Projection::Perspective { fov_y_rad, .. })) => fov_y_rad,
        _ => FOV_Y_RAD,
    };
    (Mat4::from_rotation_translation(rotation, eye), Projection::Perspective { fov_y_rad, near_m, far_m: None })
}

/// The orbit from which the user sets out: where the scene's first camera stands, so that the picture does not jump, or
/// else yaw 30, pitch 20 around the whole model.
pub(crate) fn start(scene: &Scene, aspect: f32) -> Orbit {
    let bounds = scene.framing_bounds_world();
    let center = bounds.center();
    let Some((world_from_view, _)) = file_camera(scene) else {
        let half_height = (0.5 * FOV_Y_RAD).tan();
        let half_extent = Vec2::new(half_height * aspect, half_height);
        let radius_m = bounds.framing_distance_m(center, rotation(30.0, 20.0), half_extent);
        return Orbit { yaw_deg: 30.0, pitch_deg: 20.0, radius_m, target_world: center };
    };
    let (eye, back) = (world_from_view.w_axis.truncate(), world_from_view.z_axis.truncate());
    let is_inside = eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all();
    // Inside a room a short arm looks around; outside, the point beside the middle of the model stays in place.
    let least_m = 0.05 * bounds.radius_around_m(center);
    let radius_m = if is_inside { least_m } else { (eye - center).dot(back).max(least_m) };
    Orbit {
        yaw_deg: back.x.atan2(back.z).to_degrees(),
        pitch_deg: back.y.clamp(-1.0, 1.0).asin().to_degrees(),
        radius_m,
        target_world: eye - back * radius_m,
    }
}

fn rotation(yaw_deg: f32, pitch_deg: f32) -> Quat {
    Quat::from_rotation_y(yaw_deg.to_radians()) * Quat::from_rotation_x(-pitch_deg.to_radians())
}

fn file_camera(scene: &Scene) -> Option<(Mat4, Projection)> {
    scene.placed_cameras().first().map(|(_, world_from_view, projection)| (*world_from_view, *projection))
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::{Aabb, Camera, Mesh, Node, Primitive};

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
            let orbit = Orbit { yaw_deg, pitch_deg, radius_m: 5.0, target_world: Vec3::X };
            let (view, _) = resolve(Some(orbit), &unit_scene(), 1.5);
            assert!(view.w_axis.truncate().abs_diff_eq(5.0 * eye + Vec3::X, 1e-4), "{yaw_deg} {pitch_deg}: {view}");
            assert!((-view.z_axis.truncate()).abs_diff_eq(-eye, 1e-5), "{yaw_deg} {pitch_deg}: {view}");
        }
    }

    #[test]
    fn turning_sets_out_from_the_files_camera() {
        let mut scene = unit_scene();
        let whole = resolve(None, &scene, 1.0);
        assert!(whole.0.abs_diff_eq(resolve(Some(start(&scene, 1.0)), &scene, 1.0).0, 1e-5));
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        scene.cameras.push(Camera { name: String::new(), projection });
        for place in [Vec3::new(0.3, 1.0, 7.0), Vec3::new(0.2, 0.1, -0.5)] {
            let rotation = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-0.3);
            let node =
                Node { camera: Some(0), translation: place, rotation, scale: Vec3::splat(3.0), ..Node::default() };
            scene.nodes.truncate(1);
            scene.add_node(None, node);
            scene.update_transforms();
            let own = Mat4::from_rotation_translation(rotation, place);
            assert!(resolve(None, &scene, 1.0).0.abs_diff_eq(own, 1e-5));
            let (turned, _) = resolve(Some(start(&scene, 1.0)), &scene, 1.0);
            assert!(turned.abs_diff_eq(own, 1e-4), "{turned} against {own}");
        }
    }
}
