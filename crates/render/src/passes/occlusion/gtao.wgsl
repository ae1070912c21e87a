// occlusion: of the environment's diffuse light the share that reaches a surface, by how high others rise around it.
// Source: Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion": slices through the line
// of sight, in which visibility is weighted by the cosine in closed form. Differs from it:
// - slices are spread evenly around the line of sight, not around the camera's axis, so that the integral is right away
// from the middle;
// - a texel's height is that over the tangent plane, so that no texel of a plane rises over the plane, wherever in its
// pixel it lies;
// - what is written is 1 less the mean of what slices lose, whose expectation is the same, and which is 1 where nothing
// is lost. Reads: normal, linear_depth. Writes: occlusion (r; a sample of few slices may lie outside of 0 to 1), with
// `bends` also the mean direction of what is left (gba, in world space, its length tells nothing).
// Program: occlusion_gtao.

import package::view::{view, pixel_step_from_step_view};
import package::shaders::brdf::PI;
import package::shaders::screen_space::Center;
import package::passes::occlusion::taps::{
    bends, center_of_texel, noise_at, occlusion, seen_from, share_at, slices, steps, texel_of_loss,
};

// Depth of 32 bits and normals of 16 bits leave heights of a plane's texels as exact as this, as a share of their
// distance.
const HEIGHT_NOISE: f32 = 2e-4;
// Longer ways in the picture are cut off, as a share of its height: near surfaces would be looked at in too few places.
const REACH_MAX: f32 = 0.5;

// The cosine from the line of sight of the highest that rises along a slice, to one side. `tangent` is the direction of
// that side on the surface, `upright` at right angles to it within the slice, and 1 / how long the normal is there.
fn horizon_cosine(center: Center, step_px: vec2f, tangent: vec3f, upright: vec4f, place: f32) -> f32 {
    let lowest = dot(tangent, center.to_eye);
    let highest = dot(upright.xyz, center.to_eye);
    let length_px = max(length(step_px), 1e-6);
    let direction_px = step_px / length_px;
    var horizon = lowest;
    for (var i = 0u; i < steps; i++) {
        let along = (f32(i) + place) / f32(max(steps, 1u));
        // Not the texel itself.
        let position_px = center.position_px + direction_px * max(along * sqrt(along) * length_px, 1.0 + f32(i));
        let seen = seen_from(center, position_px);
        let length_m = sqrt(dot(seen.xyz, seen.xyz));
        let height = dot(seen.xyz, center.normal) - HEIGHT_NOISE * length_m;
        let offset = vec2f(dot(seen.xyz, tangent), height * upright.w);
        let cosine = dot(offset, vec2f(lowest, highest)) * inverseSqrt(max(dot(offset, offset), 1e-30));
        // Seen at a grazing angle, the nearest pixel on the plane may lie to the other side.
        let share = select(0.0, share_at(length_m) * seen.w, height > 0.0);
        let risen = mix(lowest, max(cosine, lowest), share);
        horizon = select(mix(horizon, risen, occlusion.thinness * share), risen, risen > horizon);
    }
    return horizon;
}

// The integral over a slice from the line of sight to an angle of |sin| times the cosine from the normal, whose angle
// is `tilt`.
fn arc(angle: f32, tilt: f32) -> f32 {
    return 0.25 * (cos(tilt) - cos(2.0 * angle - tilt) + 2.0 * angle * sin(tilt));
}

// The same of its directions: the component across the line of sight, and that along it.
fn arc_direction(angle: f32, tilt: f32) -> vec2f {
    let across = 6.0 * sin(angle - tilt) - sin(3.0 * angle - tilt) - 3.0 * sin(angle + tilt) + 8.0 * sin(tilt);
    let along = 4.0 * cos(tilt) - cos(3.0 * angle - tilt) - 3.0 * cos(angle + tilt);
    return vec2f(across, along) / 12.0;
}

@fragment
fn fs_occlusion_gtao(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let center = center_of_texel(vec2i(position.xy));
    if !center.is_surface {
        return vec4f(1.0, 0.0, 0.0, 0.0);
    }
    let noise = noise_at(position.xy);
    // Directions at right angles to the line of sight.
    let right = normalize(vec3f(center.to_eye.z, 0.0, -center.to_eye.x));
    let up = cross(center.to_eye, right);
    var lost = 0.0;
    var lost_direction = vec3f(0.0);
    for (var i = 0u; i < slices; i++) {
        let turn = (f32(i) + noise.x) / f32(max(slices, 1u)) * PI;
        let along = cos(turn) * right + sin(turn) * up;
        let across = cross(along, center.to_eye);
        // The normal within the slice.
        let projected = center.normal - across * dot(center.normal, across);
        let projected_length = length(projected);
        let normal = projected / projected_length;
        let tilt = atan2(dot(normal, along), dot(normal, center.to_eye));
        let tangent = cos(tilt) * along - sin(tilt) * center.to_eye;
        let upright = vec4f(normal, 1.0 / projected_length);
        let reach_px = pixel_step_from_step_view(center.position, along * occlusion.radius_m);
        let reach_max_px = REACH_MAX * view.size_px.y;
        let step_px = reach_px * min(reach_max_px / max(length(reach_px), 1e-6), 1.0);
        let before = acos(clamp(horizon_cosine(center, step_px, tangent, upright, noise.y), -1.0, 1.0));
        let behind = -acos(clamp(horizon_cosine(center, -step_px, -tangent, upright, noise.y), -1.0, 1.0));
        let whole = cos(tilt) + tilt * sin(tilt);
        lost += projected_length * (whole - arc(before, tilt) - arc(behind, tilt));
        if bends != 0u {
            let open = arc_direction(tilt + 0.5 * PI, tilt) + arc_direction(tilt - 0.5 * PI, tilt);
            let missing = open - arc_direction(before, tilt) - arc_direction(behind, tilt);
            lost_direction += projected_length * (missing.x * along + missing.y * center.to_eye);
        }
    }
    let share = 1.0 / f32(max(slices, 1u));
    return texel_of_loss(center, lost * share, lost_direction * share);
}
