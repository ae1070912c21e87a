//! What is drawn over the finished picture: text, lines and sprites, at places of the picture or of the world.
//!
//! It is no part of the scene's light: colours are those of the display, whatever curve and exposure. Items are drawn in
//! the order in which they stand. [`OverlayItem::check`] says what cannot be drawn.
//!
//! ```
//! # use manypass_scene::overlay::{Anchor, Overlay, OverlayItem, OverlayPlace};
//! # use manypass_scene::Scene;
//! # use glam::Vec2;
//! # let mut scene = Scene::default();
//! let title = OverlayItem::text("Helmet, 12 July", OverlayPlace::anchored(Anchor::Bottom, Vec2::new(0.0, -12.0)));
//! scene.overlay = Overlay { items: vec![OverlayItem { opacity: 0.8, ..title }] }.into();
//! ```

mod check;
mod fault;
#[cfg(feature = "text")]
mod font;
#[cfg(not(feature = "text"))]
#[path = "overlay/font_absent.rs"]
mod font;

pub use fault::OverlayFault;
pub(crate) use fault::{SIDE_PX_MAX, TEXT_SIZE_PX_MAX};
pub use font::{Coverage, Font, GlyphId};

use crate::Pixels;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// The most items of an overlay that are monitors.
pub const OVERLAY_MONITORS_MAX: usize = 64;

/// The overlay: text, sprites, monitors and lines over a picture.
#[derive(Clone, Debug, Default)]
pub struct Overlay {
    /// In the order in which they are drawn.
    pub items: Vec<OverlayItem>,
}

impl Overlay {
    /// Moves what is at points of world space, in metres; places of the picture and of nodes stay.
    pub fn move_by(&mut self, by_m: Vec3) {
        for item in &mut self.items {
            if let PlaceOf::World(position_world) = &mut item.place.of {
                *position_world += by_m;
            }
            if let OverlayShape::Line(OverlayLine { points: LinePoints::World(points_world), .. }) = &mut item.shape {
                points_world.iter_mut().for_each(|point_world| *point_world += by_m);
            }
        }
    }
}

/// An item of the overlay.
#[derive(Clone, Debug)]
pub struct OverlayItem {
    /// What it is.
    pub shape: OverlayShape,
    /// Where it is.
    pub place: OverlayPlace,
    /// Its colour in linear Rec. 709, of which what is above 1 counts as 1; sprites are multiplied by it, in display
    /// colours.
    pub color_linear: Vec3,
    /// What its coverage is multiplied by, 0 to 1.
    pub opacity: f32,
    /// Whether opaque surfaces hide what of it lies behind them. It has to be at a place of the world.
    pub depth_test: bool,
    /// By how many metres it counts as nearer to the eye than it is where depth is compared.
    pub depth_offset_m: f32,
}

/// What an item of an overlay is.
#[derive(Clone, Debug)]
pub enum OverlayShape {
    /// Letters.
    Text(OverlayText),
    /// A line through points.
    Line(OverlayLine),
    /// An image.
    Sprite(OverlaySprite),
    /// What a monitor of the scene shows: picture in picture.
    Monitor(OverlayMonitor),
}

/// Text of one or several lines. Letters stand side by side from left to right; there are no ligatures, and no letters
/// whose shape depends on their neighbours'.
#[derive(Clone, Debug)]
pub struct OverlayText {
    /// The text, whose lines end in `\n`. A letter that the font has not is a box.
    pub text: String,
    /// The font's size (its em) in pixels.
    pub size_px: f32,
    /// Where lines shorter than the longest stand.
    pub align: TextAlign,
    /// The font; none is [`Font::built_in`].
    pub font: Option<Arc<Font>>,
    /// The colour in linear Rec. 709 and the opacity of a box behind the text, if there is one.
    pub background: Option<(Vec3, f32)>,
    /// By how many pixels the box is larger than the text, on every side. They count to the text's size.
    pub padding_px: f32,
}

/// A line through two points or more, with mitred corners and square ends at the points. Coordinates are pixels from the
/// upper left corner of the picture, so that the middle of the first pixel is at (0.5, 0.5).
#[derive(Clone, Debug)]
pub struct OverlayLine {
    /// The points.
    pub points: LinePoints,
    /// Its width in pixels.
    pub width_px: f32,
}

