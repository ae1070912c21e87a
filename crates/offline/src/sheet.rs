//! Contact sheets: small pictures in a grid, each with its name and its legend below, and groups with a heading.

use crate::encode::{EncodeError, check_length};
use font8x8::UnicodeFonts;
use image::{Rgba, RgbaImage, imageops};
use manypass::LegendEntry;

/// The longest side of a sheet in pixels: more than that is no texture of every viewer.
const SIDE_MAX_PX: u32 = 8192;
/// The longest sides of small pictures in pixels: the first whose sheet is no longer than [`SIDE_MAX_PX`].
const CELLS_PX: [u32; 6] = [CELL_PX, 240, 192, 128, 96, 64];
const CELL_PX: u32 = 320;
/// Pictures of groups are drawn larger if they are smaller than this: each texel as a square.
const LEGIBLE_PX: u32 = 64;
/// The space around pictures in pixels.
const MARGIN_PX: u32 = 8;
/// The height of a line of a label in pixels: an 8-pixel font and a line of space on either side.
const LABEL_PX: u32 = 12;
/// The height of a heading above its pictures, with a line below it that is as long as its group.
const HEADING_PX: u32 = 16;
/// The colour of labels; of headings.
const LABEL_COLOR: [u8; 3] = [230; 3];
const HEADING_COLOR: [u8; 3] = [255, 190, 90];

/// A picture of the sheet.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// What stands below it.
    pub label: &'a str,
    /// What stands above it and its neighbours of the same group; without a group nothing.
    pub group: &'a str,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB with alpha, rows from the top.
    pub rgba8: &'a [u8],
    /// What its colours mean.
    pub legend: &'a [LegendEntry],
}

/// The group of the picture of a pass (`VIEW/PASS.STEP > TARGET`): its view and its pass.
pub fn group_of_pass(name: &str) -> &str {
    let pass = name.split(" > ").next().unwrap_or(name);
    let begin = pass.rfind('/').map_or(0, |slash| slash + 1);
    let end = pass.get(begin..).and_then(|of_view| of_view.find('.')).map_or(pass.len(), |dot| begin + dot);
    pass.get(..end).unwrap_or(pass)
}

/// The sheet as width, height and opaque RGBA bytes. Columns and rows are as equal in number as they can be; pictures
/// of a group stand together, where its first one is. No side is longer than 8192 pixels: pictures get smaller as they get
/// more, and of several thousand the last are left out, which the last line says.
///
/// # Errors
/// If an entry's bytes do not fit its size.
pub fn contact_sheet(entries: &[Entry<'_>]) -> Result<(u32, u32, Vec<u8>), EncodeError> {
    let entries = grouped(entries);
    draw(&entries, &Layout::fitting(&entries))
}

/// A sheet of `columns` columns, whose pictures have sides of at most `cell_px` pixels, as [`contact_sheet`], but of
/// any size, and in the order of the entries.
///
/// # Errors
/// If an entry's bytes do not fit its size.
pub fn contact_sheet_of(entries: &[Entry<'_>], columns: u32, cell_px: u32) -> Result<(u32, u32, Vec<u8>), EncodeError> {
    draw(entries, &Layout::new(entries, columns, cell_px))
}

/// The entries of each group together, in the order in which groups begin.
fn grouped<'a>(entries: &[Entry<'a>]) -> Vec<Entry<'a>> {
    let mut groups: Vec<&str> = Vec::new();
    let mut numbered: Vec<(usize, Entry<'a>)> = Vec::with_capacity(entries.len());
    for entry in entries {
        let known = groups.iter().position(|group| *group == entry.group);
        let number = known.unwrap_or_else(|| {
            groups.push(entry.group);
            groups.len() - 1
        });
        numbered.push((number, *entry));
    }
    numbered.sort_by_key(|(number, _)| *number);
    numbered.into_iter().map(|(_, entry)| entry).collect()
}

/// Where everything stands, in pixels.
struct Layout {
    width: u32,
    height: u32,
    cell_width: u32,
    /// Of each entry that is shown.
    cells: Vec<Cell>,
    /// What stands at the lower edge, if entries are left out.
    rest: Option<String>,
}

/// Where an entry stands.
struct Cell {
    x: u32,
    /// The top of its picture.
    y: u32,
    picture_px: (u32, u32),
    /// Its heading, and how long that and its line may be, if a group begins or goes on in a new row.
    heading: Option<(String, u32)>,
    label: Vec<String>,
    /// The top of its label.
    label_y: u32,
    /// The end of its row.
    end_y: u32,
}

