//! Where the camera stands: from flags, from the file, or so that the whole model is seen.

use crate::failure::Failure;
use crate::listing::choices;
use glam::{Mat3, Mat4, Quat, Vec2, Vec3};
use manypass_scene::{Aabb, Projection, Scene};

/// Where the camera is.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// The file's first camera, else the whole model.
    Default,
    /// A camera of the file, by name or index.
    Named(String),
    /// At a point.
    Eye(Vec3),
    /// Around the target.
    Orbit {
        /// Counter-clockwise seen from above; 0 is at +Z.
        yaw_deg: f32,
        /// Positive looks down from above.
        pitch_deg: f32,
        /// The distance from the target; none shows the whole model.
        radius_m: Option<f32>,
    },
}

/// The camera as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSpec {
    /// Where it is.
    pub place: Place,
    /// What it looks at; none is the middle of the model.
    pub target: Option<Vec3>,
    /// What is up.
    pub up: Vec3,
    /// Vertical, in radians.
    pub fov_y_rad: f32,
    /// Parallel rays, and the height of the picture.
    pub ortho_height_m: Option<f32>,
    /// The near plane; none is fitted.
    pub near_m: Option<f32>,
    /// The far plane; none is infinity, or fitted with parallel rays.
    pub far_m: Option<f32>,
    /// Whether the camera goes around, so that one distance must do for every yaw.
    pub turns: bool,
}

/// The yaw and pitch that show a model without a camera.
pub const DEFAULT_ORBIT: Place = Place::Orbit { yaw_deg: 30.0, pitch_deg: 20.0, radius_m: None };

impl Default for CameraSpec {
    fn default() -> Self {
        let fov_y_rad = 45f32.to_radians();
        Self {
            place: Place::Default,
            target: None,
            up: Vec3::Y,
            fov_y_rad,
            ortho_height_m: None,
            near_m: None,
            far_m: None,
            turns: false,
        }
    }
}

/// The camera of a scene whose models lie within `bounds`: `world_from_view`, and how it projects. `turn_deg` is added to
/// the yaw of an orbit; `aspect` is width / height.
///
/// # Errors
/// If the scene has no such camera, or the camera would stand on its target.
pub fn resolve(
    spec: &CameraSpec,
    scene: &Scene,
    bounds: &Aabb,
    aspect: f32,
    turn_deg: f32,
) -> Result<(Mat4, Projection), Failure> {
    let place = match &spec.place {
        Place::Default => match scene.placed_cameras().first() {
            Some((_, world_from_view, projection)) => return Ok((*world_from_view, *projection)),
            None => DEFAULT_ORBIT,
        },
        Place::Named(name) => return named(scene, name),
        place => place.clone(),
    };
    let target = spec.target.unwrap_or_else(|| bounds.center());
    let up = spec.up.normalize_or(Vec3::Y);
    let rotation_and_eye = match place {
        Place::Eye(eye) => (look(target - eye, up)?, eye),
        Place::Orbit { yaw_deg, pitch_deg, radius_m } => {
            let rotation = orbit_rotation(yaw_deg + turn_deg, pitch_deg, up);
            let distance_m =
                radius_m.unwrap_or_else(|| auto_distance_m(spec, bounds, target, aspect, (yaw_deg, pitch_deg)));
            (Mat3::from_quat(rotation), target + rotation * Vec3::Z * distance_m)
        }
        Place::Default | Place::Named(_) => (Mat3::IDENTITY, target),
    };
    let (rotation, eye) = rotation_and_eye;
    Ok((Mat4::from_translation(eye) * Mat4::from_mat3(rotation), projection(spec, bounds, eye)))
}

/// The rotation of a camera that looks along `direction`. Where `up` is parallel to it, another up is taken.
fn look(direction: Vec3, up: Vec3) -> Result<Mat3, Failure> {
    let hint = "move --eye or --target apart";
    let back = -direction.try_normalize().ok_or_else(|| Failure::usage("the camera stands on its target", hint))?;
    let right = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
    Ok(Mat3::from_cols(right, back.cross(right), back))
}

fn orbit_rotation(yaw_deg: f32, pitch_deg: f32, up: Vec3) -> Quat {
    let turn = Quat::from_rotation_y(yaw_deg.to_radians());
    Quat::from_rotation_arc(Vec3::Y, up) * turn * Quat::from_rotation_x(-pitch_deg.to_radians())
}

/// How far from the target the model just fits into the picture; with parallel rays, where it is not cut.
fn auto_distance_m(
    spec: &CameraSpec,
    bounds: &Aabb,
    target: Vec3,
    aspect: f32,
    (yaw_deg, pitch_deg): (f32, f32),
) -> f32 {
    if spec.ortho_height_m.is_some() {
        return 2.0 * bounds.radius_around_m(target);
    }
    let half_height = (0.5 * spec.fov_y_rad).tan();
    let half_extent = Vec2::new(half_height * aspect, half_height);
    let up = spec.up.normalize_or(Vec3::Y);
    let distance_m =
        |yaw_deg: f32| bounds.framing_distance_m(target, orbit_rotation(yaw_deg, pitch_deg, up), half_extent);
    let turns = if spec.turns { 72 } else { 1 };
    (0..turns).map(|i| distance_m(yaw_deg + 5.0 * i as f32)).fold(0.0, f32::max)
}

