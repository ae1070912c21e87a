//! Unit vectors in two numbers, as `octahedral.wgsl` has them.

use glam::{Vec2, Vec3};

/// The twin of `octahedral.wgsl`.
pub(crate) fn direction_from_octahedral(v: Vec2) -> Vec3 {
    let z = 1.0 - v.x.abs() - v.y.abs();
    let wrap = |a: f32, b: f32| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    let xy = if z >= 0.0 { v } else { Vec2::new(wrap(v.x, v.y), wrap(v.y, v.x)) };
    xy.extend(z).normalize()
}

/// The twin of `octahedral.wgsl`; of no direction it is that of +Z.
pub(crate) fn octahedral_from_direction(direction: Vec3) -> Vec2 {
    let n = direction / direction.abs().element_sum().max(1e-20);
    let wrap = |a: f32, b: f32| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    if n.z >= 0.0 { n.truncate() } else { Vec2::new(wrap(n.x, n.y), wrap(n.y, n.x)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_come_back() {
        for direction in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.3, -0.5, -0.7), Vec3::new(-0.9, 0.1, 0.2)] {
            let direction = direction.normalize();
            let back = direction_from_octahedral(octahedral_from_direction(direction));
            assert!(back.dot(direction) > 0.999_999, "{direction} {back}");
        }
        assert_eq!(octahedral_from_direction(Vec3::ZERO), Vec2::ZERO);
    }
}
