//! Where the camera stands: from flags, from the file, or so that the whole model is seen.

use crate::failure::Failure;
use crate::listing::choices;
use glam::{DVec3, Mat4, Quat, Vec3};
use manypass_scene::framing::{self, Framing, look_along, orbit_rotation};
use manypass_scene::{Projection, Scene};

/// What `--camera` takes for the automatic camera; a camera of that name is taken by its index.
pub const AUTOMATIC: &str = "auto";

/// Where the camera is.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Place {
    /// The file's first camera, else the whole model, or a room from inside.
    #[default]
    Default,
    /// The whole model, or a room from inside, whatever cameras the file has.
    Automatic,
    /// A camera of the file, by name or index.
    Named(String),
    /// A camera of the file, by index.
    OfFile(usize),
    /// At a point, in metres. Far from the origin a 32-bit float would be too coarse.
    Eye(DVec3),
    /// At a point, turned from looking along −Z with +Y up.
    Posed {
        /// To the world from the camera.
        rotation: Quat,
        /// Where it is, in metres.
        eye: DVec3,
    },
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
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraSpec {
    /// Where it is.
    pub place: Place,
    /// What it looks at, in metres; none is the middle of the model, or where a camera that is there looks.
    pub target: Option<DVec3>,
    /// What is up; none is +Y, or the up of a camera that is there.
    pub up: Option<Vec3>,
    /// Vertical, in radians; none is 45°, or that of a camera that is there.
    pub fov_y_rad: Option<f32>,
    /// Parallel rays, and the height of the picture.
    pub ortho_height_m: Option<f32>,
    /// The near plane; none is fitted, or that of a camera that is there.
    pub near_m: Option<f32>,
    /// The far plane; none is infinity, or fitted with parallel rays, or that of a camera that is there.
    pub far_m: Option<f32>,
    /// Whether the camera goes around, so that one distance must do for every yaw.
    pub turns: bool,
}

impl CameraSpec {
    /// The same of a scene whose world has its origin at a point of the file's space, in which the camera is asked for.
    pub fn in_world_at(&self, origin_m: Vec3) -> Self {
        let origin_m = origin_m.as_dvec3();
        let place = match self.place {
            Place::Eye(eye) => Place::Eye(eye - origin_m),
            Place::Posed { rotation, eye } => Place::Posed { rotation, eye: eye - origin_m },
            _ => self.place.clone(),
        };
        Self { place, target: self.target.map(|target| target - origin_m), ..self.clone() }
    }

    /// What a camera looks at that is asked for in world space ([`Self::in_world_at`]).
    pub fn target_world(&self) -> Option<Vec3> {
        self.target.map(|target| target.as_vec3())
    }
}

/// The yaw and pitch that show a model without a camera.
pub const DEFAULT_ORBIT: Place =
    Place::Orbit { yaw_deg: framing::DEFAULT_YAW_DEG, pitch_deg: framing::DEFAULT_PITCH_DEG, radius_m: None };

