//! Where the camera stands: the same places as `--orbit` and the default of the command line.

use glam::{Mat4, Vec3};
use manypass_scene::framing::{DEFAULT_FOV_Y_RAD, Framing, orbit_rotation};
use manypass_scene::{Projection, Scene};

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
/// first camera, or else of the whole model, as `framing` sees it.
pub(crate) fn resolve(orbit: Option<Orbit>, scene: &Scene, framing: &Framing, aspect: f32) -> (Mat4, Projection) {
    let own = own_camera(scene, framing, aspect);
    let Some(orbit) = orbit else { return own };
    let rotation = orbit_rotation(orbit.yaw_deg, orbit.pitch_deg, Vec3::Y);
    let eye = orbit.target_world + rotation * Vec3::Z * orbit.radius_m;
    let near_m = framing.fit().near_m(eye, rotation);
    let fov_y_rad = match own.1 {
        Projection::Perspective { fov_y_rad, .. } => fov_y_rad,
        Projection::Orthographic { .. } => DEFAULT_FOV_Y_RAD,
    };
    (Mat4::from_rotation_translation(rotation, eye), Projection::Perspective { fov_y_rad, near_m, far_m: None })
}

/// The orbit from which the user sets out: where the camera stands that draws without one, so that the picture does not
/// jump.
pub(crate) fn start(scene: &Scene, framing: &Framing, aspect: f32) -> Orbit {
    let (world_from_view, _) = own_camera(scene, framing, aspect);
    let (eye, back) = (world_from_view.w_axis.truncate(), world_from_view.z_axis.truncate());
    let bounds = framing.bounds_world();
    let is_inside = eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all();
    // Inside a room a short arm looks around; outside, the point beside the middle of the model stays in place.
    let least_m = 0.05 * framing.radius_m();
    let radius_m = if is_inside { least_m } else { (eye - framing.center_world()).dot(back).max(least_m) };
    Orbit {
        yaw_deg: back.x.atan2(back.z).to_degrees(),
        pitch_deg: back.y.clamp(-1.0, 1.0).asin().to_degrees(),
        radius_m,
        target_world: eye - back * radius_m,
    }
}

fn own_camera(scene: &Scene, framing: &Framing, aspect: f32) -> (Mat4, Projection) {
    scene.first_camera(aspect).unwrap_or_else(|| framing.automatic(aspect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use manypass_scene::primitives::cube;
    use manypass_scene::{Camera, Mesh, Node};

    fn unit_scene() -> Scene {
        let mesh = Mesh { primitives: vec![cube(Vec3::splat(2.0))], ..Mesh::default() };
        let mut scene = Scene { meshes: vec![mesh.into()], ..Scene::default() };
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
            let (view, _) = resolve(Some(orbit), &unit_scene(), &Framing::of_scene(&unit_scene()), 1.5);
            assert!(view.w_axis.truncate().abs_diff_eq(5.0 * eye + Vec3::X, 1e-4), "{yaw_deg} {pitch_deg}: {view}");
            assert!((-view.z_axis.truncate()).abs_diff_eq(-eye, 1e-5), "{yaw_deg} {pitch_deg}: {view}");
        }
    }

    #[test]
    fn turning_sets_out_from_the_files_camera() {
        let mut scene = unit_scene();
        let framing = Framing::of_scene(&scene);
        let whole = resolve(None, &scene, &framing, 1.0);
        assert!(whole.0.abs_diff_eq(resolve(Some(start(&scene, &framing, 1.0)), &scene, &framing, 1.0).0, 1e-5));
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
        for place in [Vec3::new(0.3, 1.0, 7.0), Vec3::new(0.2, 0.1, -0.5)] {
            let rotation = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-0.3);
            let node =
                Node { camera: Some(0), translation: place, rotation, scale: Vec3::splat(3.0), ..Node::default() };
            scene.nodes.truncate(1);
            scene.add_node(None, node);
            scene.update_transforms();
            let own = Mat4::from_rotation_translation(rotation, place);
            assert!(resolve(None, &scene, &framing, 1.0).0.abs_diff_eq(own, 1e-5));
            let (turned, _) = resolve(Some(start(&scene, &framing, 1.0)), &scene, &framing, 1.0);
            assert!(turned.abs_diff_eq(own, 1e-4), "{turned} against {own}");
        }
    }
}
