//! Metering: how bright the surfaces are that a request shows.

use super::Renderer;
use super::purpose::Purpose;
use crate::constants::RADIANCE_MAX;
use crate::environment::{Background, Environment};
use crate::exposure::{
    Anchor, Exposure, ExposureSettings, HIGHLIGHT_SHARES, Metering, MeteringPattern, color_excess_stops,
    highlight_excess_stops,
};
use crate::ground::Ground;
use crate::request::{FrameRequest, RenderError};
use crate::settings::Switch;
use crate::transparency::TransparencyMode;
use manypass_scene::Scene;

/// The longer side of the frame that is metered, whatever the size of the picture.
const LONGER_SIDE_PX: u32 = 128;

/// The same where a crowd of lights reaches every pixel: the frame shrinks as far as this, so that up to 32,768 lights
/// cost no more than a frame of [`LIGHT_PIXELS_MAX`] pixels under one light.
const LONGER_SIDE_MIN_PX: u32 = 32;

/// The most pixels times lights without a range: 2,048 lights at the full size.
const LIGHT_PIXELS_MAX: f64 = (1 << 25) as f64;

/// Radiance from this on was clamped: the limit, less the rounding of half floats.
const CLAMPED: f64 = 0.999 * RADIANCE_MAX as f64;

/// What half floats hold at one pre-exposure spans 40 stops: so many stops are between two tries, at most so many tries
/// follow the first one.
const STEP_STOPS: i32 = 16;
const STEPS_MAX: i32 = 4;

/// More clamped pixels than this ask for another try.
const CLAMPED_SHARE_MAX: f64 = 0.05;

/// A mean below this asks for another try: a 64th of it would have lost bits.
const MEAN_MIN: f64 = 1.0 / 2048.0;

/// Mirrored lamps and other sparks, of a pixel or two, come and go with the smallest step of the camera. In the mean
/// that tells what is dark, luminance counts up to so many times what this share of the pixels does not exceed.
const SPARK_FACTOR: f64 = 4.0;
const SPARKLESS_SHARE: f64 = 0.99;

/// The mean without sparks is at least this share of the mean with them: where next to nothing is lit, what the rest
/// hardly gets of that light stays dark.
const SPARKLESS_MEAN_MIN: f64 = 1.0 / 16.0;

/// One try: of each pixel that shows a surface its coverage, luminance and largest component, pre-exposed.
struct Reading {
    pixels: Vec<[f64; 3]>,
    pre_exposure_stops: i32,
}

impl Reading {
    fn new(rgba: &[f32], pre_exposure_stops: i32) -> Self {
        let pixel = |texel: &[f32]| {
            let [r, g, b, coverage] = [0, 1, 2, 3].map(|at| texel.get(at).copied().map_or(0.0, f64::from));
            let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            let scale = 1.0 / coverage.max(1e-6);
            [coverage.min(1.0), luminance * scale, r.max(g).max(b) * scale]
        };
        Self { pixels: rgba.chunks_exact(4).map(pixel).collect(), pre_exposure_stops }
    }

    fn covered(&self) -> f64 {
        self.pixels.iter().map(|pixel| pixel[0]).sum()
    }

    fn mean(&self) -> f64 {
        self.weighted_mean(|_| 1.0, f64::INFINITY)
    }

