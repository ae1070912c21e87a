//! Settings of the camera's lens and shutter.

use crate::setting::{SettingsError, choices, settings};

choices! {
    /// The projection of a fisheye lens: how angles from the camera's axis map to distances from the middle.
    pub enum Fisheye {
        /// No fisheye: the projection of the camera, perspective or orthographic.
        #[default]
        None = "none",
        /// Equal angles are equally long in the picture: r ∝ θ.
        Equidistant = "equidistant",
        /// Equal solid angles are equally large, as in most fisheye lenses: r ∝ sin(θ / 2).
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
    /// Settings of the camera's lens and shutter. The samples of a still pass through them.
    pub struct CameraSettings {
        /// The f-number of a thin lens: its focal length divided by its aperture diameter. The smaller, the stronger
        /// the depth of field. 0 is a pinhole. A single sample and live views always have a pinhole. Cameras with
        /// parallel rays have no lens and are refused.
        f_stop: f32 = 0.0, in 0.0..=1024.0, unit "f-number";
        /// The focus distance along the camera's axis. 0 focuses on the target of an automatic camera: the point it
        /// looks at, or the middle of what is drawn.
        focus_m: f32 = 0.0, in 0.0..=1e9, unit "m";
        /// The height of the sensor. It turns the vertical field of view into a focal length: 24 mm and 45° give a lens
        /// of 29 mm.
        sensor_height_mm: f32 = 24.0, in 0.1..=1000.0, unit "mm";
        /// The shutter angle: how long the shutter is open. 360° is the time from one frame to the next (`--fps`). The
        /// open time is centred on the frame's time; 0 is an instant. Each sample poses animations, and turns a
        /// turntable, at its own time. A single sample takes the frame's time.
        shutter_deg: f32 = 0.0, in 0.0..=3600.0, unit "°";
        /// The projection of a fisheye lens: how angles θ from the camera's axis map to distances r from the middle.
        /// `equidistant` is r ∝ θ, `equisolid` r ∝ sin(θ / 2), `stereographic` r ∝ tan(θ / 2). It needs a camera with
        /// perspective and ignores that camera's field of view. It has no AOVs, ambient occlusion or depth of field.
        fisheye: Fisheye = Fisheye::None;
        /// The field of view of a fisheye: the angle across its image circle.
        fisheye_fov_deg: f32 = 180.0, in 1.0..=220.0, unit "°";
        /// Whether the image circle of a fisheye touches the nearer edges of the picture or its corners. The picture is
        /// empty outside the circle.
        fisheye_frame: FisheyeFrame = FisheyeFrame::Circular;
    }
}

/// The smallest f-number but 0; no lens of glass is below 0.5.
const F_STOP_MIN: f32 = 0.1;
/// The nearest focus but 0.
const FOCUS_MIN_M: f32 = 1e-3;

impl CameraSettings {
    /// Checks what the ranges leave open: 0 has its own meaning, and numbers just above it have none.
    ///
    /// # Errors
    /// A number between 0 and the smallest that a lens can have.
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
