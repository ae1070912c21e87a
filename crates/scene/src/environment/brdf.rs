//! A table of what surfaces reflect of light from everywhere, as a file.

use super::map::EnvironmentError;
use super::picture::{decode_light, holds_light};
use crate::gltf_file::MAX_FILE_BYTES;
use crate::input_file;
use std::io::Cursor;
use std::path::Path;

/// The longest side of a table that is read.
const SIDE_MAX: u32 = 2048;

/// Scale and bias of f0 in the share of light from everywhere that a surface mirrors (Karis 2013): f0 · scale + bias.
/// Columns go by n·v, from 0 at the left to 1 at the right; rows by perceptual roughness, from 0 at the top to 1 at the
/// bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct BrdfTable {
    /// The file.
    pub name: String,
    width: usize,
    height: usize,
    texels: Vec<[f32; 2]>,
}

impl BrdfTable {
    /// Reads the bytes of a PNG, whose numbers are linear, a Radiance or an OpenEXR file: the scale is red, the bias is
    /// green. What is no number from 0 to 1 is cut. `name` appears in messages.
    ///
    /// # Errors
    /// It is none of these, is broken, or too large.
    pub fn decode(name: &str, bytes: &[u8]) -> Result<Self, EnvironmentError> {
        let failed = |message: String| EnvironmentError { name: name.into(), message };
        let (width, height, texels) = if holds_light(bytes) {
            let decoded = decode_light(bytes, check_size).map_err(failed)?;
            let texels: Vec<[f32; 2]> = decoded.rgb.iter().map(|[r, g, _]| [*r, *g]).collect();
            (decoded.width, decoded.height, texels)
        } else {
            decode_image(bytes).map_err(failed)?
        };
        let kept = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
        let texels = texels.into_iter().map(|texel| texel.map(kept)).collect();
        Ok(Self { name: name.into(), width: width as usize, height: height as usize, texels })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or as [`Self::decode`].
    pub fn load_path(path: &Path) -> Result<Self, EnvironmentError> {
        let name = path.display().to_string();
        let bytes = input_file::read(path, MAX_FILE_BYTES)
            .map_err(|error| EnvironmentError { name: name.clone(), message: error.to_string() })?;
        Self::decode(&name, &bytes)
    }

    /// Scale and bias, between the middles of the four nearest texels, or beyond those at the edges.
    pub fn at(&self, n_dot_v: f32, roughness_perceptual: f32) -> [f32; 2] {
        // The first of two texels, and how far behind its middle the place is.
        let place = |share: f32, count: usize| {
            let place = share * count as f32 - 0.5;
            let first = place.clamp(0.0, count.saturating_sub(2) as f32).floor();
            (first as usize, place - first)
        };
        let ((left, x), (top, y)) = (place(n_dot_v, self.width), place(roughness_perceptual, self.height));
        let texel = |x: usize, y: usize| {
            let index = y.min(self.height - 1) * self.width + x.min(self.width - 1);
            self.texels.get(index).copied().unwrap_or_default()
        };
        [0, 1].map(|channel: usize| {
            let along = |row: usize| {
                let [a, b] = [left, left + 1].map(|column| texel(column, row)[channel]);
                a + (b - a) * x
            };
            (along(top) + (along(top + 1) - along(top)) * y).clamp(0.0, 1.0)
        })
    }
}

fn check_size(width: u32, height: u32) -> Result<(), String> {
    if width == 0 || height == 0 || width.max(height) > SIDE_MAX {
        return Err(format!("a table of reflectance has at most {SIDE_MAX} texels a side, and this {width}x{height}"));
    }
    Ok(())
}

/// Width, height and the first two channels.
fn decode_image(bytes: &[u8]) -> Result<(u32, u32, Vec<[f32; 2]>), String> {
    let failed = |error: image::ImageError| {
        format!("{error}; a table of reflectance is a PNG, a Radiance (.hdr) or an OpenEXR file (.exr)")
    };
    let reader =
        || image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string());
    let (width, height) = reader()?.into_dimensions().map_err(failed)?;
    check_size(width, height)?;
    let picture = reader()?.decode().map_err(failed)?.into_rgb16();
    let share = |value: u16| f32::from(value) / 65_535.0;
    let texels = picture.pixels().map(|pixel| [share(pixel.0[0]), share(pixel.0[1])]).collect();
    Ok((width, height, texels))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    fn png(texels: &[[u8; 3]], width: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let picture = image::RgbImage::from_raw(width, texels.len() as u32 / width, texels.concat()).unwrap();
        picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn columns_are_angles_and_rows_are_roughness() {
        let texels = [[255, 0, 9], [0, 51, 9], [102, 255, 9], [255, 204, 9]];
        let table = BrdfTable::decode("a.png", &png(&texels, 2)).unwrap();
        for ((n_dot_v, roughness), expected) in
            [((0.25, 0.25), [1.0, 0.0]), ((0.75, 0.25), [0.0, 0.2]), ((0.25, 0.75), [0.4, 1.0])]
        {
            let found = table.at(n_dot_v, roughness);
            assert!((0..2).all(|at| (found[at] - expected[at]).abs() < 1e-6), "{n_dot_v}, {roughness}: {found:?}");
        }
        // Half a texel beyond the middle of the last one, as steep as before it.
        assert!((table.at(1.0, 0.25)[1] - 0.3).abs() < 1e-6 && table.at(0.0, 0.25) == [1.0, 0.0]);
        let [scale, bias] = table.at(0.5, 0.25);
        assert!((scale - 0.5).abs() < 1e-6 && (bias - 0.1).abs() < 1e-6, "{scale} {bias}");
        let mut hdr = Vec::new();
        let texel = image::Rgb([0.5, 4.0, 0.25]);
        image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&[texel], 1, 1).unwrap();
        assert_eq!(BrdfTable::decode("a.hdr", &hdr).unwrap().at(0.3, 0.7), [0.5, 1.0]);
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let refused = |bytes: &[u8]| BrdfTable::decode("a.png", bytes).unwrap_err().to_string();
        assert!(refused(b"nothing").contains("a table of reflectance is a PNG"), "{}", refused(b"nothing"));
        let whole = png(&[[1; 3]; 16], 4);
        assert!(refused(&whole[..40]).starts_with("environment \"a.png\""));
        let wide = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 4096\n";
        assert!(refused(wide).contains("4096x1"), "{}", refused(wide));
    }
}
