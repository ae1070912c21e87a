// reflections: what a ray that a surface reflects meets in the picture, and how much that is to be trusted.
// Sources: rays as straight lines in the picture along which 1 / distance is linear (McGuire & Mara 2014, "Efficient GPU
// Screen-Space Ray Tracing"), over a pyramid of least distances (Uludag 2014, "Hi-Z Screen-Space Cone-Traced
// Reflections"); one ray a texel and sample to a visible normal of GGX (Heitz 2018, by the caps of Dupuy & Benyoub 2023,
// "Sampling Visible GGX Normals with Spherical Caps"). Differs from them:
// - what does not rise over the plane of the triangle that the ray leaves is passed over, so that no plane meets itself;
// - light is read where the ray meets the plane of what it hits, not in the middle of its pixel; and of as much of the
// picture as the ray stands for, so that few rays find small lamps (Colbert & Křivánek 2007, "GPU-Based Importance
// Sampling"), by the share of the lobe and by how far away the next texel has a ray like it;
// - highlights of smooth surfaces are seen from where the eye is, and not from the mirror: they are cut;
// - rays below the horizon are turned up, since their light is in the energy compensation.
// Reads: G-buffer, linear_depth, reflections.pyramid, radiance, reflections.radiance, coarse_reflections.
// Writes: radiance of the hit times how much it is to be trusted, and that share, packed with how wide the filter is to
// be.
// Program: reflections_trace.

import package::view::{view, pixel_from_position_view, pixel_height_m, position_view_from_pixel};
import package::constants::{RADIANCE_MAX, REFLECTION_LEVELS};
import package::passes::reflections::rays::{
    NARROW_STEPS, filtered_share, packable_share, patterned, reflections, sharp_share, side,
};
import package::shaders::coarse::{pixel_of_texel, turn_in_square};
import package::shaders::coarse_reflections::LIKENESS_REACH;
import package::shaders::gbuffer_textures::{normal_world_at, surface_at};
import package::shaders::lit_distance::facet_normal_at;
import package::shaders::hash::{plastic_turn, seed_of_pixel, stratified};
import package::shaders::screen_space::{
    Center, FARTHEST_M, center_at, distance_from_nearness, likeness_to, nearness_from_distance, tangent_plane_at,
    tangents_of,
};
import package::shaders::shading::linear_clamp;
import package::shaders::traced_lobe::{is_traced, share_of_roughness, traced_roughness};
import package::shaders::visible_normals::{reflected_likelihood, visible_normal};

@group(1) @binding(5) var nearest_distances: texture_2d<f32>;
@group(1) @binding(6) var scene_radiance: texture_2d<f32>;
// The same at half the size, and levels of it.
@group(1) @binding(7) var coarse_radiance: texture_2d<f32>;

// What mirrors reflect, and where they do; looked at with `has_mirrors` alone.
@group(1) @binding(8) var mirrored: texture_2d<f32>;

// 1 if there are mirrors in the picture, which follow no rays.
override has_mirrors: u32 = 0u;
override steps: u32 = 96u;
// 1 if only surfaces that are smooth and flat follow rays.
override smooth_only: u32 = 0u;

// How far away backs of bodies are, looked at with `has_backs` alone.
@group(1) @binding(9) var back_distances: texture_2d<f32>;

override has_backs: u32 = 0u;

// What rays of half the picture's size brought, looked at with `smooth_only` alone.
@group(1) @binding(10) var coarse_reflections: texture_2d<f32>;

// Rays towards the eye end at this share of the distance at which they begin.
const NEAREST_SHARE: f32 = 0.05;
// So far rays go on past the edge of a square, in pixels.
const PAST_EDGE_PX: f32 = 0.01;
// Depth of 32 bits and normals of 16 bits leave heights of a plane's pixels as exact as this, as a share of their
// distances.
const HEIGHT_NOISE: f32 = 5e-5;
// Over so much of the picture's width and height hits fade out towards its edges.
const EDGE_FADE: f32 = 0.08;
// Hits on what faces the ray by less than this cosine fade out: what the picture shows there is another side.
const FACING_FADE: f32 = 0.1;
// Light is read where the ray meets the plane of what it hits if that is at most so far from the middle of the pixel,
// in pixels along each axis; else there. It is farther where the ray came from behind.
const REFINED_PX: f32 = 1.0;

// What a ray stands for is at most so large a share of the ray's length: at its foot the surface itself is near.
const FOOTPRINT_SHARE: f32 = 0.25;

// What a ray is within lies at least so high over the plane that it leaves, as the sine of an angle.
const LEAST_RISE: f32 = 0.12;

// Where half of the lobe is so wide, in texels, the filter is at its widest.
const LOBE_WIDE_TEXELS: f32 = 3.0;

