//! Stands in for fonts where the feature `text` is off: there are none.

use std::sync::Arc;

/// Letters of one shape. There are none without the feature `text`.
#[derive(Debug)]
pub enum Font {}

/// The shape of a letter in a font.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct GlyphId(pub u16);

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
    /// None.
    pub const fn built_in() -> Option<Arc<Self>> {
        None
    }

    /// Refuses every file.
    ///
    /// # Errors
    /// Always.
    pub fn parse(name: &str, _bytes: Vec<u8>) -> Result<Self, String> {
        Err(format!("`{name}` cannot be read: this program was built without the feature `text`"))
    }

    /// Its name in messages.
    pub const fn name(&self) -> &str {
        match *self {}
    }

    /// The shape of a letter.
    pub const fn glyph(&self, _letter: char) -> Option<GlyphId> {
        match *self {}
    }

    /// How far the pen goes on after a letter.
    pub const fn advance_px(&self, _glyph: GlyphId, _size_px: f32) -> f32 {
        match *self {}
    }

    /// How much farther the pen goes on between two letters.
    pub const fn kern_px(&self, _first: GlyphId, _second: GlyphId, _size_px: f32) -> f32 {
        match *self {}
    }

    /// From the upper edge of a line to its baseline.
    pub const fn ascent_px(&self, _size_px: f32) -> f32 {
        match *self {}
    }

    /// From a line to the next.
    pub const fn line_height_px(&self, _size_px: f32) -> f32 {
        match *self {}
    }

    /// How a letter covers pixels.
    pub const fn coverage(&self, _glyph: GlyphId, _size_px: f32, _offset_px: f32) -> Option<Coverage> {
        match *self {}
    }
}
