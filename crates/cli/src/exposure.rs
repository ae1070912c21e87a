//! The exposure of an input: metered once, for all pictures that are made of it.

use crate::failure::Failure;
use crate::session::still_failure;
use manypass::{Environment, Exposure, FrameRequest, Metering, Renderer};
use manypass_scene::Scene;
use serde_json::{Value, json};

/// The exposure of all pictures of an input.
#[derive(Clone, Copy, Debug)]
pub struct InputExposure {
    exposure: Exposure,
    metering: Option<Metering>,
}

impl InputExposure {
    /// What settings ask for, or else the scene; metered through `request` where that decides anything. The scene is
    /// in its pose at time 0, and the request's camera has not turned.
    ///
    /// # Errors
    /// The renderer failed.
    pub fn new(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Result<Self, Failure> {
        let settings = &request.settings;
        let exposure = settings.exposure.resolved(scene, settings.environment.source);
        let needs_metering = request.needs_metering(exposure);
        let meter = || renderer.meter(scene, request).map_err(|error| still_failure(&error.into()));
        Ok(Self { exposure, metering: needs_metering.then(meter).transpose()? })
    }

    /// Puts it into the request of one picture.
    pub fn expose(&self, request: &mut FrameRequest) {
        request.expose(self.exposure, self.metering);
    }

    /// The hint of a model of which most was metered to be too dark to be read; `environment` is resolved. A faint
    /// studio is brighter where that is so.
    pub fn dark_hint(&self, environment: Environment) -> Option<String> {
        let metering = self.metering.filter(|_| matches!(self.exposure, Exposure::Auto { .. }))?;
        let is_dark = metering.dark_share > 0.5 && environment != Environment::Fill;
        let percent = (100.0 * metering.dark_share).round();
        let flags = "--preset product shows it in the studio, and --environment fill adds a faint one";
        is_dark.then(|| format!("{percent} % of the visible model is darker than 16 of 255: {flags}"))
    }

    /// What lights of the scene are multiplied by, in stops.
    fn lamp_stops(&self) -> f32 {
        let metering = self.metering.filter(|_| matches!(self.exposure, Exposure::Auto { .. }));
        metering.map_or(0.0, |metering| metering.lamp_stops)
    }

    /// What the report says of it, and of what a picture adapted to.
    pub fn report(&self, adapted_stops: Option<f32>) -> Value {
        json!({
            "adapted_stops": adapted_stops,
            "mode": self.exposure.mode(),
            "stops": self.exposure.stops(self.metering.as_ref()),
            "log_average_luminance": self.metering.and_then(|metering| metering.log_average_luminance),
            "lamp_stops": self.lamp_stops(),
            "pre_exposure_stops": self.metering.map(|metering| metering.pre_exposure_stops),
        })
    }
}

/// The warning of a picture of whose first sample effects left so many pixels as no numbers.
pub fn scrubbed_warning(scrubbed_pixels: u64) -> Option<String> {
    let pixels = if scrubbed_pixels == 1 { "pixel" } else { "pixels" };
    let what =
        "not finite, and shown as black or white: look for divisions by 0, and roots and powers of negative numbers";
    (scrubbed_pixels > 0).then(|| format!("effects leave {scrubbed_pixels} {pixels} that are {what}"))
}

/// The warning of a picture with `clamped_pixels`.
pub fn clamped_warning(clamped_pixels: u64) -> Option<String> {
    let pixels = if clamped_pixels == 1 { "pixel is" } else { "pixels are" };
    (clamped_pixels > 0).then(|| format!("{clamped_pixels} {pixels} brighter than half floats hold, and too dark here"))
}
