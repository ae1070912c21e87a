// Slices through the line of sight of a surface, and how much of its light lies below an angle in them.
// Source: Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion": slices in which
// visibility is weighted by the cosine in closed form. Differs from it:
// - slices are spread evenly around the line of sight, not around the camera's axis, so that the integral is right away
// from the middle;
// - a texel's height is that over the tangent plane, so that no texel of a plane rises over the plane, wherever in its
// pixel it lies.

import package::view::{view, pixel_step_from_step_view};
import package::shaders::screen_space::Center;

// Depth of 32 bits and normals of 16 bits leave heights of a plane's texels as exact as this, as a share of their
// distance.
const HEIGHT_NOISE: f32 = 2e-4;
// Longer ways in the picture are cut off, as a share of its height: near surfaces would be looked at in too few places.
const REACH_MAX: f32 = 0.5;

struct Slice {
    // At right angles to the line of sight within the slice.
    along: vec3f,
    // The normal within the slice, how long it is there, and its angle from the line of sight.
    normal: vec3f,
    projected_length: f32,
    tilt: f32,
    // The direction of the side of `along` on the surface.
    tangent: vec3f,
    // The way in the picture to that side, as far as is looked.
    step_px: vec2f,
}

// The slice at an angle around the line of sight, of which `radius_m` is looked at.
fn slice_at(center: Center, turn: f32, radius_m: f32) -> Slice {
    // Directions at right angles to the line of sight.
    let right = normalize(vec3f(center.to_eye.z, 0.0, -center.to_eye.x));
    let up = cross(center.to_eye, right);
    var slice: Slice;
    slice.along = cos(turn) * right + sin(turn) * up;
    let across = cross(slice.along, center.to_eye);
    let projected = center.normal - across * dot(center.normal, across);
    slice.projected_length = length(projected);
    slice.normal = projected / slice.projected_length;
    slice.tilt = atan2(dot(slice.normal, slice.along), dot(slice.normal, center.to_eye));
    slice.tangent = cos(slice.tilt) * slice.along - sin(slice.tilt) * center.to_eye;
    let reach_px = pixel_step_from_step_view(center.position, slice.along * radius_m);
    let reach_max_px = REACH_MAX * view.size_px.y;
    slice.step_px = reach_px * min(reach_max_px / max(length(reach_px), 1e-6), 1.0);
    return slice;
}

// The place in the picture of a step to one side of a slice: denser near the center, and never its own texel.
fn place_along(center: Center, step_px: vec2f, step: u32, steps: u32, noise: f32) -> vec2f {
    let length_px = max(length(step_px), 1e-6);
    let along = (f32(step) + noise) / f32(max(steps, 1u));
    return center.position_px + step_px / length_px * max(along * sqrt(along) * length_px, 1.0 + f32(step));
}

// How many of the steps of a slice are looked at: each lies at least a pixel beyond the one before, so that those past
// the end of the way are farther than the radius, or than the way that is cut off.
fn steps_within(step_px: vec2f, steps: u32) -> u32 {
    return u32(min(ceil(length(step_px)), f32(steps)));
}

// Of what lies at `seen` from the center, the cosine of its angle from the line of sight within a slice; and how high
// it rises over the surface.
fn elevation_of(center: Center, slice: Slice, tangent: vec3f, seen: vec3f) -> vec2f {
    let height = dot(seen, center.normal) - HEIGHT_NOISE * sqrt(dot(seen, seen));
    let offset = vec2f(dot(seen, tangent), height * (1.0 / slice.projected_length));
    let eye = vec2f(dot(tangent, center.to_eye), dot(slice.normal, center.to_eye));
    return vec2f(dot(offset, eye) * inverseSqrt(max(dot(offset, offset), 1e-30)), height);
}

// The integral over a slice from the line of sight to an angle of |sin| times the cosine from the normal, whose angle
// is `tilt`.
fn arc(angle: f32, tilt: f32) -> f32 {
    return 0.25 * (cos(tilt) - cos(2.0 * angle - tilt) + 2.0 * angle * sin(tilt));
}

// `arc` of the angle of a cosine, to the side of `along` if `side_sign` is 1 and to the other if it is -1, with the
// cosine and the sine of the tilt: one inverse cosine in place of three functions of angles.
fn arc_of_cosine(cosine: f32, side_sign: f32, tilt: vec2f) -> f32 {
    let c = clamp(cosine, -1.0, 1.0);
    let sine = side_sign * sqrt(1.0 - c * c);
    let turned = (2.0 * c * c - 1.0) * tilt.x + 2.0 * c * sine * tilt.y;
    return 0.25 * (tilt.x - turned + 2.0 * side_sign * acos(c) * tilt.y);
}
