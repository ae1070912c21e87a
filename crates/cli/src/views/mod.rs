//! Views of `--cameras`: poses and lenses that a file of NeRF's tools or a folder of COLMAP lists.

mod colmap;
mod nerf;

use crate::camera::{CameraSpec, Place};
use crate::failure::{Failure, Kind};
use crate::job::LARGEST_SIDE_PX;
use crate::looks::distinct;
use glam::{DMat3, DVec3, Quat};
use manypass_scene::input_file::InputError;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// The most views of one call.
const MOST_VIEWS: usize = 100_000;

/// The largest coordinate: squares of coordinates, and sums of those, can still be computed.
const LARGEST_M: f64 = 1e15;

/// The longest side of an image, and the longest focal length, far above those of any sensor.
const MOST_PX: f64 = 1e9;

/// Focal lengths that differ by less are equal: calibration is not more exact.
const EQUAL_FOCAL: f64 = 1e-3;

/// A principal point nearer to the middle is the middle: conventions differ by half a pixel.
const MIDDLE_PX: f64 = 0.5;

/// A picture's shape that differs by less is that of the images.
const EQUAL_ASPECT: f64 = 5e-3;

/// What `--cameras` takes.
const HINT: &str =
    "give a transforms.json as NeRF's tools write it, or the folder of COLMAP's cameras and images (docs/camera.md)";

/// Views to draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Views {
    /// Each with `{camera}`; no two have the same.
    pub cameras: Vec<(CameraSpec, String)>,
    /// What was read.
    pub files: Vec<PathBuf>,
    /// What pictures show otherwise than the file says.
    pub warnings: Vec<String>,
}

/// What is wrong at a place of a file, and what to do.
#[derive(Debug, PartialEq)]
struct Fault {
    message: String,
    hint: String,
}

impl Fault {
    /// A fault whose place is not known yet.
    fn new(message: impl Into<String>, hint: impl Into<String>) -> Self {
        Self { message: message.into(), hint: hint.into() }
    }

    /// The failure at a place of the file `path`.
    fn at(self, path: &Path, place: impl Display) -> Failure {
        Failure::new(Kind::Failed, format!("{}: {place}: {}", path.display(), self.message), self.hint)
    }
}

/// The failure of a file that lists more than [`MOST_VIEWS`].
fn too_many(path: &Path) -> Failure {
    let message = format!("{} lists more than {MOST_VIEWS} views", path.display());
    Failure::new(Kind::Failed, message, format!("split it into files of {MOST_VIEWS} views at most"))
}

/// The failure of a file that cannot be read.
fn unread(path: &Path, error: &InputError) -> Failure {
    Failure::new(Kind::Failed, format!("cannot read {}: {error}", path.display()), HINT)
}

/// A pinhole, in pixels of its image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lens {
    /// Along x and y.
    focal_px: [f64; 2],
    /// The principal point from the top left corner; none is the middle.
    center_px: Option<[f64; 2]>,
    /// Width and height of its image, or of the picture where the file does not say.
    size_px: [f64; 2],
    /// Whether the file says how large the image is.
    has_size: bool,
    /// Whether the focal length is one in pixels, so that it means nothing without a size.
    is_in_pixels: bool,
    /// Whether it bends straight lines, which pictures do not show.
    is_distorted: bool,
}

impl Lens {
    /// How much the focal lengths differ; 0 where pixels are square.
    fn stretch(&self) -> f64 {
        (self.focal_px[0] / self.focal_px[1] - 1.0).abs()
    }

    /// How far the principal point is off the middle, along x or y, whichever is more.
    fn offset_px(&self) -> f64 {
        let [width, height] = self.size_px;
        self.center_px.map_or(0.0, |[x, y]| (x - 0.5 * width).abs().max((y - 0.5 * height).abs()))
    }

    /// Whether pictures show it with square pixels or with the middle as principal point, and it has neither.
    fn is_uneven(&self) -> bool {
        self.stretch() > EQUAL_FOCAL || self.offset_px() > MIDDLE_PX
    }

    /// Whether it is in pixels of an image of an unknown size.
    fn is_unsized(&self) -> bool {
        self.is_in_pixels && !self.has_size
    }

