//! Pictures of radiance in files: OpenEXR with half floats, one part, scan lines, uncompressed, as "OpenEXR File
//! Layout" writes it out. Written and read here without a library, because the reference is to share no code with the
//! renderer.

use std::fmt;
use std::path::Path;

/// A picture of linear radiance, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiancePicture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Linear Rec. 709.
    pub pixels: Vec<[f32; 3]>,
}

/// Why a file is no picture of radiance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RadianceFileError(String);

impl fmt::Display for RadianceFileError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for RadianceFileError {}

fn error(message: impl fmt::Display) -> RadianceFileError {
    RadianceFileError(message.to_string())
}

const MAGIC: [u8; 8] = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
/// Of each channel: pixel type 1 (half), three flags that are 0, and a sample at each pixel.
const HALF_CHANNEL: [u8; 16] = [1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

impl RadiancePicture {
    /// The bytes of a file. What half floats cannot hold becomes the largest that they do.
    pub fn to_exr(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            for text in [name, kind] {
                bytes.extend(text.as_bytes());
                bytes.push(0);
            }
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(value);
        };
        let mut channels = Vec::new();
        for name in [b'B', b'G', b'R'] {
            channels.extend([name, 0]);
            channels.extend(HALF_CHANNEL);
        }
        channels.push(0);
        let last = [0, 0, self.width as u32 - 1, self.height as u32 - 1].map(u32::to_le_bytes).concat();
        attribute("channels", "chlist", &channels);
        attribute("compression", "compression", &[0]);
        attribute("dataWindow", "box2i", &last);
        attribute("displayWindow", "box2i", &last);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1.0_f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1.0_f32.to_le_bytes());
        bytes.push(0);
        let line_bytes = 6 * self.width;
        let first_line = bytes.len() + 8 * self.height;
        for row in 0..self.height {
            bytes.extend(((first_line + row * (8 + line_bytes)) as u64).to_le_bytes());
        }
        for row in 0..self.height {
            bytes.extend((row as u32).to_le_bytes());
            bytes.extend((line_bytes as u32).to_le_bytes());
            let pixels = &self.pixels[row * self.width..(row + 1) * self.width];
            for channel in [2, 1, 0] {
                bytes.extend(pixels.iter().flat_map(|pixel| half_from_f32(pixel[channel]).to_le_bytes()));
            }
        }
        bytes
    }

    /// The picture in such bytes.
    ///
    /// # Errors
    /// The file is none of those that [`Self::to_exr`] makes.
    pub fn from_exr(bytes: &[u8]) -> Result<Self, RadianceFileError> {
        let mut rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| error("this is no OpenEXR file of scan lines"))?;
        let mut size = None;
        loop {
            let name = text(&mut rest)?;
            if name.is_empty() {
                break;
            }
            let kind = text(&mut rest)?;
            let length = u32::from_le_bytes(array(&mut rest)?);
            let value = take(&mut rest, length as usize)?;
            match (name, kind) {
                (b"compression", _) if value != [0] => return Err(error("the file is compressed")),
                (b"channels", _) => {
                    let own = [b"B\0".as_slice(), &HALF_CHANNEL, b"G\0", &HALF_CHANNEL, b"R\0", &HALF_CHANNEL, b"\0"];
                    if value != own.concat() {
                        return Err(error("the channels are not the half floats B, G and R"));
                    }
                }
                (b"dataWindow", _) => {
                    let mut corners = value;
                    let mut next = || Ok(u32::from_le_bytes(array(&mut corners)?) as usize);
                    let [left, top, right, bottom] = [next()?, next()?, next()?, next()?];
                    if (left, top) != (0, 0) || right.max(bottom) > 0xffff {
                        return Err(error("the data window does not begin at 0, 0 or is too large"));
                    }
                    size = Some((right + 1, bottom + 1));
                }
                _ => {}
            }
        }
        let (width, height) = size.ok_or_else(|| error("the file has no data window"))?;
        take(&mut rest, 8 * height)?;
        let mut pixels = Vec::new();
        for _ in 0..height {
            take(&mut rest, 8)?;
            let line = take(&mut rest, 6 * width)?;
            let value = |channel: usize, x: usize| {
                let at = 2 * (channel * width + x);
                f32_from_half(u16::from_le_bytes([line[at], line[at + 1]]))
            };
            pixels.extend((0..width).map(|x| [value(2, x), value(1, x), value(0, x)]));
        }
        Ok(Self { width, height, pixels })
    }

    /// The picture in a file.
    ///
    /// # Errors
    /// The file cannot be read, or is none of those that [`Self::to_exr`] makes.
    pub fn read(path: &Path) -> Result<Self, RadianceFileError> {
        let bytes = std::fs::read(path).map_err(|problem| error(format!("{}: {problem}", path.display())))?;
        Self::from_exr(&bytes).map_err(|problem| error(format!("{}: {problem}", path.display())))
    }
}

