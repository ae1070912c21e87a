//! Light from all directions, as it is kept.

use glam::Vec3;
use half::f16;

/// The widest picture that is kept: 4096 by 2048, 64 MiB. A wider one is made smaller by whole factors.
pub const KEPT_WIDTH_MAX: u32 = 4096;
/// The widest picture that is read, which takes 1.5 GiB while it is decoded.
pub const WIDTH_MAX: u32 = 16_384;
/// Radiance of texels ends here: half floats end at 65,504.
pub const RADIANCE_MAX: f32 = 65_000.0;
/// Radiance beyond this is cut, wherever it is kept.
const PEAK_MAX: f32 = 1e10;
/// The most texels of which more than [`RADIANCE_MAX`] is kept: a sun has few.
const PEAKS_MAX: usize = 1 << 16;

/// The mapping of directions to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvironmentLayout {
    /// All directions in one picture: u = 0.5 + atan2(z, x) / 2π, v = acos(y) / π.
    Equirectangular,
}

/// A light that belongs to an environment but is not in its texels. It is parallel, and casts shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// Where it is seen, of length 1.
    pub direction: Vec3,
    /// What a plane across the direction gets of it, linear Rec. 709: radiance of its source times the source's solid
    /// angle.
    pub irradiance: Vec3,
    /// The tangent of half the angle that its source takes in the sky, for the width of penumbrae; 0 is a point.
    pub half_angle_tan: f32,
}

/// An environment map: light from all directions.
#[derive(Clone, PartialEq)]
pub struct EnvironmentMap {
    /// The file, for messages.
    pub name: String,
    /// The mapping of directions to texels.
    pub layout: EnvironmentLayout,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Red, green, blue, 1: rows from the top; finite, from 0 to [`RADIANCE_MAX`].
    pub texels: Vec<[f16; 4]>,
    /// What texels, by their index, have beyond [`RADIANCE_MAX`]: the middle of a sun.
    pub peaks: Vec<(u32, Vec3)>,
    /// What rough surfaces reflect of it, where a file brings that; else the renderer works it out.
    pub prefiltered: Option<PrefilteredEnvironment>,
    /// Irradiance divided by π by the direction of normals, where a file brings that; else the renderer works it out.
    pub irradiance: Option<LightPicture>,
    /// The light that is not in the texels, if there is one.
    pub light: Option<EnvironmentLight>,
    /// What was changed when it was read; one line each.
    pub notes: Vec<String>,
}

impl std::fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EnvironmentMap({}, {}x{})", self.name, self.width, self.height)
    }
}

/// The error of an environment file that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("environment \"{name}\": {message}")]
pub struct EnvironmentError {
    /// The file.
    pub name: String,
    /// What went wrong, and what is expected.
    pub message: String,
}

/// A picture before it is checked.
pub(crate) struct UncheckedPicture {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgb: Vec<[f32; 3]>,
}

/// What says whether a width and height can be read.
pub(crate) type CheckSize = fn(u32, u32) -> Result<(), String>;

/// Light by direction, in an equirectangular picture; between its texels it goes evenly.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPicture {
    /// The file.
    pub name: String,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: Vec<Vec3>,
}

/// A face: its texels with a border of those around it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PaddedFace {
    pub(super) texels: Vec<Vec3>,
}

/// The faces of a cube.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cube {
    pub(super) side: usize,
    pub(super) faces: Vec<PaddedFace>,
}

/// What a surface of a roughness reflects.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Level {
    Cube(Cube),
    Picture(LightPicture),
}

/// What surfaces of more and more roughness reflect of an environment, seen along their normals: prefiltered by other
/// tools.
#[derive(Clone, Debug, PartialEq)]
pub struct PrefilteredEnvironment {
    /// The file, or what stands for those of all levels.
    pub name: String,
    /// Of perceptual roughness from 0 to 1, in equal steps; two at least.
    pub(super) levels: Vec<Level>,
}

