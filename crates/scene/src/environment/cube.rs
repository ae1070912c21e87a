//! The six faces of a cube as a picture of the environment: files of a folder, made into one equirectangular picture.
//!
//! Pictures are as they are seen from the middle of the cube, and lie as three.js has them: faces are named for axes of
//! a left-handed space, so that +X is on the left of who looks along +Z.

use super::exr_file::decode_exr;
use super::map::{
    Cube, EnvironmentError, EnvironmentMap, KEPT_WIDTH_MAX, PaddedFace, UncheckedPicture, cut,
    equirectangular_direction,
};
use super::picture::is_exr;
use super::radiance::{decode_radiance, is_radiance};
use crate::colour::linear_from_srgb;
use crate::gltf_file::MAX_FILE_BYTES;
use crate::input_file;
use glam::Vec3;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The widest face that is read; six of them take 1.2 GiB while they are decoded.
pub const FACE_SIDE_MAX: u32 = 4096;

/// Right, down and forward of the faces of a cube map, +X, −X, +Y, −Y, +Z, −Z, as devices have them.
pub const CUBE_FACES: [[Vec3; 3]; 6] = [
    [Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X],
    [Vec3::Z, Vec3::NEG_Y, Vec3::NEG_X],
    [Vec3::X, Vec3::Z, Vec3::Y],
    [Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y],
    [Vec3::X, Vec3::NEG_Y, Vec3::Z],
    [Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z],
];

/// How the files of faces are called, in the order of [`CUBE_FACES`].
const NAMES: [[&str; 6]; 4] = [
    ["px", "nx", "py", "ny", "pz", "nz"],
    ["posx", "negx", "posy", "negy", "posz", "negz"],
    ["+x", "-x", "+y", "-y", "+z", "-z"],
    ["right", "left", "top", "bottom", "front", "back"],
];
const ENDINGS: [&str; 5] = ["hdr", "exr", "png", "jpg", "jpeg"];

/// The files of the six faces of a cube in `folder`, in the order of [`CUBE_FACES`].
///
/// # Errors
/// The folder cannot be read, or lacks one of them; or has several for one.
pub fn face_files(folder: &Path) -> Result<[PathBuf; 6], String> {
    let entries = std::fs::read_dir(folder).map_err(|error| error.to_string())?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    let has_name = |file: &Path, name: &str| {
        let is = |part: Option<&std::ffi::OsStr>, word: &str| part.is_some_and(|part| part.eq_ignore_ascii_case(word));
        is(file.file_stem(), name) && ENDINGS.iter().any(|ending| is(file.extension(), ending))
    };
    let found = |name: &str| files.iter().filter(|file| has_name(file, name)).collect::<Vec<_>>();
    let named = NAMES.iter().max_by_key(|names| names.iter().filter(|name| !found(name).is_empty()).count());
    let names = named.unwrap_or(&NAMES[0]);
    let mut faces: [PathBuf; 6] = Default::default();
    for (face, name) in faces.iter_mut().zip(names) {
        match found(name)[..] {
            [file] => face.clone_from(file),
            [] => {
                return Err(format!(
                    "there is no {name}.{} in it: six faces are called {}",
                    ENDINGS.join(" or ."),
                    all_names()
                ));
            }
            [one, other, ..] => {
                return Err(format!("{} and {} are both the face {name}", one.display(), other.display()));
            }
        }
    }
    Ok(faces)
}

fn all_names() -> String {
    NAMES.map(|names| names.join(" ")).join(", or ")
}