    /// The mean in which the pixel of an index counts so much, and luminance up to a limit.
    fn weighted_mean(&self, weight: impl Fn(usize) -> f64, luminance_max: f64) -> f64 {
        let weigh = |(index, [coverage, luminance, _]): (usize, &[f64; 3])| {
            let weight = weight(index) * coverage;
            [weight, weight * luminance.min(luminance_max)]
        };
        let add = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b + d];
        let [weights, sum] = self.pixels.iter().enumerate().map(weigh).fold([0.0; 2], add);
        sum / weights.max(1e-9)
    }

    /// The luminance that all but the brightest hundredth of the surfaces does not exceed.
    fn sparkless_luminance(&self, weight: impl Fn(usize) -> f64) -> f64 {
        let weigh = |(index, [coverage, luminance, _]): (usize, &[f64; 3])| (*luminance, weight(index) * coverage);
        let mut weighed: Vec<(f64, f64)> =
            self.pixels.iter().enumerate().map(weigh).filter(|(_, weight)| *weight > 0.0).collect();
        weighed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut left = SPARKLESS_SHARE * weighed.iter().map(|(_, weight)| weight).sum::<f64>();
        let reached = weighed.iter().find(|(_, weight)| {
            left -= weight;
            left <= 0.0
        });
        reached.or(weighed.last()).map_or(0.0, |(luminance, _)| *luminance)
    }

    /// The mean to which surfaces that no light reaches are compared.
    fn mean_without_sparks(&self, weight: impl Fn(usize) -> f64) -> f64 {
        let limit = SPARK_FACTOR * self.sparkless_luminance(&weight);
        let whole = self.weighted_mean(&weight, f64::INFINITY);
        self.weighted_mean(&weight, limit).max(SPARKLESS_MEAN_MIN * whole)
    }

    fn clamped_share(&self) -> f64 {
        let clamped: f64 = self.pixels.iter().filter(|pixel| pixel[2] >= CLAMPED).map(|pixel| pixel[0]).sum();
        clamped / self.covered().max(1e-9)
    }

    /// Pixels that were clamped as another reading of the same frame has them.
    fn mend(&mut self, lower: &Self) {
        let scale = f64::from(self.pre_exposure_stops - lower.pre_exposure_stops).exp2();
        for (pixel, other) in self.pixels.iter_mut().zip(&lower.pixels) {
            if pixel[2] >= CLAMPED {
                *pixel = [pixel[0], other[1] * scale, other[2] * scale];
            }
        }
    }

    /// What it comes to if the pixel of an index counts so much, in an environment of a level.
    fn metering(&self, anchor: Option<Anchor>, weight_of: impl Fn(usize) -> f64) -> Metering {
        let (mean, scale) = (self.mean_without_sparks(&weight_of), f64::from(-self.pre_exposure_stops).exp2());
        let (mut weights, mut sum) = (0.0, 0.0);
        for (index, [coverage, luminance, _]) in self.pixels.iter().enumerate() {
            if *coverage > 0.0 && *luminance > 0.0 {
                let weight = weight_of(index) * coverage * luminance / (luminance + mean / 64.0);
                weights += weight;
                sum += weight * luminance.log2();
            }
        }
        let peak = self.pixels.iter().filter(|pixel| pixel[0] > 0.0).map(|pixel| pixel[2]).fold(0.0, f64::max);
        let average = (weights > 0.0).then(|| (sum / weights).exp2() * scale);
        let metering = Metering::new(average, peak * scale, self.covered() / (self.pixels.len().max(1)) as f64);
        let metering = anchor.map_or(metering, |anchor| self.anchored(metering, anchor));
        let dark_below = Metering::DARK / (scale * f64::from(metering.stops).exp2());
        let dark: f64 = self.pixels.iter().filter(|pixel| pixel[1] < dark_below).map(|pixel| pixel[0]).sum();
        Metering { dark_share: dark / self.covered().max(1e-9), ..metering }
    }

    /// With the exposure of the environment, which the surfaces move.
    fn anchored(&self, metering: Metering, anchor: Anchor) -> Metering {
        let surfaces = metering.log_average_luminance.map(|_| f64::from(metering.stops));
        let stops = anchor.moved(surfaces, metering.surface_share);
        let scale = (stops - f64::from(self.pre_exposure_stops)).exp2();
        let excess_of = |[coverage, luminance, largest]: &[f64; 3]| {
            coverage * color_excess_stops(luminance * scale, largest * scale)
        };
        let excess = self.pixels.iter().map(excess_of).sum::<f64>() / self.covered().max(1e-9);
        let stops = anchor.lowered(stops, excess);
        let highlights = anchor.highlight_share(surfaces, metering.surface_share) * self.highlight_stops(stops);
        Metering { stops: (stops - highlights) as f32, ..metering }
    }

    /// The stops less that highlights ask for at an exposure: the mean over the band of [`HIGHLIGHT_SHARES`].
    fn highlight_stops(&self, stops: f64) -> f64 {
        let scale = (stops - f64::from(self.pre_exposure_stops)).exp2();
        let mut brightest: Vec<[f64; 2]> =
            self.pixels.iter().map(|pixel| [pixel[1], pixel[0]]).filter(|[_, coverage]| *coverage > 0.0).collect();
        brightest.sort_unstable_by(|a, b| b[0].total_cmp(&a[0]));
        let [from, to] = HIGHLIGHT_SHARES.map(|share| share * self.covered());
        let (mut end, mut sum) = (0.0, 0.0);
        for [luminance, coverage] in brightest {
            let begin = end;
            end += coverage;
            // What of the pixel lies in the band.
            let counts = (f64::min(end, to) - f64::max(begin, from)).max(0.0);
            sum += counts * highlight_excess_stops(luminance * scale);
        }
        sum / (to - from).max(1e-9)
    }
}

