// Shadows of what lies so near to a surface that shadow maps miss it: a short ray in the picture, from the surface
// towards a light.
// Source: rays as straight lines in the picture along which 1 / distance is linear (McGuire & Mara 2014, "Efficient GPU
// Screen-Space Ray Tracing"). Differs from it:
// - all rays have as many steps, evenly spread and moved by noise, because they are short;
// - what does not rise over the plane of the triangle that the ray leaves hides nothing, so that no plane shadows itself;
// - a pixel hides the ray that is below the plane of what the pixel shows, so that surfaces along which a ray runs do
// not hide it, though their pixels lie to the side of it.

import package::view::{view, pixel_from_position_view, position_view_from_pixel};
import package::shaders::gbuffer_textures::{linear_depth, normal_world_at};
import package::shaders::hash::gradient_noise;
import package::shaders::light_table::{LIGHT_SHADOW, cluster_grid, light_part};
import package::shaders::samplers::nearest_clamp;
import package::shaders::screen_space::{FARTHEST_M, distance_from_nearness, nearness_from_distance};

// Steps of a ray; 0 where there are none.
override contact_steps: u32 = 0u;

// Rays towards the eye end at this share of the distance at which they begin.
const NEAREST_SHARE: f32 = 0.05;
// Depth of 32 bits and normals of 16 bits leave heights of a plane's pixels as exact as this, as a share of their
// distances.
const HEIGHT_NOISE: f32 = 1e-4;
// So far below a pixel's plane a ray has to be, in pixels' widths.
const BELOW_PX: f32 = 0.5;
// What lies in this last share of a ray fades out.
const END_FADE: f32 = 0.25;
// Over so much of the picture's width and height what hides fades out towards its edges.
const EDGE_FADE: f32 = 0.02;

// Where rays begin, in view space but for its pixel.
struct ContactOrigin {
    position_px: vec2f,
    position: vec3f,
    facet_normal: vec3f,
}

fn contact_origin(position_px: vec2f, distance_m: f32, facet_normal_world: vec3f) -> ContactOrigin {
    let facet_normal = (view.view_from_world * vec4f(facet_normal_world, 0.0)).xyz;
    return ContactOrigin(position_px, position_view_from_pixel(position_px, distance_m), facet_normal);
}

// The share of light that is left at a surface of the light that lies in the direction `to_light`, at most `reach_m`
// away, and whose place in the table is `table_uv`. 1 of lights that cast no shadows.
fn contact_visibility(origin: ContactOrigin, table_uv: vec2f, to_light: vec3f, reach_m: f32) -> f32 {
    if light_part(table_uv, LIGHT_SHADOW).x <= 0.0 {
        return 1.0;
    }
    let direction = (view.view_from_world * vec4f(to_light, 0.0)).xyz;
    let begin_m = -origin.position.z;
    let towards_eye_m = begin_m * (1.0 - NEAREST_SHARE) / max(direction.z, 1e-6);
    let whole_m = min(cluster_grid.contact.x, reach_m);
    let end = origin.position + direction * min(whole_m, towards_eye_m);
    // Place in the picture and nearness: where it begins, and the way to its end or to the picture's edge.
    let begin = vec3f(origin.position_px, nearness_from_distance(begin_m));
    let whole = vec3f(pixel_from_position_view(end), nearness_from_distance(-end.z)) - begin;
    let edge = select(vec2f(0.0), view.size_px, whole.xy > vec2f(0.0));
    let to_edge = abs(edge - begin.xy) / max(abs(whole.xy), vec2f(1e-6));
    let way = whole * min(1.0, min(to_edge.x, to_edge.y));
    let noise = gradient_noise(origin.position_px, view.sample_index);
    let width_of_pixel = 2.0 * view.view_from_ndc_scale.y * view.inverse_size_px.y;
    var hidden = 0.0;
    for (var i = 0u; i < contact_steps; i++) {
        let at = begin + way * ((f32(i) + noise) / f32(max(contact_steps, 1u)));
        let middle_px = clamp(floor(at.xy) + 0.5, vec2f(0.5), view.size_px - 0.5);
        let uv = middle_px * view.inverse_size_px;
        let seen_m = min(textureSampleLevel(linear_depth, nearest_clamp, uv, 0.0).r, FARTHEST_M);
        let seen = position_view_from_pixel(middle_px, seen_m);
        let ray_m = distance_from_nearness(at.z);
        let ray = position_view_from_pixel(at.xy, ray_m);
        let away = seen - origin.position;
        let rises = dot(away, origin.facet_normal) > HEIGHT_NOISE * (0.1 * begin_m + length(away));
        let normal = (view.view_from_world * vec4f(normal_world_at(vec2i(middle_px)), 0.0)).xyz;
        let pixel_m = mix(seen_m, 1.0, view.orthographic) * width_of_pixel;
        let is_below = dot(seen - ray, normal) > BELOW_PX * pixel_m;
        // How far behind what the pixel shows the ray is, as a share of the thickness.
        let behind = (ray_m - seen_m) * cluster_grid.contact.y;
        let left = (1.0 - length(ray - origin.position) / whole_m) / END_FADE;
        let from_edge = min(uv, 1.0 - uv) / EDGE_FADE;
        let fade = clamp(min(left, min(from_edge.x, from_edge.y)), 0.0, 1.0) * (1.0 - behind * behind);
        hidden = select(hidden, max(hidden, fade), rises & is_below & (behind > 0.0) & (behind < 1.0));
    }
    return 1.0 - hidden;
}
