// water: a flat surface of water with all that is seen in it and through it, in one pass.
// Sources: Fresnel's equations; Beer-Lambert along the refracted ray and down to what lies below, with light that is
// scattered once to all sides; reflections from the view behind the surface, as flat mirrors have them, by rays to
// normals of the waves that are too fine for the pixel (slopes are Gaussian: Cox & Munk 1954).
// What light of lit surfaces loses by entering and leaving water (the square of the index), and what goes back and forth
// below the surface, are taken to make up for each other: a white ground below clear water under even light is as bright
// as that light. What is unlit is less bright by what the surface reflects and by what the water takes there and back.
// Reads: linear_depth, the picture so far with mips, radiance and linear_depth of the view behind the surface, the tables
// of lights, clusters and shadows, the environment. Writes: radiance, and depth.
// Program: water.

import package::view::{
    view, direction_to_eye_world, pixel_from_position_view, position_view_from_pixel, position_world_from_pixel,
};
import package::gbuffer::{SHADING_MODEL_STANDARD, Surface};
import package::passes::water::uniform::{LETS_IN, water};
import package::passes::water::waves::{Slopes, slopes_at};
import package::shaders::ambient::suns_radiance;
import package::shaders::behind_mirror::{behind_radiance_at, meeting_behind, mirror};
import package::shaders::brdf::PI;
import package::shaders::colour::half_float_clamped;
import package::shaders::environment::{
    enter_surroundings, environment_irradiance, environment_reflection, outside_probes, sun_count,
};
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::hash::{mixed, plastic_turn, seed_of_pixel, unit_from_bits};
import package::shaders::light_lists::light_sums;
import package::shaders::outline_fan::corner_of_vertex;
import package::shaders::screen_space::FARTHEST_M;
import package::shaders::shading::{linear_clamp, shading_from_surface};

// The picture without water, with mips.
@group(1) @binding(10) var below: texture_2d<f32>;

// Rays of a pixel to what is reflected; 0 where the surface is at rest.
override rays: u32 = 0u;
// 1 if there is a view behind the surface; else the environment stands for it.
override has_mirror: u32 = 0u;

// 1 if there is a ground where the picture shows nothing.
override has_ground: u32 = 0u;
// 1 if waves gather light on what is below.
override has_caustics: u32 = 0u;

// The steps of the refracted ray, which are as wide as each other in the picture, and how often it looks with those
// between two of them; and how near to it is what it meets, as a share of the way.
const STEPS_BELOW: u32 = 8u;
const LOOKS_BELOW: u32 = 15u;
const NEAR_SHARE: f32 = 0.15;
// How much longer than the way of the eye to the surface the refracted ray is followed at most.
const LONGEST: f32 = 1e4;
// How far from the edges of the picture what is refracted is seen less and less, as a share of it.
const EDGE: f32 = 0.06;
// How much longer than straight down light goes to what is below, which comes from all sides.
const WAY_DOWN: f32 = 1.15;
// Over how much of a place what is below is spread by waves, of the way there.
const SCATTER: f32 = 0.02;
// Of foam.
const FOAM_ALBEDO: f32 = 0.72;

struct WaterVarying {
    @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
}

@vertex
fn vs_water(@builtin(vertex_index) vertex: u32) -> WaterVarying {
    let position = water.corners[corner_of_vertex(vertex)];
    return WaterVarying(view.clip_from_world * position, position.xyz);
}

// The share that is reflected where a ray in the first medium meets the second at a cosine; `ratio` is the second's
// index divided by the first's. All of it beyond the critical angle.
fn fresnel(cosine: f32, ratio: f32) -> f32 {
    let squared = ratio * ratio - 1.0 + cosine * cosine;
    if squared <= 0.0 {
        return 1.0;
    }
    let g = sqrt(squared);
    let a = (g - cosine) / (g + cosine);
    let b = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    return 0.5 * a * a * (1.0 + b * b);
}

// The normal of waves with a slope, on the eye's side.
fn normal_of(slope: vec2f, side: f32) -> vec3f {
    return side * normalize(water.normal.xyz - water.x_world.xyz * slope.x - water.y_world.xyz * slope.y);
}

