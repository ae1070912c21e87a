// probe_capture.texels: the light of a probe as surfaces look it up.
// Reads: probe_found (`light.wgsl`). Writes: the texels of `probes.wgsl`.
// Program: probe_texels.

import package::constants::{HALF_LARGEST, PROBE_HEIGHT, PROBE_WIDTH};
import package::shaders::octahedral::direction_from_octahedral;

struct ProbeTexels {
    // The first texel; 1 if light is six colours; zero.
    corner: vec4f,
}

@group(1) @binding(0) var probe_found: texture_2d<f32>;
@group(1) @binding(1) var<uniform> probe_texels: ProbeTexels;

fn found(index: u32) -> vec4f {
    return textureLoad(probe_found, vec2u(index, 0u), 0);
}

// Of six colours that of the side which a sign chooses.
fn side_color(axis: u32, sign: f32) -> vec3f {
    return found(1u + 2u * axis + select(0u, 1u, sign < 0.0)).rgb;
}

// Of irradiance as a square form of (x, y, z, 1) the number in a row and a column from it on.
fn form(row: u32, column: u32) -> vec3f {
    let constant = found(1u).rgb;
    let of_squares = found(7u).rgb;
    let of_difference = vec3f(found(1u).a, found(2u).a, found(3u).a);
    // Products of other axes, half of each in either of two places.
    let along = select(select(found(3u).rgb, found(2u).rgb, row == 1u), found(4u).rgb, row == 0u);
    let with_z = select(found(6u).rgb, found(8u).rgb, row == 0u);
    let across = select(select(along, with_z, column == 2u), found(5u).rgb, column == 1u) * 0.5;
    let on_height = select(constant - of_squares, 3.0 * of_squares, row == 2u);
    let on_sides = select(-of_difference, of_difference, row == 0u);
    return select(across, select(on_height, on_sides, row < 2u), row == column);
}

@fragment
fn fs_probe_texels(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = vec2u(position.xy - probe_texels.corner.xy);
    // No branch looks at it, because it would depend on uniforms alone, see docs/decisions/006.
    let is_cube = probe_texels.corner.z > 0.5;
    if place.y + 1u == PROBE_HEIGHT {
        let of_place = found(0u);
        let towards = direction_from_octahedral(vec2f(found(7u).a, found(8u).a));
        let source = select(vec4f(towards, of_place.a), vec4f(0.0), is_cube);
        return select(vec4f(0.0), select(source, vec4f(of_place.xyz, 1.0), place.x == 0u), place.x < 2u);
    }
    // Which block, and by that of which signs, and which rows and columns of the form.
    let block = place.x / 2u + PROBE_WIDTH / 2u * (place.y / 2u);
    let of_height = block == 4u || block == 5u;
    let of_both = block >= 6u;
    let signs = select(select(block, (block - 4u) << 2u, of_height), block - 6u, of_both);
    let of_signs = select(vec4f(1.0), vec4f(-1.0), (vec4u(signs) & vec4u(1u, 2u, 4u, 0u)) != vec4u(0u));
    let first = (place.y & 1u) + select(0u, 2u, of_height);
    let second = (place.x & 1u) + select(0u, 2u, of_height || of_both);
    // Forms are symmetric: the lesser of both is the row.
    let row = min(first, second);
    let column = max(first, second);
    let sources = vec3f(found(4u).a, found(5u).a, found(6u).a);
    let source = select(select(sources.x, sources.y, of_height), sources.z, of_both);
    let is_side = (row == column) & (row < 3u);
    let of_cube = vec4f(select(vec3f(0.0), side_color(min(row, 2u), of_signs[row]), is_side), 0.0);
    let light = form(row, column) * of_signs[row] * of_signs[column];
    let of_lobes = vec4f(clamp(light, vec3f(-HALF_LARGEST), vec3f(HALF_LARGEST)), source);
    return select(of_lobes, of_cube, is_cube);
}
