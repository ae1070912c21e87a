// How much of a light reaches a point past what casts shadows: the atlas of shadow maps, reached only through here.
// Source: percentage closer filtering (Reeves, Salesin & Cook 1987) with comparisons that lie on the receiver's own
// plane (Isidoro 2006, "Shadow Mapping: GPU-based Tips and Techniques") and a surface moved along its normal (Holbert
// 2011, "Saying Goodbye to Shadow Acne"); penumbrae after Fernando 2005, "Percentage-Closer Soft Shadows". Spaces of
// tiles: see `shadows/projection.rs`.

import package::view::view;
import package::constants::PENUMBRA_MAX;
import package::shaders::hash::gradient_noise;
import package::shaders::light_table::{
    LIGHT_SHADOW, cluster_grid, light_part, light_place, table_rows,
};
import package::shaders::samplers::nearest_clamp;

@group(0) @binding(8) var shadow_atlas: texture_depth_2d;
@group(0) @binding(9) var shadow_compare: sampler_comparison;
@group(0) @binding(10) var shadow_depths: texture_2d<f32>;

// 1 if any light casts shadows; else nothing here is called.
override shadowed: u32 = 0u;

// Whether penumbrae are as wide as lights make them (1): a constant of pipelines, since software adapters run both
// sides of what a uniform chooses.
override penumbrae: u32 = 0u;

// Whether a comparison stands for all four of a filter (1): in one of the samples of a still, which take them in turn.
override takes_one_tap: u32 = 0u;

// Comparisons across the filter, a texel apart, if they are not two.
override kernel_side: u32 = 2u;

// 1 if no directional light has more than one cascade.
override one_cascade: u32 = 0u;

// The border of a tile in texels, within which filters find neighbours.
const BORDER_TEXELS: f32 = 3.0;
// Room for rounding: of depth as such, and as a share of it.
const DEPTH_SLACK: f32 = 2e-7;
const DEPTH_SLACK_SHARE: f32 = 2e-5;
// Room for the rounding of positions, as a share of the largest coordinate: six times what a float of 24 bits leaves
// out, because both the map and the surface are rounded, in more than one step.
const POSITION_SLACK_SHARE: f32 = 7e-7;
// Comparisons of a penumbra, and looks for what blocks the light.
const PENUMBRA_TAPS: u32 = 16u;
// Of walls close before a surface: what is left of the bias where texels are compared at their own middles; texels that
// are read, those of the filter (3 × 3) and two up the surface's slope; the rise of a surface over a texel, in texels,
// from which on the bias lifts it through walls of two texels; what each of the two texels counts; the weight of texels
// without a wall from which on nothing is taken away; and the share of texels that show the surface, of all that tell
// anything, from which on nothing is taken away beside a drop.
const WALL_BIAS_SHARE: f32 = 0.1;
const WALL_READS: u32 = 11u;
const WALL_SLOPE_MIN: f32 = 0.5;
const UPHILL_WEIGHT: f32 = 0.125;
const OPEN_WEIGHT: f32 = 0.25;
const SHOWN_SHARE: f32 = 0.5;
// The golden angle: successive points of a spiral lie nowhere near each other (Vogel 1979).
const GOLDEN_ANGLE: f32 = 2.39996323;

struct ShadowTile {
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    // The middle in texture coordinates, half the side, the side of a texel in metres (at z = 1 if rays go through a
    // point).
    place: vec4f,
}

// Its texels, in the order of its members.
const TILE_ROW_X: f32 = 0.0;
const TILE_ROW_Y: f32 = 1.0;
const TILE_ROW_Z: f32 = 2.0;
const TILE_PLACE: f32 = 3.0;

// A point as a tile sees it: x and y from -1 to 1 across it, depth (1 nearest to the light), and by how much the depth
// of its surface rises along x and y.
struct ShadowPoint {
    position: vec2f,
    depth: f32,
    gradient: vec2f,
    // The point of the surface itself, before it is moved along its normal, in the tile's space; and the share of that
    // way that stays where walls are looked for.
    on_surface: vec3f,
    kept: f32,
}