/// The points of a line.
#[derive(Clone, Debug)]
pub enum LinePoints {
    /// In pixels, from the item's place; of one that has none (place [`PlaceOf::Picture`] without an anchor) from the
    /// upper left corner, and those below 0 from the right or the lower edge.
    Pixels(Vec<Vec2>),
    /// In world space, in metres. The item's place means nothing.
    World(Vec<Vec3>),
}

/// An image.
#[derive(Clone, Debug)]
pub struct OverlaySprite {
    /// Its texels, sRGB with unassociated alpha.
    pub pixels: Arc<Pixels>,
    /// Width and height in pixels; of none the image's, of one alone the other follows from the image's shape.
    pub size_px: [Option<f32>; 2],
    /// By how many degrees it is turned clockwise around its middle.
    pub rotation_deg: f32,
}

/// What a monitor of the scene shows ([`crate::capture::Monitor`]).
#[derive(Clone, Debug)]
pub struct OverlayMonitor {
    /// The name of its image, of which the first counts.
    pub name: String,
    /// Width and height in pixels; of none the monitor's, of one alone the other follows from its shape.
    pub size_px: [Option<f32>; 2],
    /// By how many degrees it is turned clockwise around its middle.
    pub rotation_deg: f32,
}

/// Where lines of a text stand within it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextAlign {
    /// At the left.
    #[default]
    Left,
    /// In the middle.
    Center,
    /// At the right.
    Right,
}

/// Where an item is.
#[derive(Clone, Debug)]
pub struct OverlayPlace {
    /// What it is told from.
    pub of: PlaceOf,
    /// Pixels from there, to the right and down.
    pub offset_px: Vec2,
    /// The point of the item that lies there. In the picture also the point of the picture that offsets are told from:
    /// without one that is the upper left corner, or the right or the lower edge where the offset is below 0. In the
    /// world without one it is the middle.
    pub anchor: Option<Anchor>,
}

/// What places are told from.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceOf {
    /// The picture.
    Picture,
    /// A point in world space, in metres, as the camera sees it.
    World(Vec3),
    /// The origin of the first node of that name, as the camera sees it.
    Node(String),
}

/// A point of a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The upper left corner.
    TopLeft,
    /// The middle of the upper edge.
    Top,
    /// The upper right corner.
    TopRight,
    /// The middle of the left edge.
    Left,
    /// The middle.
    Center,
    /// The middle of the right edge.
    Right,
    /// The lower left corner.
    BottomLeft,
    /// The middle of the lower edge.
    Bottom,
    /// The lower right corner.
    BottomRight,
}

impl Anchor {
    /// Their names, in the order of [`Self::ALL`].
    pub const NAMES: &[&str] =
        &["top-left", "top", "top-right", "left", "center", "right", "bottom-left", "bottom", "bottom-right"];
    /// All of them, row by row.
    pub const ALL: [Self; 9] = [
        Self::TopLeft,
        Self::Top,
        Self::TopRight,
        Self::Left,
        Self::Center,
        Self::Right,
        Self::BottomLeft,
        Self::Bottom,
        Self::BottomRight,
    ];

    /// The anchor of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().zip(Self::ALL).find(|(known, _)| **known == name).map(|(_, anchor)| anchor)
    }

    /// Its place in a rectangle whose width and height are 1, from the upper left corner.
    pub fn share(self) -> Vec2 {
        let index = self as u8;
        Vec2::new(f32::from(index % 3), f32::from(index / 3)) * 0.5
    }
}

impl TextAlign {
    /// Their names.
    pub const NAMES: &[&str] = &["left", "center", "right"];

    /// The alignment of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES
            .iter()
            .zip([Self::Left, Self::Center, Self::Right])
            .find(|(known, _)| **known == name)
            .map(|(_, align)| align)
    }
}

