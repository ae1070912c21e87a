// Places of the picture as surfaces in view space, for passes that look around in it.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::{view, affine_of_direction_view, position_view_from_pixel};
import package::shaders::gbuffer_textures::{distance_at, linear_depth, normal_world_at};

@group(0) @binding(7) var nearest_clamp: sampler;
// The least cosine between normal and direction of the eye: maps turn normals away from it.
const FACING_MIN: f32 = 1e-3;
// Beyond this squares of lengths are no numbers of 32 bits.
const FARTHEST_M: f32 = 1e15;
struct Center {
    position_px: vec2f,
    // All in view space.
    position: vec3f,
    to_eye: vec3f,
    normal: vec3f,
    is_surface: bool,
}

// What is constant of the tangent plane: its direction as `affine_of_direction_view` has it, the normal's z, and the
// plane's own product.
struct TangentPlane {
    affine: vec3f,
    normal_z: f32,
    height: f32,
}

// What is linear along a ray in the picture and rises towards the eye: 1 / distance, or less the distance where rays of
// sight are parallel.
fn nearness_from_distance(distance_m: f32) -> f32 {
    return mix(1.0 / distance_m, -distance_m, view.orthographic);
}

fn distance_from_nearness(nearness: f32) -> f32 {
    return mix(1.0 / max(nearness, 1e-30), -nearness, view.orthographic);
}

fn center_at(pixel: vec2i) -> Center {
    let distance_m = distance_at(pixel);
    var center: Center;
    center.position_px = vec2f(pixel) + 0.5;
    center.is_surface = distance_m < DISTANCE_BACKGROUND_M;
    center.position = position_view_from_pixel(center.position_px, min(distance_m, FARTHEST_M));
    center.to_eye = mix(-normalize(center.position), vec3f(0.0, 0.0, 1.0), view.orthographic);
    let normal = (view.view_from_world * vec4f(normal_world_at(pixel), 0.0)).xyz;
    let missing = max(FACING_MIN - dot(normal, center.to_eye), 0.0);
    center.normal = normalize(normal + missing * center.to_eye);
    return center;
}

// Of a pixel's middle. Software adapters find the mip of what is loaded for every lane, and that of what is sampled
// once.
fn distance_sampled(middle_px: vec2f) -> f32 {
    return textureSampleLevel(linear_depth, nearest_clamp, middle_px * view.inverse_size_px, 0.0).r;
}

fn tangent_plane_at(pixel: vec2i, distance_m: f32) -> TangentPlane {
    let normal = (view.view_from_world * vec4f(normal_world_at(pixel), 0.0)).xyz;
    var plane: TangentPlane;
    plane.affine = affine_of_direction_view(normal);
    plane.normal_z = normal.z;
    plane.height = height_of(plane, vec2f(pixel) + 0.5, distance_m);
    return plane;
}

fn height_of(plane: TangentPlane, position_px: vec2f, distance_m: f32) -> f32 {
    let across = dot(plane.affine.xy, position_px) + plane.affine.z;
    return across * mix(distance_m, 1.0, view.orthographic) - plane.normal_z * distance_m;
}

// From 0 to 1, how near to a tangent plane the surface lies that a pixel's middle shows: 0 from `reach_m` on, and where
// there is none.
fn likeness_to(plane: TangentPlane, middle_px: vec2f, reach_m: f32) -> f32 {
    let distance_m = distance_sampled(middle_px);
    let off_plane = abs(height_of(plane, middle_px, distance_m) - plane.height) / reach_m;
    return select(0.0, clamp(1.0 - off_plane, 0.0, 1.0), distance_m < DISTANCE_BACKGROUND_M);
}

// Two directions at right angles to a unit vector and to each other, with which it makes a right-handed basis; it must not
// be (0, 0, -1) (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn tangents_of(normal: vec3f) -> mat2x3f {
    let side = select(-1.0, 1.0, normal.z >= 0.0);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    return mat2x3f(
        vec3f(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
        vec3f(b, side + normal.y * normal.y * a, -normal.y),
    );
}
