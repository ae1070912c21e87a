//! Where a camera stands so that everything that is drawn is seen, as large as the picture allows.
//!
//! A [`Framing`] holds the vertices that a scene draws, in one pose or over a whole animation. Its [`Fit`] finds, for a
//! camera of a given rotation, the one place from which they fill the picture; [`Framing::turning`] does so for a model
//! that turns, so that one place does for every angle. What encloses its middle is seen from inside ([`Interior`]), and
//! points of a cloud that lie far from all others are not framed ([`Outliers`]).

mod fit;
mod furniture;
mod interior;
mod look;
mod outer;
mod outliers;
mod panorama;
mod points;
mod shown;
#[cfg(test)]
mod tests;
mod vertices;

pub use fit::{Fit, MARGIN};
pub use interior::Interior;
pub use look::look_along;
pub use outliers::Outliers;
pub use shown::{LEAST_OF_MODEL, LEAST_OF_PICTURE, PictureCoverage};

use crate::animation::{Animation, Property};
use crate::capture::{Monitor, MonitorCamera};
use crate::turns::{Turns, at_once, give_turn};
use crate::{Aabb, NodeId, Projection, Scene};
use glam::{Mat4, Quat, Vec2, Vec3};
use points::Points;

/// The vertical field of view of a camera that nobody describes: 45°.
pub const DEFAULT_FOV_Y_RAD: f32 = std::f32::consts::FRAC_PI_4;

/// The yaw of a camera that nobody describes, in degrees; see [`orbit_rotation`].
pub const DEFAULT_YAW_DEG: f32 = 30.0;

/// The pitch of a camera that nobody describes, in degrees; see [`orbit_rotation`]. The eye is shifted until the
/// margins are equal, which lowers it: from 20 degrees the top of a box would be a sliver.
pub const DEFAULT_PITCH_DEG: f32 = 28.0;

/// `world_from_view` of a camera that looks at a point from around it. Yaw 0 looks along −Z from +Z and grows
/// counter-clockwise seen from above, towards +X; positive pitch looks down from above. `up` is of length 1.
pub fn orbit_rotation(yaw_deg: f32, pitch_deg: f32, up: Vec3) -> Quat {
    let turn = Quat::from_rotation_y(yaw_deg.to_radians());
    Quat::from_rotation_arc(Vec3::Y, up) * turn * Quat::from_rotation_x(-pitch_deg.to_radians())
}

/// The extent that a camera is to show completely. It is taken from a scene once and then asked for every picture.
#[derive(Clone, Debug)]
pub struct Framing {
    bounds_world: Aabb,
    /// Half the diagonal of the bounds; 1 m for a single point.
    radius_m: f32,
    /// Relative to the middle of the bounds.
    points: Points<3>,
    interior: Option<Interior>,
    outliers: Option<Outliers>,
}

/// Whether a point is at a place, and not so far away that squares of distances are not finite.
fn is_placed(point: &Vec3) -> bool {
    point.abs().max_element() < 1e18
}

impl Framing {
    /// The vertices of everything that `scene` draws, as of its last [`Scene::update_transforms`]; above 10⁷ vertices,
    /// the boxes around them. Where the scene has no camera, this finds out whether it is to be seen from inside, and
    /// where it is a cloud of points, which are its [`Outliers`]. Takes about 20 ms for a million of triangles.
    pub fn of_scene(scene: &Scene) -> Self {
        at_once(Self::of_scene_in_turns(scene, &mut || None))
    }

    /// As [`Self::of_scene`]; now and then `turns` is asked whether others are to have the thread.
    pub async fn of_scene_in_turns(scene: &Scene, turns: &mut Turns<'_>) -> Self {
        let interior =
            if scene.placed_cameras().is_empty() { Interior::find_in_turns(scene, turns).await } else { None };
        let points = vertices::posed_in_turns(scene, turns).await;
        Self { interior, ..Self::of_drawn(points, &[scene], turns).await }
    }

    /// The vertices of everything that several scenes draw, as [`Self::of_scene`]; from inside where the first is a
    /// room and none has a camera.
    pub fn of_scenes(scenes: &[&Scene]) -> Self {
        let has_camera = scenes.iter().any(|scene| !scene.placed_cameras().is_empty());
        let interior = scenes.first().filter(|_| !has_camera).and_then(|scene| Interior::find(scene));
        let points = scenes.iter().flat_map(|scene| vertices::posed(scene)).collect();
        Self { interior, ..at_once(Self::of_drawn(points, scenes, &mut || None)) }
    }

    /// The vertices of everything that `scene` draws while an animation plays, at 32 times from its first keyframe to
    /// its last; above 10⁷ posed vertices, the boxes around them. Where there is no such animation, as
    /// [`Self::of_scene`]. The scene is left as it was.
    pub fn of_animation(scene: &mut Scene, animation: usize) -> Self {
        let interior = if scene.placed_cameras().is_empty() { Interior::find(scene) } else { None };
        let points = vertices::animated(scene, animation);
        Self { interior, ..at_once(Self::of_drawn(points, &[&*scene], &mut || None)) }
    }