impl Renderer {
    /// How bright the surfaces are that `request` shows: by their own light, that of the scene's lights and that of the
    /// environment, but not of [`Environment::Fill`], whose level follows from this. Under the sky and in a picture the
    /// exposure goes by the mean light of these as well.
    ///
    /// It draws a small frame of its own, of the picture's shape whatever its size, of one sample, without effects and
    /// background. The pictures of a sequence take the metering of one of them; the command line takes the camera at
    /// time 0 and before it turns.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn meter(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Metering, RenderError> {
        pollster::block_on(self.meter_async(scene, request))
    }

    /// As [`Self::meter`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub async fn meter_async(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Metering, RenderError> {
        let stats = self.stats.clone();
        let request = request.resolved(scene);
        let lamp_stops = request.metered_lamp_stops(scene);
        let mut small = metered(&request, longer_side_px(scene));
        small.metering = Some(Metering { lamp_stops, ..Metering::default() });
        let metering = self.meter_frames(scene, &small).await;
        self.stats = stats;
        metering.map(|metering| Metering { lamp_stops, ..metering })
    }

    /// Puts `exposure` into `request`, metering if that decides anything.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    ///
    /// ```no_run
    /// # fn show(renderer: &mut manypass::Renderer, scene: &manypass::scene::Scene) -> Result<(), manypass::RenderError> {
    /// # use manypass::{Exposure, FrameRequest};
    /// let mut request = FrameRequest::of_scene(scene, 1280, 720);
    /// renderer.expose(scene, &mut request, Exposure::of_scene(scene))?;
    /// renderer.render(scene, &request)?;
    /// # Ok(()) }
    /// ```
    #[cfg(not(target_arch = "wasm32"))]
    pub fn expose(&mut self, scene: &Scene, request: &mut FrameRequest, exposure: Exposure) -> Result<(), RenderError> {
        pollster::block_on(self.expose_async(scene, request, exposure))
    }

    /// As [`Self::expose`], where waiting is not possible.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub async fn expose_async(
        &mut self,
        scene: &Scene,
        request: &mut FrameRequest,
        exposure: Exposure,
    ) -> Result<(), RenderError> {
        *request = request.resolved(scene);
        let asked = ExposureSettings { stops: exposure, ..request.settings.exposure.clone() };
        let exposure = asked.resolved(scene, request.settings.environment.source);
        request.settings.exposure.stops = exposure;
        let metering =
            if request.needs_metering(exposure) { Some(self.meter_async(scene, request).await?) } else { None };
        request.expose(exposure, metering);
        Ok(())
    }

    async fn reading(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        pre_exposure_stops: i32,
    ) -> Result<Reading, RenderError> {
        let metering = Some(Metering { pre_exposure_stops, ..request.metering.unwrap_or_default() });
        let request = FrameRequest { metering, ..request.clone() };
        let purpose = Purpose {
            steps_simulations: true,
            is_exposed: false,
            draws_picture: false,
            shows_picture: false,
            ..Purpose::BESIDE
        };
        let readings = self.run(scene, &[("", &request)], &purpose).await?;
        let radiance = readings.exports.first().ok_or(RenderError::Internal("nothing was metered"))?;
        let rgba: Vec<f32> = radiance.floats().collect();
        Ok(Reading::new(&rgba, pre_exposure_stops))
    }

    async fn meter_frames(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Metering, RenderError> {
        let mut stops = 0;
        let mut reading = self.reading(scene, request, stops).await?;
        for _ in 0..STEPS_MAX {
            if reading.clamped_share() > CLAMPED_SHARE_MAX {
                stops -= STEP_STOPS;
            } else if reading.covered() > 0.0 && reading.mean() < MEAN_MIN {
                stops += STEP_STOPS;
            } else {
                break;
            }
            reading = self.reading(scene, request, stops).await?;
        }
        if reading.clamped_share() > 0.0 {
            let lower = self.reading(scene, request, stops - STEP_STOPS).await?;
            reading.mend(&lower);
        }
        let pattern = request.settings.exposure.metering;
        // The other patterns meter what is in the middle, whatever surrounds it.
        let anchor = self.anchor(scene, request).filter(|_| pattern == MeteringPattern::Average);
        Ok(reading.metering(anchor, |index| pattern.weight(index, (request.width, request.height))))
    }

    /// The level of the sky, which a frame has computed, or of the scene's picture, if that is the environment.
    fn anchor(&mut self, scene: &Scene, request: &FrameRequest) -> Option<Anchor> {
        let settings = &request.settings.environment;
        let of_scene = scene.environment.clone().filter(|_| settings.source == Environment::File);
        let map = of_scene.or_else(|| self.computed.of(settings))?;
        let anchor = Anchor::new(self.computed.mean_radiance(&map), settings.intensity)?;
        Some(if settings.source == Environment::Sky { anchor.of_sky() } else { anchor })
    }
}

