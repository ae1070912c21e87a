// Light that fog scatters once on its way from lights to the eye, along a ray up to where a surface ends it.
// Lights that shine everywhere are looked at in places that are equal by what fog takes of their light (directional
// ones), or by the angle in which they see the ray. Others are found in the lists of the clusters that the ray goes
// through, and looked at in one place of each, by that angle: what is near a light is bright, and its 1 / d² cancels.
// Source: Kulla & Fajardo 2012, "Importance Sampling Techniques for Path Tracing in Participating Media" (equiangular
// places); Henyey & Greenstein 1941 (phase). Places are spread over pixels by interleaved gradient noise (Jimenez 2014)
// and over samples by the golden ratio. Differs: lights do not lose strength on their way to the fog.

import package::view::{view, direction_to_eye_world};
import package::shaders::fog::{FogRay, fog, fog_ray, fog_density_per_m, optical_depth, distance_at_depth, ray_length_m};
import package::shaders::light_table::{
    LIGHT_AXIS, LIGHT_COLOR, LIGHT_POSITION, cluster_at, cluster_grid, cluster_light_at, light_part, light_place, table_rows,
};
import package::shaders::shadows::{directional_visibility_in_air, punctual_visibility_in_air, shadowed};

// Nearer than this a ray does not pass a light, in metres: a place has no size.
const ASIDE_MIN_M: f32 = 1e-4;
const FOUR_PI: f32 = 12.5663706;

// A ray, from where it enters fog to its end.
struct Air {
    origin_world: vec3f,
    direction_world: vec3f,
    length_m: f32,
    fog: FogRay,
}

// 0 to 1, another value for every pixel and sample; neighbours are far apart.
fn interleaved_noise(position_px: vec2f) -> f32 {
    let noise = fract(52.9829189 * fract(dot(floor(position_px), vec2f(0.06711056, 0.00583715))));
    return fract(noise + f32(view.sample_index) * 0.61803398875);
}

// Scattered into the ray, by the cosine between the ways of light before and after.
fn phase(cos_turn: f32) -> f32 {
    let g = fog.anisotropy;
    let squared = max(1.0 + g * g - 2.0 * g * cos_turn, 1e-6);
    return (1.0 - g * g) / (FOUR_PI * squared * sqrt(squared));
}

// A directional light, at a place that stands for `lost` of what fog takes.
fn directional_in_air(index: u32, air: Air, at_m: f32, lost: f32) -> vec3f {
    let table_uv = light_place(index, table_rows());
    var irradiance = light_part(table_uv, LIGHT_COLOR).rgb;
    let to_light = -light_part(table_uv, LIGHT_AXIS).xyz;
    if shadowed != 0u {
        irradiance *= directional_visibility_in_air(table_uv, air.origin_world + air.direction_world * at_m);
    }
    return irradiance * (lost * phase(dot(to_light, air.direction_world)));
}

// A light at a place, over the part of the ray from `first_m` to `last_m`, of which the share `place` is looked at.
fn punctual_in_air(index: u32, air: Air, first_m: f32, last_m: f32, place: f32) -> vec3f {
    let table_uv = light_place(index, table_rows());
    let source = light_part(table_uv, LIGHT_POSITION);
    let towards = source.xyz - air.origin_world;
    let middle_m = dot(towards, air.direction_world);
    let across = towards - middle_m * air.direction_world;
    let aside_squared = max(dot(across, across), ASIDE_MIN_M * ASIDE_MIN_M);
    if aside_squared * source.w >= 1.0 {
        return vec3f(0.0);
    }
    // What of it lies within the light's range.
    let half_chord_m = select(3e18, sqrt(1.0 / max(source.w, 1e-37) - aside_squared), source.w > 0.0);
    let first = max(first_m - middle_m, -half_chord_m);
    let last = min(last_m - middle_m, half_chord_m);
    if first >= last {
        return vec3f(0.0);
    }
    let aside_m = sqrt(aside_squared);
    let angle = atan(first / aside_m);
    let opening = atan(last / aside_m) - angle;
    let along_m = clamp(aside_m * tan(angle + place * opening), first, last);
    let at_m = middle_m + along_m;
    let position_world = air.origin_world + air.direction_world * at_m;
    let distance_squared = aside_squared + along_m * along_m;
    let to_light = (source.xyz - position_world) * inverseSqrt(distance_squared);
    let ratio_squared = distance_squared * source.w;
    var strength = clamp(1.0 - ratio_squared * ratio_squared, 0.0, 1.0) * opening / aside_m;
    let color = light_part(table_uv, LIGHT_COLOR);
    // Point lights have no cone.
    if color.w != 0.0 {
        let axis = light_part(table_uv, LIGHT_AXIS);
        let cone = clamp(dot(axis.xyz, -to_light) * color.w + axis.w, 0.0, 1.0);
        strength *= cone * cone;
    }
    if strength <= 0.0 {
        return vec3f(0.0);
    }
    strength *= phase(dot(to_light, air.direction_world)) * exp(-optical_depth(air.fog, at_m));
    strength *= fog_density_per_m(air.fog.height + air.fog.rise_per_m * at_m);
    if shadowed != 0u {
        strength *= punctual_visibility_in_air(table_uv, source.xyz, position_world);
    }
    return color.rgb * strength;
}

