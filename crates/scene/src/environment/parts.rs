//! What files bring of an environment that the renderer else works out: what rough surfaces reflect of it, in pictures
//! of its own, and irradiance.

use super::cube::files_of;
use super::map::{EnvironmentError, EnvironmentMap, Level, LightPicture, PrefilteredEnvironment};
use glam::Vec3;
use half::f16;
use std::f32::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// The widest picture that is kept of what was blurred before.
const KEPT_WIDTH_MAX: u32 = 1024;

/// What stands for the number of a level in the name of a file.
pub(crate) const LEVEL: &str = "{level}";

/// So many pictures are looked for.
const LEVELS_MAX: u32 = 32;

impl LightPicture {
    /// That of a map, made smaller by a whole factor where it is wide. Where the factor leaves a remainder, some blocks
    /// of texels are one wider or higher, so that none is left out.
    fn of(map: &EnvironmentMap) -> Self {
        let factor = map.width.div_ceil(KEPT_WIDTH_MAX).max(1);
        let (width, height) = ((map.width / factor).max(1), (map.height / factor).max(1));
        let at = |x: u32, y: u32| {
            let index = (y.min(map.height - 1) * map.width + x.min(map.width - 1)) as usize;
            let [r, g, b, _] = map.texels.get(index).copied().unwrap_or_default().map(f16::to_f32);
            Vec3::new(r, g, b)
        };
        let block = |i: u32, from: u32, count: u32| i * from / count..(i + 1) * from / count;
        let mean = |i: u32| {
            let (columns, rows) = (block(i % width, map.width, width), block(i / width, map.height, height));
            let count = (columns.len() * rows.len()).max(1);
            let sum: Vec3 = rows.flat_map(|y| columns.clone().map(move |x| at(x, y))).sum();
            sum / count as f32
        };
        let texels = (0..width * height).map(mean).collect();
        Self { name: map.name.clone(), width: width as usize, height: height as usize, texels }
    }

    /// What comes from a direction of length 1, linear Rec. 709.
    pub fn seen(&self, direction: Vec3) -> Vec3 {
        let x = (0.5 + direction.z.atan2(direction.x) / TAU) * self.width as f32 - 0.5;
        let y = direction.y.clamp(-1.0, 1.0).acos() / PI * self.height as f32 - 0.5;
        let (left, top) = (x.floor(), y.clamp(0.0, (self.height - 1) as f32).floor());
        let column = |at: f32| (at as i64).rem_euclid(self.width as i64) as usize;
        let row = |at: usize| at.min(self.height - 1) * self.width;
        let along = |row: usize| {
            let [a, b] = [left, left + 1.0].map(|at| self.texels.get(row + column(at)).copied().unwrap_or_default());
            a.lerp(b, x - left)
        };
        along(row(top as usize)).lerp(along(row(top as usize + 1)), (y - top).clamp(0.0, 1.0))
    }

    /// The mean over all directions.
    pub fn mean(&self) -> Vec3 {
        let mut sum = (Vec3::ZERO, 0.0);
        for (row, texels) in self.texels.chunks(self.width.max(1)).enumerate() {
            // A row covers less of all directions towards the poles.
            let weight = (PI * (row as f32 + 0.5) / self.height as f32).sin();
            sum.0 += texels.iter().sum::<Vec3>() / self.width as f32 * weight;
            sum.1 += weight;
        }
        sum.0 / sum.1.max(f32::MIN_POSITIVE)
    }

    /// All texels, for a hash.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }
}

impl Level {
    fn seen(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Cube(cube) => cube.seen(direction),
            Self::Picture(picture) => picture.seen(direction),
        }
    }
}

impl PrefilteredEnvironment {
    /// The radiance that a surface with the normal `direction`, of length 1, reflects to who looks along it, linear
    /// Rec. 709. `roughness` is perceptual, from 0 to 1.
    pub fn reflected(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let last = self.levels.len().saturating_sub(1);
        let at = roughness.clamp(0.0, 1.0) * last as f32;
        let (low, high) = (at as usize, (at as usize + 1).min(last));
        let of = |index: usize| self.levels.get(index).map_or(Vec3::ZERO, |level| level.seen(direction));
        of(low).lerp(of(high), at.fract())
    }