    /// The vertical field of view in radians.
    ///
    /// # Errors
    /// Numbers that are those of no pinhole.
    fn fov_y_rad(&self) -> Result<f32, Fault> {
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
struct Listed {
    /// The name of its image, without folders and ending; empty if it has none.
    name: String,
    /// To the world from a camera that looks along −Z with +Y up.
    rotation: Quat,
    /// In metres, in the space of the file.
    eye_world: DVec3,
    fov_y_rad: f32,
    lens: Lens,
}

impl Listed {
    /// The view of the image at `image`, a path. `world_from_view` may be scaled; it is not by then.
    ///
    /// # Errors
    /// Numbers that are those of no camera.
    fn new(image: &str, world_from_view: DMat3, eye_world: DVec3, lens: Lens) -> Result<Self, Fault> {
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
fn stem(path: &str) -> &str {
    let name = path.trim().rsplit(['/', '\\']).next().unwrap_or_default();
    match name.rsplit_once('.') {
        Some((stem, ending)) if !stem.is_empty() && ending.starts_with(|c: char| c.is_ascii_alphabetic()) => stem,
        _ => name,
    }
}

/// The views of a file or folder, in its order, for pictures of `size_px`. What it does not say of a camera is that of
/// `typed`.
///
/// # Errors
/// It cannot be read, or has a fault, with its place.
pub fn read(path: &Path, size_px: (u32, u32), typed: &CameraSpec) -> Result<Views, Failure> {
    let (mut listed, files) =
        if path.is_dir() { colmap::read(path)? } else { (nerf::read(path, size_px)?, vec![path.to_owned()]) };
    if listed.is_empty() {
        return Err(Failure::new(Kind::Failed, format!("{} lists no view", path.display()), HINT));
    }
    let names = distinct(listed.iter().map(|view| view.name.as_str()).enumerate());
    for (view, (_, name)) in listed.iter_mut().zip(names) {
        view.name = name;
    }
    let warnings = warnings(&listed, size_px);
    let camera = |view: Listed| {
        let place = Place::Posed { rotation: view.rotation, eye: view.eye_world };
        (CameraSpec { place, fov_y_rad: Some(view.fov_y_rad), ..typed.clone() }, view.name)
    };
    Ok(Views { cameras: listed.into_iter().map(camera).collect(), files, warnings })
}

/// What pictures of `size_px` show otherwise than the file says, each kind once.
fn warnings(views: &[Listed], size_px: (u32, u32)) -> Vec<String> {
    let which = |is_such: &dyn Fn(&Lens) -> bool| {
        let mut found = views.iter().filter(|view| is_such(&view.lens));
        let first = found.next()?;
        Some((format!("{} of {} views ({} first)", 1 + found.count(), views.len(), first.name), first.lens))
    };
    let most = |number: fn(&Lens) -> f64| views.iter().map(|view| number(&view.lens)).fold(0.0, f64::max);
    let (width, height) = size_px;
    let mut warnings = Vec::new();
    if let Some((which, _)) = which(&Lens::is_uneven) {
        let (stretch, offset_px) = (most(Lens::stretch), most(Lens::offset_px));
        let stretched = (stretch > EQUAL_FOCAL)
            .then(|| format!("focal lengths in x and y that differ by up to {:.2} %", 100.0 * stretch));
        let off = (offset_px > MIDDLE_PX).then(|| format!("a principal point up to {offset_px:.1} px off the middle"));
        let what: Vec<String> = stretched.into_iter().chain(off).collect();
        let drawn = "square pixels, by the focal length in y, and the middle as principal point";
        warnings.push(format!("{which} have {}; they are drawn with {drawn}", what.join(" or ")));
    }
    if let Some((which, _)) = which(&|lens: &Lens| lens.is_distorted) {
        warnings.push(format!("{which} have a lens with distortion; they are drawn without it"));
    }
    if let Some((which, _)) = which(&Lens::is_unsized) {
        let taken = format!("that of the picture is taken, {width}x{height}");
        warnings.push(format!("{which} have a focal length in pixels and no size (w, h) of the image; {taken}"));
    }
    let aspect = f64::from(width) / f64::from(height);
    let differs =
        |lens: &Lens| lens.has_size && (lens.size_px[0] / lens.size_px[1] / aspect - 1.0).abs() > EQUAL_ASPECT;
    if let Some((which, lens)) = which(&differs) {
        let [w, h] = drawable(lens.size_px);
        let other = format!("have images of another shape than --size {width}x{height}");
        warnings.push(format!("{which} {other}, and show more or less at the sides; use --size {w}x{h}"));
    }
    warnings
}

/// The size of an image as one of a picture, which has at most [`LARGEST_SIDE_PX`] a side.
fn drawable(size_px: [f64; 2]) -> [u32; 2] {
    let most = f64::from(LARGEST_SIDE_PX);
    let scale = (most / size_px[0].max(size_px[1])).min(1.0);
    size_px.map(|side| (side * scale).round().clamp(1.0, most) as u32)
}

#[cfg(test)]
mod tests;