impl EnvironmentMap {
    /// Made by code: `width` by `height` texels, equirectangular, of what `radiance` gives for the unit direction of
    /// each.
    pub fn from_fn(name: &str, width: u32, height: u32, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let texel = |i: u32| {
            let direction = equirectangular_direction((i % width, i / width), (width, height));
            let [r, g, b] = radiance(direction).to_array().map(|value| f16::from_f32(cut(value).0.min(RADIANCE_MAX)));
            [r, g, b, f16::ONE]
        };
        Self {
            name: name.into(),
            layout: EnvironmentLayout::Equirectangular,
            width,
            height,
            texels: (0..width * height).map(texel).collect(),
            peaks: Vec::new(),
            prefiltered: None,
            irradiance: None,
            light: None,
            notes: Vec::new(),
        }
    }

    /// Made smaller if it is wider than `kept_width`, without what is no radiance.
    pub(super) fn from_decoded(name: &str, decoded: &UncheckedPicture, kept_width: u32) -> Self {
        let factor = decoded.width.div_ceil(kept_width).max(1);
        let (width, height) = ((decoded.width / factor).max(1), (decoded.height / factor).max(1));
        let mut notes = Vec::new();
        if factor > 1 {
            let UncheckedPicture { width: from_width, height: from_height, .. } = decoded;
            notes.push(format!("environment \"{name}\": {from_width}x{from_height} is made smaller, {width}x{height}"));
        }
        let mut cut_count = decoded.rgb.iter().flatten().filter(|value| cut(**value).1).count();
        // How many texels of the file lie in one that is kept.
        let area = (decoded.width as f32 / width as f32) * (decoded.height as f32 / height as f32);
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        let mut peaks = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0f32; 3];
                for (row, row_share) in covered(y, decoded.height, height) {
                    for (column, column_share) in covered(x, decoded.width, width) {
                        let texel = &decoded.rgb[(row * decoded.width + column) as usize];
                        for (sum, value) in sum.iter_mut().zip(texel) {
                            *sum += row_share * column_share * cut(*value).0;
                        }
                    }
                }
                let mean = Vec3::from(sum) / area;
                let kept = mean.min(Vec3::splat(RADIANCE_MAX));
                if kept != mean && peaks.len() < PEAKS_MAX {
                    peaks.push((texels.len() as u32, mean - kept));
                } else if kept != mean {
                    cut_count += 1;
                }
                let [r, g, b] = kept.to_array().map(f16::from_f32);
                texels.push([r, g, b, f16::ONE]);
            }
        }
        if cut_count > 0 {
            notes.push(format!(
                "environment \"{name}\": {cut_count} values are not valid radiance, or too bright; NaN counts as 0"
            ));
        }
        Self {
            name: name.into(),
            layout: EnvironmentLayout::Equirectangular,
            width,
            height,
            texels,
            peaks,
            prefiltered: None,
            irradiance: None,
            light: None,
            notes,
        }
    }
}

/// The columns (or rows) of a picture, of which there are `from`, that one of `to` equal parts covers, each with the
/// share of it that lies in the part. Together all parts have each column once.
fn covered(part: u32, from: u32, to: u32) -> impl Iterator<Item = (u32, f32)> {
    // In units of which a column has `to`, and a part `from`.
    let (start, end) = (part * from, (part + 1) * from);
    (start / to..end.div_ceil(to)).map(move |column| {
        let inside = end.min((column + 1) * to) - start.max(column * to);
        (column, inside as f32 / to as f32)
    })
}

/// The unit direction of the middle of a texel of an equirectangular picture.
pub fn equirectangular_direction((x, y): (u32, u32), size: (u32, u32)) -> Vec3 {
    equirectangular_direction_within((x as f32 + 0.5, y as f32 + 0.5), size)
}

/// The unit direction of a place of an equirectangular picture, in texels from its upper left corner.
pub fn equirectangular_direction_within((x, y): (f32, f32), (width, height): (u32, u32)) -> Vec3 {
    let around = std::f32::consts::TAU * (x / width as f32 - 0.5);
    let down = std::f32::consts::PI * y / height as f32;
    Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
}

/// A value as radiance, and whether that is another one. Infinity is as bright as texels are.
pub(crate) fn cut(value: f32) -> (f32, bool) {
    match value {
        _ if value.is_nan() => (0.0, true),
        f32::INFINITY => (RADIANCE_MAX, true),
        _ => (value.clamp(0.0, PEAK_MAX), !(0.0..=PEAK_MAX).contains(&value)),
    }
}
