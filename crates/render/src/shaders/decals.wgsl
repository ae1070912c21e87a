// Decals on a surface: those of the cluster's list whose box holds the place, one over the other in their order.
// Where: `decals.rs`, which writes them, and `light_table.wgsl`, in whose textures they lie.

import package::constants::{
    DECAL_COLOR_IMAGES, DECAL_EMISSION, DECAL_EMISSION_IMAGES, DECAL_LAYERS, DECAL_NORMALS, DECAL_ROUGHNESS,
    DECAL_ROUGHNESS_IMAGES, DECAL_TEXELS, DECALS_SHOWN,
};
import package::shaders::light_table::{cluster_grid, cluster_light_at, table_rows, table_texel};
import package::shaders::shading::{directional_albedo, linear_clamp};
import package::view::view;

// What there is of decals, by the bits of `constants.rs`; 0 where there are none.
override decals: u32 = 0u;

fn has_decals() -> bool {
    return (decals & DECALS_SHOWN) != 0u;
}

// What of a surface decals change.
struct Decaled {
    base_color: vec3f,
    metallic: f32,
    roughness_perceptual: f32,
    normal_world: vec3f,
    emission: vec3f,
}

const DECAL_ROW_X: u32 = 0u;
const DECAL_ROW_Y: u32 = 1u;
const DECAL_ROW_Z: u32 = 2u;
// Cosine of the angle from which on there is nothing; by how much there is more a cosine; the layers.
const DECAL_ANGLE: u32 = 3u;
const DECAL_COLOR: u32 = 4u;
const DECAL_COLOR_PLACE: u32 = 5u;
// Metallic, roughness, opacity of roughness, opacity of the normal.
const DECAL_FINISH: u32 = 6u;
const DECAL_NORMAL_PLACE: u32 = 7u;
const DECAL_GLOW: u32 = 8u;
const DECAL_GLOW_PLACE: u32 = 9u;
const DECAL_FINISH_PLACE: u32 = 10u;
// Scale of the normal map.
const DECAL_NORMAL_SCALE: u32 = 11u;
// Where it comes from, of length 1. Before it lies `world_from_box`.
const DECAL_BACK: u32 = 15u;

fn decal_part(decal: u32, part: u32) -> vec4f {
    return table_texel(decal * DECAL_TEXELS + part, cluster_grid.decal_rows.y);
}

// Where the list of a pixel begins among all entries, and its length.
fn decal_list(position_px: vec2f, distance_m: f32) -> vec2u {
    let size = cluster_grid.decal_size;
    let tile = min(vec2u(position_px) / size.w, size.xy - 1u);
    let slice_float = log2(distance_m) * cluster_grid.decal_slices.x + cluster_grid.decal_slices.y;
    let slice = u32(clamp(slice_float, 0.0, f32(size.z - 1u)));
    let index = (slice * size.y + tile.y) * size.x + tile.x;
    // By way of signed numbers, to which processors convert at once.
    return vec2u(vec2i(table_texel(index, cluster_grid.decal_rows.x).xy));
}

// A texel of the image at `place` (corner and size in texels), `uv` from the upper left corner, of which the changes from
// pixel to pixel are given.
fn decal_texel(place: vec4f, uv: vec2f, uv_dx: vec2f, uv_dy: vec2f) -> vec4f {
    let texels = vec2f(textureDimensions(directional_albedo));
    let across = uv_dx * place.zw;
    let down = uv_dy * place.zw;
    let lod = clamp(0.5 * log2(max(max(dot(across, across), dot(down, down)), 1e-12)) - view.mip_gain, 0.0,
        log2(min(place.z, place.w)));
    // Nothing of what lies beside it: half a texel of the coarser level away from the edge.
    let edge = min(vec2f(0.5 * exp2(ceil(lod))), 0.5 * place.zw);
    let at = clamp(uv * place.zw, edge, place.zw - edge);
    return textureSampleLevel(directional_albedo, linear_clamp, (place.xy + at) / texels, lod);
}

// The layers of a node by its object id, in two halves.
fn layers_of_object(object: u32) -> vec2u {
    let pair = table_texel(object / 2u, cluster_grid.decal_rows.z);
    return vec2u(select(pair.xy, pair.zw, (object & 1u) == 1u));
}

// So many entries of a list are looked at before those are shown that hold the place.
const LOOKED_AT_ONCE: u32 = 32u;

// The index of the only bit that is set: the exponent of a float (WebGL 2 has no function for it).
fn index_of_bit(bit: u32) -> u32 {
    return (bitcast<u32>(f32(bit)) >> 23u) - 127u;
}

