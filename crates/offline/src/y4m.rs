//! YUV4MPEG2: pictures for the display as raw video, which ffmpeg, ffplay and mpv read from a pipe.
//!
//! Source: the format is described by `yuv4mpeg(5)` of mjpegtools; the colour matrix is that of ITU-R BT.709-6, in 8
//! bits of limited range (luma 16 to 235, chroma 16 to 240). Chroma is at full resolution (4:4:4). The format has no
//! field for the matrix, nor for the transfer function, which stays that of sRGB.

use crate::encode::{EncodeError, check_length};
use crate::exr_header::rational;

/// The share of red, green and blue in luma.
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// What stands before the first frame. It stays below 80 bytes, which is all that old versions of ffmpeg take.
pub(crate) fn header((width, height): (u32, u32), frames_per_second: f32) -> Vec<u8> {
    let (frames, secs) = rate(frames_per_second);
    format!("YUV4MPEG2 W{width} H{height} F{frames}:{secs} Ip A1:1 C444 XCOLORRANGE=LIMITED\n").into_bytes()
}

/// A frame rate as a fraction. Those of television, such as 29.97, are whole numbers divided by 1.001.
fn rate(frames_per_second: f32) -> (u32, u32) {
    let exact = f64::from(frames_per_second);
    let whole = (exact * 1.001).round();
    // Whoever writes 23.976 means 24000/1001; the largest such rate keeps the header short.
    if exact.fract() != 0.0 && (1.0..=1000.0).contains(&whole) && (exact - whole / 1.001).abs() < 5e-4 {
        return (whole as u32 * 1000, 1001);
    }
    match rational(frames_per_second) {
        // Below half a thousandth; a rate of 0 is none.
        (0, _) => (1, 1000),
        (frames, secs) => (frames.unsigned_abs(), secs),
    }
}

/// One frame of 8-bit sRGB pixels, whose alpha is left out: its three planes, rows from the top.
///
/// # Errors
/// If the number of bytes does not fit the size.
pub(crate) fn frame((width, height): (u32, u32), rgba8: &[u8]) -> Result<Vec<u8>, EncodeError> {
    const START: &[u8] = b"FRAME\n";
    check_length(width, height, 4, rgba8.len())?;
    let pixel_count = rgba8.len() / 4;
    let mut bytes = Vec::with_capacity(START.len() + 3 * pixel_count);
    bytes.extend_from_slice(START);
    for plane in 0..3 {
        bytes.extend(rgba8.chunks_exact(4).map(|pixel| yuv([pixel[0], pixel[1], pixel[2]])[plane]));
    }
    Ok(bytes)
}

/// Luma, blue difference and red difference of a colour.
fn yuv(rgb: [u8; 3]) -> [u8; 3] {
    let [red, green, blue] = rgb.map(|value| f32::from(value) / 255.0);
    let luma = LUMA[0] * red + LUMA[1] * green + LUMA[2] * blue;
    // Both differences go from −0.5 to 0.5.
    let blue_difference = (blue - luma) / (2.0 * (1.0 - LUMA[2]));
    let red_difference = (red - luma) / (2.0 * (1.0 - LUMA[0]));
    let byte = |value: f32| value.round() as u8;
    [byte(16.0 + 219.0 * luma), byte(128.0 + 224.0 * blue_difference), byte(128.0 + 224.0 * red_difference)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_those_of_bt_709() {
        assert_eq!(yuv([0, 0, 0]), [16, 128, 128]);
        assert_eq!(yuv([255, 255, 255]), [235, 128, 128]);
        assert_eq!(yuv([255, 0, 0]), [63, 102, 240]);
        assert_eq!(yuv([0, 0, 255]), [32, 240, 118]);
        assert_eq!(yuv([128, 128, 128]), [126, 128, 128]);
    }

    #[test]
    fn a_frame_is_three_planes_without_alpha() {
        let bytes = frame((2, 1), &[255, 0, 0, 9, 255, 255, 255, 0]).expect("a frame");
        assert_eq!(bytes, [&b"FRAME\n"[..], &[63, 235, 102, 128, 240, 128]].concat());
        assert!(frame((2, 1), &[0; 4]).is_err());
    }

    #[test]
    fn the_header_is_short_and_has_the_rate_as_a_fraction() {
        let text = String::from_utf8(header((64, 36), 24.0)).expect("text");
        assert_eq!(text, "YUV4MPEG2 W64 H36 F24:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
        assert!(header((16384, 16384), 59.94).len() < 80);
        let rates = [23.976, 29.97, 59.94, 12.5, 0.5, 30.0, 1e-6].map(rate);
        assert_eq!(rates, [(24000, 1001), (30000, 1001), (60000, 1001), (25, 2), (1, 2), (30, 1), (1, 1000)]);
    }
}