// Where a ray ends.
struct Hit {
    is_hit: bool,
    // The middle of its pixel.
    middle_px: vec2f,
    // What that shows, in view space.
    position: vec3f,
    normal: vec3f,
    // How far behind it the ray enters the pixel, as a share of the thickness.
    behind: f32,
    // Whether the ray is within a body there, whose side that it meets is not seen: the one that is stands for it.
    is_within: bool,
}

// Two numbers from 0 up to 1.
fn noise_at(position_px: vec2f) -> vec2f {
    if patterned != 0u {
        // Sixteen places of a square, one in each row and column of it, in all squares of 4 × 4 texels; other ones in
        // every sample (Roberts 2018), and those in other texels of the square, so that in sixteen samples each texel has
        // had them all.
        let texel = (vec2u(position_px) + vec2u(turn_in_square(4))) & vec2u(3u);
        let place = vec2u((texel.x << 2u) + texel.y, (texel.y << 2u) + texel.x);
        let turn = fract(plastic_turn(view.sample_index) + 0.5);
        return fract((vec2f(place) + turn) / 16.0);
    }
    return vec2f(
        stratified(view.sample_index, seed_of_pixel(position_px, 43u)),
        stratified(view.sample_index, seed_of_pixel(position_px, 44u)),
    );
}

// A direction in view space, and how likely it is by solid angle.
struct Ray {
    direction: vec3f,
    likelihood: f32,
}

// One of the directions in which a rough mirror reflects the line of sight.
fn reflected_ray(center: Center, alpha: f32, noise: vec2f) -> Ray {
    let tangents = tangents_of(center.normal);
    let to_eye = vec3f(center.to_eye * tangents, dot(center.to_eye, center.normal));
    let local = visible_normal(to_eye, alpha, noise);
    let visible = tangents * local.xy + center.normal * local.z;
    let reflected = reflect(-center.to_eye, visible);
    let direction = reflected + center.normal * (2.0 * max(-dot(reflected, center.normal), 0.0));
    let a2 = max(alpha * alpha, 1e-12);
    return Ray(direction, reflected_likelihood(local, to_eye, a2));
}

// Whether any of the 3 × 3 texels of the smaller picture around a pixel brought something.
fn has_coarse_hit(position_px: vec2f) -> bool {
    let middle = vec2i(position_px) / 2;
    let last = vec2i(textureDimensions(coarse_reflections)) - 1;
    var share = 0.0;
    for (var i = 0u; i < 9u; i++) {
        let texel = clamp(middle + vec2i(vec2u(i % 3u, i / 3u)) - 1, vec2i(0), last);
        share = max(share, textureLoad(coarse_reflections, texel, 0).a);
    }
    return share > 0.0;
}

fn normal_view_at(middle_px: vec2f) -> vec3f {
    return (view.view_from_world * vec4f(normal_world_at(vec2i(middle_px)), 0.0)).xyz;
}

