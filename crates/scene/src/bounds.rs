//! Axis-aligned boxes.

use glam::{Mat4, Vec3};

/// A box whose middle lies so many of its half diagonals from the origin is far away. A float has 24 bits, so that
/// positions there are rounded to about 1/1,000 of the half diagonal, which is half a pixel of a picture 1,000 pixels
/// high.
const FAR_RADII: f32 = 10_000.0;

/// A box whose middle lies so many of its half diagonals from the origin is drawn elsewhere: positions there are
/// rounded to 1/100,000 of the half diagonal, of which nothing is seen yet.
const AWAY_RADII: f32 = 100.0;

/// Whether something of a size lies so far away for it that it is better told from its middle.
pub(crate) fn is_away(distance_m: f32, radius_m: f32) -> bool {
    // A point loses nothing.
    radius_m > 0.0 && distance_m.is_finite() && distance_m > AWAY_RADII * radius_m
}

/// A number with three digits that stand for all.
fn rounded(value: f32) -> f64 {
    format!("{value:.2e}").parse().unwrap_or_default()
}

/// An axis-aligned box in metres. An empty box has `min > max` in every component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around `points`; points that are not finite are passed over.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points
            .into_iter()
            .filter(|point| point.is_finite())
            .fold(Self::EMPTY, |bounds, point| Self { min: bounds.min.min(point), max: bounds.max.max(point) })
    }

    /// Whether the box contains no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle of the box; the origin if the box is empty.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { 0.5 * (self.min + self.max) }
    }

    /// Half the diagonal in metres; 0 if the box is empty.
    pub fn radius_m(&self) -> f32 {
        if self.is_empty() { 0.0 } else { 0.5 * (self.max - self.min).length() }
    }

    /// Whether the box lies so far from the origin for its size that what is in it is better told from its middle.
    pub fn is_away(&self) -> bool {
        is_away(self.center().length(), self.radius_m())
    }

    /// Whether so much room lies between the boxes for their size that in a picture of both neither is more than a few
    /// pixels large.
    pub fn is_far_from(&self, other: &Self) -> bool {
        let distance_m = self.center().distance(other.center());
        !self.is_empty() && !other.is_empty() && is_away(distance_m, self.radius_m().max(other.radius_m()))
    }

    /// What is said of a box so far from the origin that the rounding of its positions, which are 32-bit floats, shows
    /// in a picture of it.
    pub fn far_warning(&self) -> Option<String> {
        // Of what has no extent, nothing is known but where it lies: it may have lost its extent by that.
        let radius_m = Some(self.radius_m()).filter(|radius_m| *radius_m > 0.0).unwrap_or(1.0);
        let center = self.center();
        let distance_m = center.length();
        if distance_m <= FAR_RADII * radius_m {
            return None;
        }
        let largest = self.min.abs().max(self.max.abs()).max_element();
        let rounding_m = f32::from_bits(largest.to_bits() + 1) - largest;
        Some(format!(
            "it lies {} m from the origin and is {} m across: positions there are rounded to {} m, which may show in edges and \
             shadows; move it to the origin: leave out its node's translation, or subtract {} {} {} from its positions",
            rounded(distance_m),
            rounded(self.radius_m() * 2.0),
            rounded(rounding_m),
            rounded(center.x),
            rounded(center.y),
            rounded(center.z),
        ))
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// The box around this box after an affine transform.
    pub fn transformed(&self, matrix: &Mat4) -> Self {
        if self.is_empty() {
            return *self;
        }
        Self::from_points(self.corners().map(|corner| matrix.transform_point3(corner)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_far_from_the_origin_for_its_size_is_warned_of() {
        let at = |center: Vec3, half_m: f32| Aabb { min: center - half_m, max: center + half_m }.far_warning();
        assert_eq!((at(Vec3::ZERO, 0.5), at(Vec3::new(5e3, 0.0, 0.0), 0.5)), (None, None));
        assert_eq!((Aabb::EMPTY.far_warning(), at(Vec3::new(500_000.0, 120.0, -4_500_000.0), 500.0)), (None, None));
        // A single point near the origin is no matter.
        assert_eq!(at(Vec3::ONE, 0.0), None);
        let said = at(Vec3::new(500_000.0, 120.0, -4_500_000.0), 25.0).unwrap_or_default();
        let expected = ["4530000 m from", "86.6 m across", "rounded to 0.5 m", "subtract 500000 120 -4500000"];
        assert!(expected.iter().all(|part| said.contains(part)), "{said}");
        // A cube that has no extent left.
        assert!(at(Vec3::splat(1e8), 0.5).is_some_and(|said| said.contains("is 0 m across") && said.contains("8 m")));
    }
}
