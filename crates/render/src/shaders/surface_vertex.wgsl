// The vertex stage of everything that draws the scene's surfaces. Positions are computed by one expression, so that a
// pass which draws a surface again gets the same depth.

import package::constants::{DATA_WIDTH, FADE_SHIFT, POINT_CORNERS, WITHOUT_NORMALS};
@if(points) import package::constants::{POINT_DIAMETER_MIN_PX, POINT_HEIGHT_SHARE};
import package::shaders::level_fade::fades;
import package::view::view;

// 1 if skins or morph targets move vertices. With `skins` alone.
override deformed: u32 = 0u;
// 1 if fragments are dropped by alpha.
override masked: u32 = 0u;

struct SurfaceInput {
    @location(0) position: vec3f,
    // The fourth is 1 where the normal that was given is no number.
    @location(1) normal: vec4f,
    @location(2) tangent: vec4f,
    @location(3) uv0: vec2f,
    @location(4) uv1: vec2f,
    @location(5) color: vec4f,
    @location(6) world_from_object_row0: vec4f,
    @location(7) world_from_object_row1: vec4f,
    @location(8) world_from_object_row2: vec4f,
    // Object id and WITHOUT_NORMALS (or what `level_fade.wgsl` puts there), first joint (all ones: not skinned), first
    // morph weight, number of morph targets.
    @location(9) instance: vec4u,
    // First displacement texel of the primitive, number of vertices.
    @location(10) morph: vec2u,
    // Anything where nothing is deformed.
    @if(skins) @location(11) joints: vec4u,
    @if(skins) @location(12) weights: vec4f,
    // A point has one for each corner of the triangle around its disc, one after the other.
    @builtin(vertex_index) vertex: u32,
}

struct SurfaceVarying {
    @invariant @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) tangent_world: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    // Object id and WITHOUT_NORMALS.
    @location(5) @interpolate(flat, either) object: u32,
    // By how much the object is larger in the world: the cube root of its volume.
    @if(detailed) @location(6) @interpolate(flat, either) object_scale: f32,
    // From the middle of the disc, which ends at 1.
    @if(points) @location(6) corner: vec2f,
    // From the middle of the disc to this corner; `motion` moves it along.
    @if(points) @location(7) disc_offset_world: vec3f,
    // Before skins and morph targets move it; what masks are hashed by. 0 without masks.
    @if(!points) @location(7) position_object: vec3f,
    // From the eye to the plane through the vertex at right angles to its normal, along that: see `surface_lift.wgsl`.
    @location(8) plane_m: f32,
}

// The index of a node, plus 1.
fn object_id(object: u32) -> u32 {
    return object & select(~WITHOUT_NORMALS, (1u << FADE_SHIFT) - 1u, fades != 0u);
}

fn is_without_normals(object: u32) -> bool {
    return (object & WITHOUT_NORMALS) != 0u;
}

@if(skins) @group(3) @binding(0) var joint_matrices: texture_2d<f32>;
@if(skins) @group(3) @binding(1) var morph_displacements: texture_2d<f32>;
@if(skins) @group(3) @binding(2) var morph_weights: texture_2d<f32>;

fn data_texel(index: u32) -> vec2i {
    return vec2i(i32(index % DATA_WIDTH), i32(index / DATA_WIDTH));
}

// The first three rows of a matrix.
struct Rows {
    row0: vec4f,
    row1: vec4f,
    row2: vec4f,
}

@if(skins) fn joint_rows(joint: u32) -> Rows {
    return Rows(
        textureLoad(joint_matrices, data_texel(joint * 3u), 0),
        textureLoad(joint_matrices, data_texel(joint * 3u + 1u), 0),
        textureLoad(joint_matrices, data_texel(joint * 3u + 2u), 0),
    );
}

