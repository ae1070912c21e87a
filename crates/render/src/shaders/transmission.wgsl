// What lies behind a surface that light comes through: the picture of what is behind it, blurred by its mips where the
// surface is rough, seen where the refracted ray meets it (KHR_materials_transmission and KHR_materials_volume); and
// the environment where the ray leaves the picture. Bodies bend rays twice, the second time by the normal of their back:
// so faces that are parallel shift what is seen, and a ball turns it upside down.

import package::view::{view, position_world_from_pixel};
import package::constants::{LAYER_DISPERSION, LAYER_VOLUME, ROUGHNESS_PERCEPTUAL_MIN};
import package::shaders::brdf::Shading;
import package::shaders::environment::environment_reflection;
import package::shaders::layer_maps::has_layer;
import package::shaders::octahedral::direction_from_octahedral;
import package::shaders::shading::linear_clamp;
import package::shaders::transparency::{distance_at, glass_distances};

// Radiance and coverage of what lies behind, with its mips.
@group(1) @binding(2) var behind: texture_2d<f32>;

// 1 if what is asked is how much of the background comes through, of which `behind` has that up to there: by channel, and
// as coverage says.
override shows_transmittance: u32 = 0u;

// 1 if there are bodies, so that `glass_distances` is what the pass `glass` makes: normal, octahedral, and distance of
// the nearest back of a body, or 0; and the distance of what lies behind.
override has_bodies: u32 = 0u;

const CORNERS: u32 = 4u;
// Of rays through a ball of 26 pixels the first half of the steps is within 5 % of its radius of where they leave it,
// and all are within 0.2 %, whatever its thickness is said to be.
const LEAVING_STEPS: u32 = 8u;
const MEETING_STEPS: u32 = 8u;
// Rays that gain less distance, or meet planes at less of an angle, are taken as if they gained so much.
const RATE_MIN: f32 = 0.05;
const SLOPE_MIN: f32 = 0.3;
// Rays that gain less distance a metre go to the sides, where the picture shows little.
const RATE_SIDEWAYS: f32 = 0.1;
// What is nearer than this share of the distance of a body's back is in the body, or before it.
const WITHIN_SHARE: f32 = 0.999;
// Backs whose normals are 60° apart are two. Texels beside each other on a ball of 8 pixels are less than that apart.
const BACK_LIKENESS_MIN: f32 = 0.5;
// A ray that meets nothing goes so many times as far as the body is away: what is infinitely far away is seen as if it
// was there, beside its place by a 64th of the angle that the body is wide.
const FARTHEST: f32 = 64.0;

// A cubic B-spline of four by four texels by four samples (Sigg & Hadwiger 2005, GPU Gems 2), because squares of coarse
// mips show.
fn behind_at_mip(uv: vec2f, mip: f32) -> vec4f {
    // The branch depends on more than uniforms, see docs/decisions/006.
    if (uv.x > -1.0) & (mip < 0.5) {
        // As sharp as it is.
        return textureSampleLevel(behind, linear_clamp, uv, 0.0);
    }
    let size = vec2f(textureDimensions(behind, i32(mip)));
    let texel = uv * size - 0.5;
    let first = floor(texel);
    let f = texel - first;
    let f2 = f * f;
    let f3 = f2 * f;
    let w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
    let w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    let w3 = f3 / 6.0;
    let w2 = 1.0 - w0 - w1 - w3;
    let low = w0 + w1;
    let high = w2 + w3;
    let at_low = (first - 0.5 + w1 / low) / size;
    let at_high = (first + 1.5 + w3 / high) / size;
    let above = textureSampleLevel(behind, linear_clamp, at_low, mip) * low.x
        + textureSampleLevel(behind, linear_clamp, vec2f(at_high.x, at_low.y), mip) * high.x;
    let below = textureSampleLevel(behind, linear_clamp, vec2f(at_low.x, at_high.y), mip) * low.x
        + textureSampleLevel(behind, linear_clamp, at_high, mip) * high.x;
    return above * low.y + below * high.y;
}

fn behind_at(uv: vec2f, mip: f32) -> vec4f {
    let finer = floor(mip);
    return mix(behind_at_mip(uv, finer), behind_at_mip(uv, finer + 1.0), mip - finer);
}