    /// The same, of what encloses its middle also where it has cameras: for a camera that is none of them.
    pub fn looking_inside(self, scene: &Scene) -> Self {
        let interior = self.interior.or_else(|| Interior::find(scene));
        Self { interior, ..self }
    }

    /// The corners of a box.
    pub fn of_bounds(bounds_world: &Aabb) -> Self {
        let points = if bounds_world.is_empty() { Vec::new() } else { bounds_world.corners().to_vec() };
        Self::of_points(points)
    }

    /// Of the points that scenes draw; of a cloud without its outliers.
    async fn of_drawn(mut points: Vec<Vec3>, scenes: &[&Scene], turns: &mut Turns<'_>) -> Self {
        let vertices: usize = scenes.iter().map(|scene| outliers::points_of(scene)).sum();
        // Of a cloud of too many points there are but the corners of boxes.
        if points.len() < vertices || !scenes.iter().all(|scene| outliers::is_cloud(scene)) {
            return Self::of_points_in_turns(points, turns).await;
        }
        points.retain(is_placed);
        let outliers = outliers::leave_out(&mut points);
        Self { outliers, ..Self::of_points_in_turns(points, turns).await }
    }

    /// Of points in world space. Points that are not finite are passed over; where there are none, a cube of 2 m around
    /// the origin is framed.
    fn of_points(points: Vec<Vec3>) -> Self {
        at_once(Self::of_points_in_turns(points, &mut || None))
    }

    async fn of_points_in_turns(mut points: Vec<Vec3>, turns: &mut Turns<'_>) -> Self {
        give_turn(turns).await;
        points.retain(is_placed);
        let bounds_world = Aabb::from_points(points.iter().copied());
        if points.is_empty() {
            points = Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE }.corners().to_vec();
        }
        let center = bounds_world.center();
        outer::drop_inner(&mut points, center, turns).await;
        let points = Points::new(points.iter().map(|point| (*point - center).to_array()));
        // What is smaller than that at its distance from the origin is one point.
        let least_m = 1e-6 * center.length();
        let radius_m = Some(bounds_world.radius_m()).filter(|radius_m| *radius_m > least_m);
        let radius_m = radius_m.unwrap_or(1.0f32.max(100.0 * least_m));
        Self { bounds_world, radius_m, points, interior: None, outliers: None }
    }

    /// Places cameras before what is framed.
    pub fn fit(&self) -> Fit<'_> {
        Fit::of_points(&self.points, self.center_world(), self.radius_m)
    }

    /// Places cameras before all that is swept by what is framed while it turns around the line through `on_axis_world`
    /// along `up`, which is of length 1: from one distance it is seen whole at every yaw.
    pub fn turning(&self, on_axis_world: Vec3, up: Vec3) -> Fit<'_> {
        Fit::of_turning_points(&self.points, self.center_world(), self.radius_m, on_axis_world, up)
    }

    /// The smallest box around everything that is framed; empty if there is nothing.
    pub fn bounds_world(&self) -> &Aabb {
        &self.bounds_world
    }

    /// The height of the lowest point; none if there is nothing.
    pub fn lowest_m(&self) -> Option<f32> {
        (!self.bounds_world.is_empty()).then_some(self.bounds_world.min.y)
    }

    /// The middle of the box; the origin if there is nothing.
    pub fn center_world(&self) -> Vec3 {
        self.bounds_world.center()
    }

    /// Half the diagonal of the box in metres; 1 m for a single point and for nothing.
    pub fn radius_m(&self) -> f32 {
        self.radius_m
    }

    /// From where a scene is seen that encloses its middle; none for all others, and for those with a camera.
    pub fn interior(&self) -> Option<&Interior> {
        self.interior.as_ref()
    }

    /// The points of a cloud that are drawn and not framed, because they lie far from all others; none elsewhere, and
    /// where leaving them out would not make the box around all points less than half as large.
    pub fn outliers(&self) -> Option<&Outliers> {
        self.outliers.as_ref()
    }

    /// A far plane that cuts nothing, seen from `eye_world`.
    pub fn far_m(&self, eye_world: Vec3) -> f32 {
        let behind = |center: Vec3, radius_m: f32| eye_world.distance(center) + 2.0 * radius_m;
        let outliers = self
            .outliers
            .map_or(0.0, |outliers| behind(outliers.bounds_world.center(), outliers.bounds_world.radius_m()));
        behind(self.center_world(), self.radius_m).max(outliers)
    }

    /// `world_from_view` and the projection of a camera of which nothing is known: inside what encloses its middle,
    /// else all from yaw 30, pitch 28, with a vertical field of view of 45°. `aspect` is width / height.
    pub fn automatic(&self, aspect: f32) -> (Mat4, Projection) {
        if let Some(interior) = &self.interior {
            return (interior.world_from_view, interior.projection);
        }
        let rotation = orbit_rotation(DEFAULT_YAW_DEG, DEFAULT_PITCH_DEG, Vec3::Y);
        let lens = Projection::Perspective { fov_y_rad: DEFAULT_FOV_Y_RAD, near_m: 0.0, far_m: None };
        let fit = self.fit();
        let eye = fit.eye(rotation, lens.half_extent(aspect));
        let near_m = fit.near_m(eye, rotation);
        let projection = Projection::Perspective { fov_y_rad: DEFAULT_FOV_Y_RAD, near_m, far_m: None };
        (Mat4::from_rotation_translation(rotation, eye), projection)
    }
}