fn follow(center: Center, direction: vec3f, facet_normal: vec3f) -> Hit {
    let begin_m = -center.position.z;
    let towards_eye_m = begin_m * (1.0 - NEAREST_SHARE) / max(direction.z, 1e-6);
    let end = center.position + direction * min(reflections.distance_m, towards_eye_m);
    // Place in the picture and nearness: where it begins, and the way to its end or to the picture's edge.
    let begin = vec3f(center.position_px, nearness_from_distance(begin_m));
    let whole = vec3f(pixel_from_position_view(end), nearness_from_distance(-end.z)) - begin;
    let forward = select(vec2f(0.0), vec2f(1.0), whole.xy > vec2f(0.0));
    let signs = 2.0 * forward - 1.0;
    let to_edge = (forward * view.size_px - begin.xy) * signs / max(abs(whole.xy), vec2f(1e-6));
    let way = whole * min(1.0, min(to_edge.x, to_edge.y));
    let per_px = signs / max(abs(way.xy), vec2f(1e-6));
    let width_of_pixel = 2.0 * view.view_from_ndc_scale.y * view.inverse_size_px.y;
    let past_edge = PAST_EDGE_PX / max(length(way.xy), 1e-3);

    var hit = Hit(false, vec2f(0.0), vec3f(0.0), vec3f(0.0), 0.0, false);
    var level = 0u;
    let own_exit = 0.5 * abs(per_px);
    var along = min(own_exit.x, own_exit.y) + past_edge;
    for (var i = 0u; i < steps; i++) {
        if along >= 1.0 {
            break;
        }
        let position_px = clamp(begin.xy + way.xy * along, vec2f(0.0), view.size_px - 0.5);
        let side_px = f32(1u << level);
        let cell = floor(position_px / side_px);
        let nearest_m = textureLoad(nearest_distances, vec2i(cell), i32(level)).r;
        let to_exit = ((cell + forward) * side_px - begin.xy) * per_px;
        let exit = max(min(to_exit.x, to_exit.y), along) + past_edge;
        let entering = begin.z + way.z * along;
        let leaving = begin.z + way.z * min(exit, 1.0);
        let cell_nearness = nearness_from_distance(nearest_m);
        if min(entering, leaving) > cell_nearness {
            along = exit;
            level = min(level + 1u, REFLECTION_LEVELS - 1u);
        } else if level > 0u {
            level -= 1u;
            // Until the ray is as far away as anything there, it meets nothing.
            let until = (cell_nearness - begin.z) / min(way.z, -1e-30);
            along = select(along, clamp(until - past_edge, along, exit), entering > cell_nearness);
        } else {
            let middle_px = floor(position_px) + 0.5;
            let position = position_view_from_pixel(middle_px, min(nearest_m, FARTHEST_M));
            let away = position - center.position;
            let rises = dot(away, facet_normal) > HEIGHT_NOISE * (0.1 * begin_m + length(away));
            // How far the ray is below the pixel's plane as it enters: by what it goes within a pixel, and by a pixel's
            // width, is nothing, because pixels have one distance.
            let normal = normal_view_at(middle_px);
            let facing = -dot(direction, normal);
            let entry = position_view_from_pixel(position_px, distance_from_nearness(entering));
            let within_m = abs(distance_from_nearness(leaving) - distance_from_nearness(entering));
            let pixel_m = mix(nearest_m, 1.0, view.orthographic) * width_of_pixel;
            let below_m = dot(position - entry, normal) - pixel_m - within_m * facing;
            let behind = below_m / (reflections.thickness_m * max(facing, FACING_FADE));
            let is_met = facing > 0.0 && behind < 1.0;
            // Of a body whose back is known all between what is seen of it and that.
            var is_body = false;
            var is_hit = is_met;
            if has_backs != 0u {
                let back_m = textureLoad(back_distances, vec2i(middle_px), 0).r;
                let entering_m = distance_from_nearness(max(entering, leaving));
                is_body = back_m > nearest_m && back_m < nearest_m + reflections.thickness_max_m;
                // Rays along a silhouette go far within a pixel, whose middle tells whether they are within.
                let middle_m = distance_from_nearness(0.5 * (entering + leaving));
                // A round body of flat triangles rises a little over the planes of its own.
                let is_other = dot(away, facet_normal) > LEAST_RISE * length(away);
                let is_inside = middle_m > nearest_m && middle_m < back_m && is_other;
                is_hit = select(is_met, is_inside || (is_met && entering_m < back_m), is_body);
            }
            if rises && is_hit {
                // A side of a body that is seen from along it says no more of the one that is met than one that is turned away.
                let is_within = is_body && (facing < FACING_FADE || behind >= 1.0);
                hit = Hit(true, middle_px, position, normal, select(max(behind, 0.0), 0.0, is_body), is_within);
                break;
            }
            along = exit;
        }
    }
    return hit;
}

// How far from the middle of the pixel light is read, towards where the ray meets its plane: along each axis only to a
// pixel that shows the same plane, since the texels between are mixed.
fn refinement(hit: Hit, offset: vec2f) -> vec2f {
    let distance_m = -hit.position.z;
    let plane = tangent_plane_at(vec2i(hit.middle_px), distance_m);
    let side = select(vec2f(-1.0), vec2f(1.0), offset > vec2f(0.0));
    let across = likeness_to(plane, hit.middle_px + vec2f(side.x, 0.0), LIKENESS_REACH * distance_m);
    let down = likeness_to(plane, hit.middle_px + vec2f(0.0, side.y), LIKENESS_REACH * distance_m);
    let is_near = all(abs(offset) <= vec2f(REFINED_PX));
    let is_plane = vec2f(across, down) > vec2f(0.0);
    return select(vec2f(0.0), offset, vec2<bool>(is_near && is_plane.x, is_near && is_plane.y));
}

// How wide a pixel is so far behind a flat mirror.
fn pixel_in_mirror_m(center: Center, length_m: f32) -> f32 {
    return pixel_height_m(length_m - center.position.z);
}

// How much narrower than at its widest the filter is for what lies so far from the surface, in steps: there is no noise
// where the lobe brings the same as its neighbours' do, and where it is a texel wide, they bring the same within that.
fn steps_narrower(center: Center, length_m: f32, alpha: f32) -> f32 {
    if patterned == 0u || alpha <= 0.0 {
        return 0.0;
    }
    // A normal that is tilted by an angle turns the ray by twice as much.
    let half_lobe_m = 2.0 * alpha * length_m;
    let half_lobe_texels = half_lobe_m / (pixel_in_mirror_m(center, length_m) * f32(side));
    return round(NARROW_STEPS * (1.0 - clamp(half_lobe_texels / LOBE_WIDE_TEXELS, 0.0, 1.0)));
}

