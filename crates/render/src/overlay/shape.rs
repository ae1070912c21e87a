//! Items as rectangles, before it is known where they go.

use super::OverlayError;
use super::atlas::{Atlas, PEN_STEPS, WHITE};
use glam::Vec2;
use manypass_scene::overlay::{Font, OverlayItem, OverlayShape, OverlayText, TextAlign};
use std::sync::Arc;

/// Columns of a tab, in spaces.
const TAB_SPACES: f32 = 4.0;

/// Width and height of the box for a letter that the font has not, and the room that it takes, in parts of the em.
const BOX_EM: [f32; 2] = [0.5, 0.72];
const BOX_ADVANCE_EM: f32 = 0.62;

/// An item.
#[derive(Debug)]
pub(super) enum Shape {
    /// Rectangles within one of `size_px`.
    Pieces { size_px: Vec2, pieces: Vec<Piece>, is_whole: bool },
    /// A line, whose parts depend on where its points are.
    Line,
    /// What a monitor shows, whose size the scene knows.
    Monitor,
}

/// A rectangle of an item.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// From the item's upper left corner, in pixels.
    pub corner_px: Vec2,
    pub size_px: Vec2,
    image: usize,
    /// Corner and size in the atlas.
    pub texels: [f32; 4],
    /// Whether it has the colour of the box behind a text.
    pub is_background: bool,
    /// By how much it is turned around its middle, clockwise.
    pub rotation_rad: f32,
}

impl Piece {
    /// That of a monitor's picture with so many texels, turned clockwise.
    pub fn of_monitor(size_px: Vec2, (width, height): (u32, u32), rotation_deg: f32) -> Self {
        let texels = [0.0, 0.0, width as f32, height as f32];
        let rotation_rad = (rotation_deg % 360.0).to_radians();
        Self { texels, rotation_rad, ..Self::plain(Vec2::ZERO, size_px) }
    }

    fn plain(corner_px: Vec2, size_px: Vec2) -> Self {
        Self { corner_px, size_px, image: WHITE, texels: [0.0; 4], is_background: false, rotation_rad: 0.0 }
    }
}

impl Shape {
    /// That of an item that was checked. Letters and images go into `atlas`.
    pub fn new(item: &OverlayItem, atlas: &mut Atlas) -> Result<Self, OverlayError> {
        Ok(match &item.shape {
            OverlayShape::Line(_) => Self::Line,
            OverlayShape::Monitor(_) => Self::Monitor,
            OverlayShape::Sprite(sprite) => {
                let size_px = sprite.drawn_size_px();
                let image = atlas.sprite(&sprite.pixels, size_px.to_array());
                let rotation_rad = (sprite.rotation_deg % 360.0).to_radians();
                let piece = Piece { image, rotation_rad, ..Piece::plain(Vec2::ZERO, size_px) };
                Self::Pieces { size_px, pieces: vec![piece], is_whole: rotation_rad == 0.0 }
            }
            OverlayShape::Text(text) => {
                let font = text.font.clone().or_else(Font::built_in).ok_or(OverlayError::NoFont)?;
                set(text, &font, atlas)
            }
        })
    }

    pub fn piece_count(&self) -> usize {
        match self {
            Self::Pieces { pieces, .. } => pieces.len(),
            Self::Monitor => 1,
            Self::Line => 0,
        }
    }

    /// Tells rectangles where their images are in the atlas.
    pub fn place(&mut self, places: &[[f32; 4]]) {
        let Self::Pieces { pieces, .. } = self else { return };
        for piece in pieces {
            piece.texels = places.get(piece.image).copied().unwrap_or_default();
        }
    }
}

