//! Views of `--cameras`: poses and lenses that a file of NeRF's tools or a folder of COLMAP lists.

mod colmap;
mod listed;
mod nerf;

use crate::camera::{CameraSpec, Place};
use crate::failure::{Failure, Kind};
use crate::looks::distinct;
use crate::size::LARGEST_SIDE_PX;
use listed::{EQUAL_FOCAL, HINT, Lens, ListedView, MIDDLE_PX};
use std::path::{Path, PathBuf};

/// A picture's shape that differs by less is that of the images.
const EQUAL_ASPECT: f64 = 5e-3;

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
    let camera = |view: ListedView| {
        let place = Place::Posed { rotation: view.rotation, eye: view.eye_world };
        (CameraSpec { place, fov_y_rad: Some(view.fov_y_rad), ..typed.clone() }, view.name)
    };
    Ok(Views { cameras: listed.into_iter().map(camera).collect(), files, warnings })
}

/// What pictures of `size_px` show otherwise than the file says, each kind once.
fn warnings(views: &[ListedView], size_px: (u32, u32)) -> Vec<String> {
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