// The lights that are in no list.
fn global_in_air(air: Air, noise: f32, position_px: vec2f) -> vec3f {
    var sum = vec3f(0.0);
    // How long loops are depends on more than uniforms, see docs/decisions/006.
    let steps = select(0u, fog.steps, position_px.x >= 0.0);
    let directional_count = select(0u, cluster_grid.directional_count, position_px.x >= 0.0);
    let global_count = select(0u, cluster_grid.global_count, position_px.x >= 0.0);
    let whole = optical_depth(air.fog, air.length_m);
    let lost = 1.0 - exp(-whole);
    for (var step = 0u; step < steps; step++) {
        let place = (f32(step) + noise) / f32(steps);
        let depth = min(-log(max(1.0 - place * lost, 1e-37)), whole);
        let at_m = distance_at_depth(air.fog, depth, whole, air.length_m);
        for (var light = 0u; light < directional_count; light++) {
            sum += directional_in_air(light, air, at_m, lost / f32(steps));
        }
        for (var light = directional_count; light < global_count; light++) {
            sum += punctual_in_air(light, air, 0.0, air.length_m, place) / f32(steps);
        }
    }
    return sum;
}

// Pre-exposed radiance that fog scatters into the ray from `eye_world` through a pixel, up to `distance_m` along it.
fn light_in_fog(position_px: vec2f, noise: f32, eye_world: vec3f, direction_world: vec3f, distance_m: f32) -> vec3f {
    var air: Air;
    air.origin_world = eye_world + direction_world * fog.start_m;
    air.direction_world = direction_world;
    air.length_m = distance_m - fog.start_m;
    air.fog = fog_ray(air.origin_world, direction_world);
    // What depends on more than uniforms comes first, see docs/decisions/006.
    if (position_px.x < 0.0) | (air.length_m <= 0.0) {
        return vec3f(0.0);
    }
    var sum = global_in_air(air, noise, position_px);
    // Slices are of distances along the view's axis.
    let along_axis = max(-dot(direction_world, view.world_from_view[2].xyz), 1e-4);
    let from_log = cluster_grid.slice_from_log_distance;
    let size = cluster_grid.size;
    let tile = min(vec2u(position_px) / size.w, size.xy - 1u);
    let slices = select(0u, size.z, position_px.x >= 0.0);
    let parts = max(fog.steps / size.z, 1u);
    let rows = table_rows();
    var first_m = 0.0;
    for (var slice = 0u; slice < slices; slice++) {
        let end_m = exp2((f32(slice + 1u) - from_log.y) / from_log.x) / along_axis - fog.start_m;
        // The last takes all that lies beyond.
        let last_m = select(clamp(end_m, 0.0, air.length_m), air.length_m, slice + 1u == slices);
        let list = cluster_at((slice * size.y + tile.y) * size.x + tile.x);
        let count = select(0u, list.end - list.first, last_m > first_m) * parts;
        for (var i = 0u; i < count; i++) {
            let part = f32(i % parts);
            let light = cluster_light_at(list.first + i / parts, rows);
            let ends_m = mix(vec2f(first_m), vec2f(last_m), vec2f(part, part + 1.0) / f32(parts));
            // Another place for each light and slice, else what one shadow lets through another would, too.
            let place = fract(noise + f32(light) * 0.754877666 + f32(slice * parts + i % parts) * 0.569840291);
            sum += punctual_in_air(light, air, ends_m.x, ends_m.y, place);
        }
        first_m = last_m;
        if first_m >= air.length_m {
            break;
        }
    }
    return sum * fog.scattering;
}

// The same before a surface that is shaded where it is drawn.
fn light_in_fog_before(position_px: vec2f, position_world: vec3f) -> vec3f {
    let to_eye = direction_to_eye_world(position_world);
    let distance_m = ray_length_m(position_world);
    let eye_world = position_world + to_eye * distance_m;
    return light_in_fog(position_px, interleaved_noise(position_px), eye_world, -to_eye, distance_m);
}