// How wide in the picture is half of what a ray stands for, in pixels: its neighbours bring the same. It is a share of the
// lobe, and where a flat mirror shows farther apart what the rays alike it bring, all between: else small lamps are missed
// by all of them or found by one that counts as many.
fn half_footprint_px(center: Center, hit: Hit, length_m: f32, likelihood: f32, filtered: f32) -> f32 {
    let of_lobe_m = 0.5 * length_m * sqrt(reflections.share_of_ray / likelihood);
    let spacing_m = reflections.spacing_px * filtered * pixel_in_mirror_m(center, length_m);
    let of_texels_m = min(spacing_m, FOOTPRINT_SHARE * length_m);
    let pixel_m = pixel_height_m(-hit.position.z);
    return max(of_lobe_m, of_texels_m) / pixel_m;
}

@fragment
fn fs_reflections_trace(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = pixel_of_texel(vec2i(position.xy), i32(side));
    let surface = surface_at(pixel);
    let center = center_at(pixel);
    let roughness = traced_roughness(surface);
    var share = share_of_roughness(roughness, reflections.roughness_max);
    if !center.is_surface || share <= 0.0 || !is_traced(surface) {
        return vec4f(0.0);
    }
    if smooth_only != 0u {
        // Where no ray of the smaller picture met anything nearby, those of pixels do not either.
        let is_near_hit = has_coarse_hit(position.xy);
        if !is_near_hit || sharp_share(pixel, surface.normal_world, roughness) <= 0.0 {
            return vec4f(0.0);
        }
    }
    if has_mirrors != 0u {
        if textureLoad(mirrored, pixel, 0).a > 0.0 {
            return vec4f(0.0);
        }
    }
    let alpha = roughness * roughness;
    let ray = reflected_ray(center, alpha, noise_at(position.xy));
    let direction = ray.direction;
    let facet_world = facet_normal_at(pixel, -center.position.z, surface.normal_world, false).xyz;
    let facet_normal = (view.view_from_world * vec4f(facet_world, 0.0)).xyz;
    let hit = follow(center, direction, facet_normal);
    if !hit.is_hit || dot(direction, facet_normal) <= 0.0 {
        return vec4f(0.0);
    }
    let facing = select(-dot(direction, hit.normal), 1.0, hit.is_within);
    let to_plane_m = max(dot(hit.position - center.position, hit.normal) / min(-facing, -1e-3), 0.0);
    let length_m = select(to_plane_m, length(hit.position - center.position), hit.is_within);
    let met_px = pixel_from_position_view(center.position + direction * length_m);
    let refined = select(refinement(hit, met_px - hit.middle_px), vec2f(0.0), hit.is_within);
    let uv = (hit.middle_px + refined) * view.inverse_size_px;
    let narrower = steps_narrower(center, length_m, alpha);
    let filtered = filtered_share(roughness) * (1.0 - narrower / NARROW_STEPS);
    let footprint_px = half_footprint_px(center, hit, length_m, ray.likelihood, filtered);
    let level = log2(max(footprint_px, 1e-3));
    let from_edge = min(uv, 1.0 - uv) / EDGE_FADE;
    share *= smoothstep(0.0, 1.0, min(from_edge.x, from_edge.y)) * smoothstep(0.0, 1.0, facing / FACING_FADE);
    share *= 1.0 - hit.behind * hit.behind;
    let left_m = reflections.distance_m - length(hit.position - center.position);
    share *= select(1.0, clamp(left_m * reflections.fade_per_m, 0.0, 1.0), reflections.fade_per_m > 0.0);
    // Where nothing is to be trusted, there is nothing to pack either.
    let packed_beside = select(0.0, narrower, share > 0.0);
    share = packable_share(share, packed_beside);
    // Nothing of the background, which is not drawn yet. In GLSL a texture has one sampler.
    let smooth_texel = textureSampleLevel(scene_radiance, linear_clamp, uv, 0.0);
    let hit_texel = textureSampleLevel(scene_radiance, linear_clamp, hit.middle_px * view.inverse_size_px, 0.0);
    let fine = select(hit_texel.rgb, smooth_texel.rgb, smooth_texel.a > 0.999);
    let coarse_texel = textureSampleLevel(coarse_radiance, linear_clamp, uv, max(level - 1.0, 0.0));
    let coarse = coarse_texel.rgb / max(coarse_texel.a, 1e-3);
    let radiance = mix(fine, coarse, clamp(level, 0.0, 1.0));
    let brightest = max(max(radiance.r, radiance.g), max(radiance.b, 1e-6));
    let brightness_max = min(reflections.radiance_max / max(alpha, 1e-6), RADIANCE_MAX);
    return vec4f(max(radiance, vec3f(0.0)) * (min(brightness_max / brightest, 1.0) * share), share + packed_beside);
}
