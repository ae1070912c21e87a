//! Fonts: outlines of letters, and how much of each pixel they cover.
//!
//! The built-in one is a part of DejaVu Sans (Latin, Greek and Cyrillic letters, signs), renamed as its licence asks;
//! `manypass_sans.LICENSE.txt` beside it.

use ab_glyph::{Font as _, FontVec, PxScale, ScaleFont as _};
use std::sync::{Arc, LazyLock};

pub use ab_glyph::GlyphId;

static BUILT_IN: LazyLock<Option<Arc<Font>>> = LazyLock::new(|| {
    let bytes = include_bytes!("manypass_sans.ttf").to_vec();
    Font::parse("the built-in font", bytes).ok().map(Arc::new)
});

/// The largest font file: 64 MiB, which is more than fonts of all of Unicode have.
const MAX_FONT_BYTES: usize = 64 << 20;

/// The largest side of a letter in pixels. Of fonts that are no fonts an outline may have any size.
const GLYPH_PX_MAX: f32 = 4096.0;

/// How many letters are looked at to find one that has an outline.
const LOOKED_AT: usize = 1000;

/// Letters of one shape.
#[derive(Debug)]
pub struct Font {
    name: String,
    font: FontVec,
    units_per_em: f32,
}

/// How much of each pixel a letter covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Where the left column is, in pixels from the pen.
    pub left_px: i32,
    /// Where the upper row is, in pixels from the baseline, downwards.
    pub top_px: i32,
    /// Its width in pixels.
    pub width: u32,
    /// Its height in pixels.
    pub height: u32,
    /// `width · height` shares of 255, rows from the top.
    pub data: Vec<u8>,
}

impl Font {
    /// The font that is there without a file: Latin, Greek and Cyrillic letters, signs of mathematics, arrows. None only
    /// if the program was built with another file in its place.
    pub fn built_in() -> Option<Arc<Self>> {
        BUILT_IN.clone()
    }

    /// The font of a TrueType or OpenType file; of a collection the first one.
    ///
    /// # Errors
    /// The file is too large, or no font.
    pub fn parse(name: &str, bytes: Vec<u8>) -> Result<Self, String> {
        if bytes.len() > MAX_FONT_BYTES {
            return Err(format!("`{name}` is larger than 64 MiB"));
        }
        let no_font = || format!("`{name}` is not a readable font; name a TrueType or OpenType file (.ttf, .otf)");
        let font = FontVec::try_from_vec(bytes).map_err(|_| no_font())?;
        let units_per_em = font.units_per_em().filter(|units| *units > 0.0).ok_or_else(no_font)?;
        if font.height_unscaled().is_nan() || font.height_unscaled() <= 0.0 {
            return Err(no_font());
        }
        let has_outline = |(glyph, _): (GlyphId, char)| font.outline(glyph).is_some();
        if !font.codepoint_ids().take(LOOKED_AT).any(has_outline) {
            return Err(format!("`{name}` has no outlines of letters; name a TrueType or OpenType file that has them"));
        }
        Ok(Self { name: name.into(), font, units_per_em })
    }

    /// Its name in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn scale(&self, size_px: f32) -> PxScale {
        PxScale::from(size_px * self.font.height_unscaled() / self.units_per_em)
    }

    /// The shape of a letter, if the font has it.
    pub fn glyph(&self, letter: char) -> Option<GlyphId> {
        Some(self.font.glyph_id(letter)).filter(|glyph| glyph.0 != 0)
    }

    /// How far the pen goes on after a letter, in pixels, at a size of the em.
    pub fn advance_px(&self, glyph: GlyphId, size_px: f32) -> f32 {
        let advance = self.font.as_scaled(self.scale(size_px)).h_advance(glyph);
        if advance.is_finite() { advance.clamp(0.0, GLYPH_PX_MAX) } else { 0.0 }
    }

    /// How much farther the pen goes on between two letters, in pixels.
    pub fn kern_px(&self, first: GlyphId, second: GlyphId, size_px: f32) -> f32 {
        let kern = self.font.as_scaled(self.scale(size_px)).kern(first, second);
        if kern.is_finite() { kern.clamp(-size_px, size_px) } else { 0.0 }
    }

    /// From the upper edge of a line to its baseline, in pixels.
    pub fn ascent_px(&self, size_px: f32) -> f32 {
        self.font.as_scaled(self.scale(size_px)).ascent().clamp(0.0, 4.0 * size_px)
    }

    /// From a line to the next, in pixels.
    pub fn line_height_px(&self, size_px: f32) -> f32 {
        let scaled = self.font.as_scaled(self.scale(size_px));
        (scaled.height() + scaled.line_gap()).clamp(0.5 * size_px, 4.0 * size_px)
    }

    /// How a letter covers pixels whose pen stands `offset_px` (0 to 1) right of a pixel's edge, on the edge of a row.
    /// None of what has no outline, such as a space, and of outlines larger than 4,096 pixels.
    pub fn coverage(&self, glyph: GlyphId, size_px: f32, offset_px: f32) -> Option<Coverage> {
        let placed = glyph.with_scale_and_position(self.scale(size_px), ab_glyph::point(offset_px, 0.0));
        let outline = self.font.outline_glyph(placed)?;
        let bounds = outline.px_bounds();
        let (width, height) = (bounds.width(), bounds.height());
        let is_drawn = |side: f32| (1.0..=GLYPH_PX_MAX).contains(&side);
        if !is_drawn(width) || !is_drawn(height) || bounds.min.x.abs().max(bounds.min.y.abs()) > 2.0 * GLYPH_PX_MAX {
            return None;
        }
        let (width, height) = (width as u32, height as u32);
        let mut data = vec![0; width as usize * height as usize];
        outline.draw(|x, y, share| {
            if let Some(texel) = data.get_mut((y * width + x) as usize).filter(|_| x < width) {
                *texel = (share.clamp(0.0, 1.0) * 255.0).round() as u8;
            }
        });
        Some(Coverage { left_px: bounds.min.x as i32, top_px: bounds.min.y as i32, width, height, data })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    #[test]
    fn the_built_in_font_has_letters_of_their_size() {
        let font = Font::built_in().unwrap();
        let glyph = font.glyph('H').unwrap();
        let coverage = font.coverage(glyph, 100.0, 0.0).unwrap();
        // An H of this font is 0.729 em high (its OS/2 table), and stands on the baseline.
        assert_eq!((coverage.top_px, coverage.height), (-73, 73));
        assert_eq!(coverage.data[(36 * coverage.width + coverage.width / 2) as usize], 255, "the bar is in the middle");
        assert_eq!(coverage.data[(10 * coverage.width + coverage.width / 2) as usize], 0);
        assert!(font.coverage(font.glyph(' ').unwrap(), 100.0, 0.0).is_none());
        for letter in "äßŁΩж°²→≤".chars() {
            assert!(font.glyph(letter).is_some(), "{letter}");
        }
        assert!(font.glyph('漢').is_none());
    }

    #[test]
    fn what_is_no_font_is_refused() {
        for bytes in [Vec::new(), b"no font".to_vec(), include_bytes!("manypass_sans.ttf")[..2000].to_vec()] {
            let error = Font::parse("a.ttf", bytes).unwrap_err();
            assert!(
                error.starts_with("`a.ttf` is not a readable font") || error.starts_with("`a.ttf` has no outlines"),
                "{error}"
            );
        }
    }
}
