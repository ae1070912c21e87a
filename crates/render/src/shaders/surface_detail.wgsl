// Detail of a surface's normal: heights without relief's shift, and normals that are laid over others.

import package::constants::LAYER_BUMP;
import package::shaders::facet::{Facet, gradient};
import package::shaders::height::{exact_height_at, height_level};
import package::shaders::layer_maps::{
    MAP_DETAIL_NORMAL, MAP_HEIGHT, data_map, has_layer, has_map, layer_data, layer_factors, map_uv, map_uv_step,
};
import package::shaders::surface_vertex::SurfaceVarying;

// `detail`, which is a normal beside `vertex`, as it is beside `base` (Barré-Brisebois & Hill 2012, "Blending in
// Detail": the shortest turn from `vertex` to `base`).
fn reoriented(base: vec3f, detail: vec3f, vertex: vec3f) -> vec3f {
    let t = base + vertex;
    let u = vertex * (2.0 * dot(detail, vertex)) - detail;
    let turned = t * (dot(t, u) / max(dot(t, vertex), 1e-3)) - u;
    return turned * inverseSqrt(max(dot(turned, turned), 1e-12));
}

// The normal of heights over a surface of normal `vertex`: it leans away from where they rise (Blinn 1978), by their
// differences over two texels.
fn height_normal(in: SurfaceVarying, facet: Facet, vertex: vec3f) -> vec3f {
    let uv = map_uv(in.uv, MAP_HEIGHT);
    let uv_dx = map_uv_step(facet.uv_dx, MAP_HEIGHT);
    let uv_dy = map_uv_step(facet.uv_dy, MAP_HEIGHT);
    let level = height_level(uv_dx, uv_dy);
    let texel = exp2(round(level)) / vec2f(textureDimensions(layer_data));
    let rise = vec2f(
        exact_height_at(uv + vec2f(texel.x, 0.0), level) - exact_height_at(uv - vec2f(texel.x, 0.0), level),
        exact_height_at(uv + vec2f(0.0, texel.y), level) - exact_height_at(uv - vec2f(0.0, texel.y), level),
    ) / (2.0 * texel);
    let slope = gradient(facet, dot(rise, uv_dx), dot(rise, uv_dy)) * (layer_factors.detail.x * in.object_scale);
    // Where the triangle is too small for its pixels to tell anything, it is flat.
    let leaning = vertex - slope;
    let length_squared = dot(leaning, leaning);
    return select(vertex, leaning * inverseSqrt(max(length_squared, 1e-12)), length_squared < 1e12);
}

// A texel of the map of detail as a normal beside `vertex`; u of the map runs along the tangent, and v against the
// bitangent.
fn detail_map_normal(in: SurfaceVarying, facet: Facet, vertex: vec3f, facing: f32, y_sign: f32) -> vec3f {
    let encoded = data_map(in, MAP_DETAIL_NORMAL).xyz * 2.0 - 1.0;
    let uv_dx = map_uv_step(facet.uv_dx, MAP_DETAIL_NORMAL);
    let uv_dy = map_uv_step(facet.uv_dy, MAP_DETAIL_NORMAL);
    let turn = select(-1.0, 1.0, uv_dx.x * uv_dy.y - uv_dy.x * uv_dx.y >= 0.0);
    // Along u is where v stays, which is across the direction in which it rises.
    let rise_u = gradient(facet, uv_dx.x, uv_dy.x);
    let rise_v = gradient(facet, uv_dx.y, uv_dy.y);
    let across = facet.across * turn;
    let along_u = cross(rise_v, across);
    let along_v = cross(across, rise_u);
    let tangent = along_u - vertex * dot(along_u, vertex);
    let bitangent = vertex * dot(along_v, vertex) - along_v;
    let lengths = vec2f(dot(tangent, tangent), dot(bitangent, bitangent));
    let inverse = inverseSqrt(max(lengths, vec2f(1e-36))) * layer_factors.detail.z * facing;
    let bent = tangent * (inverse.x * encoded.x) + bitangent * (inverse.y * encoded.y * y_sign) + vertex * encoded.z;
    let length_squared = dot(bent, bent);
    let is_normal = (length_squared > 1e-12) & (min(lengths.x, lengths.y) > 1e-30);
    return select(vertex, bent * inverseSqrt(max(length_squared, 1e-12)), is_normal);
}

// `normal`, which a surface of normal `vertex` has so far, with all its detail.
fn detailed_normal(in: SurfaceVarying, facet: Facet, normal: vec3f, vertex: vec3f, facing: f32, y_sign: f32) -> vec3f {
    var detailed = normal;
    if has_layer(LAYER_BUMP) {
        detailed = reoriented(detailed, height_normal(in, facet, vertex), vertex);
    }
    if has_map(MAP_DETAIL_NORMAL) {
        detailed = reoriented(detailed, detail_map_normal(in, facet, vertex, facing, y_sign), vertex);
    }
    return detailed;
}
