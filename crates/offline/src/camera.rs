//! A picture's camera as data: for reports, for headers of files, and for OpenCV.

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};
use manypass::{FrameRequest, View};
use manypass_scene::{Projection, Scene};
use serde::Serialize;
use std::collections::HashMap;

/// A matrix as a list of its rows; it multiplies column vectors from the left.
pub type Rows<const N: usize, const M: usize> = [[f64; M]; N];

/// Where a camera is and how it maps space to a picture.
///
/// World space is right-handed with +y up, view space is right-handed with +x right, +y up and −z ahead, as in glTF.
/// OpenCV's camera space has +x right, +y down and +z ahead. Pixels are counted from the top left corner of the picture,
/// +x right and +y down; the middle of the first pixel is at (0.5, 0.5).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraData {
    /// `perspective`, `orthographic` or `fisheye`.
    pub kind: &'static str,
    /// Where it is, in metres.
    pub eye_world_m: [f64; 3],
    /// The horizontal field of view; none with parallel rays, and of a fisheye.
    pub fov_x_deg: Option<f64>,
    /// The vertical field of view; none with parallel rays, and of a fisheye.
    pub fov_y_deg: Option<f64>,
    /// The height of the picture in metres; only with parallel rays.
    pub height_m: Option<f64>,
    /// The distance of the near plane in metres.
    pub near_m: f64,
    /// The distance of the far plane in metres; none is infinity.
    pub far_m: Option<f64>,
    /// From view space to world space, in metres.
    pub world_from_view: Rows<4, 4>,
    /// From world space to view space, in metres.
    pub view_from_world: Rows<4, 4>,
    /// From world space to the picture: (x, y, z, w) whose x / w and y / w are pixels; none of a fisheye.
    pub pixel_from_world: Option<Rows<4, 4>>,
    /// The same in OpenCV's terms; none of a fisheye.
    pub opencv: Option<OpenCv>,
    /// How a fisheye maps view space to the picture; none of other cameras.
    pub fisheye: Option<FisheyeData>,
}

/// The circle that a fisheye shows. What is at the angle θ from the axis lies at the distance r from its middle, as far to
/// the side and up as it is in view space: `r / radius_px` is `f(θ) / f(fov_deg / 2)`, where f(θ) is θ (equidistant),
/// sin(θ / 2) (equisolid) or tan(θ / 2) (stereographic).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FisheyeData {
    /// `equidistant`, `equisolid` or `stereographic`.
    pub map: &'static str,
    /// The angle across the circle.
    pub fov_deg: f64,
    /// Its middle, in pixels from the left.
    pub cx: f64,
    /// Its middle, in pixels from the top.
    pub cy: f64,
    /// Its radius in pixels.
    pub radius_px: f64,
}

impl FisheyeData {
    /// Of what `request` asks for; none if that is no fisheye.
    fn of(request: &FrameRequest) -> Option<Self> {
        let radius_px = request.fisheye_radius_px()?;
        let settings = &request.settings.camera;
        Some(Self {
            map: settings.fisheye.name(),
            fov_deg: settings.fisheye_fov_deg.into(),
            cx: 0.5 * f64::from(request.width),
            cy: 0.5 * f64::from(request.height),
            radius_px,
        })
    }
}

/// `pixel = (fx · x / z + cx, fy · y / z + cy)` for `(x, y, z) = rotation · position_world + translation_m`; with parallel
/// rays without `/ z`. Where pixel middles are whole numbers, as `cv::remap` has them, take 0.5 from `cx` and `cy`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenCv {
    /// The width of the picture in pixels.
    pub width: u32,
    /// The height of the picture in pixels.
    pub height: u32,
    /// Pixels per unit of x / z; with parallel rays, pixels a metre.
    pub fx: f64,
    /// Pixels per unit of y / z; with parallel rays, pixels a metre.
    pub fy: f64,
    /// Where the axis meets the picture, in pixels from the left.
    pub cx: f64,
    /// Where the axis meets the picture, in pixels from the top.
    pub cy: f64,
    /// From world axes to OpenCV's camera axes.
    pub rotation: Rows<3, 3>,
    /// The world's origin in OpenCV's camera space, in metres.
    pub translation_m: [f64; 3],
}