    /// All texels, for a hash.
    pub fn texels(&self) -> impl Iterator<Item = &[Vec3]> {
        self.levels.iter().flat_map(|level| {
            let texels: Vec<&[Vec3]> = match level {
                Level::Cube(cube) => cube.texels().collect(),
                Level::Picture(picture) => vec![picture.texels()],
            };
            texels
        })
    }
}

/// The files of a picture for each level, from 0 on as far as they are there; none if the path has no `{level}`.
fn level_files(path: &Path) -> Option<Vec<PathBuf>> {
    let pattern = path.to_str().filter(|text| text.contains(LEVEL))?;
    let files = (0..LEVELS_MAX).map(|level| PathBuf::from(pattern.replace(LEVEL, &level.to_string())));
    Some(files.take_while(|file| file.exists()).collect())
}

impl EnvironmentMap {
    /// Reads an environment with what rough surfaces reflect of it: a cube map with levels (.ktx2); or a picture for
    /// each level, as [`Self::load_path`] reads them, by a path with `{level}` in place of a number from 0 on. Level i
    /// of n is that of the perceptual roughness i / (n − 1); the first is the environment itself.
    ///
    /// # Errors
    /// A file cannot be read, or there is one level alone.
    pub fn load_prefiltered(path: &Path) -> Result<Self, EnvironmentError> {
        let failed = |message: String| EnvironmentError { name: path.display().to_string(), message };
        let Some(files) = level_files(path) else { return Self::load_path(path)?.checked_prefiltered() };
        if files.len() < 2 {
            let next = path.display().to_string().replace(LEVEL, &files.len().to_string());
            return Err(failed(format!(
                "there is no {next}; a picture for each level begins with that of roughness 0, and there are two at least"
            )));
        }
        let mut levels = Vec::with_capacity(files.len());
        let mut first = None;
        for file in &files {
            let map = Self::load_path(file)?;
            levels.push(Level::Picture(LightPicture::of(&map)));
            first.get_or_insert(map);
        }
        let mut map = first.ok_or_else(|| failed("it has no levels".into()))?;
        map.prefiltered = Some(PrefilteredEnvironment { name: path.display().to_string(), levels });
        Ok(map)
    }

    /// Reads the bytes of a cube map with levels, as [`Self::load_prefiltered`]; `name` appears in messages.
    ///
    /// # Errors
    /// As [`Self::decode`], or there is one level alone.
    pub fn decode_prefiltered(name: &str, bytes: &[u8]) -> Result<Self, EnvironmentError> {
        Self::decode(name, bytes)?.checked_prefiltered()
    }

    fn checked_prefiltered(self) -> Result<Self, EnvironmentError> {
        if self.prefiltered.is_some() {
            return Ok(self);
        }
        let message = format!(
            "it has one level; a prefiltered map has several: \
             a cube map with levels (.ktx2), or a picture for each, NAME_{LEVEL}.hdr"
        );
        Err(EnvironmentError { name: self.name, message })
    }

    /// With what rough surfaces reflect of another map in place of what the renderer works out of this one.
    #[must_use]
    pub fn with_prefiltered(self, of: Self) -> Self {
        Self { prefiltered: of.prefiltered, ..self }.with_notes(&of.notes)
    }

    /// With diffuse light from a map whose radiance in a direction is irradiance divided by π of a surface that faces
    /// there, in place of what the renderer works out of this one.
    #[must_use]
    pub fn with_irradiance(self, of: &Self) -> Self {
        Self { irradiance: Some(LightPicture::of(of)), ..self }.with_notes(&of.notes)
    }

    fn with_notes(mut self, more: &[String]) -> Self {
        self.notes.extend_from_slice(more);
        self
    }
}