fn projection(spec: &CameraSpec, bounds: &Aabb, eye: Vec3) -> Projection {
    let fitted_near_m = bounds.fitted_near_m(eye);
    let near_m = spec.near_m.unwrap_or(spec.far_m.map_or(fitted_near_m, |far| fitted_near_m.min(0.5 * far)));
    match spec.ortho_height_m {
        Some(height_m) => {
            let center = bounds.center();
            let beyond_m = eye.distance(center) + 2.0 * bounds.radius_around_m(center);
            let far_m = spec.far_m.unwrap_or(beyond_m.max(2.0 * near_m));
            Projection::Orthographic { height_m, near_m, far_m }
        }
        None => Projection::Perspective { fov_y_rad: spec.fov_y_rad, near_m, far_m: spec.far_m },
    }
}

fn named(scene: &Scene, name: &str) -> Result<(Mat4, Projection), Failure> {
    let node_name = |index: usize| scene.nodes.iter().find(|node| node.camera == Some(index)).map(|node| &node.name);
    let by_name = scene.cameras.iter().position(|camera| camera.name == name);
    let by_node = || (0..scene.cameras.len()).find(|index| node_name(*index).is_some_and(|node| node == name));
    let index = by_name.or_else(by_node).or_else(|| name.parse().ok());
    let placed = scene.placed_cameras().into_iter().find(|(placed, ..)| index == Some(*placed));
    placed.map(|(_, world_from_view, projection)| (world_from_view, projection)).ok_or_else(|| {
        let named = scene.placed_cameras().into_iter().map(|(index, ..)| {
            let name = scene.cameras.get(index).map(|camera| camera.name.as_str()).filter(|name| !name.is_empty());
            (index, name.or(node_name(index).map(String::as_str)).unwrap_or_default())
        });
        Failure::usage(format!("there is no camera `{name}`"), choices("cameras", named))
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

    fn orbit(yaw_deg: f32, pitch_deg: f32) -> (Vec3, Vec3) {
        let place = Place::Orbit { yaw_deg, pitch_deg, radius_m: Some(5.0) };
        let spec = CameraSpec { place, ..CameraSpec::default() };
        let (view, _) = resolve(&spec, &unit_scene(), &unit_scene().bounds_world(), 1.5, 0.0).expect("camera");
        (view.w_axis.truncate(), -view.z_axis.truncate())
    }

    #[test]
    fn orbits_turn_as_the_contract_says() {
        for (yaw, pitch, eye) in
            [(0.0, 0.0, Vec3::Z), (90.0, 0.0, Vec3::X), (-90.0, 0.0, -Vec3::X), (0.0, 90.0, Vec3::Y)]
        {
            let (position, forward) = orbit(yaw, pitch);
            assert!(position.abs_diff_eq(5.0 * eye, 1e-4), "{yaw} {pitch}: {position}");
            assert!(forward.abs_diff_eq(-eye, 1e-5), "{yaw} {pitch}: {forward}");
        }
    }

    #[test]
    fn the_whole_model_fits_into_narrow_and_wide_pictures() {
        for aspect in [0.25, 1.0, 4.0] {
            let (view, projection) =
                resolve(&CameraSpec::default(), &unit_scene(), &unit_scene().bounds_world(), aspect, 0.0)
                    .expect("camera");
            let Projection::Perspective { fov_y_rad, near_m, .. } = projection else { panic!("perspective") };
            let tan_y = (0.5 * fov_y_rad).tan();
            for corner in unit_scene().bounds_world().corners() {
                let p = view.inverse().transform_point3(corner);
                assert!(
                    -p.z > near_m && p.y.abs() <= -p.z * tan_y && p.x.abs() <= -p.z * tan_y * aspect,
                    "{aspect}: {p}"
                );
            }
        }
    }

    #[test]
    fn eye_looks_at_the_target_even_straight_down() {
        for eye in [Vec3::new(3.0, 2.0, 1.0), Vec3::new(0.0, 4.0, 0.0)] {
            let spec = CameraSpec { place: Place::Eye(eye), ..CameraSpec::default() };
            let (view, _) = resolve(&spec, &unit_scene(), &unit_scene().bounds_world(), 1.0, 0.0).expect("camera");
            assert!((-view.z_axis.truncate()).abs_diff_eq(-eye.normalize(), 1e-5));
            assert!((view.determinant() - 1.0).abs() < 1e-4);
        }
        let spec = CameraSpec { place: Place::Eye(Vec3::ZERO), ..CameraSpec::default() };
        assert_eq!(
            resolve(&spec, &unit_scene(), &unit_scene().bounds_world(), 1.0, 0.0).expect_err("degenerate").code(),
            2
        );
    }

    #[test]
    fn the_files_camera_wins_without_flags() {
        let mut scene = unit_scene();
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        scene.cameras.push(Camera { name: "Main".into(), projection });
        scene.add_node(
            None,
            Node { camera: Some(0), translation: Vec3::new(0.0, 0.0, 7.0), scale: Vec3::splat(3.0), ..Node::default() },
        );
        scene.update_transforms();
        for place in [Place::Default, Place::Named("Main".into()), Place::Named("0".into())] {
            let (view, found) =
                resolve(&CameraSpec { place, ..CameraSpec::default() }, &scene, &scene.bounds_world(), 1.0, 0.0)
                    .expect("camera");
            assert_eq!((view, found), (Mat4::from_translation(Vec3::new(0.0, 0.0, 7.0)), projection));
        }
        let unknown = CameraSpec { place: Place::Named("Side".into()), ..CameraSpec::default() };
        assert_eq!(
            resolve(&unknown, &scene, &scene.bounds_world(), 1.0, 0.0).expect_err("unknown").hint,
            "cameras by index or name: 0 `Main`"
        );
    }
}