// The direction that a normal reflects, not into the surface.
fn reflected_by(normal: vec3f, to_eye: vec3f, plane_normal: vec3f) -> vec3f {
    let direction = reflect(-to_eye, normal);
    return normalize(direction - min(2.0 * dot(direction, plane_normal) - 0.02, 0.0) * plane_normal);
}

// Radiance that comes from a direction in world space, of rays that are spread by a slope's deviation, and from how far.
fn reflected_radiance(position_view: vec3f, direction: vec3f, spread: f32) -> vec4f {
    if has_mirror == 0u {
        return vec4f(environment_reflection(direction, min(spread, 1.0)), 1e9);
    }
    let direction_view = (view.view_from_world * vec4f(direction, 0.0)).xyz;
    let over_plane = dot(direction_view, mirror.normal_view);
    let met = meeting_behind(position_view, direction_view - 2.0 * over_plane * mirror.normal_view);
    let level = log2(max(2.0 * met.length_m * spread / met.pixel_m, 1.0));
    return vec4f(behind_radiance_at(met.uv, level), met.length_m);
}

// Two numbers of a normal distribution (Box & Muller 1958).
fn gaussian(noise: vec2f) -> vec2f {
    let radius = sqrt(-2.0 * log(max(1.0 - noise.x, 1e-6)));
    return radius * vec2f(cos(2.0 * PI * noise.y), sin(2.0 * PI * noise.y));
}

// What is seen through the surface: the place in the picture, and how long the ray is to what is there.
struct Through {
    uv: vec2f,
    length_m: f32,
}

// What the picture shows at a place, in view space: where it shows nothing the ground, if there is one.
fn surface_at_pixel(position_px: vec2f) -> vec3f {
    let pixel = clamp(vec2i(position_px), vec2i(0), vec2i(view.size_px) - 1);
    let middle_px = vec2f(pixel) + 0.5;
    var distance_m = min(distance_at(pixel), FARTHEST_M);
    if has_ground != 0u {
        let near = position_world_from_pixel(middle_px, 0.0);
        let fall = position_world_from_pixel(middle_px, 1.0).y - near.y;
        let ground_m = (water.ground_m - near.y) / min(fall, -1e-9);
        distance_m = select(distance_m, min(distance_m, ground_m), (fall < 0.0) & (ground_m > 0.0));
    }
    return position_view_from_pixel(middle_px, distance_m);
}

// How long a ray in view space is from a place in the picture to the picture's edge.
fn length_in_picture_m(position: vec3f, ray: vec3f) -> f32 {
    let extent = abs(view.view_from_ndc_scale);
    // How wide the picture is at that place, in halves of it at 1 m, and how much wider a metre on; with parallel rays it
    // is as wide everywhere.
    let wide = mix(vec2f(max(-position.z, 1e-6), -ray.z), vec2f(1.0, 0.0), view.orthographic);
    let to_high = max(extent * wide.x - position.xy, vec2f(0.0)) / max(ray.xy - extent * wide.y, vec2f(1e-6));
    let to_low = max(extent * wide.x + position.xy, vec2f(0.0)) / max(-ray.xy - extent * wide.y, vec2f(1e-6));
    let nearer = min(to_high, to_low);
    return min(min(nearer.x, nearer.y), LONGEST * wide.x * max(extent.y, 1.0));
}