/// The files that [`EnvironmentMap::load_prefiltered`] reads.
pub fn prefiltered_files(path: &Path) -> Vec<PathBuf> {
    level_files(path).unwrap_or_else(|| files_of(path))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use crate::environment::equirectangular_direction;

    #[test]
    fn light_is_seen_between_texels() {
        let smooth = |to: Vec3| Vec3::new(2.0 + to.x, 2.0 + to.y, 2.0 + to.z);
        let picture = LightPicture::of(&EnvironmentMap::from_fn("a", 2048, 1024, smooth));
        assert_eq!((picture.width, picture.height), (1024, 512));
        for i in (0..64 * 32).step_by(7) {
            let to = equirectangular_direction((i % 64, i / 64), (64, 32));
            assert!((picture.seen(to) - smooth(to)).abs().max_element() < 5e-3, "{to}");
        }
        for to in [Vec3::Y, Vec3::NEG_Y, Vec3::NEG_X, Vec3::new(-1.0, 0.0, -1e-9)] {
            assert!((picture.seen(to) - smooth(to)).abs().max_element() < 5e-3, "{to}");
        }
        let one = LightPicture::of(&EnvironmentMap::from_fn("one", 1, 1, |_| Vec3::splat(0.5)));
        assert_eq!(one.seen(Vec3::new(0.6, -0.8, 0.0)), Vec3::splat(0.5));
    }

    #[test]
    fn no_column_or_row_is_left_out() {
        // Halves of 1025 by 513 leave one of each.
        let (width, height) = (1025, 513);
        let mut map = EnvironmentMap::from_fn("a", width, height, |_| Vec3::ONE);
        for (i, texel) in (0..).zip(&mut map.texels) {
            let is_last = [i % width == width - 1, i / width == height - 1];
            let value = |is_last: bool| f16::from_f32(if is_last { 7.0 } else { 1.0 });
            *texel = [value(is_last[0]), value(is_last[1]), f16::ONE, f16::ONE];
        }
        let picture = LightPicture::of(&map);
        assert_eq!((picture.width, picture.height), (512, 256));
        // A third of the last block, whose row or column is one of three.
        let last = picture.texels[512 * 256 - 1];
        assert!((last - Vec3::new(3.0, 3.0, 1.0)).abs().max_element() < 1e-3, "{last}");
        assert_eq!(
            (picture.texels[0], picture.texels[511].x, picture.texels[512 * 255].y),
            (Vec3::ONE, last.x, last.y)
        );
    }

    fn hdr(value: f32) -> Vec<u8> {
        let mut bytes = Vec::new();
        image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&[image::Rgb([value; 3]); 8], 4, 2).unwrap();
        bytes
    }

    #[test]
    fn pictures_of_levels_are_read_by_their_numbers() {
        let folder = std::env::temp_dir().join(format!("manypass_levels_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let pattern = folder.join("room_{level}.hdr");
        let lacking = |pattern: &Path| EnvironmentMap::load_prefiltered(pattern).unwrap_err().to_string();
        assert!(lacking(&pattern).contains("there is no") && lacking(&pattern).contains("room_0.hdr"));
        std::fs::write(folder.join("room_0.hdr"), hdr(1.0)).unwrap();
        assert!(lacking(&pattern).contains("room_1.hdr"));
        assert!(lacking(&folder.join("room_0.hdr")).contains("it has one level"));
        std::fs::write(folder.join("room_1.hdr"), hdr(2.0)).unwrap();
        std::fs::write(folder.join("room_2.hdr"), hdr(4.0)).unwrap();
        let map = EnvironmentMap::load_prefiltered(&pattern).unwrap();
        assert_eq!(prefiltered_files(&pattern).len(), 3);
        std::fs::write(folder.join("room_2.hdr"), b"nothing").unwrap();
        let broken = lacking(&pattern);
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(broken.contains("room_2.hdr"), "{broken}");
        assert_eq!(map.texels[0].map(f16::to_f32), [1.0; 4]);
        let reflected = |roughness| map.prefiltered.as_ref().unwrap().reflected(Vec3::X, roughness).x;
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(reflected), [1.0, 1.5, 2.0, 3.0, 4.0]);
    }
}
