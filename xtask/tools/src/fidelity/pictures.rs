//! Rendering a scene, scaling its picture and comparing it.

use super::Fidelity;
use super::scenarios::Scenario;
use crate::step::{last_json, open_picture};
use anyhow::{Context, Result, ensure};
use image::imageops::{FilterType, resize};
use image::{Rgba, Rgba32FImage, RgbaImage};
use manypass_testkit::compare::{Picture, Rmse, rmse_over_grey};
use std::path::{Path, PathBuf};
use std::process::Command;

/// How many times wider our pictures are rendered than they are compared; those of others were scaled down, too.
const SCALE: u32 = 2;
/// The samples of a pixel of the large picture: 16 of one that is compared.
const SAMPLES: &str = "4";

/// How a picture's light became bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// By the curve of sRGB, as Filament's.
    Srgb,
    /// By a power of 1/2.2, as the sample viewer's and Cycles' (SOURCES.md), and so ours beside them.
    Gamma,
}

impl Encoding {
    /// The other one, and what a value from 0 to 1 becomes in it.
    fn other(self) -> (Self, fn(f32) -> f32) {
        match self {
            Self::Srgb => (Self::Gamma, |value| {
                let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
                linear.max(0.0).powf(1.0 / 2.2)
            }),
            Self::Gamma => (Self::Srgb, |value| {
                let linear = value.max(0.0).powf(2.2);
                if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
            }),
        }
    }
}

/// How far apart two pictures are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Distance {
    pub rmse: Rmse,
    /// The same over all pixels, if the second picture had the other encoding.
    pub rmse_other: f64,
    /// The same over all pixels, with the second picture's colours as coarse as lossy WebP holds them.
    pub rmse_packed: f64,
    /// The mean FLIP.
    pub flip: f64,
}

/// A picture that was rendered.
#[derive(Clone, Debug)]
pub(super) struct RenderedPicture {
    pub path: PathBuf,
    /// What the program warned of.
    pub warnings: Vec<String>,
}

impl Fidelity<'_> {
    /// Renders a scene in a size that is compared.
    pub fn render(
        &self,
        scenario: &Scenario,
        model: &Path,
        environment: &Path,
        size: (u32, u32),
    ) -> Result<RenderedPicture> {
        let large = self.folder.join(format!("{}.large.png", scenario.name));
        let mut command = Command::new(&self.program);
        command.arg("render").arg(model).arg("-o").arg(&large).arg("--environment").arg(environment);
        // Published pictures have the aspect of the scene up to whole pixels, and show what the scene's camera shows.
        let (width, aspect) = (SCALE * size.0, scenario.size_px.0 / scenario.size_px.1);
        let height = (f64::from(width) / aspect).round() as u32;
        command.args(["--size", &format!("{width}x{height}"), "--samples", SAMPLES]);
        command.args(["--eye", &vector(scenario.eye), "--target", &vector(scenario.target)]);
        command.args(["--fov-y", &scenario.fov_y_deg.to_string()]);
        command.args(["--background", if scenario.shows_environment { "environment" } else { "transparent" }]);
        command.args(["--tonemap", "aces", "--exposure", "0", "--set", "shadows.enabled=false"]);
        command.args(&self.left_out);
        let output = command.env("RUST_LOG", "off").output().with_context(|| format!("starting {command:?}"))?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        ensure!(output.status.success(), "{command:?} ended with {}: {}", output.status, said.trim());
        let path = self.folder.join(format!("{}.png", scenario.name));
        let picture = image::open(&large).with_context(|| format!("reading {}", large.display()))?.to_rgba8();
        // The program's are sRGB.
        scaled(&picture, size, Encoding::Srgb.other().1)
            .save(&path)
            .with_context(|| format!("writing {}", path.display()))?;
        std::fs::remove_file(&large).with_context(|| format!("removing {}", large.display()))?;
        let warnings = said.lines().filter_map(|line| line.strip_prefix("warning: ")).map(str::to_owned).collect();
        Ok(RenderedPicture { path, warnings })
    }

    /// Compares two pictures, of which the second has an encoding; `sheet` is the name of the sheet that shows both.
    pub fn compare(
        &self,
        reference: &Path,
        (test, encoding): (&Path, Encoding),
        sheet: Option<&str>,
    ) -> Result<Distance> {
        let (first, second) = (open_picture(reference)?, open_picture(test)?);
        let rmse = rmse_over_grey(&first, &second);
        let rmse_other = rmse_over_grey(&first, &recoded(&second, encoding.other().1)).whole;
        let rmse_packed = rmse_over_grey(&first, &packed(&second)).whole;
        let mut command = Command::new(&self.program);
        command.arg("diff").arg(reference).arg(test).arg("--json");
        if let Some(sheet) = sheet {
            command.arg("-o").arg(self.folder.join(sheet));
        }
        let found = last_json(&mut command)?;
        let flip = found["flip"]["mean"].as_f64().with_context(|| format!("no mean in {found}"))?;
        Ok(Distance { rmse, rmse_other, rmse_packed, flip })
    }
}

