//! NeRF's list of cameras: `transforms.json` of nerfstudio, of instant-ngp and of Blender's synthetic scenes.
//!
//! `transform_matrix` is rows, for column vectors, to the world from a camera that looks along −Z with +Y up, as in
//! OpenGL. What one frame does not say of its lens is that of the file.

use super::listed::{Fault, HINT, Lens, ListedView, MOST_VIEWS, unread};
use crate::failure::{Failure, Kind};
use glam::{DMat3, DVec3};
use manypass_scene::input_file;
use serde::de::{Error as _, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::f64::consts::PI;
use std::fmt;
use std::path::Path;

/// The largest file: 100,000 frames have 60 MB.
const MOST_BYTES: u64 = 256 << 20;

/// A file, or a frame of one, which has no frames: both may have any key.
#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
struct Object<F> {
    #[serde(default)]
    frames: F,
    file_path: Option<String>,
    transform_matrix: Option<[[f64; 4]; 4]>,
    /// Horizontal, in radians.
    camera_angle_x: Option<f64>,
    /// Vertical, in radians.
    camera_angle_y: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    k1: Option<f64>,
    k2: Option<f64>,
    k3: Option<f64>,
    k4: Option<f64>,
    p1: Option<f64>,
    p2: Option<f64>,
    camera_model: Option<String>,
}

/// A frame of a file.
type Frame = Object<IgnoredAny>;

/// A file.
type Transforms = Object<Option<Frames>>;

/// The frames of a file, as many as are drawn at most.
#[derive(Debug)]
struct Frames(Vec<Frame>);

impl<'de> Deserialize<'de> for Frames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(FramesVisitor)
    }
}

/// Reads [`Frames`].
struct FramesVisitor;

impl<'de> Visitor<'de> for FramesVisitor {
    type Value = Frames;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of frames")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Frames, A::Error> {
        let mut frames = Vec::new();
        while let Some(frame) = list.next_element::<Frame>()? {
            if frames.len() == MOST_VIEWS {
                return Err(A::Error::custom(format!("`frames` has more than {MOST_VIEWS} views; split the file")));
            }
            frames.push(frame);
        }
        Ok(Frames(frames))
    }
}

impl<F> Object<F> {
    /// The focal lengths in pixels of an image of a size, if it says any, and whether they are written so.
    fn focal_px(&self, [width, height]: [f64; 2]) -> Option<([f64; 2], bool)> {
        let of_angle =
            |angle_rad: Option<f64>, side_px: f64| angle_rad.map(|angle| 0.5 * side_px / (0.5 * angle).tan());
        let x = self.fl_x.or_else(|| of_angle(self.camera_angle_x, width));
        let y = self.fl_y.or_else(|| of_angle(self.camera_angle_y, height));
        Some(([x.or(y)?, y.or(x)?], self.fl_x.is_some() || self.fl_y.is_some()))
    }

    /// An angle that is none between 0 and π.
    fn wrong_angle(&self) -> Option<(&'static str, f64)> {
        let angles = [("camera_angle_x", self.camera_angle_x), ("camera_angle_y", self.camera_angle_y)];
        let mut given = angles.into_iter().filter_map(|(key, angle)| Some((key, angle?)));
        given.find(|(_, angle)| *angle <= 0.0 || *angle >= PI)
    }

    /// The coefficients of its distortion.
    fn distortion(&self) -> [Option<f64>; 6] {
        [self.k1, self.k2, self.k3, self.k4, self.p1, self.p2]
    }
}