// A ray that left a body.
struct Ray {
    position_world: vec3f,
    direction_world: vec3f,
}

fn uv_at(position_world: vec3f) -> vec2f {
    let clip = view.clip_from_world * vec4f(position_world, 1.0);
    return clip.xy / max(clip.w, 1e-6) * vec2f(0.5, -0.5) + 0.5;
}

fn body_texel(texel: vec2f) -> vec4f {
    return textureLoad(glass_distances, vec2i(clamp(texel, vec2f(0.0), view.size_px - 1.0)), 0);
}

// How much farther away a point is after a metre of a ray.
fn axis_rate(direction_world: vec3f) -> f32 {
    return -(view.view_from_world * vec4f(direction_world, 0.0)).z;
}

// The normal of the back between four texels, of which those count where there is one; (0, 0, 0) where there is none.
// Where two backs meet, or one ends before another, that of the nearest texel counts: a mean of the two bends rays as
// neither does, which was a dashed line along every such edge.
fn back_normal_at(uv: vec2f) -> vec3f {
    let place = uv * view.size_px - 0.5;
    let first = floor(place);
    let f = place - first;
    let nearest = body_texel(uv * view.size_px);
    let nearest_normal = direction_from_octahedral(nearest.xy);
    var sum = vec3f(0.0);
    for (var i = 0u; i < CORNERS; i++) {
        let corner = vec2f(f32(i % 2u), f32(i / 2u));
        let texel = body_texel(first + corner);
        let share = mix(1.0 - f, f, corner);
        let normal = direction_from_octahedral(texel.xy);
        let is_alike = (nearest.z <= 0.0) | (dot(normal, nearest_normal) > BACK_LIKENESS_MIN);
        sum += select(0.0, share.x * share.y, (texel.z > 0.0) & is_alike) * normal;
    }
    return sum * inverseSqrt(max(dot(sum, sum), 1e-30));
}

// How a ray goes on that has entered a body in a point: from where it leaves the body, as the normal there bends it. A
// body that has no back, such as a single sheet, ends at a face that is parallel to its front.
fn leaving_ray(position_world: vec3f, inside: vec3f, to_eye: vec3f, thickness_m: f32, ior: f32) -> Ray {
    let parallel = Ray(position_world + inside * thickness_m, -to_eye);
    if has_bodies == 0u {
        return parallel;
    }
    let start_m = distance_at(position_world);
    let rate = max(axis_rate(inside), RATE_MIN);
    var length_m = thickness_m;
    var met = vec4f(0.0);
    for (var i = 0u; i < LEAVING_STEPS; i++) {
        let position_px = uv_at(position_world + inside * length_m) * view.size_px;
        met = body_texel(position_px);
        // At first as far as the back in the pixel is, then to the plane there.
        let as_far_m = max(met.z - start_m, 0.0) / rate;
        let normal = direction_from_octahedral(met.xy);
        let slope = dot(normal, inside);
        let back_world = position_world_from_pixel(floor(position_px) + 0.5, met.z);
        let to_plane_m = max(dot(normal, back_world - position_world), 0.0) / max(slope, SLOPE_MIN);
        let found_m = select(as_far_m, to_plane_m, (i >= LEAVING_STEPS / 2u) & (slope > SLOPE_MIN));
        // Beside the body it was too far.
        length_m = select(0.5 * length_m, found_m, met.z > 0.0);
    }
    let end_world = position_world + inside * length_m;
    let normal = back_normal_at(uv_at(end_world));
    let bent = refract(inside, -normal, ior);
    // Totally reflected light leaves elsewhere; it goes on as it is then.
    let direction = select(reflect(inside, normal), bent, dot(bent, bent) > 0.5);
    // What is in the body is seen before its back.
    let is_within = (met.w > start_m) & (met.w < met.z * WITHIN_SHARE);
    let is_there = (met.z > 0.0) & (dot(normal, normal) > 0.5);
    let origin = select(end_world, position_world, is_within);
    let towards = select(direction, inside, is_within);
    return Ray(select(parallel.position_world, origin, is_there), select(-to_eye, towards, is_there));
}