fn shadow_tile(index: u32) -> ShadowTile {
    let table_uv = light_place(index, table_rows());
    return ShadowTile(
        light_part(table_uv, TILE_ROW_X),
        light_part(table_uv, TILE_ROW_Y),
        light_part(table_uv, TILE_ROW_Z),
        light_part(table_uv, TILE_PLACE),
    );
}

fn in_tile(tile: ShadowTile, position_world: vec3f) -> vec3f {
    let p = vec4f(position_world, 1.0);
    return vec3f(dot(tile.row_x, p), dot(tile.row_y, p), dot(tile.row_z, p));
}

// The surface of normal `normal` at a point, moved along it so that it does not shadow itself within a texel.
fn shadow_point(tile: ShadowTile, position_world: vec3f, normal: vec3f, perspective: bool) -> ShadowPoint {
    let on_surface = in_tile(tile, position_world);
    let texel_m = tile.place.w * select(1.0, max(on_surface.z, 0.0), perspective);
    // A surface that lies as the map does needs less of it, however the light's rays meet it; half of it is kept
    // because normals may be bent.
    let facing = min(abs(dot(tile.row_z.xyz, normal)) / length(tile.row_z.xyz), 1.0);
    // Far from the origin positions are rounded to more than a texel.
    let largest = max(max(abs(position_world.x), abs(position_world.y)), abs(position_world.z));
    let of_texel_m = cluster_grid.shadow_filter.w * texel_m * max(sqrt(1.0 - facing * facing), 0.5);
    let slack_m = POSITION_SLACK_SHARE * largest;
    let offset_m = max(of_texel_m, slack_m);
    let at = in_tile(tile, position_world + normal * offset_m);
    // Normals turn by the inverse transpose; the rows are at right angles, so that this is a division by squared
    // lengths. Those of a map whose texels are moved are so within a texel of 128 at most, far less than the bias.
    let plane = vec3f(
        dot(tile.row_x.xyz, normal) / dot(tile.row_x.xyz, tile.row_x.xyz),
        dot(tile.row_y.xyz, normal) / dot(tile.row_y.xyz, tile.row_y.xyz),
        dot(tile.row_z.xyz, normal) / dot(tile.row_z.xyz, tile.row_z.xyz),
    );
    let inverse_z = 1.0 / max(at.z, 1e-6);
    var point: ShadowPoint;
    point.position = at.xy * select(1.0, inverse_z, perspective);
    point.depth = select(at.z, inverse_z, perspective);
    // The plane of the surface, not of the point beside it, which a light that stands low sees from below: with rays
    // through a point, 1 / z is linear in x / z and y / z. At a grazing angle it is taken to be less steep than it is.
    let through_eye = min(dot(plane, on_surface), -0.02 * length(plane) * length(on_surface));
    let parallel = max(plane.z, 0.02 * length(plane));
    point.gradient = select(-plane.xy / parallel, plane.xy / through_eye, perspective);
    point.on_surface = on_surface;
    point.kept = max(WALL_BIAS_SHARE * of_texel_m, slack_m) / max(offset_m, 1e-30);
    return point;
}

// The share of light that passes at `offset` from a point, in units of the tile's half side.
fn shadow_tap(tile: ShadowTile, point: ShadowPoint, offset: vec2f, texels: f32) -> f32 {
    let limit = 1.0 - 1.0 / texels;
    let position = clamp(point.position + offset, vec2f(-limit), vec2f(limit));
    let depth = point.depth + dot(point.gradient, position - point.position);
    let uv = tile.place.xy + position * vec2f(tile.place.z, -tile.place.z);
    let reference = depth * (1.0 + DEPTH_SLACK_SHARE) + DEPTH_SLACK;
    return textureSampleCompareLevel(shadow_atlas, shadow_compare, uv, clamp(reference, 0.0, 1.0));
}

// 0 to 1, another value for every pixel and sample.
fn rotation_noise(position_world: vec3f) -> f32 {
    let clip = view.clip_from_world * vec4f(position_world, 1.0);
    return gradient_noise((clip.xy / max(clip.w, 1e-6) * 0.5 + 0.5) * view.size_px, view.sample_index);
}