/// The camera of a scene whose models are those of `framing`: `world_from_view`, and how it projects. `turn_deg` is
/// added to the yaw of an orbit; `aspect` is width / height.
///
/// # Errors
/// If the scene has no such camera, or the camera would stand on its target.
pub fn resolve(
    spec: &CameraSpec,
    scene: &Scene,
    framing: &Framing,
    aspect: f32,
    turn_deg: f32,
) -> Result<(Mat4, Projection), Failure> {
    let spec = &spec.in_world_at(scene.origin_m);
    let place = match &spec.place {
        Place::Default if spec.turns => match turning_inside(spec, framing, turn_deg) {
            Some(inside) => return Ok(inside),
            None => DEFAULT_ORBIT,
        },
        Place::Default => match own_camera(scene, framing, aspect) {
            Some(own) => return changed(spec, framing, own),
            None => DEFAULT_ORBIT,
        },
        Place::Automatic => match framing.interior() {
            Some(interior) => return changed(spec, framing, (interior.world_from_view, interior.projection)),
            None => DEFAULT_ORBIT,
        },
        Place::Named(name) => return named(scene, name, aspect),
        Place::OfFile(index) => {
            let gone = || Failure::usage(format!("camera {index} is not in the scene"), "show another --scene");
            return of_file(scene, *index, aspect).ok_or_else(gone);
        }
        place => place.clone(),
    };
    let up = spec.up.unwrap_or(Vec3::Y).normalize_or(Vec3::Y);
    let (rotation, eye) = match place {
        Place::Eye(eye) => {
            // Before rounding: a camera can stand near its target, and both far away.
            let target = spec.target.unwrap_or_else(|| framing.center_world().as_dvec3());
            (look((target - eye).as_vec3(), up)?, eye.as_vec3())
        }
        Place::Posed { rotation, eye } => (rotation, eye.as_vec3()),
        Place::Orbit { yaw_deg, pitch_deg, radius_m } => {
            let orbit = Orbit { yaw_deg, pitch_deg, radius_m, up };
            (orbit_rotation(yaw_deg + turn_deg, pitch_deg, up), orbit.eye(spec, framing, aspect, turn_deg))
        }
        Place::Default | Place::Automatic | Place::Named(_) | Place::OfFile(_) => {
            (Quat::IDENTITY, framing.center_world())
        }
    };
    Ok((Mat4::from_rotation_translation(rotation, eye), projection(spec, framing, eye, rotation)))
}

/// What to say about a camera that nobody asked for and nobody would expect.
pub fn hint(spec: &CameraSpec, scene: &Scene, framing: &Framing) -> Option<String> {
    let has_no_other = scene.placed_cameras().is_empty() || spec.turns;
    let is_inside = spec.place == Place::Default && has_no_other && framing.interior().is_some();
    is_inside.then(|| "it encloses its middle and is seen from inside; --orbit 30,28,auto shows it from outside".into())
}

/// What to say of points of a cloud that lie far from all others, where the camera is fitted to the rest.
pub fn outlier_hint(spec: &CameraSpec, scene: &Scene, framing: &Framing) -> Option<String> {
    let is_fitted = match spec.place {
        Place::Default => spec.turns || scene.placed_cameras().is_empty(),
        Place::Automatic | Place::Orbit { radius_m: None, .. } => true,
        _ => false,
    };
    let outliers = framing.outliers().filter(|_| is_fitted)?;
    let corners = outliers.bounds_world.corners();
    let reach_m = corners.iter().map(|corner| corner.distance(framing.center_world())).fold(0.0, f32::max);
    // A sphere fills a picture of 45° from 2.6 of its radii; the number is rounded for people.
    let distance_m: f64 = format!("{:.1e}", 3.0 * reach_m).parse().unwrap_or_default();
    let count = outliers.count;
    let found = format!("{count} of its points lie far from all others, and the camera is fitted to the rest");
    Some(format!("{found}; --orbit 30,28,{distance_m} shows more of them"))
}

/// What to say where nobody asks for a camera and the file's own shows hardly anything of the model, so that the
/// automatic one is taken; none where it does, where it moves, and in a room, of which a camera sees a part.
///
/// `plays` says whether `framing` is that of an animation. Where it is not, the animation that a time plays is looked
/// at: every time of a file and a still without a time have the same camera.
pub fn hides_model(
    spec: &CameraSpec,
    scene: &Scene,
    (framing, plays): (&Framing, bool),
    aspect: f32,
) -> Option<String> {
    if *spec != CameraSpec::default() || scene.has_moving_cameras() {
        return None;
    }
    let camera = scene.first_camera(aspect)?;
    let is_posed = !plays && !scene.animations.is_empty();
    // Materials and lights would stay as the animation leaves them.
    let over_time = is_posed.then(|| Framing::of_animation(&mut scene.clone(), 0));
    let framing = over_time.as_ref().unwrap_or(framing);
    if framing.bounds_world().is_empty() {
        return None;
    }
    let shown = framing.shown_by(camera, aspect);
    if shown.is_enough() || framing.clone().looking_inside(scene).interior().is_some() {
        return None;
    }
    let percent = |share: f32| (100.0 * share).round();
    let (of_model, of_picture) = (percent(shown.of_model), percent(shown.of_picture));
    let found = format!("the file's camera shows {of_model} % of the model, in {of_picture} % of the picture");
    let index = scene.placed_cameras().first().map_or(0, |(index, ..)| *index);
    Some(format!("{found}: it is shown whole; --camera {index} takes the file's"))
}

