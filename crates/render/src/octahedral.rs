//! Unit vectors in two numbers, as `octahedral.wgsl` has them.

use glam::{Vec2, Vec3};

/// The twin of `octahedral.wgsl`.
pub(crate) fn direction_from_octahedral(v: Vec2) -> Vec3 {
    let z = 1.0 - v.x.abs() - v.y.abs();
    let wrap = |a: f32, b: f32| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    let xy = if z >= 0.0 { v } else { Vec2::new(wrap(v.x, v.y), wrap(v.y, v.x)) };
    xy.extend(z).normalize()
}