// The points of a disc of radius 1, the first of them nearest to its middle.
fn spiral(index: u32, count: u32, rotation: f32) -> vec2f {
    let angle = f32(index) * GOLDEN_ANGLE + rotation * 6.2831853;
    return vec2f(cos(angle), sin(angle)) * sqrt((f32(index) + 0.5) / f32(max(count, 1u)));
}

// The radius of the penumbra at a point, in units of the tile's half side: that of the light, seen from the point
// through what blocks it, which `count` looks around the point find. 0 if they find nothing.
fn penumbra_radius(
    tile: ShadowTile,
    point: ShadowPoint,
    radius: f32,
    perspective: bool,
    texels: f32,
    rotation: f32,
    count: u32,
) -> f32 {
    // Metres in which depth, or with rays through a point z, changes by 1.
    let depth_m = inverseSqrt(dot(tile.row_z.xyz, tile.row_z.xyz));
    // The light's radius in units of half the tile: of parallel rays for every metre on the way, else where z is 1.
    let light = radius / (0.5 * texels * tile.place.w);
    let z = 1.0 / max(point.depth, 1e-6);
    // As wide as what blocks the light could make it if it lay as near to the light as it can, or three quarters of the
    // way.
    let search = clamp(light * select(depth_m * (1.0 - point.depth), 3.0 / z, perspective), 1.0 / texels, PENUMBRA_MAX);
    let size = vec2f(textureDimensions(shadow_depths));
    let limit = vec2f(1.0 - 1.0 / texels);
    var blockers = vec2f(0.0);
    for (var i = 0u; i < count; i++) {
        let position = clamp(point.position + spiral(i, count, rotation) * search, -limit, limit);
        let uv = tile.place.xy + position * vec2f(tile.place.z, -tile.place.z);
        let texel = (floor(uv * size) + 0.5) / size;
        let depth = textureSampleLevel(shadow_depths, nearest_clamp, texel, 0.0).r;
        let receiver = point.depth + dot(point.gradient, position - point.position);
        let is_blocker = depth > receiver * (1.0 + DEPTH_SLACK_SHARE) + DEPTH_SLACK;
        blockers += select(vec2f(0.0), vec2f(depth, 1.0), is_blocker);
    }
    let blocker = blockers.x / max(blockers.y, 1.0);
    // Similar triangles: radius (d - b) / b, seen from the light at the receiver's distance d; of parallel rays radius
    // (d - b).
    let of_parallel = light * depth_m * max(blocker - point.depth, 0.0);
    let of_point = light * max(z - 1.0 / max(blocker, 1e-6), 0.0) * blocker / z;
    return min(select(of_parallel, of_point, perspective), PENUMBRA_MAX);
}

// The share of light that passes around a point of the surface at `position_world`.
fn filtered_visibility(
    tile: ShadowTile,
    point: ShadowPoint,
    position_world: vec3f,
    radius: f32,
    perspective: bool,
    texels: f32,
) -> f32 {
    let texel = 2.0 / max(texels, 1.0);
    if penumbrae == 1u {
        let rotation = rotation_noise(position_world);
        // A loop without rounds rather than a branch, of which software adapters run both sides.
        let looks = select(0u, PENUMBRA_TAPS, radius > 0.0);
        let width = max(penumbra_radius(tile, point, radius, perspective, texels, rotation, looks), texel);
        var soft = 0.0;
        for (var i = 0u; i < PENUMBRA_TAPS; i++) {
            soft += shadow_tap(tile, point, spiral(i, PENUMBRA_TAPS, rotation) * width, texels);
        }
        return soft / f32(PENUMBRA_TAPS);
    }
    // The middle of its texel if texels are seen as they are.
    let snapped = (floor(point.position / texel) + 0.5) * texel - point.position;
    let middle = snapped * cluster_grid.shadow_filter.y;
    let spread = cluster_grid.shadow_filter.x * texel;
    if kernel_side != 2u {
        let side = max(kernel_side, 1u);
        let taps = side * side;
        let first = -0.5 * (f32(side) - 1.0);
        var wide = 0.0;
        for (var i = 0u; i < taps; i++) {
            let place = vec2f(f32(i % side), f32(i / side));
            wide += shadow_tap(tile, point, middle + (place + first) * texel, texels);
        }
        return wide / f32(taps);
    }
    if takes_one_tap == 1u {
        let turn = u32(cluster_grid.shadow_filter.z);
        let corner = vec2f(f32(turn & 1u), f32(turn >> 1u)) * 2.0 - 1.0;
        return shadow_tap(tile, point, middle + corner * spread, texels);
    }
    var sum = shadow_tap(tile, point, middle + vec2f(-spread, -spread), texels);
    sum += shadow_tap(tile, point, middle + vec2f(spread, -spread), texels);
    sum += shadow_tap(tile, point, middle + vec2f(-spread, spread), texels);
    sum += shadow_tap(tile, point, middle + vec2f(spread, spread), texels);
    return 0.25 * sum;
}

