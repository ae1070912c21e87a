//! Contact sheets: small pictures in a grid, each with its name and its legend below.

use crate::encode::{EncodeError, check_length};
use font8x8::UnicodeFonts;
use image::{Rgba, RgbaImage, imageops};
use manypass::LegendEntry;

/// The longest side of a small picture in pixels.
const CELL_PX: u32 = 320;
/// The space around pictures in pixels.
const MARGIN_PX: u32 = 8;
/// The height of a line of a label in pixels: an 8-pixel font and a line of space on either side.
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
    /// What its colours mean.
    pub legend: &'a [LegendEntry],
}

/// The sheet as width, height and opaque RGBA bytes. Columns and rows are as equal in number as they can be.
///
/// # Errors
/// If an entry's bytes do not fit its size.
pub fn contact_sheet(entries: &[Entry<'_>]) -> Result<(u32, u32, Vec<u8>), EncodeError> {
    let columns = (entries.len() as f64).sqrt().ceil() as u32;
    contact_sheet_of(entries, columns, CELL_PX)
}

/// A sheet of `columns` columns, whose pictures have sides of at most `cell_px` pixels, as [`contact_sheet`].
///
/// # Errors
/// If an entry's bytes do not fit its size.
pub fn contact_sheet_of(entries: &[Entry<'_>], columns: u32, cell_px: u32) -> Result<(u32, u32, Vec<u8>), EncodeError> {
    let columns = columns.max(1);
    let mut pictures = Vec::with_capacity(entries.len());
    for entry in entries {
        check_length(entry.width, entry.height, 4, entry.rgba8.len())?;
        pictures.push(small(entry, cell_px));
    }
    // A letter of space keeps labels side by side apart.
    let words = |entry: &Entry<'_>| legend_width(entry.legend).max(text_width(entry.label) + 8);
    let widest_words = entries.iter().map(words).max().unwrap_or(0).min(cell_px);
    let cell_width = pictures.iter().map(RgbaImage::width).max().unwrap_or(1).max(64).max(widest_words);
    let labels: Vec<Vec<String>> = entries.iter().map(|entry| label_lines(entry.label, cell_width)).collect();
    // A row is as high as its highest picture, and its longest label and legend, want it.
    let highest = |row: &[RgbaImage]| row.iter().map(RgbaImage::height).max().unwrap_or(1);
    let heights: Vec<u32> = pictures.chunks(columns as usize).map(highest).collect();
    let rows_px: Vec<u32> = entries
        .chunks(columns as usize)
        .zip(labels.chunks(columns as usize))
        .zip(&heights)
        .map(|((row, labels), height)| {
            let lines = row.iter().zip(labels);
            let lines = lines.map(|(entry, label)| label.len() as u32 + legend_lines(entry.legend, cell_width));
            height + lines.max().unwrap_or(0) * LABEL_PX + MARGIN_PX
        })
        .collect();
    let (step_x, height) = (cell_width + MARGIN_PX, rows_px.iter().sum::<u32>().max(MARGIN_PX));
    let mut sheet = RgbaImage::from_pixel(columns * step_x + MARGIN_PX, height + MARGIN_PX, Rgba([32, 32, 32, 255]));
    for (index, ((entry, picture), label)) in entries.iter().zip(&pictures).zip(&labels).enumerate() {
        let (x, row) = (MARGIN_PX + index as u32 % columns * step_x, index / columns as usize);
        let y = MARGIN_PX + rows_px.iter().take(row).sum::<u32>();
        imageops::overlay(&mut sheet, picture, i64::from(x), i64::from(y));
        let mut line_y = y + heights[row] + 2;
        for line in label {
            draw_label(&mut sheet, line, x, line_y, cell_width);
            line_y += LABEL_PX;
        }
        draw_legend(&mut sheet, entry.legend, x, line_y, cell_width);
    }
    Ok((sheet.width(), sheet.height(), sheet.into_raw()))
}

fn small(entry: &Entry<'_>, cell_px: u32) -> RgbaImage {
    let Some(image) = RgbaImage::from_raw(entry.width, entry.height, entry.rgba8.to_vec()) else {
        return RgbaImage::new(1, 1);
    };
    let longest = entry.width.max(entry.height);
    if longest <= cell_px {
        return image;
    }
    let scaled = |side: u32| (u64::from(side) * u64::from(cell_px) / u64::from(longest)).max(1) as u32;
    imageops::thumbnail(&image, scaled(entry.width), scaled(entry.height))
}

/// The width of a line of text, in pixels.
fn text_width(text: &str) -> u32 {
    8 * text.chars().count() as u32
}

/// The lines of a label that is `width_px` wide at most: broken at spaces, and within words that are longer alone. At
/// least one.
fn label_lines(label: &str, width_px: u32) -> Vec<String> {
    let letters = (width_px / 8).max(1) as usize;
    let mut lines = vec![String::new()];
    for word in label.split(' ') {
        let word: Vec<char> = word.chars().collect();
        for (index, piece) in word.chunks(letters).enumerate() {
            let Some(line) = lines.last_mut() else { continue };
            let length = line.chars().count();
            if length > 0 && (index > 0 || length + 1 + piece.len() > letters) {
                lines.push(piece.iter().collect());
            } else {
                if length > 0 {
                    line.push(' ');
                }
                line.extend(piece);
            }
        }
    }
    lines
}

/// The side of a legend's squares of colour, and how far from them its words begin, in pixels.
const SQUARE_PX: u32 = 8;
const WORDS_PX: u32 = 12;

/// The width of the widest entry of a legend, in pixels.
fn legend_width(legend: &[LegendEntry]) -> u32 {
    legend.iter().map(|entry| WORDS_PX + text_width(&entry.label)).max().unwrap_or(0)
}

/// How many lines a legend takes.
fn legend_lines(legend: &[LegendEntry], width_px: u32) -> u32 {
    // Columns are two letters apart.
    let columns = ((width_px + 16) / (legend_width(legend) + 16)).max(1);
    (legend.len() as u32).div_ceil(columns)
}

/// Draws the entries in columns, from top to bottom.
fn draw_legend(sheet: &mut RgbaImage, legend: &[LegendEntry], x: u32, y: u32, width_px: u32) {
    let (lines, column_px) = (legend_lines(legend, width_px).max(1), legend_width(legend) + 16);
    for (index, entry) in legend.iter().enumerate() {
        let (left, top) = (x + index as u32 / lines * column_px, y + index as u32 % lines * LABEL_PX);
        let [r, g, b] = entry.color_srgb;
        let square = RgbaImage::from_pixel(SQUARE_PX, SQUARE_PX, Rgba([r, g, b, 255]));
        imageops::overlay(sheet, &square, i64::from(left), i64::from(top));
        draw_label(sheet, &entry.label, left + WORDS_PX, top, (x + width_px).saturating_sub(left + WORDS_PX));
    }
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
        let entry = |label| Entry { label, width: 64, height: 32, rgba8: &red, legend: &[] };
        let entries = [entry("geometry"), entry("lights"), entry("tonemap ☃")];
        let (width, height, pixels) = contact_sheet(&entries).expect("sheet");
        // The longest label has nine letters.
        assert_eq!((width, height), (2 * 88 + 8, 2 * 52 + 8));
        let at = |x: u32, y: u32| pixels[(y * width + x) as usize * 4];
        assert_eq!((at(8, 8), at(96, 8), at(8, 60)), (255, 255, 255));
        let lit = |x0: u32, y0: u32| (y0..y0 + 8).any(|y| (x0..x0 + 8).any(|x| at(x, y) == 230));
        assert!(lit(8, 42) && lit(8, 94) && lit(8 + 8 * 8, 94));
    }

    #[test]
    fn rows_are_as_high_as_their_pictures() {
        let black = [0, 0, 0, 255].repeat(64 * 32);
        let entry = |height: u32| Entry {
            label: "a",
            width: 64,
            height,
            rgba8: &black[..64 * 4 * height as usize],
            legend: &[],
        };
        let (_, height, _) = contact_sheet_of(&[entry(32), entry(4), entry(8)], 2, CELL_PX).expect("sheet");
        assert_eq!(height, (32 + 12 + 8) + (8 + 12 + 8) + 8);
    }

    #[test]
    fn long_labels_widen_cells_and_then_break() {
        assert_eq!(label_lines("a.b > c", 64), ["a.b > c"]);
        assert_eq!(label_lines("debug.opaque > drawn", 96), ["debug.opaque", "> drawn"]);
        assert_eq!(label_lines("abcdefghij k", 64), ["abcdefgh", "ij k"]);
        assert_eq!(label_lines("", 64), [""]);
        let label = "effect.of.a.long.name > ".repeat(3);
        let red = [255, 0, 0, 255].repeat(16 * 16);
        let entry = Entry { label: label.trim_end(), width: 16, height: 16, rgba8: &red, legend: &[] };
        // Two of its words do not fit into the 40 letters of the widest cell.
        assert_eq!(contact_sheet(&[entry]).map(|(w, h, _)| (w, h)).ok(), Some((320 + 16, 16 + 3 * 12 + 8 + 8)));
    }

    #[test]
    fn legends_stand_below_the_name_in_columns() {
        let black = [0, 0, 0, 255].repeat(64 * 32);
        let legend = [(1, "one"), (2, "two"), (3, "many")]
            .map(|(r, label)| LegendEntry { label: label.into(), color_srgb: [r, 90, 91] });
        let entry = |legend| Entry { label: "heat", width: 64, height: 32, rgba8: &black, legend };
        let (width, height, pixels) = contact_sheet(&[entry(&legend[..]), entry(&[])]).expect("sheet");
        // Words of four letters take 44 pixels, so that there is one column, of three lines.
        assert_eq!((width, height), (2 * 72 + 8, 32 + 4 * 12 + 8 + 8));
        let at = |x: u32, y: u32| pixels[(y * width + x) as usize * 4..][..3].to_vec();
        for (line, r) in [1, 2, 3].into_iter().enumerate() {
            let y = 8 + 32 + 2 + 12 + 12 * line as u32;
            assert!(at(8, y) == [r, 90, 91] && at(15, y + 7) == [r, 90, 91] && at(16, y) == [32; 3]);
            assert!((20..72).any(|x| (y..y + 8).any(|y| at(x, y) == [230; 3])), "line {line} has words");
        }
        let (width, height, _) =
            contact_sheet(&[Entry { width: 128, height: 16, ..entry(&legend[..]) }]).expect("sheet");
        assert_eq!((width, height), (128 + 16, 16 + 3 * 12 + 8 + 8), "two columns");
    }

    #[test]
    fn large_pictures_shrink_and_wrong_ones_are_errors() {
        let pixels = vec![9; 1000 * 10 * 4];
        let (width, _, _) =
            contact_sheet(&[Entry { label: "", width: 1000, height: 10, rgba8: &pixels, legend: &[] }]).expect("sheet");
        assert_eq!(width, CELL_PX + 2 * MARGIN_PX);
        assert!(contact_sheet(&[Entry { label: "", width: 2, height: 1, rgba8: &pixels, legend: &[] }]).is_err());
        assert!(contact_sheet(&[]).is_ok());
    }
}