impl Layout {
    /// The largest pictures in a sheet that is not too long.
    fn fitting(entries: &[Entry<'_>]) -> Self {
        let square = (entries.len() as f64).sqrt().ceil() as u32;
        for cell_px in CELLS_PX {
            let layout = Self::new(entries, square, cell_px);
            if layout.fits() {
                return layout;
            }
            // What is too high may have room beside it.
            let widest = (SIDE_MAX_PX - MARGIN_PX) / (layout.cell_width + MARGIN_PX);
            let layout = Self::new(entries, widest, cell_px);
            if widest > square && layout.fits() {
                return layout;
            }
        }
        let cell_px = CELLS_PX[CELLS_PX.len() - 1];
        let columns = (SIDE_MAX_PX - MARGIN_PX) / (Self::new(entries, 1, cell_px).cell_width + MARGIN_PX);
        Self::new(entries, columns, cell_px).cut()
    }

    /// Without the rows that make the sheet too high.
    fn cut(mut self) -> Self {
        let count = self.cells.len();
        let shown = self.cells.iter().take_while(|cell| cell.end_y + LABEL_PX <= SIDE_MAX_PX).count();
        self.cells.truncate(shown);
        self.height = self.cells.last().map_or(MARGIN_PX, |cell| cell.end_y) + LABEL_PX;
        self.rest = Some(format!("and {} more", count - shown));
        self
    }

    fn fits(&self) -> bool {
        self.width.max(self.height) <= SIDE_MAX_PX
    }

    fn new(entries: &[Entry<'_>], columns: u32, cell_px: u32) -> Self {
        let columns = columns.max(1) as usize;
        let pictures: Vec<(u32, u32)> = entries.iter().map(|entry| shown_size(entry, cell_px)).collect();
        // A letter of space keeps labels side by side apart.
        let words = |entry: &Entry<'_>| legend_width(entry.legend).max(text_width(entry.label) + 8);
        let widest_words = entries.iter().map(words).max().unwrap_or(0).min(cell_px);
        let widest = pictures.iter().map(|(width, _)| *width).max().unwrap_or(1);
        let cell_width = widest.max(64).max(widest_words);
        let step_x = cell_width + MARGIN_PX;
        let heading_px = if entries.iter().any(|entry| !entry.group.is_empty()) { HEADING_PX } else { 0 };
        let mut cells = Vec::with_capacity(entries.len());
        let mut top = MARGIN_PX;
        for (row, row_pictures) in entries.chunks(columns).zip(pictures.chunks(columns)) {
            // A row is as high as its highest picture, and its longest label and legend, want it.
            let highest = row_pictures.iter().map(|(_, height)| *height).max().unwrap_or(1);
            let y = top + heading_px;
            let labels: Vec<Vec<String>> = row.iter().map(|entry| label_lines(entry.label, cell_width)).collect();
            let lines = row.iter().zip(&labels);
            let lines = lines.map(|(entry, label)| label.len() as u32 + legend_lines(entry.legend, cell_width));
            let end_y = y + highest + lines.max().unwrap_or(0) * LABEL_PX + MARGIN_PX;
            for (column, ((entry, label), picture_px)) in row.iter().zip(labels).zip(row_pictures).enumerate() {
                let begins = column == 0 || row[column - 1].group != entry.group;
                let of_group = row[column..].iter().take_while(|other| other.group == entry.group).count() as u32;
                let heading = (begins && !entry.group.is_empty())
                    .then(|| (entry.group.to_owned(), of_group * step_x - MARGIN_PX));
                let x = MARGIN_PX + column as u32 * step_x;
                let label_y = y + highest + 2;
                cells.push(Cell { x, y, picture_px: *picture_px, heading, label, label_y, end_y });
            }
            top = end_y;
        }
        let height = top.max(2 * MARGIN_PX);
        // Without entries there is a column all the same.
        Self { width: columns as u32 * step_x + MARGIN_PX, height, cell_width, cells, rest: None }
    }
}

/// Draws the entries that have a place.
fn draw(entries: &[Entry<'_>], layout: &Layout) -> Result<(u32, u32, Vec<u8>), EncodeError> {
    let Layout { width, height, cell_width, cells, rest } = layout;
    let mut sheet = RgbaImage::from_pixel(*width, *height, Rgba([32, 32, 32, 255]));
    for (entry, cell) in entries.iter().zip(cells) {
        check_length(entry.width, entry.height, 4, entry.rgba8.len())?;
        imageops::overlay(&mut sheet, &small(entry, cell.picture_px), i64::from(cell.x), i64::from(cell.y));
        if let Some((heading, length)) = &cell.heading {
            let top = cell.y.saturating_sub(HEADING_PX);
            draw_text(&mut sheet, heading, (cell.x, top), *length, HEADING_COLOR);
            let [r, g, b] = HEADING_COLOR;
            let line = RgbaImage::from_pixel(*length, 1, Rgba([r, g, b, 255]));
            imageops::overlay(&mut sheet, &line, i64::from(cell.x), i64::from(top + 10));
        }
        let mut line_y = cell.label_y;
        for line in &cell.label {
            draw_label(&mut sheet, line, cell.x, line_y, *cell_width);
            line_y += LABEL_PX;
        }
        draw_legend(&mut sheet, entry.legend, cell.x, line_y, *cell_width);
    }
    if let Some(rest) = rest {
        draw_label(&mut sheet, rest, MARGIN_PX, height.saturating_sub(LABEL_PX), *width);
    }
    Ok((*width, *height, sheet.into_raw()))
}

/// The size in which a picture is shown, whose sides are at most `cell_px`.
fn shown_size(entry: &Entry<'_>, cell_px: u32) -> (u32, u32) {
    let longest = entry.width.max(entry.height).max(1);
    if longest <= cell_px {
        let times = if entry.group.is_empty() { 1 } else { (LEGIBLE_PX / longest).max(1) };
        return (entry.width * times, entry.height * times);
    }
    let scaled = |side: u32| (u64::from(side) * u64::from(cell_px) / u64::from(longest)).max(1) as u32;
    (scaled(entry.width), scaled(entry.height))
}

fn small(entry: &Entry<'_>, (width, height): (u32, u32)) -> RgbaImage {
    let Some(image) = RgbaImage::from_raw(entry.width, entry.height, entry.rgba8.to_vec()) else {
        return RgbaImage::new(1, 1);
    };
    if (width, height) == (entry.width, entry.height) {
        return image;
    }
    if width > entry.width {
        return imageops::resize(&image, width, height, imageops::FilterType::Nearest);
    }
    imageops::thumbnail(&image, width, height)
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

/// Draws as many letters of a label as fit into `width_px`.
fn draw_label(sheet: &mut RgbaImage, label: &str, x: u32, y: u32, width_px: u32) {
    draw_text(sheet, label, (x, y), width_px, LABEL_COLOR);
}

/// Draws as many letters as fit into `width_px`; a letter without a glyph becomes `?`.
fn draw_text(sheet: &mut RgbaImage, text: &str, (x, y): (u32, u32), width_px: u32, [r, g, b]: [u8; 3]) {
    for (column, letter) in text.chars().take((width_px / 8) as usize).enumerate() {
        let glyph = font8x8::BASIC_FONTS.get(letter).or_else(|| font8x8::BASIC_FONTS.get('?')).unwrap_or_default();
        for (row, bits) in glyph.iter().enumerate() {
            for bit in (0..8).filter(|bit| bits & (1 << bit) != 0) {
                let (px, py) = (x + column as u32 * 8 + bit, y + row as u32);
                if px < sheet.width() && py < sheet.height() {
                    sheet.put_pixel(px, py, Rgba([r, g, b, 255]));
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
        let entry = |label| Entry { label, group: "", width: 64, height: 32, rgba8: &red, legend: &[] };
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
            group: "",
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
        let entry = Entry { label: label.trim_end(), group: "", width: 16, height: 16, rgba8: &red, legend: &[] };
        // Two of its words do not fit into the 40 letters of the widest cell.
        assert_eq!(contact_sheet(&[entry]).map(|(w, h, _)| (w, h)).ok(), Some((320 + 16, 16 + 3 * 12 + 8 + 8)));
    }

    #[test]
    fn legends_stand_below_the_name_in_columns() {
        let black = [0, 0, 0, 255].repeat(64 * 32);
        let legend = [(1, "one"), (2, "two"), (3, "many")]
            .map(|(r, label)| LegendEntry { label: label.into(), color_srgb: [r, 90, 91] });
        let entry = |legend| Entry { label: "heat", group: "", width: 64, height: 32, rgba8: &black, legend };
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
            contact_sheet(&[Entry { label: "", group: "", width: 1000, height: 10, rgba8: &pixels, legend: &[] }])
                .expect("sheet");
        assert_eq!(width, CELL_PX + 2 * MARGIN_PX);
        assert!(
            contact_sheet(&[Entry { label: "", group: "", width: 2, height: 1, rgba8: &pixels, legend: &[] }]).is_err()
        );
        assert!(contact_sheet(&[]).is_ok());
    }

    /// Names as long as those of views within views.
    fn names(count: usize) -> Vec<String> {
        let pass = |index: usize| ["geometry.normal", "occlusion", "reflections.pyramid.mip3"][index % 3];
        (0..count).map(|index| format!("mirror/Mirror {}/{}.{index}", index / 24, pass(index))).collect()
    }

    fn wide<'a>(name: &'a str, rgba8: &'a [u8]) -> Entry<'a> {
        Entry { label: name, group: group_of_pass(name), width: 640, height: 360, rgba8, legend: &[] }
    }

    #[test]
    fn two_hundred_targets_have_a_legible_sheet() {
        let names = names(200);
        let entries = grouped(&names.iter().map(|name| wide(name, &[])).collect::<Vec<_>>());
        let layout = Layout::fitting(&entries);
        assert!(layout.fits() && layout.rest.is_none() && layout.cells.len() == 200);
        for (entry, cell) in entries.iter().zip(&layout.cells) {
            assert!(cell.picture_px.0 >= 128, "{} is {:?}", entry.label, cell.picture_px);
            // The whole name stands below the picture, within its cell and the sheet.
            assert_eq!(cell.label.concat().replace(' ', ""), entry.label.replace(' ', ""));
            let widest = cell.label.iter().map(|line| text_width(line)).max().unwrap_or(0);
            assert!(widest <= layout.cell_width && cell.x + layout.cell_width <= layout.width);
            assert!(cell.label_y + cell.label.len() as u32 * LABEL_PX <= layout.height);
        }
        // Nothing lies over anything else, and each group begins under its heading.
        for (i, a) in layout.cells.iter().enumerate() {
            for b in &layout.cells[..i] {
                let end_y = b.label_y + b.label.len() as u32 * LABEL_PX;
                assert!(a.x >= b.x + layout.cell_width || b.x >= a.x + layout.cell_width || a.y >= end_y + HEADING_PX);
            }
            let begins = i == 0 || entries[i - 1].group != entries[i].group;
            assert!(!begins || a.heading.as_ref().is_some_and(|(heading, _)| heading == entries[i].group));
        }
        let headings: Vec<&str> = entries.iter().map(|entry| entry.group).collect();
        let begun = (1..200).filter(|at| headings[*at] != headings[at - 1]).count() + 1;
        assert_eq!(begun, 27, "9 views of 3 passes, each in one place");
    }

    #[test]
    fn no_sheet_is_too_long() {
        for count in [1, 1000, 3000, 10_000] {
            let names = names(count);
            let entries: Vec<Entry<'_>> = names.iter().map(|name| wide(name, &[])).collect();
            let layout = Layout::fitting(&entries);
            assert!(layout.fits(), "{count}: {} x {}", layout.width, layout.height);
            let shown = layout.cells.len();
            assert!(shown == count || count > 3000 && layout.rest == Some(format!("and {} more", count - shown)));
        }
    }

    #[test]
    fn passes_are_groups() {
        for (name, group) in [
            ("occlusion.blur", "occlusion"),
            ("direct > radiance", "direct"),
            ("reflections.pyramid.0 > reflections.pyramid.mip0", "reflections"),
            ("mirror/Mr. X/geometry.normal", "mirror/Mr. X/geometry"),
            ("", ""),
        ] {
            assert_eq!(group_of_pass(name), group);
        }
    }

    #[test]
    fn headings_stand_above_and_small_pictures_are_enlarged() {
        let red = [255, 0, 0, 255].repeat(2);
        let entry = |label, group| Entry { label, group, width: 2, height: 1, rgba8: &red, legend: &[] };
        let (width, height, pixels) =
            contact_sheet(&[entry("a.x", "a"), entry("b", "b"), entry("a.y", "a")]).expect("sheet");
        assert_eq!((width, height), (2 * 72 + 8, 2 * (16 + 32 + 12 + 8) + 8));
        let at = |x: u32, y: u32| pixels[(y * width + x) as usize * 4..][..3].to_vec();
        // The line below the heading spans both pictures of the first group; the third is of the other.
        assert!(at(8, 18) == HEADING_COLOR && at(8 + 72 + 63, 18) == HEADING_COLOR && at(8 + 64 + 72, 18) == [32; 3]);
        assert!(at(8, 24) == [255, 0, 0] && at(8 + 63, 24 + 31) == [255, 0, 0]);
        assert!(at(8, 8 + 68 + 10) == HEADING_COLOR && at(8 + 72, 8 + 68 + 10) == [32; 3]);
    }
}
