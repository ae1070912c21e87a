//! What cannot be drawn over a picture.

use super::fault::{OverlayFault, SIDE_PX_MAX, TEXT_SIZE_PX_MAX};
use super::{LinePoints, OverlayItem, OverlayLine, OverlayMonitor, OverlayShape, OverlaySprite, OverlayText, PlaceOf};
use glam::Vec2;

/// The farthest place in pixels.
const PLACE_PX_MAX: f32 = 1e6;
/// The most letters of a text.
const LETTERS_MAX: usize = 100_000;

fn fault(key: &'static str, message: impl Into<String>) -> OverlayFault {
    OverlayFault { key, message: message.into() }
}

/// A number above 0 up to a limit.
fn check_length(key: &'static str, length: f32, most: f32) -> Result<(), OverlayFault> {
    if length > 0.0 && length <= most {
        return Ok(());
    }
    Err(fault(key, format!("{length} is not a length above 0 and at most {most} pixels")))
}

fn check_share(key: &'static str, share: f32) -> Result<(), OverlayFault> {
    if (0.0..=1.0).contains(&share) { Ok(()) } else { Err(fault(key, format!("{share} is not from 0 to 1"))) }
}

fn check_place(key: &'static str, place_px: Vec2) -> Result<(), OverlayFault> {
    if place_px.abs().max_element() <= PLACE_PX_MAX && place_px.is_finite() {
        return Ok(());
    }
    Err(fault(key, format!("{place_px} is farther than {PLACE_PX_MAX} pixels away")))
}

impl OverlayItem {
    /// Whether it can be drawn.
    ///
    /// # Errors
    /// An empty text or one with control characters, a size or place that is 0, not finite or too large, an opacity
    /// that is none, a line through less than two points, or depth that is to be compared of what is in no place of the
    /// world.
    pub fn check(&self) -> Result<(), OverlayFault> {
        let is_color = |color: glam::Vec3| color.is_finite() && color.min_element() >= 0.0;
        if !is_color(self.color_linear) {
            return Err(fault("color", "it is not a colour: three finite numbers of at least 0"));
        }
        check_share("opacity", self.opacity)?;
        check_place("position", self.place.offset_px)?;
        if let PlaceOf::World(position) = &self.place.of
            && !position.is_finite()
        {
            return Err(fault("at_world", "it is not a position: three finite numbers"));
        }
        if !self.depth_offset_m.is_finite() {
            return Err(fault("depth_offset_m", "it is not a finite number"));
        }
        if self.depth_test && !self.is_in_world() {
            return Err(fault(
                "depth_test",
                "an item placed in pixels of the picture has no depth; give it `at_world`, `node` or `points_world`",
            ));
        }
        match &self.shape {
            OverlayShape::Text(text) => {
                if let Some((color, opacity)) = text.background {
                    check_share("background_opacity", opacity)?;
                    if !is_color(color) {
                        return Err(fault("background", "it is not a colour: three finite numbers of at least 0"));
                    }
                }
                text.check()
            }
            OverlayShape::Line(line) => line.check(),
            OverlayShape::Sprite(sprite) => sprite.check(),
            OverlayShape::Monitor(monitor) => monitor.check(),
        }
    }
}

impl OverlayText {
    fn check(&self) -> Result<(), OverlayFault> {
        if self.text.trim().is_empty() {
            return Err(fault("text", "the text is empty; leave out the item, or write what it shows"));
        }
        if let Some(control) = self.text.chars().find(|letter| letter.is_control() && !['\n', '\t'].contains(letter)) {
            let code = u32::from(control);
            let message =
                format!("the text holds the control character U+{code:04X}; ends of lines (\\n) and tabs are possible");
            return Err(fault("text", message));
        }
        let letters = self.text.chars().count();
        if letters > LETTERS_MAX {
            return Err(fault("text", format!("the text has {letters} letters, and {LETTERS_MAX} are possible")));
        }
        if !(0.0..=SIDE_PX_MAX).contains(&self.padding_px) {
            return Err(fault("padding_px", format!("{} is not from 0 to {SIDE_PX_MAX} pixels", self.padding_px)));
        }
        check_length("size_px", self.size_px, TEXT_SIZE_PX_MAX)
    }
}

impl OverlayLine {
    fn check(&self) -> Result<(), OverlayFault> {
        check_length("width_px", self.width_px, SIDE_PX_MAX)?;
        let (key, count) = match &self.points {
            LinePoints::Pixels(points) => {
                points.iter().try_for_each(|point| check_place("points", *point))?;
                ("points", points.len())
            }
            LinePoints::World(points) => {
                if !points.iter().all(|point| point.is_finite()) {
                    return Err(fault("points_world", "a point is not a position: three finite numbers"));
                }
                ("points_world", points.len())
            }
        };
        if count < 2 {
            return Err(fault(key, format!("a line leads through two points or more, and there is {count}")));
        }
        Ok(())
    }
}

impl OverlaySprite {
    fn check(&self) -> Result<(), OverlayFault> {
        let size_px = self.drawn_size_px();
        let (width, height) = (self.pixels.width as usize, self.pixels.height as usize);
        if width == 0 || height == 0 || self.pixels.data.len() != 4 * width * height {
            return Err(fault("sprite", "the image has no texels"));
        }
        let key =
            |axis: usize, otherwise: &'static str| if self.size_px[axis].is_some() { otherwise } else { "sprite" };
        check_length(key(0, "width_px"), size_px.x, SIDE_PX_MAX)?;
        check_length(key(1, "height_px"), size_px.y, SIDE_PX_MAX)?;
        if !self.rotation_deg.is_finite() {
            return Err(fault("rotation_deg", "it is not a finite number"));
        }
        Ok(())
    }
}

impl OverlayMonitor {
    fn check(&self) -> Result<(), OverlayFault> {
        for (key, length) in ["width_px", "height_px"].into_iter().zip(self.size_px) {
            length.map_or(Ok(()), |length| check_length(key, length, SIDE_PX_MAX))?;
        }
        if !self.rotation_deg.is_finite() {
            return Err(fault("rotation_deg", "it is not a finite number"));
        }
        Ok(())
    }
}
