//! A view as a file lists it, its lens, and what can be wrong with them.

use crate::failure::{Failure, Kind};
use glam::{DMat3, DVec3, Quat};
use manypass_scene::input_file::InputError;
use std::fmt::Display;
use std::path::Path;

/// The most views of one call.
pub(super) const MOST_VIEWS: usize = 100_000;

/// The largest coordinate: squares of coordinates, and sums of those, can still be computed.
const LARGEST_M: f64 = 1e15;

/// The longest side of an image, and the longest focal length, far above those of any sensor.
const MOST_PX: f64 = 1e9;

/// Focal lengths that differ by less are equal: calibration is not more exact.
pub(super) const EQUAL_FOCAL: f64 = 1e-3;

/// A principal point nearer to the middle is the middle: conventions differ by half a pixel.
pub(super) const MIDDLE_PX: f64 = 0.5;

/// What `--cameras` takes.
pub(super) const HINT: &str =
    "give a transforms.json as NeRF's tools write it, or the folder of COLMAP's cameras and images (docs/camera.md)";

/// What is wrong at a place of a file, and what to do.
#[derive(Debug, PartialEq)]
pub(super) struct Fault {
    pub(super) message: String,
    pub(super) hint: String,
}

impl Fault {
    /// A fault whose place is not known yet.
    pub(super) fn new(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { message: message.into(), hint: hint.into() }
    }

    /// The failure at a place of the file `path`.
    pub(super) fn at(self, path: &Path, place: impl Display) -> Failure {
        Failure::new(Kind::Failed, format!("{}: {place}: {}", path.display(), self.message), self.hint)
    }
}

/// The failure of a file that lists more than [`MOST_VIEWS`].
pub(super) fn too_many(path: &Path) -> Failure {
    let message = format!("{} lists more than {MOST_VIEWS} views", path.display());
    Failure::new(Kind::Failed, message, format!("split it into files of {MOST_VIEWS} views at most"))
}

/// The failure of a file that cannot be read.
pub(super) fn unread(path: &Path, error: &InputError) -> Failure {
    Failure::new(Kind::Failed, format!("cannot read {}: {error}", path.display()), HINT)
}

/// A pinhole, in pixels of its image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    /// Along x and y.
    pub(super) focal_px: [f64; 2],
    /// The principal point from the top left corner; none is the middle.
    pub(super) center_px: Option<[f64; 2]>,
    /// Width and height of its image, or of the picture where the file does not say.
    pub(super) size_px: [f64; 2],
    /// Whether the file says how large the image is.
    pub(super) has_size: bool,
    /// Whether the focal length is one in pixels, so that it means nothing without a size.
    pub(super) is_in_pixels: bool,
    /// Whether it bends straight lines, which pictures do not show.
    pub(super) is_distorted: bool,
}

impl Lens {
    /// How much the focal lengths differ; 0 where pixels are square.
    pub(super) fn stretch(&self) -> f64 {
        (self.focal_px[0] / self.focal_px[1] - 1.0).abs()
    }

    /// How far the principal point is off the middle, along x or y, whichever is more.
    pub(super) fn offset_px(&self) -> f64 {
        let [width, height] = self.size_px;
        self.center_px.map_or(0.0, |[x, y]| (x - 0.5 * width).abs().max((y - 0.5 * height).abs()))
    }

    /// Whether pictures show it with square pixels or with the middle as principal point, and it has neither.
    pub(super) fn is_uneven(&self) -> bool {
        self.stretch() > EQUAL_FOCAL || self.offset_px() > MIDDLE_PX
    }

    /// Whether it is in pixels of an image of an unknown size.
    pub(super) fn is_unsized(&self) -> bool {
        self.is_in_pixels && !self.has_size
    }