fn rows(matrix: DMat4) -> Rows<4, 4> {
    [0, 1, 2, 3].map(|row| clean(matrix.row(row)))
}

/// Without negative zeros, which only puzzle.
fn clean(row: DVec4) -> [f64; 4] {
    (row + DVec4::ZERO).to_array()
}

/// From OpenCV's camera space to the picture: pixels in x and y, what `near` and `far` are mapped to 0 and 1 in z.
fn pixel_from_camera(projection: Projection, (width, height): (u32, u32)) -> (DMat4, f64) {
    let (width, height) = (f64::from(width), f64::from(height));
    let half_height = match projection {
        Projection::Perspective { fov_y_rad, .. } => (0.5 * f64::from(fov_y_rad)).tan(),
        Projection::Orthographic { height_m, .. } => 0.5 * f64::from(height_m),
    };
    let focal_px = 0.5 * height / half_height;
    let (cx, cy) = (0.5 * width, 0.5 * height);
    let (near, far) = planes_m(projection);
    let matrix = match projection {
        Projection::Perspective { .. } => {
            let (scale, offset) = far.map_or((1.0, -near), |far| (far / (far - near), -near * far / (far - near)));
            DMat4::from_cols(
                DVec4::new(focal_px, 0.0, 0.0, 0.0),
                DVec4::new(0.0, focal_px, 0.0, 0.0),
                DVec4::new(cx, cy, scale, 1.0),
                DVec4::new(0.0, 0.0, offset, 0.0),
            )
        }
        Projection::Orthographic { .. } => {
            let scale = far.map_or(1.0, |far| 1.0 / (far - near));
            DMat4::from_cols(
                DVec4::new(focal_px, 0.0, 0.0, 0.0),
                DVec4::new(0.0, focal_px, 0.0, 0.0),
                DVec4::new(0.0, 0.0, scale, 0.0),
                DVec4::new(cx, cy, -near * scale, 1.0),
            )
        }
    };
    (matrix, focal_px)
}

fn planes_m(projection: Projection) -> (f64, Option<f64>) {
    match projection {
        Projection::Perspective { near_m, far_m, .. } => (f64::from(near_m), far_m.map(f64::from)),
        Projection::Orthographic { near_m, far_m, .. } => (f64::from(near_m), Some(f64::from(far_m))),
    }
}

impl CameraData {
    /// The camera of the picture that `request` asks for.
    pub fn of(request: &FrameRequest) -> Self {
        let camera = Self::from_origin(&request.camera, request.origin_m, request.width, request.height);
        let Some(fisheye) = FisheyeData::of(request) else { return camera };
        Self {
            kind: "fisheye",
            fov_x_deg: None,
            fov_y_deg: None,
            pixel_from_world: None,
            opencv: None,
            fisheye: Some(fisheye),
            ..camera
        }
    }

    /// The camera of a picture of `width` × `height` pixels.
    pub fn new(view: &View, width: u32, height: u32) -> Self {
        Self::from_origin(view, Vec3::ZERO, width, height)
    }

