//! How much a camera shows of a model.

/// A camera that shows less of a model's outer points than this does not show the model.
pub const LEAST_OF_MODEL: f32 = 0.1;

/// A camera in whose picture the rectangle around a model takes a smaller share than this does not show the model.
pub const LEAST_OF_PICTURE: f32 = 0.1;

/// What of a model a camera has in its picture; what hides it is not looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureCoverage {
    /// The share of the model's outer points that lie in the picture.
    pub of_model: f32,
    /// The share of the picture that the rectangle around them takes.
    pub of_picture: f32,
}

impl PictureCoverage {
    /// Whether that is enough for a picture of the model.
    pub fn is_enough(self) -> bool {
        self.of_model >= LEAST_OF_MODEL && self.of_picture >= LEAST_OF_PICTURE
    }
}