/// The lens of a frame; `picture_px` is the size of an image of which nothing is said.
///
/// # Errors
/// It has no focal length, or one by an angle that is none.
fn lens(file: &Transforms, frame: &Frame, picture_px: [f64; 2]) -> Result<Lens, Fault> {
    if let Some((key, angle)) = frame.wrong_angle().or_else(|| file.wrong_angle()) {
        let message = format!("{key} {angle} is not between 0 and pi");
        return Err(Fault::new(message, format!("give {key} in radians: 50 degrees are 0.8727")));
    }
    let said_px = frame.w.or(file.w).zip(frame.h.or(file.h));
    let size_px = said_px.map_or(picture_px, |(width, height)| [width, height]);
    let focal = frame.focal_px(size_px).or_else(|| file.focal_px(size_px));
    let Some((focal_px, is_in_pixels)) = focal else {
        let hint = "add `camera_angle_x` in radians, or `fl_x`, `fl_y`, `w` and `h` in pixels, to it or to the file";
        return Err(Fault::new("it has no focal length", hint));
    };
    let center_px = said_px.map(|(width, height)| {
        [frame.cx.or(file.cx).unwrap_or(0.5 * width), frame.cy.or(file.cy).unwrap_or(0.5 * height)]
    });
    let mut coefficients = frame.distortion().into_iter().zip(file.distortion());
    let is_bent = coefficients.any(|(of_frame, of_file)| of_frame.or(of_file).unwrap_or(0.0) != 0.0);
    let model = frame.camera_model.as_deref().or(file.camera_model.as_deref()).unwrap_or_default();
    Ok(Lens {
        focal_px,
        center_px,
        size_px,
        has_size: said_px.is_some(),
        is_in_pixels,
        is_distorted: is_bent || model.contains("FISHEYE"),
    })
}

/// The view of a frame.
///
/// # Errors
/// What it lacks, or numbers that are those of no camera.
fn view(file: &Transforms, frame: &Frame, picture_px: [f64; 2]) -> Result<ListedView, Fault> {
    let Some([x, y, z, last]) = frame.transform_matrix else {
        let hint = "add the matrix to the world from the camera: 4 rows of 4 numbers";
        return Err(Fault::new("it has no `transform_matrix`", hint));
    };
    let is_last =
        last.iter().zip([0.0_f64, 0.0, 0.0, 1.0]).all(|(number, expected)| (*number - expected).abs() <= 1e-6);
    if !is_last {
        let message = format!("the last row of `transform_matrix` is {last:?}, not [0, 0, 0, 1]");
        return Err(Fault::new(message, "write the matrix as a list of rows; one that has columns is transposed"));
    }
    let column = |index: usize| DVec3::new(x[index], y[index], z[index]);
    let rotation = DMat3::from_cols(column(0), column(1), column(2));
    let image = frame.file_path.as_deref().unwrap_or_default();
    ListedView::new(image, rotation, column(3), lens(file, frame, picture_px)?)
}

/// The views of `text`, that of the file `path`.
///
/// # Errors
/// It is no such file, or a frame has a fault.
fn parse(path: &Path, text: &str, picture_px: (u32, u32)) -> Result<Vec<ListedView>, Failure> {
    let failed = |message: String, hint: &str| {
        Failure::new(Kind::Failed, format!("{}: {message}", path.display()), format!("{hint}; {HINT}"))
    };
    let file: Transforms = serde_json::from_str(text)
        .map_err(|error| failed(error.to_string(), "correct it; NaN and Infinity are not JSON numbers"))?;
    let Some(Frames(frames)) = &file.frames else {
        return Err(failed("it has no `frames`".into(), "add the list of frames"));
    };
    let picture_px = [f64::from(picture_px.0), f64::from(picture_px.1)];
    let place = |index: usize, frame: &Frame| match &frame.file_path {
        Some(image) => format!("frame {index} (`{image}`)"),
        None => format!("frame {index}"),
    };
    let listed = |(index, frame): (usize, &Frame)| {
        view(&file, frame, picture_px).map_err(|fault| fault.at(path, place(index, frame)))
    };
    frames.iter().enumerate().map(listed).collect()
}

/// The views of a file.
///
/// # Errors
/// As [`parse`], or it cannot be read.
pub(super) fn read(path: &Path, picture_px: (u32, u32)) -> Result<Vec<ListedView>, Failure> {
    let text = input_file::read_text(path, MOST_BYTES).map_err(|error| unread(path, &error))?;
    parse(path, &text, picture_px)
}
