//! A picture that is compared: read from its file, and laid over mid grey where it is transparent.

use crate::failure::{Failure, Kind};
use manypass_flip::{FlipError, Picture};
use manypass_offline::Picture as Drawn;
use manypass_offline::decode::{DecodeError, DecodedPicture, Light, MAX_PIXELS, decode, is_known};
use manypass_scene::gltf_file;
use manypass_scene::input_file::{self, InputError};
use std::io::Read;
use std::path::Path;

/// Mid grey of displays: half of what a byte holds, as viewers blend encoded values.
const GREY_SRGB: f32 = 0.5;
/// Mid grey of radiance.
pub const GREY_LINEAR: f32 = 0.18;
/// No file of as many pixels as are read is larger: four channels of 32 bits and as much again.
const MAX_FILE_BYTES: u64 = 32 * MAX_PIXELS as u64;

/// A picture.
#[derive(Debug)]
pub struct Source {
    /// Its file.
    pub name: String,
    /// What its numbers stand for.
    pub light: Light,
    /// Opaque.
    pub picture: Picture,
    /// The mean of 1 − alpha before the picture was laid over grey.
    pub transparency: f64,
}

impl Source {
    /// A picture that was drawn for a display.
    ///
    /// # Errors
    /// If it has no pixels.
    pub fn of_display(name: &str, picture: &Drawn) -> Result<Self, Failure> {
        let value = |byte: &u8| f32::from(*byte) / 255.0;
        let rgba = picture.display_rgba8.chunks_exact(4).map(|pixel| std::array::from_fn(|c| value(&pixel[c])));
        let rgba: Vec<[f32; 4]> = rgba.collect();
        let transparency = transparency(&rgba);
        let rgb = over_grey(rgba, false);
        let picture = Picture::from_srgb(picture.width as usize, picture.height as usize, rgb);
        let picture =
            picture.map_err(|error| Failure::new(Kind::Failed, format!("{name}: {error}"), "try another --size"))?;
        Ok(Self { name: name.to_owned(), light: Light::Display, picture, transparency })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, is no picture, or holds infinite values.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let failed =
            |error: &dyn std::fmt::Display, hint: &str| Failure::new(Kind::Failed, format!("{name}: {error}"), hint);
        let bytes = bytes(path).map_err(|error| failed(&error, "name a PNG, JPEG, WebP or EXR file"))?;
        if bytes.is_empty() {
            return Err(failed(&"the file is empty", "write the picture again, or name another file"));
        }
        let DecodedPicture { width, height, light, rgba } = decode(&bytes).map_err(|error| {
            let hint = match error {
                DecodeError::Unknown => "convert it, or name another file",
                DecodeError::TooLarge { .. } => "compare smaller pictures, or parts of them",
                DecodeError::Decoder { .. } => "write the picture again, or name another file",
            };
            failed(&error, hint)
        })?;
        drop(bytes);
        let transparency = transparency(&rgba);
        let picture = match light {
            Light::Display => Picture::from_srgb(width, height, over_grey(rgba, false)),
            Light::Scene => Picture::from_linear(width, height, over_grey(rgba, true)),
        };
        let picture =
            picture.map_err(|error: FlipError| failed(&error, "clear such pixels first, or write it again"))?;
        Ok(Self { name, light, picture, transparency })
    }
}

/// The bytes of a file, or how it begins if that is no picture.
fn bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    if input_file::is_open_pipe(path) {
        return input_file::read(path, MAX_FILE_BYTES.min(gltf_file::MAX_FILE_BYTES));
    }
    let mut bytes = Vec::new();
    let mut file = input_file::open(path)?;
    // What does not begin like a picture can be endless.
    file.by_ref().take(16).read_to_end(&mut bytes)?;
    if !is_known(&bytes) {
        return Ok(bytes);
    }
    file.take(MAX_FILE_BYTES).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_FILE_BYTES { Err(InputError::TooLarge(MAX_FILE_BYTES)) } else { Ok(bytes) }
}

/// Pixels over mid grey; `is_associated` if they are multiplied by their alpha, and linear.
fn over_grey(rgba: Vec<[f32; 4]>, is_associated: bool) -> Vec<[f32; 3]> {
    let opaque = |[r, g, b, a]: [f32; 4]| {
        let alpha = a.clamp(0.0, 1.0);
        match is_associated {
            true => [r, g, b].map(|value| value + (1.0 - alpha) * GREY_LINEAR),
            false => [r, g, b].map(|value| alpha * value + (1.0 - alpha) * GREY_SRGB),
        }
    };
    rgba.into_iter().map(opaque).collect()
}

fn transparency(rgba: &[[f32; 4]]) -> f64 {
    let sum: f64 = rgba.iter().map(|[.., alpha]| 1.0 - f64::from(alpha.clamp(0.0, 1.0))).sum();
    sum / rgba.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_pixels_are_grey_and_opaque_ones_stay() {
        let pixels = vec![[0.2, 0.4, 1.0, 1.0], [0.2, 0.4, 1.0, 0.0], [0.0, 1.0, 0.5, 0.5]];
        assert_eq!(over_grey(pixels, false), [[0.2, 0.4, 1.0], [0.5; 3], [0.25, 0.75, 0.5]]);
        assert_eq!(over_grey(vec![[0.0, 0.0, 0.0, 0.0], [3.0, 2.0, 1.0, 1.0]], true), [[0.18; 3], [3.0, 2.0, 1.0]]);
    }
}
