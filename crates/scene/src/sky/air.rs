//! What the air of the Earth does to light, and the ways of rays through it. Lengths are in km, coefficients per km,
//! for red, green and blue light (680, 550 and 440 nm).

use glam::DVec3;
use std::f64::consts::PI;

/// From the middle of the Earth to its ground, and to the end of its air.
pub(super) const GROUND_KM: f64 = 6360.0;
pub(super) const TOP_KM: f64 = 6460.0;

/// Coefficients on the ground: Bruneton 2017, "Precomputed Atmospheric Scattering: a New Implementation"; Hillaire
/// 2020, table 1.
const RAYLEIGH_SCATTERING: DVec3 = DVec3::new(5.802e-3, 13.558e-3, 33.1e-3);
const RAYLEIGH_SCALE_KM: f64 = 8.0;
const MIE_SCATTERING: f64 = 3.996e-3;
const MIE_EXTINCTION: f64 = 4.44e-3;
const MIE_SCALE_KM: f64 = 1.2;
const MIE_G: f64 = 0.8;
const OZONE_ABSORPTION: DVec3 = DVec3::new(0.650e-3, 1.881e-3, 0.085e-3);
const OZONE_MIDDLE_KM: f64 = 25.0;
const OZONE_HALF_KM: f64 = 15.0;

/// The air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// How much haze there is beside what the paper has.
    haze: f64,
}

/// The air at a height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium {
    pub rayleigh: DVec3,
    pub mie: f64,
    pub extinction: DVec3,
}

impl Medium {
    /// All that is scattered.
    pub fn scattering(&self) -> DVec3 {
        self.rayleigh + self.mie
    }
}

impl Air {
    /// With a `turbidity`: the optical depth of air and haze straight up, divided by that of the air alone, in green
    /// light.
    pub fn new(turbidity: f64) -> Self {
        let haze_depth = (turbidity - 1.0).max(0.0) * RAYLEIGH_SCATTERING.y * RAYLEIGH_SCALE_KM;
        Self { haze: haze_depth / (MIE_EXTINCTION * MIE_SCALE_KM) }
    }

    pub fn at(&self, height_km: f64) -> Medium {
        let rayleigh = RAYLEIGH_SCATTERING * (-height_km / RAYLEIGH_SCALE_KM).exp();
        let haze = self.haze * (-height_km / MIE_SCALE_KM).exp();
        let ozone = (1.0 - (height_km - OZONE_MIDDLE_KM).abs() / OZONE_HALF_KM).max(0.0);
        Medium {
            rayleigh,
            mie: MIE_SCATTERING * haze,
            extinction: rayleigh + MIE_EXTINCTION * haze + OZONE_ABSORPTION * ozone,
        }
    }
}

/// How much of scattered light goes in a direction, by the cosine of the angle from its way: air, then haze (Cornette &
/// Shanks 1992).
pub(super) fn phases(cosine: f64) -> [f64; 2] {
    let g2 = MIE_G * MIE_G;
    let rayleigh = 3.0 / (16.0 * PI) * (1.0 + cosine * cosine);
    let toward = (1.0 + g2 - 2.0 * MIE_G * cosine).powf(1.5);
    [rayleigh, 3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + cosine * cosine) / ((2.0 + g2) * toward)]
}

/// A ray through the air: where it begins, and the cosine of its angle from straight up there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub radius_km: f64,
    pub cosine: f64,
}

impl Ray {
    /// Half the discriminant of where it meets a sphere.
    fn discriminant(&self, sphere_km: f64) -> f64 {
        let Self { radius_km, cosine } = self;
        radius_km * radius_km * (cosine * cosine - 1.0) + sphere_km * sphere_km
    }

    /// Whether it ends on the ground.
    pub fn meets_ground(&self) -> bool {
        self.cosine < 0.0 && self.discriminant(GROUND_KM) >= 0.0
    }

    /// The way to the end of the air, through the ground if that is in the way.
    pub fn to_top_km(self) -> f64 {
        (-self.radius_km * self.cosine + self.discriminant(TOP_KM).max(0.0).sqrt()).max(0.0)
    }

    /// The way to its end: on the ground, or where the air ends.
    pub fn length_km(&self) -> f64 {
        if self.meets_ground() {
            (-self.radius_km * self.cosine - self.discriminant(GROUND_KM).sqrt()).max(0.0)
        } else {
            self.to_top_km()
        }
    }

    /// The distance from the middle of the Earth after a way.
    pub fn radius_at(&self, way_km: f64) -> f64 {
        let Self { radius_km, cosine } = self;
        (radius_km * radius_km + way_km * (way_km + 2.0 * radius_km * cosine)).max(0.0).sqrt()
    }
}
