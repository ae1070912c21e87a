//! effect outline
//! reads: radiance, depth, normal, base_color, material, ids if object or material
//! passes: fs_edges -> edges, fs_rows -> rows, fs_outline

// Outlines at steps of depth (silhouettes), at creases, at changes of base colour, and at borders of objects and
// materials.
// Sources: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes"; Decaudin 1996, "Cartoon-Looking Rendering of 3D
// Scenes" (ids); Felzenszwalb & Huttenlocher 2012, "Distance
// Transforms of Sampled Functions" (rows, then columns). Differs from the first: depth is compared with what a plane
// through its neighbours would have. The inverse of depth is affine on a plane in a picture (depth itself where rays are
// parallel), so that no plane, however oblique, has lines on it.

struct Outline {
    /// Colour of the lines, linear Rec. 709, of white as it is exposed
    // = 0, 0, 0 in 0..
    color: vec3f,
    /// The opacity of lines, share
    // = 1 in 0..1
    strength: f32,
    /// The width of lines, px
    // = 2 in 0..32
    width_px: f32,
    /// The step of depth that gets a line, share of the farther distance
    // = 0.03 in 0.001..1
    depth: f32,
    /// The angle between neighbouring normals from which a crease gets a line; 180: none does, °
    // = 35 in 1..180
    crease_deg: f32,
    /// The difference of neighbouring base colours that gets a line, of a channel in linear light; 1: none does.
    // = 1 in 0.01..1
    base_color: f32,
    /// Whether borders between nodes get a line: 1 or 0
    // = 0 in 0..1
    object: f32,
    /// Whether borders between materials get a line: 1 or 0
    // = 0 in 0..1
    material: f32,
}

@group(2) @binding(0) var<uniform> outline: Outline;

// What has no surface counts as so far away: its inverse is a number still.
const FARTHEST_M: f32 = 1e12;

fn inside(pixel: vec2i) -> vec2i {
    return clamp(pixel, vec2i(0), vec2i(view.size_px) - 1);
}

// What is affine along a plane, and greater where it is nearer.
fn nearness(pixel: vec2i) -> f32 {
    return 1.0 / clamp(distance_at(pixel), 1e-6, FARTHEST_M);
}

// How far the middle one of three depths is off the line through the others, as a share of the farther distance.
fn depth_step(before: f32, here: f32, after: f32) -> f32 {
    let nearest = max(here, max(before, after));
    let by_inverse = abs(before + after - 2.0 * here) / nearest;
    // Where rays are parallel, distances themselves are affine.
    let distances = 1.0 / vec3f(before, here, after);
    let farthest = max(distances.y, max(distances.x, distances.z));
    let by_distance = abs(distances.x + distances.z - 2.0 * distances.y) / farthest;
    return select(by_inverse, by_distance, view.orthographic > 0.5);
}

// Whether two surfaces beside each other are one.
fn differs(a: Surface, ids_here: vec2u, pixel: vec2i) -> bool {
    let b = surface_at(inside(pixel));
    let is_surface = distance_at(inside(pixel)) < DISTANCE_BACKGROUND_M;
    let change = abs(a.base_color - b.base_color);
    let by_id = vec2f(outline.object, outline.material) >= vec2f(0.5);
    let is_another = any((ids_here != textureLoad(ids, inside(pixel), 0).rg) & by_id);
    let is_crease = dot(a.normal_world, b.normal_world) < cos(radians(outline.crease_deg));
    return is_surface && (is_another || is_crease || max(change.r, max(change.g, change.b)) > outline.base_color);
}

// 1 on both sides of an edge.
@fragment
fn fs_edges(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = nearness(pixel);
    let last = vec2i(view.size_px) - 1;
    let across = depth_step(nearness(inside(pixel - vec2i(1, 0))), here, nearness(inside(pixel + vec2i(1, 0))));
    let down = depth_step(nearness(inside(pixel - vec2i(0, 1))), here, nearness(inside(pixel + vec2i(0, 1))));
    // At the border of the picture a pixel is its own neighbour, and no plane.
    let is_inside = (pixel > vec2i(0)) & (pixel < last);
    var is_edge = any((vec2f(across, down) > vec2f(outline.depth)) & is_inside);
    if distance_at(pixel) < DISTANCE_BACKGROUND_M && !is_edge {
        let surface = surface_at(pixel);
        let of_this = textureLoad(ids, pixel, 0).rg;
        is_edge = differs(surface, of_this, pixel + vec2i(1, 0)) || differs(surface, of_this, pixel - vec2i(1, 0))
            || differs(surface, of_this, pixel + vec2i(0, 1)) || differs(surface, of_this, pixel - vec2i(0, 1));
    }
    return vec4f(select(0.0, 1.0, is_edge), 0.0, 0.0, 1.0);
}

// So many pixels to each side can be part of a line.
fn reach() -> i32 {
    return i32(ceil(0.5 * outline.width_px));
}

// The distance to the nearest edge of the row.
@fragment
fn fs_rows(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    var nearest = 1000.0;
    for (var x = -reach(); x <= reach(); x++) {
        let is_edge = textureLoad(edges, inside(pixel + vec2i(x, 0)), 0).r > 0.5;
        nearest = min(nearest, select(1000.0, f32(abs(x)), is_edge));
    }
    return vec4f(nearest, 0.0, 0.0, 1.0);
}

@fragment
fn fs_outline(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    var nearest = 1000.0;
    for (var y = -reach(); y <= reach(); y++) {
        let across = textureLoad(rows, inside(pixel + vec2i(0, y)), 0).r;
        nearest = min(nearest, length(vec2f(across, f32(y))));
    }
    // An edge lies between two pixels, which both are marked: half of the line is on each side.
    let covered = outline.strength * clamp(0.5 * outline.width_px - nearest, 0.0, 1.0);
    return mix(here, vec4f(half_float_clamped(outline.color), 1.0), covered);
}
