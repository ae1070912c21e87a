//! The size of a picture, as `--size` has it.

use crate::failure::Failure;

/// The longest side of a picture in pixels: the largest texture that common adapters offer.
pub const LARGEST_SIDE_PX: u32 = 16384;

/// `WxH`, with a small or large letter or the sign of multiplication.
///
/// # Errors
/// It is no size, or too large a one.
pub fn parse(text: &str) -> Result<(u32, u32), Failure> {
    let parsed = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match parsed {
        Some((w, h)) if (1..=LARGEST_SIDE_PX).contains(&w) && (1..=LARGEST_SIDE_PX).contains(&h) => Ok((w, h)),
        _ => Err(Failure::usage(
            format!("`{text}` is not a size"),
            format!("write --size WIDTHxHEIGHT, each from 1 to {LARGEST_SIDE_PX}"),
        )),
    }
}
