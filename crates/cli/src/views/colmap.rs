//! COLMAP's folder of cameras and images, as text or binary: <https://colmap.github.io/format.html>.
//!
//! A pose is to the camera from the world: a quaternion, w first, and a translation. The camera has +X right, +Y down
//! and looks along +Z, as in OpenCV.

use super::listed::{Fault, HINT, Lens, ListedView, MOST_VIEWS, too_many, unread};
use crate::failure::{Failure, Kind};
use glam::{DMat3, DQuat, DVec3};
use manypass_scene::input_file;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The largest file of cameras.
const MOST_CAMERA_BYTES: u64 = 64 << 20;

/// The largest file of images, which holds the points that were found in each.
const MOST_IMAGE_BYTES: u64 = 1 << 30;

/// The models of cameras, in the order of their numbers in binary files: the name, how many parameters it has, and how
/// many of them are focal lengths. Those come first, then the principal point, then the distortion.
const MODELS: [(&str, usize, usize); 12] = [
    ("SIMPLE_PINHOLE", 3, 1),
    ("PINHOLE", 4, 2),
    ("SIMPLE_RADIAL", 4, 1),
    ("RADIAL", 5, 1),
    ("OPENCV", 8, 2),
    ("OPENCV_FISHEYE", 8, 2),
    ("FULL_OPENCV", 12, 2),
    ("FOV", 5, 2),
    ("SIMPLE_RADIAL_FISHEYE", 4, 1),
    ("RADIAL_FISHEYE", 5, 1),
    ("THIN_PRISM_FISHEYE", 12, 2),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 16, 2),
];

/// Lenses by the number of their camera.
type Lenses = BTreeMap<u32, Lens>;

/// An image as both formats have it.
#[derive(Debug, PartialEq)]
struct Image {
    /// To the camera from the world: w, x, y, z.
    quaternion: [f64; 4],
    /// The world's origin in the camera's space.
    translation_m: [f64; 3],
    camera: u32,
    name: String,
}

/// The lens of a camera of a model.
///
/// # Errors
/// Too few or too many parameters, or numbers that are those of no pinhole.
fn lens((name, count, focal_count): (&str, usize, usize), size_px: [f64; 2], params: &[f64]) -> Result<Lens, Fault> {
    let wrong = || {
        let message = format!("a camera {name} has {count} parameters, and here are {}", params.len());
        Fault::new(message, "write CAMERA_ID MODEL WIDTH HEIGHT and the parameters of the model")
    };
    let (focal_px, center_px) = match params {
        _ if params.len() != count => return Err(wrong()),
        [x, y, cx, cy, ..] if focal_count == 2 => ([*x, *y], [*cx, *cy]),
        [focal, cx, cy, ..] if focal_count == 1 => ([*focal, *focal], [*cx, *cy]),
        _ => return Err(wrong()),
    };
    let is_bent = params.iter().skip(focal_count + 2).any(|coefficient| *coefficient != 0.0);
    let lens = Lens {
        focal_px,
        center_px: Some(center_px),
        size_px,
        has_size: true,
        is_in_pixels: true,
        is_distorted: is_bent || name.contains("FISHEYE"),
    };
    lens.fov_y_rad().map(|_| lens)
}

/// The view of an image.
///
/// # Errors
/// Numbers that are those of no pose, or no such camera.
fn view(image: &Image, lenses: &Lenses) -> Result<ListedView, Fault> {
    let lens = *lenses.get(&image.camera).ok_or_else(|| {
        let message = format!("camera {} of image `{}` is not among the cameras", image.camera, image.name);
        Fault::new(message, "name a CAMERA_ID of the file of cameras")
    })?;
    let [w, x, y, z] = image.quaternion;
    let length = DVec3::new(x, y, z).length().hypot(w);
    if !(length.is_finite() && length > 1e-9) {
        let message = format!("the quaternion {w} {x} {y} {z} is not a rotation");
        return Err(Fault::new(message, "write QW QX QY QZ, a quaternion of length 1"));
    }
    let camera_from_world = DMat3::from_quat(DQuat::from_xyzw(x / length, y / length, z / length, w / length));
    let world_from_camera = camera_from_world.transpose();
    let eye_world = world_from_camera * -DVec3::from_array(image.translation_m);
    let world_from_view =
        DMat3::from_cols(world_from_camera.x_axis, -world_from_camera.y_axis, -world_from_camera.z_axis);
    ListedView::new(&image.name, world_from_view, eye_world, lens)
}

/// The cameras of a text: lines of `CAMERA_ID MODEL WIDTH HEIGHT PARAMS…`.
///
/// # Errors
/// A line that is none, with its number.
fn text_cameras(path: &Path, text: &str) -> Result<Lenses, Failure> {
    let mut lenses = Lenses::new();
    for (number, line) in (1_u64..).zip(text.lines()) {
        let line = line.trim();
        if !(line.is_empty() || line.starts_with('#')) {
            let (id, lens) = text_camera(line).map_err(|fault| fault.at(path, format_args!("line {number}")))?;
            lenses.insert(id, lens);
        }
    }
    Ok(lenses)
}

