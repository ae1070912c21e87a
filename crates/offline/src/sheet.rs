//! Contact sheets: small pictures in a grid, each with its name below.

use crate::encode::{EncodeError, check_length};
use font8x8::UnicodeFonts;
use image::{Rgba, RgbaImage, imageops};

/// The longest side of a small picture in pixels.
const CELL_PX: u32 = 320;
/// The space around pictures in pixels.
const MARGIN_PX: u32 = 8;
/// The height of a label in pixels: an 8-pixel font and a line of space on either side.
const LABEL_PX: u32 = 12;

/// A picture of the sheet.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// What stands below it.
    pub label: &'a str,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB with alpha, rows from the top.
    pub rgba8: &'a [u8],
}

/// The sheet as width, height and opaque RGBA bytes. Columns and rows are as equal in number as they can be.
///
/// # Errors
/// If an entry's bytes do not fit its size.
pub fn contact_sheet(entries: &[Entry<'_>]) -> Result<(u32, u32, Vec<u8>), EncodeError> {
    let columns = (entries.len() as f64).sqrt().ceil().max(1.0) as u32;
    let rows = (entries.len() as u32).div_ceil(columns).max(1);
    let mut pictures = Vec::with_capacity(entries.len());
    for entry in entries {
        check_length(entry.width, entry.height, 4, entry.rgba8.len())?;
        pictures.push(small(entry));
    }
    let cell_width = pictures.iter().map(RgbaImage::width).max().unwrap_or(1).max(64);
    let cell_height = pictures.iter().map(RgbaImage::height).max().unwrap_or(1);
    let (step_x, step_y) = (cell_width + MARGIN_PX, cell_height + LABEL_PX + MARGIN_PX);
    let mut sheet =
        RgbaImage::from_pixel(columns * step_x + MARGIN_PX, rows * step_y + MARGIN_PX, Rgba([32, 32, 32, 255]));
    for (index, (entry, picture)) in entries.iter().zip(&pictures).enumerate() {
        let x = MARGIN_PX + index as u32 % columns * step_x;
        let y = MARGIN_PX + index as u32 / columns * step_y;
        imageops::overlay(&mut sheet, picture, i64::from(x), i64::from(y));
        draw_label(&mut sheet, entry.label, x, y + cell_height + 2, cell_width);
    }
    Ok((sheet.width(), sheet.height(), sheet.into_raw()))
}

fn small(entry: &Entry<'_>) -> RgbaImage {
    let Some(image) = RgbaImage::from_raw(entry.width, entry.height, entry.rgba8.to_vec()) else {
        return RgbaImage::new(1, 1);
    };
    let longest = entry.width.max(entry.height);
    if longest <= CELL_PX {
        return image;
    }
    let scaled = |side: u32| (u64::from(side) * u64::from(CELL_PX) / u64::from(longest)).max(1) as u32;
    imageops::thumbnail(&image, scaled(entry.width), scaled(entry.height))
}

/// Draws as many letters as fit into `width_px`; a letter without a glyph becomes `?`.
fn draw_label(sheet: &mut RgbaImage, label: &str, x: u32, y: u32, width_px: u32) {
    for (column, letter) in label.chars().take((width_px / 8) as usize).enumerate() {
        let glyph = font8x8::BASIC_FONTS.get(letter).or_else(|| font8x8::BASIC_FONTS.get('?')).unwrap_or_default();
        for (row, bits) in glyph.iter().enumerate() {
            for bit in (0..8).filter(|bit| bits & (1 << bit) != 0) {
                let (px, py) = (x + column as u32 * 8 + bit, y + row as u32);
                if px < sheet.width() && py < sheet.height() {
                    sheet.put_pixel(px, py, Rgba([230, 230, 230, 255]));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_in_a_grid_with_labels() {
        let red = [255, 0, 0, 255].repeat(64 * 32);
        let entry = |label| Entry { label, width: 64, height: 32, rgba8: &red };
        let entries = [entry("geometry"), entry("lights"), entry("tonemap ☃")];
        let (width, height, pixels) = contact_sheet(&entries).expect("sheet");
        assert_eq!((width, height), (2 * 72 + 8, 2 * 52 + 8));
        let at = |x: u32, y: u32| pixels[(y * width + x) as usize * 4];
        assert_eq!((at(8, 8), at(80, 8), at(8, 60)), (255, 255, 255));
        let lit = |y0: u32| (y0..y0 + 8).any(|y| (8..72).any(|x| at(x, y) == 230));
        assert!(lit(42) && lit(94));
    }

    #[test]
    fn large_pictures_shrink_and_wrong_ones_are_errors() {
        let pixels = vec![9; 1000 * 10 * 4];
        let (width, _, _) =
            contact_sheet(&[Entry { label: "", width: 1000, height: 10, rgba8: &pixels }]).expect("sheet");
        assert_eq!(width, CELL_PX + 2 * MARGIN_PX);
        assert!(contact_sheet(&[Entry { label: "", width: 2, height: 1, rgba8: &pixels }]).is_err());
        assert!(contact_sheet(&[]).is_ok());
    }
}