    /// The same in the space of a file, in which world space has its origin at `origin_m` ([`Scene::origin_m`]).
    pub fn from_origin(view: &View, origin_m: Vec3, width: u32, height: u32) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let world_from_view = DMat4::from_translation(origin_m.as_dvec3()) * view.world_from_view.as_dmat4();
        let view_from_world = world_from_view.inverse();
        let camera_from_world = DMat4::from_scale(DVec3::new(1.0, -1.0, -1.0)) * view_from_world;
        let (pixel_from_camera, focal_px) = pixel_from_camera(view.projection, (width, height));
        let (near_m, far_m) = planes_m(view.projection);
        let fov_deg = |side_px: u32| {
            (!view.is_orthographic()).then(|| 2.0 * (0.5 * f64::from(side_px) / focal_px).atan().to_degrees())
        };
        let [x, y, z, _] = rows(camera_from_world);
        let height_m = match view.projection {
            Projection::Orthographic { height_m, .. } => Some(f64::from(height_m)),
            Projection::Perspective { .. } => None,
        };
        Self {
            kind: if view.is_orthographic() { "orthographic" } else { "perspective" },
            eye_world_m: world_from_view.w_axis.truncate().to_array(),
            fov_x_deg: fov_deg(width),
            fov_y_deg: fov_deg(height),
            height_m,
            near_m,
            far_m,
            world_from_view: rows(world_from_view),
            view_from_world: rows(view_from_world),
            pixel_from_world: Some(rows(pixel_from_camera * camera_from_world)),
            fisheye: None,
            opencv: Some(OpenCv {
                width,
                height,
                fx: focal_px,
                fy: focal_px,
                cx: 0.5 * f64::from(width),
                cy: 0.5 * f64::from(height),
                rotation: [x, y, z].map(|row| [row[0], row[1], row[2]]),
                translation_m: [x[3], y[3], z[3]],
            }),
        }
    }

    /// OpenEXR's `worldToCamera`: left-handed, +x right, +y up, +z ahead; for row vectors, row by row.
    pub fn exr_world_to_camera(&self) -> [f32; 16] {
        for_row_vectors(DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * from_rows(&self.view_from_world))
    }

    /// OpenEXR's `worldToNDC`: (0, 0) is the top left corner of the picture, (1, 1) the bottom right one, and z is 0 at
    /// the near and 1 at the far plane; for row vectors, row by row. None of a fisheye.
    pub fn exr_world_to_ndc(&self) -> Option<[f32; 16]> {
        let opencv = self.opencv.as_ref()?;
        let size = DVec3::new(f64::from(opencv.width), f64::from(opencv.height), 1.0);
        Some(for_row_vectors(DMat4::from_scale(size.recip()) * from_rows(self.pixel_from_world.as_ref()?)))
    }

    /// OpenEXR's `screenWindowWidth`: the width of the picture in view space, 1 m ahead; with parallel rays everywhere.
    /// 1 of a fisheye, because every file has one.
    pub fn exr_screen_window_width(&self) -> f32 {
        self.opencv.as_ref().map_or(1.0, |opencv| (f64::from(opencv.width) / opencv.fx) as f32)
    }
}

fn from_rows(rows: &Rows<4, 4>) -> DMat4 {
    DMat4::from_cols_array_2d(rows).transpose()
}

/// The columns of a matrix for column vectors are the rows of that for row vectors.
fn for_row_vectors(matrix: DMat4) -> [f32; 16] {
    (matrix.as_mat4()).to_cols_array()
}

/// A camera of a file, as `info` lists it.
#[derive(Clone, Debug, Serialize)]
pub struct SceneCamera {
    /// Its index.
    pub index: usize,
    /// Its name; empty if it has none.
    pub name: String,
    /// The node that holds it; none if nothing does, so that nobody sees through it.
    pub node: Option<usize>,
    /// The rest of it, in a picture of the given size; none if nothing holds it.
    #[serde(flatten)]
    pub camera: Option<CameraData>,
}