// Where the refracted ray meets what the picture shows, step by step as far as the picture goes. Where it meets none of
// that, what is there straight on stands for it.
fn seen_below(position_px: vec2f, position: vec3f, ray: vec3f, plane_normal: vec3f) -> Through {
    let straight = surface_at_pixel(position_px) - position;
    let fall = max(-dot(ray, plane_normal), 1e-2);
    let straight_m = max(-dot(straight, plane_normal), 0.0) / fall;
    // Where nothing is there straight on, the ray may meet something all the same, because it is steeper.
    let has_straight = length(straight) < 0.5 * FARTHEST_M;
    let straight_uv = position_px * view.inverse_size_px;
    var through = Through(straight_uv, min(straight_m, length(straight)));
    let around_m = 1.5 * max(straight_m, length(straight));
    let longest_m = min(length_in_picture_m(position, ray), around_m);
    // By how much the picture grows along the ray.
    let growth = (1.0 - view.orthographic) * longest_m * -ray.z / max(-position.z, 1e-6);
    // The ray is before what the picture shows up to a place, and from another one on beyond it.
    var before_m = 0.0;
    var beyond_m = longest_m;
    var has_crossed = false;
    var is_settled = false;
    for (var look = 0u; look < LOOKS_BELOW; look++) {
        // First as if all of it lay level, then step by step.
        let share = min(f32(look) / f32(STEPS_BELOW), 1.0);
        let is_between = has_crossed | (look > STEPS_BELOW);
        let even_m = longest_m * share / max(1.0 + growth * (1.0 - share), 1e-6);
        let stepped_m = select(even_m, 0.5 * (before_m + beyond_m), is_between);
        let length_m = select(stepped_m, straight_m, look == 0u);
        let end = position + ray * length_m;
        let found = surface_at_pixel(pixel_from_position_view(end)) - position;
        let height_m = dot(found, plane_normal);
        let off_m = length(found - ray * length_m);
        let level_m = -height_m / fall;
        let is_level = abs(level_m - length_m) < NEAR_SHARE * length_m;
        // What stands before the surface, or before what is below, is not what the ray meets.
        let is_below = height_m < -1e-4 * length(found);
        let is_beyond = is_below & (-end.z >= -(position + found).z);
        let is_first = (look == 0u) & has_straight & (off_m < 0.4 * NEAR_SHARE * length_m);
        let is_met = is_first | ((look > 0u) & is_beyond & (off_m < NEAR_SHARE * length_m));
        if !is_settled & is_below & is_met {
            // Of level ground this is exact, wherever in its pixel the ray ends.
            let met_m = select(length_m, level_m, is_level);
            through = Through(pixel_from_position_view(position + ray * met_m) * view.inverse_size_px, met_m);
        }
        is_settled |= is_first & is_below & is_level;
        if look > 0u {
            before_m = select(length_m, before_m, is_beyond);
            beyond_m = select(beyond_m, length_m, is_beyond);
            has_crossed |= is_beyond;
        }
    }
    // Towards the picture's edges, beyond which nothing is known, less of it.
    let inside = min(through.uv, 1.0 - through.uv);
    let known = select(1.0, smoothstep(0.0, EDGE, min(inside.x, inside.y)), has_straight);
    through.uv = mix(straight_uv, through.uv, known);
    return through;
}

// Foam from 0 to 1, where the water is so deep.
fn foam_at(at: vec2f, depth_m: f32) -> f32 {
    let share = 1.0 - depth_m / max(water.foam_depth_m, 1e-6);
    if (water.foam_depth_m <= 0.0) | (share <= 0.0) {
        return 0.0;
    }
    let scale = 3.0 / water.foam_depth_m;
    let drift = water.time_secs * 0.35;
    let pattern = 0.5 * bubbles(at * scale + vec2f(drift, 0.3 * drift)) + 0.5 * bubbles(at * (2.1 * scale) - vec2f(0.4 * drift, drift));
    return smoothstep(0.0, 0.3, share - pattern) * min(4.0 * share, 1.0);
}

// From 0 to 1: how near a place is to one of many points, a cell each (Worley 1996, "A Cellular Texture Basis Function").
fn bubbles(at: vec2f) -> f32 {
    let cell = floor(at);
    var nearest = 1.0;
    for (var i = 0; i < 9; i++) {
        let other = cell + vec2f(f32(i % 3) - 1.0, f32(i / 3) - 1.0);
        let bits = mixed((bitcast<u32>(i32(other.x)) * 0x8da6b343u) ^ (bitcast<u32>(i32(other.y)) * 0xd8163841u));
        let point = other + vec2f(unit_from_bits(bits), unit_from_bits(mixed(bits)));
        let away = point - at;
        nearest = min(nearest, dot(away, away));
    }
    return sqrt(nearest);
}