    /// The vertical field of view in radians.
    ///
    /// # Errors
    /// Numbers that are those of no pinhole.
    pub(super) fn fov_y_rad(&self) -> Result<f32, Fault> {
        let [width, height] = self.size_px;
        if ![width, height].iter().all(|side| (1.0..=MOST_PX).contains(side)) {
            let message = format!("an image of {width} x {height} pixels is out of range");
            return Err(Fault::new(message, "give the width and height of the image in pixels, from 1 to 1e9"));
        }
        let [x, y] = self.focal_px;
        if ![x, y].iter().all(|focal| *focal > 0.0 && *focal <= MOST_PX) {
            let message = format!("a focal length of {x}, {y} pixels is out of range");
            return Err(Fault::new(message, "give focal lengths above 0 and up to 1e9 pixels"));
        }
        if !self.center_px.is_none_or(|center| center.iter().all(|number| number.abs() <= MOST_PX)) {
            return Err(Fault::new("the principal point is out of range", "give pixels from the top left corner"));
        }
        let fov_y_rad = 2.0 * (0.5 * height / y).atan();
        let fov_y_deg = fov_y_rad.to_degrees();
        if !(0.001..=179.0).contains(&fov_y_deg) {
            let message = format!("a focal length of {y} pixels is a vertical field of view of {fov_y_deg} degrees");
            return Err(Fault::new(message, "give a focal length whose field of view is 0.001 to 179 degrees"));
        }
        Ok(fov_y_rad as f32)
    }
}

/// A view as a file lists it, in the axes of glTF.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ListedView {
    /// The name of its image, without folders and ending; empty if it has none.
    pub(super) name: String,
    /// To the world from a camera that looks along −Z with +Y up.
    pub(super) rotation: Quat,
    /// In metres, in the space of the file.
    pub(super) eye_world: DVec3,
    pub(super) fov_y_rad: f32,
    pub(super) lens: Lens,
}

impl ListedView {
    /// The view of the image at `image`, a path. `world_from_view` may be scaled; it is not by then.
    ///
    /// # Errors
    /// Numbers that are those of no camera.
    pub(super) fn new(image: &str, world_from_view: DMat3, eye_world: DVec3, lens: Lens) -> Result<Self, Fault> {
        let rotation = Quat::from_mat3(&orthonormal(world_from_view)?.as_mat3());
        if !(eye_world.is_finite() && eye_world.abs().max_element() <= LARGEST_M) {
            let message = format!("the camera's place {eye_world} is out of range");
            return Err(Fault::new(message, "give numbers from -1e15 to 1e15"));
        }
        let fov_y_rad = lens.fov_y_rad()?;
        Ok(Self { name: stem(image).to_owned(), rotation, eye_world, fov_y_rad, lens })
    }
}

/// The rotation of a matrix, without its scale. The camera's axis keeps its direction, and up turns least.
///
/// # Errors
/// No rotation is in it.
fn orthonormal(matrix: DMat3) -> Result<DMat3, Fault> {
    let hint = "write the pose of a camera: a rotation and where the camera is";
    if !matrix.is_finite() {
        return Err(Fault::new("the rotation has a number that is not finite", hint));
    }
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let volume = x.length() * y.length() * z.length();
    let determinant = matrix.determinant();
    // Rounding alone leaves 1e-16; a skew of this share is no camera's.
    let is_regular = volume.is_normal() && determinant.abs() > 1e-6 * volume;
    if !is_regular {
        return Err(Fault::new("the rotation is singular: its columns do not span space", hint));
    }
    if determinant < 0.0 {
        let hint = "turn one axis around, so that the determinant is 1: cameras are right-handed, +X right, +Y up";
        return Err(Fault::new("the rotation is mirrored: its determinant is negative", hint));
    }
    let back = z.normalize();
    let up = (y - back * back.dot(y)).normalize();
    Ok(DMat3::from_cols(up.cross(back), up, back))
}

/// The name of an image without folders, of either system, and without its ending, which begins with a letter: that of
/// `r_0.5` is none.
pub(super) fn stem(path: &str) -> &str {
    let name = path.trim().rsplit(['/', '\\']).next().unwrap_or_default();
    match name.rsplit_once('.') {
        Some((stem, ending)) if !stem.is_empty() && ending.starts_with(|c: char| c.is_ascii_alphabetic()) => stem,
        _ => name,
    }
}