// How much of the parallel light that the filter found is no leak: 0 if a wall close before the surface covers all
// texels of the filter, else 1. Its bias, and comparisons for four texels at once, lift a surface that leans through
// walls of some texels. Here each texel is compared at its own middle with the surface's plane, so that a tenth of the
// bias is enough. Walls count only as far as there are leaks, so that the edges of what is farther before the surface
// stay exactly what the filter makes them.
// Beside a drop (the edge of a closed box of sheets, as the light sees it) texels show what is far behind the surface,
// or nothing. They say nothing about walls before it. There light is kept only if enough of the other texels show the
// surface itself.
fn light_without_leaks(tile: ShadowTile, point: ShadowPoint, filtered: f32, texels: f32) -> f32 {
    let texel = 2.0 / max(texels, 1.0);
    let limit = vec2f(1.0 - 1.0 / texels);
    // In units of depth: how far the surface rises over a texel, and the side of a texel.
    let rise = length(point.gradient) * texel;
    let side = tile.place.w * length(tile.row_z.xyz);
    let foot = point.on_surface;
    let lift = point.depth - foot.z - dot(point.gradient, point.position - foot.xy);
    let bias = max(lift, 0.0) * point.kept + max(foot.z, 0.0) * DEPTH_SLACK_SHARE + DEPTH_SLACK;
    // What covers a texel by less than that counts in part, so that fine relief shadows itself no more than before.
    let ramp = 0.5 * (rise + side);
    // Of a wall at a right angle to the surface no texel is farther where it leaks.
    let reach = 6.0 * rise + 4.0 * side;
    let uphill = point.gradient * (texel / max(length(point.gradient), 1e-30));
    // The filter's place, unless a large bias moves that away from what the surface itself is lit by.
    let moved = point.position - foot.xy;
    let place = foot.xy + moved * min(1.0, 1.5 * texel / max(length(moved), 1e-30));
    let own = (floor(place / texel) + 0.5) * texel;
    // A surface that faces the light leaks beside drops alone, and there the filter finds something, too.
    let is_asked = (filtered > 0.0) & ((rise > WALL_SLOPE_MIN * side) | (filtered < 1.0));
    // Without rounds where nothing can leak, rather than a branch, of which software adapters run both sides.
    let rounds = select(0u, WALL_READS, is_asked);
    var open = select(OPEN_WEIGHT, 0.0, is_asked);
    // The weights of texels that show the surface itself, of those with a wall, and of those with a drop.
    var shown = 0.0;
    var walled = 0.0;
    var dropped = 0.0;
    // And of those with something farther away: a wall that the light grazes may be such.
    var farther = 0.0;
    for (var i = 0u; i < rounds; i++) {
        // The texel in the middle first: nearly always it decides.
        let turn = (i + 4u) % 9u;
        let around = own + (vec2f(f32(turn % 3u), f32(turn / 3u)) - 1.0) * texel;
        // Lit surfaces in a corner are themselves what the map shows up their slope; beside a leak two texels in a row
        // are not.
        let is_uphill = i >= 9u;
        let ahead = foot.xy + uphill * select(1.0, 2.5, i > 9u);
        let middle = (floor(ahead / texel) + 0.5) * texel;
        let position = clamp(select(around, middle, is_uphill), -limit, limit);
        let uv = tile.place.xy + position * vec2f(tile.place.z, -tile.place.z);
        let depth = textureSampleLevel(shadow_depths, nearest_clamp, uv, 0.0).r;
        let gap = depth - (foot.z + dot(point.gradient, position - foot.xy));
        // Nothing was drawn where depth is 0.
        let is_drop = (gap < -reach) | (depth <= 0.0);
        let is_wall = (gap > bias) & (gap <= reach) & (depth > 0.0);
        let covered = select(0.0, clamp((gap - bias) / ramp, 0.0, 1.0), is_wall);
        // Texels on the line where a wall meets the surface count as the surface, less so the higher the wall is.
        let likeness = select(clamp(1.25 - 1.25 * gap / bias, 0.0, 1.0), 0.0, is_drop);
        // Those of four comparisons, each between four texels.
        let weights = 0.5 * clamp(1.5 - abs(around - place) / texel, vec2f(0.0), vec2f(1.0));
        let weight = select(weights.x * weights.y, UPHILL_WEIGHT, is_uphill);
        let uphill_weight = select(0.0, UPHILL_WEIGHT, abs(gap) < 0.5 * bias);
        open += select(weight * (1.0 - covered), uphill_weight, is_uphill);
        shown += select(weight * likeness, uphill_weight, is_uphill);
        walled += select(0.0, weight, is_wall & !is_uphill);
        farther += select(0.0, weight, (gap > reach) & (depth > 0.0) & !is_uphill);
        dropped += select(0.0, weight, is_drop);
        if shown >= OPEN_WEIGHT {
            break;
        }
    }
    // Where no texel tells anything, the filter is believed.
    let told = shown + walled;
    let trust_filter = select(1.0, 0.0, farther > 0.0);
    let of_shown = select(trust_filter, shown / (SHOWN_SHARE * max(told, 1e-6)), told > 0.0);
    let is_at_drop = (dropped > 0.0) & (shown < OPEN_WEIGHT);
    let kept = select(open / OPEN_WEIGHT, of_shown, is_at_drop);
    return clamp(2.0 * kept - 1.0, 0.0, 1.0);
}