/// The camera of a turntable in a room, which turns in its middle; none elsewhere, and where something is to be looked at.
fn turning_inside(spec: &CameraSpec, framing: &Framing, turn_deg: f32) -> Option<(Mat4, Projection)> {
    let is_asked_for_more = spec.target.is_some() || spec.up.is_some() || spec.ortho_height_m.is_some();
    let interior = framing.interior().filter(|_| !is_asked_for_more)?;
    let (_, rotation, eye) = interior.world_from_view.to_scale_rotation_translation();
    let eye = framing.center_world().with_y(eye.y);
    let rotation = Quat::from_rotation_y(turn_deg.to_radians()) * rotation;
    let Projection::Perspective { fov_y_rad, near_m, far_m } = interior.projection else { return None };
    let projection = Projection::Perspective {
        fov_y_rad: spec.fov_y_rad.unwrap_or(fov_y_rad),
        near_m: spec.near_m.unwrap_or(near_m),
        far_m: spec.far_m.or(far_m),
    };
    Some((Mat4::from_rotation_translation(rotation, eye), projection))
}

/// The first camera of the file; of a room without one, the view from inside.
fn own_camera(scene: &Scene, framing: &Framing, aspect: f32) -> Option<(Mat4, Projection)> {
    let of_room = || framing.interior().map(|interior| (interior.world_from_view, interior.projection));
    scene.first_camera(aspect).or_else(of_room)
}

/// A camera that is there, with what flags change about it.
fn changed(
    spec: &CameraSpec,
    framing: &Framing,
    (world_from_view, own): (Mat4, Projection),
) -> Result<(Mat4, Projection), Failure> {
    let (eye, back) = (world_from_view.w_axis.truncate(), world_from_view.z_axis.truncate());
    let world_from_view = if spec.target.is_some() || spec.up.is_some() {
        let direction = spec.target_world().map_or(-back, |target| target - eye);
        let up = spec.up.unwrap_or(Vec3::Y).normalize_or(Vec3::Y);
        Mat4::from_rotation_translation(look(direction, up)?, eye)
    } else {
        world_from_view
    };
    let (own_near_m, own_far_m) = match own {
        Projection::Perspective { near_m, far_m, .. } => (near_m, far_m),
        Projection::Orthographic { near_m, far_m, .. } => (near_m, Some(far_m)),
    };
    let (near_m, far_m) = (spec.near_m.unwrap_or(own_near_m), spec.far_m.or(own_far_m));
    if far_m.is_some_and(|far_m| near_m >= far_m) {
        let message = format!("the near plane at {near_m} m is not before the far plane of the camera");
        return Err(Failure::usage(message, "give both --near and --far"));
    }
    let projection = match (spec.ortho_height_m, spec.fov_y_rad, own) {
        (None, None, Projection::Perspective { fov_y_rad, .. }) | (None, Some(fov_y_rad), _) => {
            Projection::Perspective { fov_y_rad, near_m, far_m }
        }
        (Some(height_m), ..) | (None, None, Projection::Orthographic { height_m, .. }) => {
            // A pinhole may see without end.
            let far_m = far_m.unwrap_or_else(|| framing.far_m(eye).max(2.0 * near_m));
            Projection::Orthographic { height_m, near_m, far_m }
        }
    };
    Ok((world_from_view, projection))
}

/// The rotation of a camera that looks along `direction`.
fn look(direction: Vec3, up: Vec3) -> Result<Quat, Failure> {
    let hint = "move --eye or --target apart";
    look_along(direction, up).ok_or_else(|| Failure::usage("the camera stands on its target", hint))
}

/// An orbit, its yaw without the turn of a turntable.
struct Orbit {
    yaw_deg: f32,
    pitch_deg: f32,
    radius_m: Option<f32>,
    up: Vec3,
}

