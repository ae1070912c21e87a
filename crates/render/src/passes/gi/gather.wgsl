// gi: the light that a surface gets from others that the picture shows around it, and of its hemisphere the share, by
// the cosine, that they take.
// Sources: light of the picture's pixels for diffuse surfaces (Ritschel, Grosch & Seidel 2009, "Approximating Dynamic
// Global Illumination in Image Space"), by horizons whose light is that of the arc by which each rises (Mayaux 2018,
// "Horizon-Based Indirect Lighting"), in the form of `shaders/horizons.wgsl`. Differs from them: where light comes past
// behind what is thin, that takes the same part of the light along that was found below, so that what is found is never
// brighter than the brightest that is seen. Reads: normal, linear_depth, radiance. Writes: the mean radiance, by the
// cosine, times that share, and the share (a sample of few slices may lie above 1).
// Program: gi_gather.

import package::view::view;
import package::constants::RADIANCE_MAX;
import package::passes::gi::gathered::{gi, patterned, side};
import package::shaders::brdf::PI;
import package::shaders::coarse::pixel_of_texel;
import package::shaders::gbuffer_textures::normal_world_at;
import package::shaders::horizons::{Slice, arc_of_cosine, elevation_of, place_along, slice_at, steps_within};
import package::shaders::samplers::nearest_clamp;
import package::shaders::screen_space::{Center, center_at, seen_from, slice_noise};

@group(1) @binding(5) var scene_radiance: texture_2d<f32>;

override slices: u32 = 2u;
override steps: u32 = 12u;

// What a surface at `seen` from the center, which the picture shows at a place, sends to the center: nothing from its
// other side, which the picture does not show.
fn radiance_towards(position_px: vec2f, seen: vec3f) -> vec3f {
    let middle_px = clamp(floor(position_px) + 0.5, vec2f(0.5), view.size_px - 0.5);
    let normal = (view.view_from_world * vec4f(normal_world_at(vec2i(middle_px)), 0.0)).xyz;
    let texel = textureSampleLevel(scene_radiance, nearest_clamp, middle_px * view.inverse_size_px, 0.0).rgb;
    let radiance = clamp(texel, vec3f(0.0), vec3f(RADIANCE_MAX));
    let brightest = max(max(radiance.r, radiance.g), max(radiance.b, 1e-6));
    let facing = select(0.0, 1.0, dot(normal, seen) < 0.0);
    return radiance * (facing * min(gi.radiance_max / brightest, 1.0));
}

// The light of what rises along a slice, to the side of `tangent`: the one of `along` if `side_sign` is 1, and the other
// if it is -1. The last is the arc that it takes.
fn light_beside(center: Center, slice: Slice, side_sign: f32, noise: f32) -> vec4f {
    let tangent = side_sign * slice.tangent;
    let lowest = dot(tangent, center.to_eye);
    let tilt = vec2f(cos(slice.tilt), sin(slice.tilt));
    let open = arc_of_cosine(lowest, side_sign, tilt);
    var horizon = lowest;
    var covered = 0.0;
    var taken = vec4f(0.0);
    let count = steps_within(slice.step_px, steps);
    for (var i = 0u; i < count; i++) {
        let position_px = place_along(center, side_sign * slice.step_px, i, steps, noise);
        let seen = seen_from(center, position_px);
        let elevation = elevation_of(center, slice, tangent, seen.xyz);
        let near = clamp((gi.radius_m - length(seen.xyz)) * gi.fade_per_m, 0.0, 1.0);
        let share = select(0.0, near * seen.w, elevation.y > 0.0);
        let cosine = max(elevation.x, lowest);
        let rises = (share > 0.0) & (cosine > horizon);
        horizon = select(mix(horizon, cosine, gi.thinness * share), cosine, rises);
        let below = max(open - arc_of_cosine(horizon, side_sign, tilt), 0.0);
        let more = vec4f(radiance_towards(position_px, seen.xyz), 1.0) * (share * max(below - covered, 0.0));
        let kept = min(below / max(covered, 1e-6), 1.0);
        taken = select(taken * kept, taken + more, rises);
        covered = below;
    }
    return taken;
}

@fragment
fn fs_gi_gather(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let center = center_at(pixel_of_texel(vec2i(position.xy), i32(side)));
    if !center.is_surface {
        return vec4f(0.0);
    }
    let noise = slice_noise(position.xy, patterned != 0u, 45u);
    var taken = vec4f(0.0);
    for (var i = 0u; i < slices; i++) {
        let slice = slice_at(center, (f32(i) + noise.x) / f32(max(slices, 1u)) * PI, gi.radius_m);
        let beside = light_beside(center, slice, 1.0, noise.y) + light_beside(center, slice, -1.0, noise.y);
        taken += slice.projected_length * beside;
    }
    return taken / f32(max(slices, 1u));
}