impl Cube {
    /// Of faces of `side` texels a side.
    fn new(side: usize, faces: &[Vec<Vec3>]) -> Self {
        let texel = |face: usize, x: usize, y: usize| faces[face][y * side + x];
        let middle = |at: usize| (2.0 * at as f32 + 1.0) / side as f32 - 1.0;
        // Over an edge, beside a texel: that of the other face there.
        let beside = |face: usize, x: f32, y: f32| {
            let [right, down, forward] = CUBE_FACES[face];
            let (face, x, y) = face_of(forward + right * x + down * y);
            let at = |place: f32| (((0.5 + 0.5 * place) * side as f32) as usize).min(side - 1);
            texel(face, at(x), at(y))
        };
        const OUT: f32 = 1.0001;
        let wide = side + 2;
        let padded = |face: usize| {
            let mut texels = vec![Vec3::ZERO; wide * wide];
            for y in 0..side {
                for x in 0..side {
                    texels[(y + 1) * wide + x + 1] = texel(face, x, y);
                }
                let place = middle(y);
                texels[(y + 1) * wide] = beside(face, -OUT, place);
                texels[(y + 1) * wide + wide - 1] = beside(face, OUT, place);
                texels[y + 1] = beside(face, place, -OUT);
                texels[(wide - 1) * wide + y + 1] = beside(face, place, OUT);
            }
            // Three faces meet in a corner, and agree there.
            for (x, y) in [(0, 0), (wide - 1, 0), (0, wide - 1), (wide - 1, wide - 1)] {
                let [inner_x, inner_y] = [x, y].map(|at: usize| at.clamp(1, side));
                let meeting = [(inner_x, inner_y), (x, inner_y), (inner_x, y)];
                let sum: Vec3 = meeting.into_iter().map(|(x, y)| texels[y * wide + x]).sum();
                texels[y * wide + x] = sum / 3.0;
            }
            PaddedFace { texels }
        };
        Self { side, faces: (0..6).map(padded).collect() }
    }

    /// Made smaller by a whole factor if faces are wider than `kept_side`; and how many values were no radiance.
    pub fn made_smaller(faces: &[UncheckedPicture], kept_side: u32) -> (Self, u64) {
        let side = faces.first().map_or(1, |face| face.width);
        let factor = side.div_ceil(kept_side).max(1);
        let mut cut_count = 0;
        let smaller: Vec<Vec<Vec3>> = faces.iter().map(|face| made_smaller(face, factor, &mut cut_count)).collect();
        (Self::new((side / factor).max(1) as usize, &smaller), cut_count)
    }

    /// The radiance in a direction of the world: as who stands in the middle sees it, for whom +X is on the left.
    pub fn seen(&self, to: Vec3) -> Vec3 {
        self.at(Vec3::new(-to.x, to.y, to.z))
    }

    /// The texels of each face with those around it.
    pub fn texels(&self) -> impl Iterator<Item = &[Vec3]> {
        self.faces.iter().map(|face| face.texels.as_slice())
    }

    /// The radiance in a direction, between the four nearest texels.
    fn at(&self, direction: Vec3) -> Vec3 {
        let (face, x, y) = face_of(direction);
        let wide = self.side + 2;
        let [x, y] =
            [x, y].map(|place| ((0.5 + 0.5 * place) * self.side as f32 + 0.5).clamp(0.0, self.side as f32 + 0.999));
        let first = y as usize * wide + x as usize;
        let texels = &self.faces[face].texels;
        let along = |first: usize| texels[first].lerp(texels[first + 1], x.fract());
        along(first).lerp(along(first + wide), y.fract())
    }
}

/// The face that a direction meets, and where on it, from −1 to 1.
fn face_of(direction: Vec3) -> (usize, f32, f32) {
    let size = direction.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let face = 2 * axis + usize::from(direction[axis] < 0.0);
    let [right, down, forward] = CUBE_FACES[face];
    let ahead = direction.dot(forward);
    (face, direction.dot(right) / ahead, direction.dot(down) / ahead)
}

impl EnvironmentMap {
    /// Of the six faces of a cube, +X, −X, +Y, −Y, +Z, −Z: the names of their files and their bytes. Radiance and
    /// OpenEXR hold radiance, others sRGB.
    ///
    /// # Errors
    /// One cannot be read, is not square, larger than [`FACE_SIDE_MAX`], or of another size than the first.
    pub fn of_faces(name: &str, files: &[(String, Vec<u8>)]) -> Result<Self, EnvironmentError> {
        let failed = |message: String| EnvironmentError { name: name.into(), message };
        let mut faces = Vec::with_capacity(6);
        let mut side = 0;
        for (file, bytes) in files {
            let of_face = |message: String| failed(format!("{file}: {message}"));
            let face = decode_face(bytes).map_err(of_face)?;
            if !faces.is_empty() && face.width != side {
                let message = format!("it has {0}x{0} pixels, and the first face {side}x{side}", face.width);
                return Err(of_face(message));
            }
            side = face.width;
            faces.push(face);
        }
        if faces.len() != 6 {
            return Err(failed(format!("a cube has six faces, and there are {}", faces.len())));
        }
        Ok(Self::of_cube(name, &faces))
    }