/// The cameras of a scene, in a picture of `width` × `height` pixels, as of the last update of its transforms.
pub fn scene_cameras(scene: &Scene, width: u32, height: u32) -> Vec<SceneCamera> {
    let places: HashMap<usize, Mat4> =
        scene.placed_cameras().into_iter().map(|(index, world_from_view, _)| (index, world_from_view)).collect();
    let mut nodes = HashMap::new();
    for (node, camera) in scene.nodes.iter().enumerate().filter_map(|(node, of)| Some((node, of.camera?))) {
        nodes.entry(camera).or_insert(node);
    }
    let camera = |(index, camera): (usize, &manypass_scene::Camera)| SceneCamera {
        index,
        name: camera.name.clone(),
        node: nodes.get(&index).copied(),
        camera: places.get(&index).map(|world_from_view| {
            let projection = camera.projection_in(width as f32 / height.max(1) as f32);
            let view = View { world_from_view: *world_from_view, projection };
            CameraData::from_origin(&view, scene.origin_m, width, height)
        }),
    };
    scene.cameras.iter().enumerate().map(camera).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    const EYE: Vec3 = Vec3::new(3.0, 4.0, 5.0);

    fn views() -> [View; 3] {
        let world_from_view =
            Mat4::from_rotation_translation(Quat::from_euler(glam::EulerRot::YXZ, 0.7, -0.4, 0.2), EYE);
        [
            Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: None },
            Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: Some(40.0) },
            Projection::Orthographic { height_m: 5.0, near_m: 0.1, far_m: 40.0 },
        ]
        .map(|projection| View { world_from_view, projection })
    }

    /// Row vector times matrix, and the division by w.
    fn times(p: DVec3, matrix: &[f32; 16]) -> DVec3 {
        let v = [p.x, p.y, p.z, 1.0];
        let sum = |column: usize| (0..4).map(|row| v[row] * f64::from(matrix[row * 4 + column])).sum::<f64>();
        DVec3::new(sum(0), sum(1), sum(2)) / sum(3)
    }

    #[test]
    fn every_form_of_the_camera_says_the_same() {
        let (width, height) = (200, 120);
        for view in views() {
            let camera = CameraData::new(&view, width, height);
            // 7 m ahead, 1 m to the right, 0.5 m up, by the camera's own axes.
            let p = view.world_from_view.transform_point3(Vec3::new(1.0, 0.5, -7.0)).as_dvec3();
            let half_height = match view.projection {
                Projection::Perspective { fov_y_rad, .. } => 7.0 * (0.5 * f64::from(fov_y_rad)).tan(),
                Projection::Orthographic { height_m, .. } => 0.5 * f64::from(height_m),
            };
            let expected = [100.0 + 60.0 / half_height, 60.0 - 0.5 * 60.0 / half_height];
            let near = |x: f64, y: f64| (x - expected[0]).abs() < 1e-4 && (y - expected[1]).abs() < 1e-4;
            let cv = camera.opencv.as_ref().expect("a matrix");
            let axis = |row: usize| DVec3::from_array(cv.rotation[row]).dot(p) + cv.translation_m[row];
            let divisor = if view.is_orthographic() { 1.0 } else { axis(2) };
            assert!((DVec3::new(axis(0), axis(1), axis(2)) - DVec3::new(1.0, -0.5, 7.0)).length() < 1e-5);
            assert!(near(cv.fx * axis(0) / divisor + cv.cx, cv.fy * axis(1) / divisor + cv.cy));
            let pixel = from_rows(camera.pixel_from_world.as_ref().expect("a matrix")).project_point3(p);
            assert!(near(pixel.x, pixel.y), "{pixel} {expected:?}");
            let to_camera = times(p, &camera.exr_world_to_camera());
            assert!((to_camera - DVec3::new(1.0, 0.5, 7.0)).length() < 1e-5, "{to_camera}");
            let world_to_ndc = camera.exr_world_to_ndc().expect("a matrix");
            let ndc = times(p, &world_to_ndc);
            assert!(near(ndc.x * 200.0, ndc.y * 120.0), "{ndc}");
            let plane = |distance: f32| {
                let p = view.world_from_view.transform_point3(Vec3::new(0.0, 0.0, -distance)).as_dvec3();
                times(p, &world_to_ndc).z
            };
            assert!(plane(0.1).abs() < 1e-4, "{}", plane(0.1));
            assert!((plane(40.0) - if camera.far_m.is_some() { 1.0 } else { 1.0 - 0.1 / 40.0 }).abs() < 1e-4);
            assert_eq!(camera.eye_world_m, EYE.as_dvec3().to_array());
        }
    }
}