// The share of the light from a point that reaches a surface, by one tile.
fn tile_visibility(tile: ShadowTile, position_world: vec3f, normal: vec3f, radius: f32) -> f32 {
    let point = shadow_point(tile, position_world, normal, true);
    let texels = 2.0 * tile.place.z * f32(textureDimensions(shadow_atlas).x);
    return filtered_visibility(tile, point, position_world, radius, true, texels);
}

// The share of parallel light that reaches a surface, by one tile. Walls are looked for before what is flat: folds of
// bodies whose normals are smooth would count as walls.
fn parallel_tile_visibility(
    tile: ShadowTile,
    position_world: vec3f,
    normal: vec3f,
    radius: f32,
    is_flat: bool,
) -> f32 {
    let point = shadow_point(tile, position_world, normal, false);
    let texels = 2.0 * tile.place.z * f32(textureDimensions(shadow_atlas).x);
    let filtered = filtered_visibility(tile, point, position_world, radius, false, texels);
    // Wider filters see past what covers 3 × 3 texels.
    if (penumbrae == 1u) | (kernel_side > 2u) {
        return filtered;
    }
    return filtered * light_without_leaks(tile, point, select(0.0, filtered, is_flat), texels);
}

// Which face of a cube around a light sees what lies away from it: +x, -x, +y, -y, +z, -z.
fn cube_face(away: vec3f) -> u32 {
    let size = abs(away);
    let is_x = (size.x >= size.y) & (size.x >= size.z);
    let is_y = size.y >= size.z;
    let axis = select(select(2u, 1u, is_y), 0u, is_x);
    let along = select(select(away.z, away.y, is_y), away.x, is_x);
    return axis * 2u + select(0u, 1u, along < 0.0);
}