/// The camera of a line.
///
/// # Errors
/// It is none.
fn text_camera(line: &str) -> Result<(u32, Lens), Fault> {
    // No model has as many parameters.
    let words: Vec<&str> = line.split_whitespace().take(32).collect();
    let hint = "write CAMERA_ID MODEL WIDTH HEIGHT and the parameters of the model";
    let [id, model, width, height, params @ ..] = &words[..] else {
        return Err(Fault::new("this is not a camera", hint));
    };
    let id = id.parse::<u32>().map_err(|_| Fault::new(format!("`{id}` is not a CAMERA_ID"), hint))?;
    let known = MODELS.iter().find(|(name, ..)| name == model).copied();
    let known = known.ok_or_else(|| {
        let names: Vec<&str> = MODELS.iter().map(|(name, ..)| *name).collect();
        Fault::new(format!("unknown model of a camera `{model}`"), format!("known: {}", names.join(", ")))
    })?;
    let number = |word: &&str| word.parse::<f64>().map_err(|_| Fault::new(format!("`{word}` is not a number"), hint));
    let size_px = [number(width)?, number(height)?];
    let params = params.iter().map(number).collect::<Result<Vec<f64>, Fault>>()?;
    Ok((id, lens(known, size_px, &params)?))
}

/// The views of a text: two lines an image, `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME` and its points, which may be
/// empty.
///
/// # Errors
/// A line that is none, with its number.
fn text_images(path: &Path, text: &str, lenses: &Lenses) -> Result<Vec<ListedView>, Failure> {
    let mut views = Vec::new();
    let mut lines = (1_u64..).zip(text.lines());
    while let Some((number, line)) = lines.next() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if views.len() == MOST_VIEWS {
            return Err(too_many(path));
        }
        let listed = text_image(line).and_then(|image| view(&image, lenses));
        views.push(listed.map_err(|fault| fault.at(path, format_args!("line {number}")))?);
        if let Some((number, points)) = lines.next()
            && points.split_whitespace().count() % 3 != 0
        {
            let message = "here should be the points of the image before, X Y POINT3D_ID each, or nothing";
            let fault = Fault::new(message, "leave a line empty after each image that has no points");
            return Err(fault.at(path, format_args!("line {number}")));
        }
    }
    Ok(views)
}

/// The image of a line.
///
/// # Errors
/// It is none.
fn text_image(line: &str) -> Result<Image, Fault> {
    let hint = "write IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME";
    // Names may have spaces, but not that many.
    let words: Vec<&str> = line.split_whitespace().take(64).collect();
    let [_, qw, qx, qy, qz, tx, ty, tz, camera, name @ ..] = &words[..] else {
        return Err(Fault::new("this is not an image", hint));
    };
    if name.is_empty() {
        return Err(Fault::new("the image has no name", hint));
    }
    let number = |word: &str| word.parse::<f64>().map_err(|_| Fault::new(format!("`{word}` is not a number"), hint));
    Ok(Image {
        quaternion: [number(qw)?, number(qx)?, number(qy)?, number(qz)?],
        translation_m: [number(tx)?, number(ty)?, number(tz)?],
        camera: camera.parse::<u32>().map_err(|_| Fault::new(format!("`{camera}` is not a CAMERA_ID"), hint))?,
        name: name.join(" "),
    })
}

/// What is left of a binary file, little endian.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    /// The next bytes.
    ///
    /// # Errors
    /// There are not as many.
    fn next<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (head, rest) = self.0.split_first_chunk::<N>().ok_or_else(ended)?;
        self.0 = rest;
        Ok(*head)
    }

    fn next_u32(&mut self) -> Result<u32, Fault> {
        self.next::<4>().map(u32::from_le_bytes)
    }

    fn next_u64(&mut self) -> Result<u64, Fault> {
        self.next::<8>().map(u64::from_le_bytes)
    }

    fn next_f64(&mut self) -> Result<f64, Fault> {
        self.next::<8>().map(f64::from_le_bytes)
    }

    /// A text that ends with a zero.
    fn next_text(&mut self) -> Result<String, Fault> {
        let end = self.0.iter().position(|byte| *byte == 0).ok_or_else(ended)?;
        let (text, rest) = self.0.split_at(end);
        self.0 = rest.get(1..).unwrap_or_default();
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    /// Leaves out so many pieces of a length.
    fn skip(&mut self, count: u64, bytes: u64) -> Result<(), Fault> {
        let length = count.checked_mul(bytes).and_then(|length| usize::try_from(length).ok()).ok_or_else(ended)?;
        self.0 = self.0.get(length..).ok_or_else(ended)?;
        Ok(())
    }
}

/// The fault of a file that is too short.
fn ended() -> Fault {
    Fault::new("the file ends here", "copy it again, or let COLMAP's `model_converter` write it as text")
}