    /// Of six faces of one size.
    pub(super) fn of_cube(name: &str, faces: &[UncheckedPicture]) -> Self {
        // As fine as the middles of faces.
        let (cube, cut_count) = Cube::made_smaller(faces, KEPT_WIDTH_MAX / 4);
        let side = cube.side as u32;
        let (width, height) = (4 * side, 2 * side);
        let texel = |i: u32| cube.seen(equirectangular_direction((i % width, i / width), (width, height))).to_array();
        let decoded = UncheckedPicture { width, height, rgb: (0..width * height).map(texel).collect() };
        let mut map = Self::from_decoded(name, &decoded, KEPT_WIDTH_MAX);
        if faces.iter().any(|face| face.width > side) {
            map.notes.push(format!("environment \"{name}\": its faces are made smaller, {side}x{side}"));
        }
        if cut_count > 0 {
            map.notes
                .push(format!("environment \"{name}\": {cut_count} values are not valid radiance, and were clamped"));
        }
        map
    }

    /// Reads a file, or a folder with the six faces of a cube.
    ///
    /// # Errors
    /// It cannot be read, or as [`Self::decode`] and [`Self::of_faces`].
    pub fn load_path(path: &Path) -> Result<Self, EnvironmentError> {
        let name = path.display().to_string();
        let failed = |message: String| EnvironmentError { name: name.clone(), message };
        let read = |path: &Path| {
            input_file::read(path, MAX_FILE_BYTES).map_err(|error| failed(format!("{}: {error}", path.display())))
        };
        if !path.is_dir() {
            let bytes = input_file::read(path, MAX_FILE_BYTES).map_err(|error| failed(error.to_string()))?;
            return Self::decode(&name, &bytes);
        }
        let files = face_files(path).map_err(failed)?;
        let faces: Result<Vec<_>, _> = files.iter().map(|file| Ok((file.display().to_string(), read(file)?))).collect();
        Self::of_faces(&name, &faces?)
    }
}

/// The files that an environment is read from: one, or those of six faces as far as they are there.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    if path.is_dir() { face_files(path).map(Vec::from).unwrap_or_default() } else { vec![path.to_owned()] }
}

fn check_face(width: u32, height: u32) -> Result<(), String> {
    if width != height || width == 0 || width > FACE_SIDE_MAX {
        return Err(format!(
            "a face is square, of at most {FACE_SIDE_MAX} pixels a side, and this has {width}x{height}"
        ));
    }
    Ok(())
}

fn decode_face(bytes: &[u8]) -> Result<UncheckedPicture, String> {
    if is_exr(bytes) {
        return decode_exr(bytes, check_face);
    }
    if is_radiance(bytes) {
        return decode_radiance(bytes, check_face);
    }
    let failed = |error: image::ImageError| error.to_string();
    let reader =
        || image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string());
    let (width, height) = reader()?.into_dimensions().map_err(failed)?;
    check_face(width, height)?;
    let picture = reader()?.decode().map_err(failed)?.into_rgb8();
    let linear: [f32; 256] = std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0));
    let rgb = picture.pixels().map(|pixel| pixel.0.map(|byte| linear[usize::from(byte)])).collect();
    Ok(UncheckedPicture { width, height, rgb })
}