// Where a ray meets what lies behind surfaces that light comes through, as the picture has it.
fn met_world(ray: Ray) -> vec3f {
    let start_m = distance_at(ray.position_world);
    let rate = max(axis_rate(ray.direction_world), RATE_MIN);
    let farthest_m = FARTHEST * abs(start_m);
    // What it does not reach yet, and what it has passed. Steps that leave that range halve it.
    var least_m = 0.0;
    var most_m = farthest_m;
    var length_m = 0.0;
    for (var i = 0u; i < MEETING_STEPS; i++) {
        let texel = body_texel(uv_at(ray.position_world + ray.direction_world * length_m) * view.size_px);
        let found_m = clamp((min(texel.w, 2.0 * farthest_m) - start_m) / rate, 0.0, farthest_m);
        let is_before = found_m >= length_m;
        least_m = select(least_m, length_m, is_before);
        most_m = select(length_m, most_m, is_before);
        let is_between = (found_m >= least_m) & (found_m <= most_m);
        length_m = select(0.5 * (least_m + most_m), found_m, is_between);
    }
    return ray.position_world + ray.direction_world * length_m;
}

// What is seen through the surface with a refractive index: radiance and coverage.
fn seen_through(shading: Shading, position_world: vec3f, ior: f32) -> vec4f {
    let terms = shading.layers;
    var ray = Ray(position_world, -shading.to_eye);
    var length_m = 0.0;
    // What light meets away from the eye is not in the picture.
    var sideways = 0.0;
    if has_layer(LAYER_VOLUME) {
        length_m = terms.thickness_m;
        let refracted = refract(-shading.to_eye, shading.normal, 1.0 / ior);
        let leaving = leaving_ray(position_world, refracted, shading.to_eye, length_m, ior);
        // Without thickness it is a thin wall.
        let is_body = length_m > 0.0;
        ray = Ray(
            select(position_world, leaving.position_world, is_body),
            select(-shading.to_eye, leaving.direction_world, is_body),
        );
        if has_bodies != 0u {
            sideways = 1.0 - smoothstep(0.0, RATE_SIDEWAYS, axis_rate(ray.direction_world));
            ray.position_world = met_world(ray);
        }
    }
    let uv = uv_at(ray.position_world);
    // A thin wall refracts twice, and not at all; rough ones blur by their index.
    // Smooth ones do not: the least roughness of highlights is none here.
    let roughness = (sqrt(shading.roughness_alpha) - ROUGHNESS_PERCEPTUAL_MIN) / (1.0 - ROUGHNESS_PERCEPTUAL_MIN);
    let mip_last = floor(log2(max(view.size_px.x, view.size_px.y)) + 1e-3);
    let blur = max(roughness, 0.0) * clamp(2.0 * ior - 2.0, 0.0, 1.0);
    let mip = clamp(log2(view.size_px.x) * blur, 0.0, max(mip_last - 1.0, 0.0));
    let seen = behind_at(clamp(uv, vec2f(0.0), vec2f(1.0)), mip);
    let beyond = max(abs(uv - 0.5) - 0.5, vec2f(0.0));
    let outside = max(smoothstep(0.0, 0.1, max(beyond.x, beyond.y)), sideways);
    var around = vec4f(environment_reflection(ray.direction_world, shading.roughness_alpha * blur), 1.0);
    if shows_transmittance != 0u {
        around = vec4f(0.0);
    }
    let absorbed = exp(-terms.absorption * length_m);
    let found = mix(seen, around, outside);
    return vec4f(found.rgb * absorbed, found.a);
}

// What is seen through the surface, every colour as it is refracted.
fn seen_behind(shading: Shading, position_world: vec3f) -> vec4f {
    let terms = shading.layers;
    if !has_layer(LAYER_DISPERSION) {
        return seen_through(shading, position_world, terms.ior);
    }
    // The indices of red and blue (KHR_materials_dispersion).
    let spread = (terms.ior - 1.0) * 0.025 * terms.dispersion;
    let red = seen_through(shading, position_world, max(terms.ior - spread, 1.0));
    let green = seen_through(shading, position_world, terms.ior);
    let blue = seen_through(shading, position_world, terms.ior + spread);
    return vec4f(red.r, green.g, blue.b, (red.a + green.a + blue.a) / 3.0);
}