/// A vector as flags of the camera take it.
pub(super) fn vector([x, y, z]: [f64; 3]) -> String {
    format!("{x},{y},{z}")
}

/// Width and height of a picture in a file.
pub(super) fn size_of(path: &Path) -> Result<(u32, u32)> {
    image::image_dimensions(path).with_context(|| format!("reading {}", path.display()))
}

/// A picture in another size, and its colours in another encoding. They are weighted by alpha, so that what is
/// transparent has none.
fn scaled(picture: &RgbaImage, (width, height): (u32, u32), recode: fn(f32) -> f32) -> RgbaImage {
    let associated = Rgba32FImage::from_fn(picture.width(), picture.height(), |x, y| {
        let [r, g, b, a] = picture.get_pixel(x, y).0.map(|value| f32::from(value) / 255.0);
        Rgba([r * a, g * a, b * a, a])
    });
    let small = resize(&associated, width, height, FilterType::Lanczos3);
    RgbaImage::from_fn(width, height, |x, y| {
        let [r, g, b, a] = small.get_pixel(x, y).0;
        let straight = |value: f32| if a > 0.0 { recode((value / a).clamp(0.0, 1.0)) } else { 0.0 };
        Rgba([straight(r), straight(g), straight(b), a].map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8))
    })
}

/// A picture whose colours have another encoding.
fn recoded(picture: &Picture, recode: fn(f32) -> f32) -> Picture {
    let table: Vec<u8> = (0..=255).map(|byte: u16| (recode(f32::from(byte) / 255.0) * 255.0).round() as u8).collect();
    let [width, height] = [picture.width, picture.height];
    let recoded = |&[r, g, b, a]: &[u8; 4]| {
        let [r, g, b] = [r, g, b].map(|byte| table[usize::from(byte)]);
        [r, g, b, a]
    };
    Picture { width, height, pixels: picture.pixels.iter().map(recoded).collect() }
}