@if(skins) fn skinned_rows(in: SurfaceInput, first_joint: u32) -> Rows {
    var rows = Rows(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    for (var i = 0u; i < 4u; i++) {
        let joint = joint_rows(first_joint + in.joints[i]);
        rows.row0 += joint.row0 * in.weights[i];
        rows.row1 += joint.row1 * in.weights[i];
        rows.row2 += joint.row2 * in.weights[i];
    }
    return rows;
}

// What the morph targets add to position, normal and tangent.
struct Displacement {
    position: vec3f,
    normal: vec3f,
    tangent: vec3f,
}

@if(skins) fn vertex_of_primitive(in: SurfaceInput) -> u32 {
    @if(points) {
        return in.vertex / POINT_CORNERS;
    }
    @if(!points) {
        return in.vertex;
    }
}

@if(skins) fn morph_displacement(in: SurfaceInput, first_weight: u32) -> Displacement {
    var sum = Displacement(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    for (var target_index = 0u; target_index < in.instance.w; target_index++) {
        let weight = textureLoad(morph_weights, data_texel(first_weight + target_index), 0).r;
        let first = in.morph.x + (target_index * in.morph.y + vertex_of_primitive(in)) * 3u;
        sum.position += weight * textureLoad(morph_displacements, data_texel(first), 0).xyz;
        sum.normal += weight * textureLoad(morph_displacements, data_texel(first + 1u), 0).xyz;
        sum.tangent += weight * textureLoad(morph_displacements, data_texel(first + 2u), 0).xyz;
    }
    return sum;
}

fn transform_point(rows: Rows, position: vec3f) -> vec3f {
    let point = vec4f(position, 1.0);
    return vec3f(dot(rows.row0, point), dot(rows.row1, point), dot(rows.row2, point));
}

// A corner of the triangle with equal sides around a disc, which faces the eye.
@if(points) fn disc_corner(vertex: u32) -> vec2f {
    let index = vertex % POINT_CORNERS;
    return select(vec2f(select(-1.7320508, 1.7320508, index == 1u), -1.0), vec2f(0.0, 2.0), index == 2u);
}

// From the middle of a disc to a corner. Discs are parallel to the picture, so that all of a disc has one distance.
@if(points) fn disc_offset_world(middle_world: vec3f, corner: vec2f) -> vec3f {
    let diameter_px = max(view.size_px.y * POINT_HEIGHT_SHARE, POINT_DIAMETER_MIN_PX);
    let distance_m = -(view.view_from_world * vec4f(middle_world, 1.0)).z;
    let half_extent_m = diameter_px * view.inverse_size_px * view.view_from_ndc_scale * mix(distance_m, 1.0, view.orthographic);
    return (view.world_from_view * vec4f(corner * half_extent_m, 0.0, 0.0)).xyz;
}

// The normal of a point, turned towards the eye; without one (zero), that of its disc.
@if(points) fn point_normal_world(normal_world: vec3f) -> vec3f {
    let disc_normal = view.world_from_view[2].xyz;
    let facing = normal_world * select(-1.0, 1.0, dot(normal_world, disc_normal) >= 0.0);
    return select(disc_normal, facing, dot(normal_world, normal_world) > 0.5);
}

fn surface_varying(in: SurfaceInput) -> SurfaceVarying {
    var position = in.position;
    var normal = in.normal.xyz;
    var tangent = in.tangent.xyz;
    var rows = Rows(in.world_from_object_row0, in.world_from_object_row1, in.world_from_object_row2);
    @if(skins) {
        if deformed != 0u {
            let displacement = morph_displacement(in, in.instance.z);
            position += displacement.position;
            normal += displacement.normal;
            tangent += displacement.tangent;
            if in.instance.y != 0xffffffffu {
                rows = skinned_rows(in, in.instance.y);
            }
        }
    }
    let row_x = rows.row0.xyz;
    let row_y = rows.row1.xyz;
    let row_z = rows.row2.xyz;
    @if(points) let corner = disc_corner(in.vertex);
    @if(points) let middle_world = transform_point(rows, position);
    @if(points) let offset_world = disc_offset_world(middle_world, corner);
    @if(points) let position_world = middle_world + offset_world;
    @if(!points) let position_world = transform_point(rows, position);
    // The cofactor matrix turns normals rightly under any scale; its sign is that of the determinant.
    let cofactor_x = cross(row_y, row_z);
    let cofactor_y = cross(row_z, row_x);
    let cofactor_z = cross(row_x, row_y);
    let handedness = select(-1.0, 1.0, dot(row_x, cofactor_x) >= 0.0);
    let normal_world = vec3f(dot(cofactor_x, normal), dot(cofactor_y, normal), dot(cofactor_z, normal)) * handedness;

    var out: SurfaceVarying;
    out.position_clip = view.clip_from_world * vec4f(position_world, 1.0);
    out.position_world = position_world;
    @if(!points) {
        if masked != 0u {
            out.position_object = in.position;
        }
    }
    out.normal_world = normal_world * inverseSqrt(max(dot(normal_world, normal_world), 1e-30));
    @if(points) {
        out.normal_world = point_normal_world(out.normal_world);
        out.corner = corner;
        out.disc_offset_world = offset_world;
    }
    let tangent_world = vec3f(dot(row_x, tangent), dot(row_y, tangent), dot(row_z, tangent));
    out.tangent_world = vec4f(
        tangent_world * inverseSqrt(max(dot(tangent_world, tangent_world), 1e-30)),
        in.tangent.w * handedness,
    );
    @if(detailed) {
        out.object_scale = pow(abs(dot(row_x, cofactor_x)), 1.0 / 3.0);
    }
    out.plane_m = dot(position_world - view.world_from_view[3].xyz, out.normal_world);
    out.uv = vec4f(in.uv0, in.uv1);
    out.color = in.color;
    out.object = in.instance.x;
    return out;
}