/// Sets a text: its lines, and the box behind it.
fn set(text: &OverlayText, font: &Arc<Font>, atlas: &mut Atlas) -> Shape {
    let line_px = font.line_height_px(text.size_px).round().max(1.0);
    let ascent_px = font.ascent_px(text.size_px).round();
    let lines: Vec<(Vec<Letter>, f32)> = text.text.split('\n').map(|line| letters(line, text.size_px, font)).collect();
    let width_px = lines.iter().map(|(_, width_px)| *width_px).fold(0.0, f32::max).ceil();
    let padding = Vec2::splat(text.padding_px.round());
    let size_px = Vec2::new(width_px, line_px * lines.len() as f32) + 2.0 * padding;
    let mut pieces = Vec::new();
    if text.background.is_some() {
        pieces.push(Piece { is_background: true, ..Piece::plain(Vec2::ZERO, size_px) });
    }
    for (number, (line, line_width_px)) in lines.iter().enumerate() {
        let share = match text.align {
            TextAlign::Left => 0.0,
            TextAlign::Center => 0.5,
            TextAlign::Right => 1.0,
        };
        let start = padding + Vec2::new((width_px - line_width_px) * share, ascent_px + line_px * number as f32);
        for letter in line {
            let steps = ((start.x + letter.pen_px) * PEN_STEPS as f32).round();
            let (whole_px, step) = ((steps / PEN_STEPS as f32).floor(), steps.rem_euclid(PEN_STEPS as f32) as u32);
            let pen = Vec2::new(whole_px, start.y);
            let Some(glyph) = letter.glyph else {
                pieces.extend(missing(pen, text.size_px));
                continue;
            };
            let Some(glyph) = atlas.glyph(font, glyph, text.size_px, step) else { continue };
            let [corner, size] =
                [glyph.corner_px.map(|px| px as f32), glyph.size_px.map(|px| px as f32)].map(Vec2::from_array);
            pieces.push(Piece { image: glyph.image, ..Piece::plain(pen + corner, size) });
        }
    }
    Shape::Pieces { size_px, pieces, is_whole: true }
}

/// A letter of a line: where the pen stands, and what it draws; none is a letter that the font has not.
struct Letter {
    pen_px: f32,
    glyph: Option<manypass_scene::overlay::GlyphId>,
}

/// The letters of a line, and its width.
fn letters(line: &str, size_px: f32, font: &Font) -> (Vec<Letter>, f32) {
    let (mut letters, mut pen_px, mut before) = (Vec::new(), 0.0, None);
    for letter in line.chars() {
        let glyph = font.glyph(letter);
        if letter == '\t' {
            let space_px = font.glyph(' ').map_or(0.25 * size_px, |space| font.advance_px(space, size_px));
            let tab_px = (TAB_SPACES * space_px).max(1.0);
            (pen_px, before) = (((pen_px / tab_px).floor() + 1.0) * tab_px, None);
            continue;
        }
        if let (Some(before), Some(glyph)) = (before, glyph) {
            pen_px += font.kern_px(before, glyph, size_px);
        }
        letters.push(Letter { pen_px, glyph });
        pen_px += glyph.map_or(BOX_ADVANCE_EM * size_px, |glyph| font.advance_px(glyph, size_px));
        before = glyph;
    }
    (letters, pen_px)
}

/// The sides of a box on the baseline, for a letter that the font has not.
fn missing(pen: Vec2, size_px: f32) -> [Piece; 4] {
    let size = (Vec2::from_array(BOX_EM) * size_px).round().max(Vec2::splat(2.0));
    let side_px = (size_px / 16.0).round().max(1.0);
    let corner = pen - Vec2::new(-side_px, size.y);
    let (across, down) = (Vec2::new(size.x, side_px), Vec2::new(side_px, (size.y - 2.0 * side_px).max(0.0)));
    [
        Piece::plain(corner, across),
        Piece::plain(corner + Vec2::new(0.0, size.y - side_px), across),
        Piece::plain(corner + Vec2::new(0.0, side_px), down),
        Piece::plain(corner + Vec2::new(size.x - side_px, side_px), down),
    ]
}