/// A picture as lossy WebP holds it, without its quantisation: differences of colour (BT.601) have half the width and
/// height. Published pictures are such files, and crisp edges between colours are lost in them.
fn packed(picture: &Picture) -> Picture {
    let (width, height) = (picture.width, picture.height);
    let luma = |[r, g, b, _]: [u8; 4]| 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
    // Red and blue less luminance, of four pixels; what is transparent has no colour.
    let at = |x: usize, y: usize| picture.pixels[y.min(height - 1) * width + x.min(width - 1)];
    let chroma = |x: usize, y: usize| -> [f64; 2] {
        let (mut sum, mut weight) = ([0.0; 2], 1e-9);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let pixel = at(2 * x + dx, 2 * y + dy);
            let alpha = f64::from(pixel[3]);
            sum[0] += alpha * (f64::from(pixel[0]) - luma(pixel));
            sum[1] += alpha * (f64::from(pixel[2]) - luma(pixel));
            weight += alpha;
        }
        sum.map(|sum| sum / weight)
    };
    let (columns, rows) = (width.div_ceil(2), height.div_ceil(2));
    let coarse: Vec<[f64; 2]> = (0..columns * rows).map(|i| chroma(i % columns, i / columns)).collect();
    let pixels = picture.pixels.iter().enumerate().map(|(index, &pixel)| {
        // Between the four coarse texels around the pixel, the nearest of which has nine sixteenths.
        let near = |place: usize, count: usize| {
            let (own, odd) = (place / 2, place % 2 == 1);
            (own, if odd { (own + 1).min(count - 1) } else { own.saturating_sub(1) })
        };
        let ((x, other_x), (y, other_y)) = (near(index % width, columns), near(index / width, rows));
        let [red, blue] = [0, 1].map(|channel| {
            let texel = |x: usize, y: usize| coarse[y * columns + x][channel];
            (9.0 * texel(x, y) + 3.0 * (texel(other_x, y) + texel(x, other_y)) + texel(other_x, other_y)) / 16.0
        });
        let luma = luma(pixel);
        let green = luma - (0.299 * red + 0.114 * blue) / 0.587;
        let byte = |value: f64| value.round().clamp(0.0, 255.0) as u8;
        [byte(luma + red), byte(green), byte(luma + blue), pixel[3]]
    });
    Picture { width, height, pixels: pixels.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transparent_pixels_lend_no_colour() {
        let picture = RgbaImage::from_fn(64, 64, |x, _| Rgba(if x < 32 { [200, 100, 50, 255] } else { [0, 0, 0, 0] }));
        let small = scaled(&picture, (32, 32), |value| value);
        assert_eq!(small.get_pixel(3, 9).0, [200, 100, 50, 255]);
        assert_eq!(small.get_pixel(29, 9).0[3], 0);
        for x in 0..32 {
            let [r, g, b, a] = small.get_pixel(x, 16).0;
            // What is nearly transparent has too few steps for a colour.
            assert!(
                a < 32 || (r.abs_diff(200) < 5 && g.abs_diff(100) < 5 && b.abs_diff(50) < 5),
                "{x}: {r} {g} {b} {a}"
            );
        }
    }

    #[test]
    fn encodings_lead_back_and_forth() {
        let bytes = Picture { width: 16, height: 16, pixels: (0..=255).map(|i| [i, i, i, 255]).collect() };
        for encoding in [Encoding::Srgb, Encoding::Gamma] {
            let (other, recode) = encoding.other();
            let there = recoded(&bytes, recode);
            let back = recoded(&there, other.other().1);
            // Where one of them is steep the other has fewer steps.
            let is_near = |(a, b): (&[u8; 4], &[u8; 4])| a[0].abs_diff(b[0]) <= if a[0] < 32 { 4 } else { 1 };
            assert!(back.pixels.iter().zip(&bytes.pixels).all(is_near), "{encoding:?}: {:?}", back.pixels);
            assert!(there.pixels.iter().zip(&bytes.pixels).any(|(a, b)| a[0].abs_diff(b[0]) >= 5), "{encoding:?}");
        }
        // 50 of sRGB is 0.0319 of white, whose power of 1/2.2 is 53.
        assert_eq!(recoded(&bytes, Encoding::Srgb.other().1).pixels[50], [53, 53, 53, 255]);
    }

    #[test]
    fn packing_keeps_brightness_and_blurs_colour() {
        let grey = Picture { width: 5, height: 3, pixels: (0..15).map(|i| [i * 9, i * 9, i * 9, 255]).collect() };
        assert_eq!(packed(&grey), grey);
        let flat = Picture { width: 4, height: 4, pixels: vec![[200, 100, 50, 255]; 16] };
        assert_eq!(packed(&flat), flat);
        let stripes = (0..64).map(|i| if i % 2 == 0 { [180, 180, 60, 255] } else { [60, 160, 200, 255] });
        let stripes = Picture { width: 8, height: 8, pixels: stripes.collect() };
        let (a, b) = (packed(&stripes).pixels[27], packed(&stripes).pixels[28]);
        assert!(a[0].abs_diff(b[0]) < 40 && a[2].abs_diff(b[2]) < 40, "{a:?} {b:?}");
    }
}