impl Orbit {
    /// Where the camera stands. Without a radius, everything is in the picture; without a target, in its middle.
    fn eye(&self, spec: &CameraSpec, framing: &Framing, aspect: f32, turn_deg: f32) -> Vec3 {
        let target = spec.target_world().unwrap_or_else(|| framing.center_world());
        let start = orbit_rotation(self.yaw_deg, self.pitch_deg, self.up);
        let half_extent = lens(spec).half_extent(aspect);
        let fit = if spec.turns { framing.turning(target, self.up) } else { framing.fit() };
        // The arm is found for one yaw and then turned, so that nothing wobbles.
        let arm = match (self.radius_m, spec.ortho_height_m, spec.target) {
            (Some(radius_m), ..) => start * Vec3::Z * radius_m,
            (None, Some(_), None) => fit.eye_of_parallel_rays(start) - target,
            (None, Some(_), Some(_)) => start * Vec3::Z * (framing.far_m(target)),
            (None, None, None) => fit.eye(start, half_extent) - target,
            (None, None, Some(_)) => start * Vec3::Z * fit.distance_m(target, start, half_extent),
        };
        target + Quat::from_axis_angle(self.up, turn_deg.to_radians()) * arm
    }
}

/// How a camera projects that is not of the file, before its planes are fitted.
fn lens(spec: &CameraSpec) -> Projection {
    match spec.ortho_height_m {
        Some(height_m) => Projection::Orthographic { height_m, near_m: 0.0, far_m: 0.0 },
        None => {
            let fov_y_rad = spec.fov_y_rad.unwrap_or(framing::DEFAULT_FOV_Y_RAD);
            Projection::Perspective { fov_y_rad, near_m: 0.0, far_m: None }
        }
    }
}

fn projection(spec: &CameraSpec, framing: &Framing, eye: Vec3, rotation: Quat) -> Projection {
    let fitted_near_m = framing.fit().near_m(eye, rotation);
    let near_m = spec.near_m.unwrap_or(spec.far_m.map_or(fitted_near_m, |far| fitted_near_m.min(0.5 * far)));
    match lens(spec) {
        Projection::Orthographic { height_m, .. } => {
            let far_m = spec.far_m.unwrap_or(framing.far_m(eye).max(2.0 * near_m));
            Projection::Orthographic { height_m, near_m, far_m }
        }
        Projection::Perspective { fov_y_rad, .. } => Projection::Perspective { fov_y_rad, near_m, far_m: spec.far_m },
    }
}

/// What a camera is called: by itself, or else by its node; the empty text if by neither.
pub fn camera_name(scene: &Scene, index: usize) -> &str {
    let of_camera = scene.cameras.get(index).map(|camera| camera.name.as_str()).filter(|name| !name.is_empty());
    of_camera.or_else(|| node_name(scene, index)).unwrap_or_default()
}

fn node_name(scene: &Scene, index: usize) -> Option<&str> {
    scene.nodes.iter().find(|node| node.camera == Some(index)).map(|node| node.name.as_str())
}

fn named(scene: &Scene, name: &str, aspect: f32) -> Result<(Mat4, Projection), Failure> {
    let by_name = scene.cameras.iter().position(|camera| camera.name == name);
    let by_node = || (0..scene.cameras.len()).find(|index| node_name(scene, *index) == Some(name));
    let index = by_name.or_else(by_node).or_else(|| name.parse().ok());
    index.and_then(|index| of_file(scene, index, aspect)).ok_or_else(|| {
        let named = scene.placed_cameras().into_iter().map(|(index, ..)| (index, camera_name(scene, index)));
        Failure::usage(format!("there is no camera `{name}`"), choices("cameras", named))
    })
}

fn of_file(scene: &Scene, index: usize, aspect: f32) -> Option<(Mat4, Projection)> {
    let (_, world_from_view, _) = scene.placed_cameras().into_iter().find(|(placed, ..)| *placed == index)?;
    Some((world_from_view, scene.cameras.get(index)?.projection_in(aspect)))
}

#[cfg(test)]
mod tests;