// Lays a decal over a surface that lies within its box.
fn put_decal(
    out: ptr<function, Decaled>,
    decal: u32,
    place: vec4f,
    dx: vec3f,
    dy: vec3f,
    vertex_normal: vec3f,
    layers: vec2u,
) {
    let row_x = decal_part(decal, DECAL_ROW_X);
    let row_y = decal_part(decal, DECAL_ROW_Y);
    let angle = decal_part(decal, DECAL_ANGLE);
    let facing = dot(vertex_normal, decal_part(decal, DECAL_BACK).xyz);
    var share = clamp((facing - angle.x) * angle.y, 0.0, 1.0);
    if (decals & DECAL_LAYERS) != 0u {
        let both = vec2u(angle.zw) & layers;
        share = select(0.0, share, (both.x | both.y) != 0u);
    }
    let uv = vec2f(dot(row_x, place) + 0.5, 0.5 - dot(row_y, place));
    let uv_dx = vec2f(dot(row_x.xyz, dx), -dot(row_y.xyz, dx));
    let uv_dy = vec2f(dot(row_x.xyz, dy), -dot(row_y.xyz, dy));
    let color = decal_part(decal, DECAL_COLOR);
    let finish = decal_part(decal, DECAL_FINISH);
    // Times alpha.
    var paint = vec4f(1.0);
    if (decals & DECAL_COLOR_IMAGES) != 0u {
        let color_place = decal_part(decal, DECAL_COLOR_PLACE);
        paint = select(paint, decal_texel(color_place, uv, uv_dx, uv_dy), color_place.z > 0.0);
    }
    paint *= share;
    var roughness = finish.y;
    var metallic = finish.x;
    if (decals & DECAL_ROUGHNESS_IMAGES) != 0u {
        let finish_place = decal_part(decal, DECAL_FINISH_PLACE);
        let texel = decal_texel(finish_place, uv, uv_dx, uv_dy);
        roughness *= select(1.0, texel.g, finish_place.z > 0.0);
        metallic *= select(1.0, texel.b, finish_place.z > 0.0);
    }
    (*out).base_color = (*out).base_color * (1.0 - paint.a * color.a) + color.rgb * paint.rgb * color.a;
    (*out).metallic = mix((*out).metallic, metallic, paint.a * color.a);
    if (decals & DECAL_ROUGHNESS) != 0u {
        (*out).roughness_perceptual = mix((*out).roughness_perceptual, roughness, paint.a * finish.z);
    }
    if (decals & DECAL_NORMALS) != 0u {
        let normal_place = decal_part(decal, DECAL_NORMAL_PLACE);
        let scale = decal_part(decal, DECAL_NORMAL_SCALE).x;
        let encoded = decal_texel(normal_place, uv, uv_dx, uv_dy).xyz * 2.0 - 1.0;
        // The box's sides, laid onto the surface.
        let right = row_x.xyz - vertex_normal * dot(vertex_normal, row_x.xyz);
        let up = row_y.xyz - vertex_normal * dot(vertex_normal, row_y.xyz);
        let bent = right * (inverseSqrt(max(dot(right, right), 1e-30)) * encoded.x * scale)
            + up * (inverseSqrt(max(dot(up, up), 1e-30)) * encoded.y * scale) + vertex_normal * encoded.z;
        let unit = bent * inverseSqrt(max(dot(bent, bent), 1e-30));
        let mixed = mix((*out).normal_world, unit, select(0.0, paint.a * finish.w, normal_place.z > 0.0));
        let length_squared = dot(mixed, mixed);
        (*out).normal_world = select((*out).normal_world, mixed * inverseSqrt(max(length_squared, 1e-30)),
            length_squared > 1e-12);
    }
    if (decals & DECAL_EMISSION) != 0u {
        let glow = decal_part(decal, DECAL_GLOW);
        var emission = glow.rgb * paint.a;
        if (decals & DECAL_EMISSION_IMAGES) != 0u {
            let glow_place = decal_part(decal, DECAL_GLOW_PLACE);
            let texel = decal_texel(glow_place, uv, uv_dx, uv_dy);
            emission *= select(vec3f(1.0), texel.rgb, glow_place.z > 0.0);
        }
        (*out).emission = (*out).emission * (1.0 - paint.a * glow.a) + emission * glow.a;
    }
}

// `below` with the decals that hold the place; `vertex_normal` is that of the mesh.
fn decaled_surface(
    below: Decaled,
    position_px: vec2f,
    position_world: vec3f,
    dx: vec3f,
    dy: vec3f,
    vertex_normal: vec3f,
    object: u32,
) -> Decaled {
    var out = below;
    let distance_m = -(view.view_from_world * vec4f(position_world, 1.0)).z;
    let list = decal_list(position_px, distance_m);
    var layers = vec2u(0u);
    if (decals & DECAL_LAYERS) != 0u {
        layers = layers_of_object(object);
    }
    let place = vec4f(position_world, 1.0);
    let rows = table_rows();
    // First which they are, then what they show: software adapters run all of a loop's body for what is not held, too.
    let parts = (list.y + LOOKED_AT_ONCE - 1u) / LOOKED_AT_ONCE;
    for (var part = 0u; part < parts; part++) {
        let first = list.x + part * LOOKED_AT_ONCE;
        let count = min(list.x + list.y - first, LOOKED_AT_ONCE);
        var held = 0u;
        var held_count = 0u;
        for (var at = 0u; at < count; at++) {
            let decal = cluster_light_at(first + at, rows);
            let in_box = vec3f(
                dot(decal_part(decal, DECAL_ROW_X), place),
                dot(decal_part(decal, DECAL_ROW_Y), place),
                dot(decal_part(decal, DECAL_ROW_Z), place),
            );
            let is_held = max(max(abs(in_box.x), abs(in_box.y)), abs(in_box.z)) <= 0.5;
            held |= select(0u, 1u << at, is_held);
            held_count += select(0u, 1u, is_held);
        }
        for (var hit = 0u; hit < held_count; hit++) {
            let lowest = held & (~held + 1u);
            held ^= lowest;
            let decal = cluster_light_at(first + index_of_bit(lowest), rows);
            put_decal(&out, decal, place, dx, dy, vertex_normal, layers);
        }
    }
    return out;
}