impl Framing {
    /// What a camera shows of what is framed, in a picture whose width is `aspect` times its height.
    pub fn shown_by(&self, (world_from_view, projection): (Mat4, Projection), aspect: f32) -> PictureCoverage {
        let view_from_world = world_from_view.inverse();
        let half = projection.half_extent(aspect);
        let is_parallel = matches!(projection, Projection::Orthographic { .. });
        let (mut low, mut high, mut inside, mut all) = (Vec2::INFINITY, Vec2::NEG_INFINITY, 0u32, 0u32);
        for point in self.points.iter() {
            let seen = view_from_world.transform_point3(point + self.center_world());
            let depth = -seen.z;
            let place = seen.truncate() / (half * if is_parallel { 1.0 } else { depth });
            all += 1;
            if depth <= 0.0 || !place.is_finite() {
                continue;
            }
            inside += u32::from(place.abs().max_element() <= 1.0);
            (low, high) = (low.min(place), high.max(place));
        }
        let extent = (high.clamp(Vec2::NEG_ONE, Vec2::ONE) - low.clamp(Vec2::NEG_ONE, Vec2::ONE)).max(Vec2::ZERO);
        let of_picture = if low.is_finite() { 0.25 * extent.x * extent.y } else { 0.0 };
        PictureCoverage { of_model: inside as f32 / all.max(1) as f32, of_picture }
    }
}

impl Scene {
    /// `world_from_view` and the projection of the first of [`Scene::placed_cameras`] that no monitor shows: what a scene
    /// is seen through where nobody says, in a picture whose width is `aspect` times its height.
    pub fn first_camera(&self, aspect: f32) -> Option<(Mat4, Projection)> {
        let node_of = |monitor: &Monitor| match monitor.camera {
            MonitorCamera::Node(id) => self.nodes.get(id.0 as usize)?.camera,
            MonitorCamera::Fixed { .. } => None,
        };
        let shown: Vec<usize> = self.monitors().filter_map(|(_, _, monitor)| node_of(monitor)).collect();
        let placed = self.placed_cameras().into_iter().find(|(index, ..)| !shown.contains(index));
        placed.and_then(|(index, world_from_view, _)| {
            Some((world_from_view, self.cameras.get(index)?.projection_in(aspect)))
        })
    }

    /// Whether an animation moves a camera, or what carries it.
    pub fn has_moving_cameras(&self) -> bool {
        let mut carries = vec![false; self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().filter(|(_, node)| node.camera.is_some()) {
            let (mut index, mut parent) = (index, node.parent);
            // Above what is known all is known.
            while let Some(slot) = carries.get_mut(index).filter(|carries| !**carries) {
                *slot = true;
                let Some(NodeId(above)) = parent else { break };
                index = above as usize;
                parent = self.nodes.get(index).and_then(|node| node.parent);
            }
        }
        let is_carrier = |id: NodeId| carries.get(id.0 as usize).copied().unwrap_or(false);
        let moves = |animation: &Animation| {
            let changes_lens = animation.properties.iter().any(|of| matches!(of.property, Property::Camera(..)));
            changes_lens || animation.channels.iter().any(|channel| is_carrier(channel.node))
        };
        self.animations.iter().any(moves)
    }

    /// The cameras of visible nodes in the order of the file, each with its index, `world_from_view` without the scale
    /// of its node, and projection.
    pub fn placed_cameras(&self) -> Vec<(usize, Mat4, Projection)> {
        let mut node_of: Vec<Option<NodeId>> = vec![None; self.cameras.len()];
        for id in self.visible_nodes() {
            if let Some(slot) = self.node(id).camera.and_then(|camera| node_of.get_mut(camera)) {
                slot.get_or_insert(id);
            }
        }
        let placed = self.cameras.iter().zip(node_of).enumerate().filter_map(|(index, (camera, id))| {
            let (_, rotation, translation) = self.node(id?).world_from_object.to_scale_rotation_translation();
            Some((index, Mat4::from_rotation_translation(rotation, translation), camera.projection))
        });
        placed.collect()
    }
}