impl OverlayPlace {
    /// Pixels of the picture from its upper left corner; below 0 from its right or its lower edge, where the item's
    /// right or lower edge is then.
    pub fn at_px(offset_px: Vec2) -> Self {
        Self { of: PlaceOf::Picture, offset_px, anchor: None }
    }

    /// Pixels from a point of the picture, where the same point of the item is.
    pub fn anchored(anchor: Anchor, offset_px: Vec2) -> Self {
        Self { of: PlaceOf::Picture, offset_px, anchor: Some(anchor) }
    }

    /// A point in world space, in metres, where the middle of the item is.
    pub fn at_world(position_world: Vec3) -> Self {
        Self { of: PlaceOf::World(position_world), offset_px: Vec2::ZERO, anchor: None }
    }

    /// The origin of the first node of a name, where the middle of the item is.
    pub fn at_node(name: impl Into<String>) -> Self {
        Self { of: PlaceOf::Node(name.into()), offset_px: Vec2::ZERO, anchor: None }
    }
}

impl OverlayItem {
    fn new(shape: OverlayShape, place: OverlayPlace) -> Self {
        Self { shape, place, color_linear: Vec3::ONE, opacity: 1.0, depth_test: false, depth_offset_m: 0.0 }
    }

    /// White text of 16 pixels in the built-in font.
    pub fn text(text: impl Into<String>, place: OverlayPlace) -> Self {
        Self::new(OverlayShape::Text(OverlayText::new(text)), place)
    }

    /// A white line of a pixel's width through points of the picture, in pixels.
    pub fn line(points_px: Vec<Vec2>) -> Self {
        let line = OverlayLine { points: LinePoints::Pixels(points_px), width_px: 1.0 };
        Self::new(OverlayShape::Line(line), OverlayPlace::at_px(Vec2::ZERO))
    }

    /// A white line of a pixel's width through points in world space, in metres.
    pub fn line_world(points_world: Vec<Vec3>) -> Self {
        let line = OverlayLine { points: LinePoints::World(points_world), width_px: 1.0 };
        Self::new(OverlayShape::Line(line), OverlayPlace::at_px(Vec2::ZERO))
    }

    /// An image, a pixel for each texel.
    pub fn sprite(pixels: Arc<Pixels>, place: OverlayPlace) -> Self {
        let sprite = OverlaySprite { pixels, size_px: [None; 2], rotation_deg: 0.0 };
        Self::new(OverlayShape::Sprite(sprite), place)
    }

    /// What the monitor of a name shows, a pixel for each texel.
    pub fn monitor(name: impl Into<String>, place: OverlayPlace) -> Self {
        let monitor = OverlayMonitor { name: name.into(), size_px: [None; 2], rotation_deg: 0.0 };
        Self::new(OverlayShape::Monitor(monitor), place)
    }

    /// Whether it is at a place of the world.
    pub fn is_in_world(&self) -> bool {
        let has_points = matches!(&self.shape, OverlayShape::Line(OverlayLine { points: LinePoints::World(_), .. }));
        has_points || self.place.of != PlaceOf::Picture
    }
}

impl OverlayText {
    /// Text of 16 pixels in the built-in font.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), size_px: 16.0, align: TextAlign::Left, font: None, background: None, padding_px: 0.0 }
    }
}

impl OverlaySprite {
    /// Width and height in pixels.
    pub fn drawn_size_px(&self) -> Vec2 {
        drawn_size_px(self.size_px, (self.pixels.width, self.pixels.height))
    }
}

impl OverlayMonitor {
    /// Width and height in pixels, of a monitor whose picture has so many texels.
    pub fn drawn_size_px(&self, texels: (u32, u32)) -> Vec2 {
        drawn_size_px(self.size_px, texels)
    }
}

fn drawn_size_px(size_px: [Option<f32>; 2], (width, height): (u32, u32)) -> Vec2 {
    let texels = Vec2::new(width as f32, height as f32);
    match size_px {
        [Some(width), Some(height)] => Vec2::new(width, height),
        [Some(width), None] => Vec2::new(width, width * texels.y / texels.x.max(1.0)),
        [None, Some(height)] => Vec2::new(height * texels.x / texels.y.max(1.0), height),
        [None, None] => texels,
    }
}