// The share of the light whose place in the table is `table_uv` that reaches a surface.
fn punctual_visibility(table_uv: vec2f, light_position: vec3f, position_world: vec3f, normal: vec3f) -> f32 {
    let shadow = light_part(table_uv, LIGHT_SHADOW);
    if shadow.x <= 0.0 {
        return 1.0;
    }
    let face = select(0u, cube_face(position_world - light_position), shadow.y > 1.5);
    let tile = shadow_tile(u32(shadow.x) + face);
    // Without a side there is nothing that casts a shadow.
    if tile.place.z <= 0.0 {
        return 1.0;
    }
    return tile_visibility(tile, position_world, normal, shadow.z);
}

// How far within a cascade, less its border, a place lies, as a share of half its side; none outside.
fn within_cascade(tile: ShadowTile, position_world: vec3f) -> f32 {
    let texels = 2.0 * tile.place.z * f32(textureDimensions(shadow_atlas).x);
    let at = abs(in_tile(tile, position_world).xy);
    let within = 1.0 - 2.0 * BORDER_TEXELS / texels - max(at.x, at.y);
    return select(0.0, within, tile.place.z > 0.0);
}

// The share of the directional light whose place in the table is `table_uv` that reaches a surface: by the first of its
// cascades that shows it, and where that ends, more and more by the next. `is_flat`: see `Shading`.
fn directional_visibility(table_uv: vec2f, position_world: vec3f, normal: vec3f, is_flat: bool) -> f32 {
    let shadow = light_part(table_uv, LIGHT_SHADOW);
    let count = u32(shadow.y);
    if one_cascade != 0u {
        let tile = shadow_tile(u32(shadow.x));
        let visibility = parallel_tile_visibility(tile, position_world, normal, shadow.z, is_flat);
        return select(1.0, visibility, (count > 0u) & (within_cascade(tile, position_world) > 0.0));
    }
    var visibility = 0.0;
    var left = 1.0;
    for (var i = 0u; i < count; i++) {
        let tile = shadow_tile(u32(shadow.x) + i);
        let within = within_cascade(tile, position_world);
        if within <= 0.0 {
            continue;
        }
        // The last of them goes on to its edge, unless shadows end at a distance.
        let goes_on = (i + 1u == count) & (shadow.w == 0.0);
        let weight = left * select(min(within * 10.0, 1.0), 1.0, goes_on);
        visibility += weight * parallel_tile_visibility(tile, position_world, normal, shadow.z, is_flat);
        left -= weight;
        if left <= 0.0 {
            break;
        }
    }
    return visibility + left;
}

// The share of light that gets to a place in the air, by one tile: the comparison of its texels alone, because no
// surface lies there that could shadow itself.
fn tile_visibility_in_air(tile: ShadowTile, position_world: vec3f, perspective: bool) -> f32 {
    let at = in_tile(tile, position_world);
    let inverse_z = 1.0 / max(at.z, 1e-6);
    var point: ShadowPoint;
    point.position = at.xy * select(1.0, inverse_z, perspective);
    point.depth = select(at.z, inverse_z, perspective);
    let texels = 2.0 * tile.place.z * f32(textureDimensions(shadow_atlas).x);
    return shadow_tap(tile, point, vec2f(0.0), texels);
}

// The share of the light whose place in the table is `table_uv` that gets to a place in the air.
fn punctual_visibility_in_air(table_uv: vec2f, light_position: vec3f, position_world: vec3f) -> f32 {
    let shadow = light_part(table_uv, LIGHT_SHADOW);
    if shadow.x <= 0.0 {
        return 1.0;
    }
    let face = select(0u, cube_face(position_world - light_position), shadow.y > 1.5);
    let tile = shadow_tile(u32(shadow.x) + face);
    if tile.place.z <= 0.0 {
        return 1.0;
    }
    return tile_visibility_in_air(tile, position_world, true);
}

// The share of the directional light whose place in the table is `table_uv` that gets to a place in the air: by the
// first of its cascades that shows it.
fn directional_visibility_in_air(table_uv: vec2f, position_world: vec3f) -> f32 {
    let shadow = light_part(table_uv, LIGHT_SHADOW);
    let count = u32(shadow.y);
    for (var i = 0u; i < count; i++) {
        let tile = shadow_tile(u32(shadow.x) + i);
        if within_cascade(tile, position_world) > 0.0 {
            return tile_visibility_in_air(tile, position_world, false);
        }
    }
    return 1.0;
}