fn take<'b>(rest: &mut &'b [u8], count: usize) -> Result<&'b [u8], RadianceFileError> {
    let (taken, left) = rest.split_at_checked(count).ok_or_else(|| error("the file is cut off"))?;
    *rest = left;
    Ok(taken)
}

fn array<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], RadianceFileError> {
    take(rest, N)?.try_into().map_err(|_| error("the file is cut off"))
}

/// Up to a zero.
fn text<'b>(rest: &mut &'b [u8]) -> Result<&'b [u8], RadianceFileError> {
    let end = rest.iter().position(|byte| *byte == 0).ok_or_else(|| error("the file is cut off"))?;
    let text = take(rest, end)?;
    take(rest, 1)?;
    Ok(text)
}

/// The nearest half float (IEEE 754 binary16), of two the even one; at most 65,504.
fn half_from_f32(value: f32) -> u16 {
    let sign = if value.is_sign_negative() { 0x8000 } else { 0 };
    let magnitude = value.abs().min(65_504.0);
    // The least step of half floats is 2⁻²⁴; from 2⁻¹⁴ on they have eleven bits.
    let exponent = magnitude.max(2.0_f32.powi(-14)).log2().floor() as i32;
    let step = 2.0_f64.powi(exponent - 10);
    let steps = (f64::from(magnitude) / step).round_ties_even() as u16;
    // A carry into the next exponent is right as it is, as the bits go on counting.
    sign + ((exponent + 14) as u16) * 1024 + steps
}

fn f32_from_half(half: u16) -> f32 {
    let sign = if half & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(half >> 10 & 31), f32::from(half & 1023));
    match exponent {
        0 => sign * fraction * 2.0_f32.powi(-24),
        31 => f32::NAN,
        _ => sign * (fraction + 1024.0) * 2.0_f32.powi(exponent - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_float_comes_back_and_others_are_rounded() {
        for half in (0..0x7c00).chain(0x8000..0xfc00) {
            assert_eq!(half_from_f32(f32_from_half(half)), half, "{half:#x}");
        }
        assert_eq!(f32_from_half(0x3c00), 1.0);
        assert_eq!(f32_from_half(0x3555), 0.333_251_95);
        assert_eq!(half_from_f32(1.0 / 3.0), 0x3555);
        assert_eq!(half_from_f32(1e9), 0x7bff);
        assert_eq!(half_from_f32(0.999_99), 0x3c00);
        assert_eq!(half_from_f32(1.0 + 0.5 / 1024.0), 0x3c00);
    }

    #[test]
    fn a_picture_comes_back_from_its_file_and_a_broken_one_does_not() {
        let pixels = (0..35_u8).map(|i| [f32::from(i) / 4.0, 1.0 / 1024.0, 300.0 - f32::from(i)]).collect();
        let picture = RadiancePicture { width: 7, height: 5, pixels };
        let bytes = picture.to_exr();
        assert_eq!(RadiancePicture::from_exr(&bytes), Ok(picture));
        for end in [0, 7, 20, 100, bytes.len() - 1] {
            assert!(RadiancePicture::from_exr(&bytes[..end]).is_err());
        }
    }
}