/// Means of `factor` by `factor` texels.
fn made_smaller(face: &UncheckedPicture, factor: u32, cut_count: &mut u64) -> Vec<Vec3> {
    let side = (face.width / factor).max(1);
    let mut mean = |i: u32| {
        let (x, y) = (i % side * factor, i / side * factor);
        let mut sum = Vec3::ZERO;
        for at in 0..factor * factor {
            let texel = face.rgb[((y + at / factor) * face.width + x + at % factor) as usize];
            sum += Vec3::from(texel.map(|value| {
                let (value, is_cut) = cut(value);
                *cut_count += u64::from(is_cut);
                value
            }));
        }
        sum / (factor * factor) as f32
    };
    (0..side * side).map(&mut mean).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    fn hdr(side: u32, radiance: impl Fn(u32, u32) -> Vec3) -> Vec<u8> {
        let mut bytes = Vec::new();
        let texels: Vec<_> = (0..side * side).map(|i| image::Rgb(radiance(i % side, i / side).to_array())).collect();
        image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, side as usize, side as usize).unwrap();
        bytes
    }

    fn png(side: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let picture = image::RgbImage::from_pixel(side, side, image::Rgb([188, 0, 255]));
        picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    /// Faces of what is smooth over all directions, as who stands in the middle sees it.
    fn smooth(to: Vec3) -> Vec3 {
        Vec3::new(2.0 + to.x, 2.0 + to.y, 2.0 + to.z)
    }

    fn faces(side: u32) -> Vec<(String, Vec<u8>)> {
        let face = |face: usize| {
            let [right, down, forward] = CUBE_FACES[face];
            let place = |at: u32| (2.0 * at as f32 + 1.0) / side as f32 - 1.0;
            let file = hdr(side, |x, y| {
                let to = (forward + right * place(x) + down * place(y)).normalize();
                smooth(Vec3::new(-to.x, to.y, to.z))
            });
            (format!("{face}.hdr"), file)
        };
        (0..6).map(face).collect()
    }

    #[test]
    fn faces_become_one_picture_without_seams() {
        let map = EnvironmentMap::of_faces("cube", &faces(32)).unwrap();
        assert_eq!((map.width, map.height, map.notes.len()), (128, 64, 0));
        let mut worst = 0.0f32;
        for i in 0..map.width * map.height {
            let to = equirectangular_direction((i % map.width, i / map.width), (map.width, map.height));
            let [r, g, b, _] = map.texels[i as usize].map(f32::from);
            worst = worst.max((Vec3::new(r, g, b) - smooth(to)).abs().max_element());
        }
        // Radiance files have steps of 1/128.
        assert!(worst < 0.03, "{worst}");
    }

    #[test]
    fn what_is_no_cube_is_refused() {
        let refused = |faces: &[(String, Vec<u8>)]| EnvironmentMap::of_faces("c", faces).unwrap_err().to_string();
        let mut odd = faces(8);
        odd[3].1 = hdr(4, |_, _| Vec3::ONE);
        assert!(refused(&odd).contains("3.hdr: it has 4x4 pixels, and the first face 8x8"), "{}", refused(&odd));
        assert!(refused(&faces(8)[..5]).contains("six faces, and there are 5"));
        odd[3].1 = b"nothing".to_vec();
        assert!(refused(&odd).contains("3.hdr: "));
        odd[3].1 = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
        assert!(refused(&odd).contains("a face is square"), "{}", refused(&odd));
    }

    #[test]
    fn a_folder_of_faces_is_read_and_says_what_it_lacks() {
        let folder = std::env::temp_dir().join(format!("manypass_cube_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for name in ["posx", "negx", "posy", "negy", "posz"] {
            std::fs::write(folder.join(name).with_extension("png"), png(2)).unwrap();
        }
        let lacking = EnvironmentMap::load_path(&folder).unwrap_err().to_string();
        assert!(lacking.contains("there is no negz"), "{lacking}");
        std::fs::write(folder.join("negZ.PNG"), png(2)).unwrap();
        let map = EnvironmentMap::load_path(&folder).unwrap();
        assert_eq!(files_of(&folder).len(), 6);
        std::fs::write(folder.join("negz.hdr"), hdr(2, |_, _| Vec3::ONE)).unwrap();
        let twice = EnvironmentMap::load_path(&folder).unwrap_err().to_string();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(twice.contains("both the face negz"), "{twice}");
        let [r, g, b, _] = map.texels[5].map(f32::from);
        // 188 of 255 in sRGB is half the light.
        assert!((r - 0.5029).abs() < 1e-3 && g == 0.0 && b == 1.0, "{r} {g} {b}");
    }
}