// How many times as much light a place below gets as without waves: what they refract of light from straight above spreads by
// the Jacobian of where it goes (Shah, Konttinen & Pattanaik 2007, "Caustics Mapping"), here of the surface right above.
fn gathered(at: vec2f, depth_m: f32, footprint_m: f32) -> f32 {
    let step_m = max(water.step_m, footprint_m);
    let step_x = vec2f(step_m, 0.0);
    let step_y = vec2f(0.0, step_m);
    let slope = slopes_at(at, step_x, step_y).mean;
    let along_x = (slopes_at(at + step_x, step_x, step_y).mean - slope) / step_m;
    let along_y = (slopes_at(at + step_y, step_x, step_y).mean - slope) / step_m;
    // Upwards slopes turn light back by what the index leaves of them.
    let bend_m = (1.0 - 1.0 / water.ior) * min(depth_m, water.focus_m);
    let cross = 0.5 * (along_x.y + along_y.x) * bend_m;
    let spread = (1.0 + along_x.x * bend_m) * (1.0 + along_y.y * bend_m) - cross * cross;
    return min(1.0 / max(abs(spread), 0.16), 6.0);
}

@fragment
fn fs_water(in: WaterVarying) -> @location(0) vec4f {
    let position_px = in.position_clip.xy;
    let position_world = in.position_world;
    let at = vec2f(dot(position_world, water.x_world.xyz), dot(position_world, water.y_world.xyz));
    let step_x = dpdx(at);
    let step_y = dpdy(at);
    let slopes = slopes_at(at, step_x, step_y);
    let position_view = (view.view_from_world * vec4f(position_world, 1.0)).xyz;
    let to_eye = direction_to_eye_world(position_world);
    // Depends on more than uniforms, see docs/decisions/006.
    let is_below = (water.from_below > 0.5) & (position_px.x > -1.0);
    let side = select(1.0, -1.0, is_below);
    let plane_normal = side * water.normal.xyz;
    let ratio = select(water.ior, 1.0 / water.ior, is_below);
    // What leans away from the eye is not seen.
    var normal = normal_of(slopes.mean, side);
    normal = normalize(normal + max(0.02 - dot(normal, to_eye), 0.0) * to_eye);

    // What is reflected, and how much of it.
    var share = fresnel(min(dot(normal, to_eye), 1.0), ratio);
    var reflected = vec4f(0.0);
    if rays == 0u {
        reflected = reflected_radiance(position_view, reflect(-to_eye, plane_normal), 0.0) * vec4f(vec3f(share), 1.0);
    } else {
        let seed = vec2f(
            unit_from_bits(seed_of_pixel(position_px, 71u)),
            unit_from_bits(seed_of_pixel(position_px, 72u)),
        );
        let deviation = sqrt(0.5 * slopes.variance);
        var shares = 0.0;
        var weights = 0.0;
        for (var ray = 0u; ray < rays; ray++) {
            let noise = fract(seed + plastic_turn(view.sample_index * rays + ray));
            let facet = normal_of(slopes.mean + deviation * gaussian(noise), side);
            // As much of it as the eye sees.
            let cosine = dot(facet, to_eye);
            let weight = max(cosine, 1e-3) / max(dot(facet, plane_normal), 0.1);
            let of_facet = fresnel(clamp(cosine, 1e-3, 1.0), ratio);
            let direction = reflected_by(facet, to_eye, plane_normal);
            let found = reflected_radiance(position_view, direction, deviation * sqrt(mirror.share_of_ray));
            reflected += vec4f(found.rgb * of_facet, found.w) * weight;
            shares += of_facet * weight;
            weights += weight;
        }
        reflected /= weights;
        share = shares / weights;
    }

    // What is seen through it.
    let refracted = refract(-to_eye, normal, 1.0 / ratio);
    let ray_view = (view.view_from_world * vec4f(select(-to_eye, refracted, dot(refracted, refracted) > 0.5), 0.0)).xyz;
    let normal_view = (view.view_from_world * vec4f(plane_normal, 0.0)).xyz;
    let through = seen_below(position_px, position_view, ray_view, normal_view);
    let bend = abs(1.0 - 1.0 / ratio) * sqrt(0.5 * slopes.variance);
    let pixel_m = mix(max(-position_view.z, 1e-6) + through.length_m, 1.0, view.orthographic)
        * 2.0 * view.view_from_ndc_scale.y * view.inverse_size_px.y;
    let level = log2(max(2.0 * through.length_m * bend / pixel_m, 1.0));
    let depth_m = through.length_m * abs(dot(ray_view, normal_view));
    let behind_texel = textureSampleLevel(below, linear_clamp, clamp(through.uv, vec2f(0.0), vec2f(1.0)), level);
    var behind = behind_texel.rgb;
    if has_caustics != 0u {
        let way = (view.world_from_view * vec4f(ray_view * through.length_m, 0.0)).xyz;
        let over = at + vec2f(dot(way, water.x_world.xyz), dot(way, water.y_world.xyz));
        // What rays scatter that the surface bends is not seen as sharply; and deep down many waves shine on one place.
        let footprint_m = max(length(step_x), length(step_y)) + SCATTER * through.length_m;
        let strength = water.caustics * exp(-depth_m / (4.0 * water.focus_m));
        behind *= mix(1.0, gathered(over, depth_m, footprint_m), strength);
    }

    // The light that comes in from above, as a white surface would send it back.
    var surface: Surface;
    surface.base_color = vec3f(1.0);
    surface.occlusion = 1.0;
    surface.normal_world = select(normal, water.normal.xyz, is_below);
    surface.metallic = 0.0;
    surface.roughness_perceptual = pow(slopes.variance, 0.25);
    let f0 = (water.ior - 1.0) / (water.ior + 1.0);
    surface.f0_dielectric = f0 * f0;
    surface.shading_model = SHADING_MODEL_STANDARD;
    enter_surroundings(position_world);
    var shading = shading_from_surface(surface, select(to_eye, water.normal.xyz, is_below));
    shading.facet_normal = water.normal.xyz;
    let sums = light_sums(position_px, -position_view.z, position_world, shading);
    var light = sums.radiance - sums.specular + environment_irradiance(water.normal.xyz) * (LETS_IN / PI);
    var highlights = select(sums.specular, vec3f(0.0), is_below);
    if sun_count > 0u {
        let with_diffuse = suns_radiance(shading, outside_probes);
        let of_suns = suns_radiance(shading, 0.0);
        light += with_diffuse - of_suns;
        highlights += select(of_suns, vec3f(0.0), is_below | (rays == 0u));
    }

    let lost_per_m = water.absorption_per_m + water.scattering_per_m;
    // Of light that is as strong below the surface on every side of the upper half.
    let scattered = 0.5 * light * water.scattering_per_m / max(lost_per_m, vec3f(1e-9));
    var radiance: vec3f;
    // Before nothing what is seen through it is nothing, too.
    var coverage = 1.0;
    if is_below {
        let way_m = select(length(position_view), max(-position_view.z, 0.0), view.orthographic > 0.5);
        let comes = exp(-lost_per_m * way_m);
        let returns = exp(-lost_per_m * min(reflected.w, 1e6));
        let of_reflected = reflected.rgb * returns + share * scattered * (1.0 - returns);
        radiance = (of_reflected + (1.0 - share) * behind) * comes + scattered * (1.0 - comes);
    } else {
        let fall = clamp(-dot(refracted, water.normal.xyz), 0.0, 1.0);
        let comes = exp(-lost_per_m * min(through.length_m + WAY_DOWN * depth_m, 1e6));
        coverage = 1.0 - (1.0 - clamp(behind_texel.a, 0.0, 1.0)) * (1.0 - share) * dot(comes, vec3f(1.0 / 3.0));
        let part = (1.0 - exp(-lost_per_m * min(through.length_m * (1.0 + fall), 1e6))) / (1.0 + fall);
        radiance = reflected.rgb + (1.0 - share) * (behind * comes + scattered * part) + highlights;
        let straight_m = -dot(surface_at_pixel(position_px) - position_view, normal_view);
        let foam = foam_at(at, straight_m);
        radiance = mix(radiance, light * FOAM_ALBEDO, foam);
        coverage = mix(coverage, 1.0, foam);
    }
    return vec4f(half_float_clamped(radiance), coverage);
}
