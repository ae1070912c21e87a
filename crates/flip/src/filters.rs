//! The filters of FLIP: how sensitive eyes are to contrast, and detectors of edges and points.

use crate::kernel::Kernel;
use std::f64::consts::PI;

/// One of the Gaussians that approximate a contrast sensitivity function: a √(π / b) exp(−π² d² / b), d in degrees.
struct Gaussian {
    a: f64,
    b: f64,
}

/// The table of the paper: luminance, red against green, blue against yellow.
const LUMINANCE: Gaussian = Gaussian { a: 1.0, b: 0.0047 };
const RED_GREEN: Gaussian = Gaussian { a: 1.0, b: 0.0053 };
const BLUE_YELLOW: [Gaussian; 2] = [Gaussian { a: 34.1, b: 0.04 }, Gaussian { a: 13.5, b: 0.025 }];

/// The width of an edge or point in degrees; the standard deviation of its detectors is half of that.
const FEATURE_WIDTH_DEG: f64 = 0.082;

/// The filters for some number of pixels a degree. Each is one row of weights, to be used along rows and along columns.
#[derive(Debug)]
pub struct Filters {
    pub luminance: Kernel,
    pub red_green: Kernel,
    /// Two, whose results along rows and columns add up; the share of each is in its weights along columns.
    pub blue_yellow: [Kernel; 2],
    pub blue_yellow_columns: [Kernel; 2],
    /// A Gaussian, its first and its second derivative.
    pub smooth: Kernel,
    pub edge: Kernel,
    pub point: Kernel,
}

impl Filters {
    /// The filters for `pixels_per_degree`, which is in [`crate::PIXELS_PER_DEGREE_RANGE`].
    pub fn new(pixels_per_degree: f64) -> Self {
        // All of them have the window of the widest, three standard deviations.
        let sigma_deg = (BLUE_YELLOW[0].b / (2.0 * PI * PI)).sqrt();
        let window_px = (3.0 * sigma_deg * pixels_per_degree).ceil();
        let exponent = |gaussian: &Gaussian| PI * PI / (gaussian.b * pixels_per_degree * pixels_per_degree);
        let contrast = |gaussian: &Gaussian, share: f64| {
            let exponent = exponent(gaussian);
            // Weights below 10⁻⁹ are none.
            let reach_px = (20.7 / exponent).sqrt().ceil().min(window_px);
            let weight = |x: f64| (-exponent * x * x).exp();
            Kernel::new(reach_px as usize, share / sum(reach_px, weight), weight)
        };
        let volume = |gaussian: &Gaussian| {
            let exponent = exponent(gaussian);
            gaussian.a * (PI / gaussian.b).sqrt() * sum(window_px, |x| (-exponent * x * x).exp()).powi(2)
        };
        let volumes = BLUE_YELLOW.each_ref().map(volume);
        let [wide, narrow] = volumes.map(|volume| volume / (volumes[0] + volumes[1]));

        let sigma_px = 0.5 * FEATURE_WIDTH_DEG * pixels_per_degree;
        let reach_px = (3.0 * sigma_px).ceil();
        let smooth = |x: f64| (-x * x / (2.0 * sigma_px * sigma_px)).exp();
        let edge = |x: f64| -x * smooth(x);
        let point = |x: f64| (x * x / (sigma_px * sigma_px) - 1.0) * smooth(x);
        // Positive weights of the detectors add up to 1, negative ones to −1.
        let halves = |weight: &dyn Fn(f64) -> f64| {
            let positive = sum(reach_px, |x| weight(x).max(0.0));
            let negative = sum(reach_px, |x| (-weight(x)).max(0.0));
            Kernel::new(reach_px as usize, 1.0, |x| {
                if weight(x) > 0.0 { weight(x) / positive } else { weight(x) / negative }
            })
        };
        Self {
            luminance: contrast(&LUMINANCE, 1.0),
            red_green: contrast(&RED_GREEN, 1.0),
            blue_yellow: BLUE_YELLOW.each_ref().map(|gaussian| contrast(gaussian, 1.0)),
            blue_yellow_columns: [contrast(&BLUE_YELLOW[0], wide), contrast(&BLUE_YELLOW[1], narrow)],
            smooth: Kernel::new(reach_px as usize, 1.0 / sum(reach_px, smooth), smooth),
            edge: halves(&edge),
            point: halves(&point),
        }
    }

    /// How many pixels the widest of them reaches.
    pub fn radius_px(&self) -> usize {
        let [wide, narrow] = &self.blue_yellow;
        let all = [&self.luminance, &self.red_green, wide, narrow, &self.smooth, &self.edge, &self.point];
        all.iter().map(|kernel| kernel.radius_px()).max().unwrap_or(0)
    }
}

fn sum(reach_px: f64, weight: impl Fn(f64) -> f64) -> f64 {
    let reach = reach_px as i64;
    (-reach..=reach).map(|x| weight(x as f64)).sum()
}
