// occlusion: of the environment's diffuse light the share that reaches a surface, by how high others rise around it.
// Source: Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", in the form of
// `shaders/horizons.wgsl`. Differs from it: what is written is 1 less the mean of what slices lose, whose expectation is
// the same, and which is 1 where nothing is lost. Reads: normal, linear_depth. Writes: occlusion (r; a sample of few
// slices may lie outside of 0 to 1), with `bends` also the mean direction of what is left (gba, in world space, its
// length tells nothing).
// Program: occlusion_gtao.

import package::shaders::brdf::PI;
import package::shaders::horizons::{Slice, arc, elevation_of, place_along, slice_at, steps_within};
import package::shaders::screen_space::{Center, seen_from};
import package::passes::occlusion::taps::{
    bends, center_of_texel, noise_at, occlusion, share_at, slices, steps, texel_of_background, texel_of_loss,
};

// The cosine from the line of sight of the highest that rises along a slice, to the side of `tangent`.
fn horizon_cosine(center: Center, slice: Slice, step_px: vec2f, tangent: vec3f, noise: f32) -> f32 {
    let lowest = dot(tangent, center.to_eye);
    var horizon = lowest;
    let count = steps_within(step_px, steps);
    for (var i = 0u; i < count; i++) {
        let seen = seen_from(center, place_along(center, step_px, i, steps, noise));
        let elevation = elevation_of(center, slice, tangent, seen.xyz);
        // Seen at a grazing angle, the nearest pixel on the plane may lie to the other side.
        let share = select(0.0, share_at(sqrt(dot(seen.xyz, seen.xyz))) * seen.w, elevation.y > 0.0);
        let risen = mix(lowest, max(elevation.x, lowest), share);
        horizon = select(mix(horizon, risen, occlusion.thinness * share), risen, risen > horizon);
    }
    return horizon;
}

// As `arc`, of the directions in a slice: the component across the line of sight, and that along it.
fn arc_direction(angle: f32, tilt: f32) -> vec2f {
    let across = 6.0 * sin(angle - tilt) - sin(3.0 * angle - tilt) - 3.0 * sin(angle + tilt) + 8.0 * sin(tilt);
    let along = 4.0 * cos(tilt) - cos(3.0 * angle - tilt) - 3.0 * cos(angle + tilt);
    return vec2f(across, along) / 12.0;
}

@fragment
fn fs_occlusion_gtao(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let center = center_of_texel(vec2i(position.xy));
    if !center.is_surface {
        return texel_of_background();
    }
    let noise = noise_at(position.xy);
    var lost = 0.0;
    var lost_direction = vec3f(0.0);
    for (var i = 0u; i < slices; i++) {
        let slice = slice_at(center, (f32(i) + noise.x) / f32(max(slices, 1u)) * PI, occlusion.radius_m);
        let tilt = slice.tilt;
        let rises_before = horizon_cosine(center, slice, slice.step_px, slice.tangent, noise.y);
        let rises_behind = horizon_cosine(center, slice, -slice.step_px, -slice.tangent, noise.y);
        let before = acos(clamp(rises_before, -1.0, 1.0));
        let behind = -acos(clamp(rises_behind, -1.0, 1.0));
        let whole = cos(tilt) + tilt * sin(tilt);
        lost += slice.projected_length * (whole - arc(before, tilt) - arc(behind, tilt));
        if bends != 0u {
            let open = arc_direction(tilt + 0.5 * PI, tilt) + arc_direction(tilt - 0.5 * PI, tilt);
            let missing = open - arc_direction(before, tilt) - arc_direction(behind, tilt);
            lost_direction += slice.projected_length * (missing.x * slice.along + missing.y * center.to_eye);
        }
    }
    let share = 1.0 / f32(max(slices, 1u));
    return texel_of_loss(center, lost * share, lost_direction * share);
}
