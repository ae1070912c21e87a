//! Settings of the camera's lens and shutter.

use crate::setting::{SettingsError, choices, settings};

choices! {
    /// How a fisheye maps angles from the camera's axis to distances from the middle of the picture.
    pub enum Fisheye {
        /// There is none: the picture has perspective, or parallel rays, as the camera says.
        #[default]
        None = "none",
        /// Equal angles are equally long: r ∝ θ.
        Equidistant = "equidistant",
        /// Equal solid angles are equally large, as most lenses have it: r ∝ sin(θ / 2).
        Equisolid = "equisolid",
        /// Small shapes keep their form: r ∝ tan(θ / 2).
        Stereographic = "stereographic",
    }
}

choices! {
    /// The size of the image circle of a fisheye.
    pub enum FisheyeFrame {
        /// It touches the nearer edges of the picture.
        #[default]
        Circular = "circular",
        /// It touches the corners, and fills the picture.
        Full = "full",
    }
}

settings! {
    /// Settings of the camera's lens and shutter, which the samples of a still are taken through.
    pub struct CameraSettings {
        /// The f-number of a thin lens, its focal length by its diameter: the smaller, the more is out of focus. 0 is a
        /// pinhole, and so is the camera of a single sample and of live views. Cameras with parallel rays have no lens
        /// and are refused.
        f_stop: f32 = 0.0, in 0.0..=1024.0, unit "f-number";
        /// The distance along the camera's axis at which everything is sharp; 0 for what an automatic camera looks at:
        /// its target, or the middle of what is drawn.
        focus_m: f32 = 0.0, in 0.0..=1e9, unit "m";
        /// The height of the sensor, which makes a focal length of the vertical field of view: 24 mm and 45° are a lens
        /// of 29 mm.
        sensor_height_mm: f32 = 24.0, in 0.1..=1000.0, unit "mm";
        /// How long the shutter is open, as an angle of which 360° are the time from one frame to the next (`--fps`),
        /// evenly around the frame's time; 0 is no time. Samples pose what is animated, and turn a turntable, each at a
        /// time of its own; a single sample is that of the frame's time.
        shutter_deg: f32 = 0.0, in 0.0..=3600.0, unit "°";
        /// Whether the picture is that of a fisheye, and how that maps angles θ from the camera's axis to distances r from
        /// the middle: equidistant is r ∝ θ, equisolid r ∝ sin(θ / 2), stereographic r ∝ tan(θ / 2). Needs a camera with
        /// perspective, of which the field of view does not matter then. It has no variables, occlusion or lens.
        fisheye: Fisheye = Fisheye::None;
        /// The field of view of a fisheye: the angle across the circle that it shows.
        fisheye_fov_deg: f32 = 180.0, in 1.0..=220.0, unit "°";
        /// Whether the circle of a fisheye touches the nearer edges of the picture, or its corners. Nothing is seen
        /// outside.
        fisheye_frame: FisheyeFrame = FisheyeFrame::Circular;
    }
}

/// The smallest f-number but 0; no lens of glass is below 0.5.
const F_STOP_MIN: f32 = 0.1;
/// The nearest focus but 0.
const FOCUS_MIN_M: f32 = 1e-3;

impl CameraSettings {
    /// Checks what the ranges leave open: 0 has a meaning of its own, and what is just above it none.
    ///
    /// # Errors
    /// A number between 0 and what a lens can be.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        let smallest =
            [("camera.f_stop", self.f_stop, F_STOP_MIN, 1024.0), ("camera.focus_m", self.focus_m, FOCUS_MIN_M, 1e9)];
        let wrong = smallest.into_iter().find(|(_, value, smallest, _)| *value > 0.0 && value < smallest);
        wrong.map_or(Ok(()), |(key, value, smallest, largest)| {
            let expected = format!("0 or a number from {smallest} to {largest}");
            Err(SettingsError::BadValue { key: key.into(), value: value.to_string(), expected })
        })
    }
}