/// The cameras of `cameras.bin`.
///
/// # Errors
/// It ends too soon, or a camera is none, with its index.
fn binary_cameras(path: &Path, bytes: &[u8]) -> Result<Lenses, Failure> {
    let mut bytes = Bytes(bytes);
    let count = bytes.next_u64().map_err(|fault| fault.at(path, "the number of cameras"))?;
    let mut lenses = Lenses::new();
    for index in 0..count {
        let (id, lens) =
            binary_camera(&mut bytes).map_err(|fault| fault.at(path, format_args!("camera {index} of {count}")))?;
        lenses.insert(id, lens);
    }
    Ok(lenses)
}

/// The next camera: number, model, width, height, parameters.
///
/// # Errors
/// It is none.
fn binary_camera(bytes: &mut Bytes<'_>) -> Result<(u32, Lens), Fault> {
    let (id, model) = (bytes.next_u32()?, bytes.next_u32()?);
    let known = usize::try_from(model).ok().and_then(|model| MODELS.get(model).copied()).ok_or_else(|| {
        let hint = "this may be no file of COLMAP; let its `model_converter` write it as text";
        Fault::new(format!("unknown model of a camera {model}"), hint)
    })?;
    let size_px = [bytes.next_u64()? as f64, bytes.next_u64()? as f64];
    let params = (0..known.1).map(|_| bytes.next_f64()).collect::<Result<Vec<f64>, Fault>>()?;
    Ok((id, lens(known, size_px, &params)?))
}

/// The views of `images.bin`.
///
/// # Errors
/// It ends too soon, or an image is none, with its index.
fn binary_images(path: &Path, bytes: &[u8], lenses: &Lenses) -> Result<Vec<ListedView>, Failure> {
    let mut bytes = Bytes(bytes);
    let count = bytes.next_u64().map_err(|fault| fault.at(path, "the number of images"))?;
    if count > MOST_VIEWS as u64 {
        return Err(too_many(path));
    }
    let mut views = Vec::new();
    for index in 0..count {
        let listed = binary_image(&mut bytes).and_then(|image| view(&image, lenses));
        views.push(listed.map_err(|fault| fault.at(path, format_args!("image {index} of {count}")))?);
    }
    Ok(views)
}

/// The next image: number, quaternion, translation, camera, name; its points are left out.
///
/// # Errors
/// It is none.
fn binary_image(bytes: &mut Bytes<'_>) -> Result<Image, Fault> {
    bytes.next_u32()?;
    let quaternion = [bytes.next_f64()?, bytes.next_f64()?, bytes.next_f64()?, bytes.next_f64()?];
    let translation_m = [bytes.next_f64()?, bytes.next_f64()?, bytes.next_f64()?];
    let camera = bytes.next_u32()?;
    let name = bytes.next_text()?;
    let point_count = bytes.next_u64()?;
    // Two coordinates and the number of a point.
    bytes.skip(point_count, 24)?;
    Ok(Image { quaternion, translation_m, camera, name })
}

/// The views of a folder of cameras and images, and the files that they were read from. It is looked for in the folder
/// itself, in `sparse/0` and in `sparse`; binary files come first, as in COLMAP.
///
/// # Errors
/// It is nowhere, cannot be read, or has a fault.
pub(super) fn read(folder: &Path) -> Result<(Vec<ListedView>, Vec<PathBuf>), Failure> {
    let folders = [folder.to_owned(), folder.join("sparse/0"), folder.join("sparse")];
    for folder in folders {
        for ending in ["bin", "txt"] {
            let [cameras, images] = ["cameras", "images"].map(|name| folder.join(format!("{name}.{ending}")));
            if !(cameras.exists() && images.exists()) {
                continue;
            }
            let views = if ending == "bin" {
                let lenses = binary_cameras(&cameras, &binary(&cameras, MOST_CAMERA_BYTES)?)?;
                binary_images(&images, &binary(&images, MOST_IMAGE_BYTES)?, &lenses)?
            } else {
                let lenses = text_cameras(&cameras, &text(&cameras, MOST_CAMERA_BYTES)?)?;
                text_images(&images, &text(&images, MOST_IMAGE_BYTES)?, &lenses)?
            };
            return Ok((views, vec![cameras, images]));
        }
    }
    let message =
        format!("neither {0} nor {0}/sparse/0 has COLMAP's cameras and images, as .bin or .txt", folder.display());
    Err(Failure::new(Kind::Failed, message, HINT))
}

/// The bytes of a file.
///
/// # Errors
/// It cannot be read, or has more than `most_bytes`.
fn binary(path: &Path, most_bytes: u64) -> Result<Vec<u8>, Failure> {
    input_file::read(path, most_bytes).map_err(|error| unread(path, &error))
}

/// The text of a file.
///
/// # Errors
/// It cannot be read, is no text, or has more than `most_bytes`.
fn text(path: &Path, most_bytes: u64) -> Result<String, Failure> {
    input_file::read_text(path, most_bytes).map_err(|error| unread(path, &error))
}