/// The longer side of the frame that is metered for pictures of a scene.
fn longer_side_px(scene: &Scene) -> u32 {
    let light_of = |light: &usize| scene.lights.get(*light).filter(|light| light.range_m.is_none());
    side_under(scene.light_indices().iter().filter_map(light_of).count())
}

/// The same under so many lights that reach every pixel.
fn side_under(lights: usize) -> u32 {
    let side = (LIGHT_PIXELS_MAX / (lights.max(1) as f64)).sqrt() as u32;
    side.clamp(LONGER_SIDE_MIN_PX, LONGER_SIDE_PX)
}

/// The request of the frame that is metered for a picture.
fn metered(request: &FrameRequest, longer_side_px: u32) -> FrameRequest {
    let (width, height) = (request.width.max(1), request.height.max(1));
    let side = |of: u32| {
        let side = f64::from(longer_side_px) * f64::from(of) / f64::from(width.max(height));
        (side.round() as u32).max(1)
    };
    let mut small = FrameRequest {
        width: side(width),
        height: side(height),
        sample_index: 0,
        sample_count: 1,
        want_aovs: Vec::new(),
        previous: None,
        effects: Vec::new(),
        light_subset: None,
        ..request.clone()
    };
    let settings = &mut small.settings;
    if settings.environment.source == Environment::Fill {
        settings.environment.source = Environment::None;
    }
    settings.background.source = Background::Transparent;
    settings.ground.mode = Ground::None;
    // Without noise.
    settings.transparency.mode = TransparencyMode::Sorted;
    settings.exposure.stops = Exposure::Stops(0.0);
    settings.exposure.adapt = false;
    settings.render.scale = 1.0;
    settings.msaa = Default::default();
    settings.occlusion.enabled = Switch::Off;
    settings.reflections.enabled = Switch::Off;
    settings.gi.enabled = false;
    small
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::View;
    use glam::Mat4;
    use manypass_scene::Projection;

    #[test]
    fn the_average_is_over_surfaces_that_light_reaches() {
        // Two at 0.5 and at 2, one half covered at 1 (associated: 0.5), one in the dark, one background.
        let grey = |value: f32, coverage: f32| [value, value, value, coverage];
        let pixels = [grey(0.5, 1.0), grey(2.0, 1.0), grey(0.5, 0.5), grey(0.0, 1.0), grey(0.0, 0.0)].concat();
        let metering = Reading::new(&pixels, 0).metering(None, |_| 1.0);
        let average = metering.log_average_luminance.unwrap_or_default();
        assert!((average - 1.0).abs() < 0.02, "{average}");
        assert!((metering.surface_share - 0.7).abs() < 1e-6 && (metering.peak - 2.0).abs() < 1e-6, "{metering:?}");
        // The same light at another pre-exposure is the same light.
        let lower: Vec<f32> =
            pixels.chunks_exact(4).flat_map(|p| [p[0] / 16.0, p[1] / 16.0, p[2] / 16.0, p[3]]).collect();
        let same = Reading::new(&lower, -4).metering(None, |_| 1.0).log_average_luminance.unwrap_or_default();
        assert!((same - average).abs() < 1e-9, "{same} {average}");
        let dark = Reading::new(&grey(0.0, 1.0), 0).metering(None, |_| 1.0);
        assert_eq!((dark.log_average_luminance, dark.stops), (None, 0.0));
    }

    #[test]
    fn a_spark_moves_nothing() {
        // A surface from 0.1 to 0.5, a third of it in the dark.
        let grey = |value: f32| [value, value, value, 1.0];
        let value = |i: u16| -> f32 { if i.is_multiple_of(3) { 1e-4 } else { 0.1 + f32::from(i) * 4e-4 } };
        let stops = |value: &dyn Fn(u16) -> f32| {
            let pixels: Vec<f32> = (0..1000).flat_map(|i| grey(value(i))).collect();
            let average = Reading::new(&pixels, 0).metering(None, |_| 1.0).log_average_luminance;
            average.unwrap_or_default().log2()
        };
        let plain = stops(&value);
        let sparkling = stops(&|i: u16| if i == 500 { 5000.0 * value(i) } else { value(i) });
        assert!((sparkling - plain).abs() < 0.03, "{plain} and {sparkling} stops");
        // Without sparks the mean is that of all. 3 of 10 are at 0.9, which is not more than a hundredth.
        let step = |i: u16| -> f32 { if i % 10 < 3 { 0.9 } else { 1e-3 } };
        let mean = 0.3 * 0.9 + 0.7 * 1e-3;
        let weight = |luminance: f64| luminance / (luminance + mean / 64.0);
        let [lit, dark] = [0.3 * weight(0.9), 0.7 * weight(1e-3)];
        let expected = (lit * 0.9f64.log2() + dark * 1e-3f64.log2()) / (lit + dark);
        assert!((stops(&step) - expected).abs() < 1e-3, "{} and {expected} stops", stops(&step));
        // A lamp that lights a two-hundredth of what is seen is exposed, and not the night around it.
        let night = |i: u16| -> f32 { if i < 5 { 1.0 } else { 1e-12 } };
        assert!(stops(&night) > -0.1, "{} stops", stops(&night));
    }

    #[test]
    fn saturated_colours_are_exposed_to_white_and_grey_is_not() {
        // In a mean of 0.5 the environment's exposure is 0. Half of the picture shows it.
        let anchor = Anchor::new(glam::Vec3::splat(0.5), 1.0);
        let stops_of = |r: f32, g: f32, b: f32, pre_exposure_stops: i32| {
            let scale = (pre_exposure_stops as f32).exp2();
            let pixels = [[r * scale, g * scale, b * scale, 1.0], [0.0; 4]].concat();
            f64::from(Reading::new(&pixels, pre_exposure_stops).metering(anchor, |_| 1.0).stops)
        };
        for pre_exposure_stops in [0, -6] {
            let red = stops_of(1.5, 0.0, 0.0, pre_exposure_stops);
            assert!((red + 1.5f64.log2()).abs() < 1e-6, "{red}: 1.5 comes to 1");
            assert!((stops_of(4.0, 0.0, 0.0, pre_exposure_stops) + 1.0).abs() < 1e-6, "a stop at most");
            let highlight = stops_of(40.0, 0.0, 0.0, pre_exposure_stops);
            assert!((highlight + 2.5).abs() < 1e-6, "{highlight}: and 1.5 for what is white");
            // Log2(1.5 / 0.18) = 3.0589; the curve leaves 1.2190, and of the 1.8399 stops less 0.3931 remain. White is
            // exceeded by the other 0.1919 of log2(1.5).
            let grey = stops_of(1.5, 1.5, 1.5, pre_exposure_stops);
            assert!((grey + 0.3931 + 0.1919).abs() < 1e-3, "{grey}: 1.5 comes to 1");
            let pale = stops_of(1.3, 1.3, 1.3, pre_exposure_stops);
            // Log2(1.3 / 0.18) = 2.8524; the curve leaves 1.2017, of the 1.6507 stops less 0.3837 remain: 0.9964.
            assert!((pale + 0.3837).abs() < 1e-3, "{pale}");
        }
        let unseen = Reading::new(&[0.0; 8], 0).metering(anchor, |_| 1.0);
        assert_eq!((unseen.log_average_luminance, unseen.stops), (None, 0.0));
    }

    #[test]
    fn highlights_lower_the_exposure_from_three_hundredths_of_the_surfaces_on() {
        // In a mean of 0.5 the environment's exposure is 0, and surfaces at mid grey leave it so. Half of the picture
        // shows it.
        let anchor = Anchor::new(glam::Vec3::splat(0.5), 1.0);
        let reading_of = |highlights: usize, value: f32, pre_exposure_stops: i32| {
            let scale = (pre_exposure_stops as f32).exp2();
            let value_of = |index: usize| scale * if index < highlights { value } else { 0.18 };
            let surface = (0..1000).flat_map(|index| [value_of(index), value_of(index), value_of(index), 1.0]);
            Reading::new(&surface.chain([0.0; 4000]).collect::<Vec<f32>>(), pre_exposure_stops)
        };
        for pre_exposure_stops in [0, -6] {
            let highlight_stops = |count, value| reading_of(count, value, pre_exposure_stops).highlight_stops(0.0);
            assert_eq!([highlight_stops(30, 40.0), highlight_stops(1000, 0.99)], [0.0; 2]);
            // 45 of 1000 are half of the band.
            assert!((highlight_stops(45, 2.0) - 0.5).abs() < 1e-6);
            assert!((highlight_stops(60, 2.0) - 1.0).abs() < 1e-6);
            assert!((highlight_stops(900, 2.0) - 1.0).abs() < 1e-6, "it is where white ends");
            assert!((highlight_stops(900, 400.0) - 1.5).abs() < 1e-6, "1.5 stops at most");
            let stops_of =
                |count, value| f64::from(reading_of(count, value, pre_exposure_stops).metering(anchor, |_| 1.0).stops);
            let [none, few, many] = [stops_of(0, 4.0), stops_of(30, 4.0), stops_of(100, 4.0)];
            // All of these are within half a stop of mid grey on the average.
            assert!(none.abs() < 1e-6 && few.abs() < 1e-6, "{none} {few}");
            assert!((many + 1.5).abs() < 1e-6, "{many}");
        }
    }

    #[test]
    fn clamped_pixels_are_taken_from_a_lower_reading() {
        let grey = |value: f32| [value, value, value, 1.0];
        let mut reading = Reading::new(&[grey(30_000.0), grey(8_192.0)].concat(), 0);
        assert!(reading.clamped_share() > 0.4);
        reading.mend(&Reading::new(&[grey(2.0), grey(0.125)].concat(), -16));
        let metering = reading.metering(None, |_| 1.0);
        assert!((metering.peak - 131_072.0).abs() < 1e-6);
        assert!((metering.log_average_luminance.unwrap_or_default() / 32_768.0 - 1.0).abs() < 0.1, "{metering:?}");
    }

    #[test]
    fn the_frame_has_the_shape_of_the_picture_at_one_size() {
        let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
        let size = |width, height| {
            let request = FrameRequest::new(width, height, View { world_from_view: Mat4::IDENTITY, projection });
            let small = metered(&request, LONGER_SIDE_PX);
            (small.width, small.height)
        };
        assert_eq!([size(1280, 720), size(64, 36)], [(128, 72); 2]);
        assert_eq!([size(100, 1), size(1, 1)], [(128, 1), (128, 128)]);
    }

    #[test]
    fn a_crowd_of_lights_that_reach_everywhere_is_metered_in_a_smaller_frame() {
        assert_eq!([0, 1, 2048].map(side_under), [LONGER_SIDE_PX; 3]);
        for lights in [4096, 16_000, 32_000] {
            let side = f64::from(side_under(lights));
            assert!(side < 128.0 && side * side * lights as f64 <= LIGHT_PIXELS_MAX, "{lights}: {side}");
        }
        assert_eq!(side_under(1_000_000), LONGER_SIDE_MIN_PX);
    }
}
