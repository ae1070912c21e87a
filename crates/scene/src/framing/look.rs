//! Where cameras look.

use glam::{Mat3, Quat, Vec3};

/// The rotation of a camera that looks along `direction`, whose length does not matter. Where `up` is parallel to it,
/// another up is taken; none where the direction is none.
pub fn look_along(direction: Vec3, up: Vec3) -> Option<Quat> {
    let longest = direction.abs().max_element();
    let back = -(direction / longest).try_normalize().filter(|_| longest > 0.0)?;
    let right = up.cross(back).try_normalize().unwrap_or_else(|| back.any_orthonormal_vector());
    Some(Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back)))
}
