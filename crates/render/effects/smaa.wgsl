//! effect smaa
//! reads: display
//! fallback: fxaa
//! passes: fs_edges -> edges, fs_around -> around, fs_weights -> weights, fs_smaa

// Morphological anti-aliasing of pictures of few samples. Edges between pixels are found and followed to both ends. They
// are reconstructed as straight lines, and a pixel blends with its neighbour by the area beyond that line.
// Source: Jimenez et al. 2012, "SMAA: Enhanced Subpixel Morphological Antialiasing", in its form for one sample (1x), with
// adaptation to local contrast, diagonals and corners. Differs from it: areas under lines are computed where the paper
// looks them up in a texture, so that a line may be of any length; edges of alpha count as well; and colours are linear
// when they are mixed.

struct Smaa {
    /// The contrast below which there is no edge, of tones from 0 to 1
    // = 0.1 in 0.02..1
    threshold: f32,
    /// The distance over which an edge is followed to each side, px
    // = 48 in 4..112
    reach_px: u32,
    /// The rounding of corners, share
    // = 0.25 in 0..1
    corners: f32,
    padding: f32,
}

@group(2) @binding(0) var<uniform> smaa: Smaa;

// A difference that is so much weaker than the strongest one beside it is none that an eye sees.
const CONTRAST_RATIO: f32 = 2.0;
// So many steps of a staircase are followed to each side, and so many make a diagonal.
const DIAGONAL_REACH: i32 = 16;
const DIAGONAL_MIN: i32 = 4;
// A hollow of an edge that is longer than this is drawn as it is; shorter ones are smoothed more.
const SMOOTHED_PX: f32 = 32.0;

// Tone and coverage. A square root is near to how displays encode light.
fn tone(pixel: vec2i) -> vec2f {
    let color = display_at(pixel);
    return vec2f(dot(sqrt(max(color.rgb, vec3f(0.0))), vec3f(0.2126, 0.7152, 0.0722)), color.a);
}

fn contrast(a: vec2f, b: vec2f) -> f32 {
    return max(abs(a.x - b.x), abs(a.y - b.y));
}

// Whether there is an edge on the left (r) and on the upper side (g) of a pixel.
@fragment
fn fs_edges(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = tone(pixel);
    let left = tone(pixel + vec2i(-1, 0));
    let above = tone(pixel + vec2i(0, -1));
    let found = vec2f(contrast(here, left), contrast(here, above));
    if max(found.x, found.y) <= smaa.threshold {
        return vec4f(0.0);
    }
    let right = contrast(here, tone(pixel + vec2i(1, 0)));
    let below = contrast(here, tone(pixel + vec2i(0, 1)));
    let left_left = contrast(left, tone(pixel + vec2i(-2, 0)));
    let above_above = contrast(above, tone(pixel + vec2i(0, -2)));
    let strongest = max(max(max(right, below), max(left_left, above_above)), max(found.x, found.y));
    let is_edge = (found > vec2f(smaa.threshold)) & (CONTRAST_RATIO * found >= vec2f(strongest));
    return vec4f(select(vec2f(0.0), vec2f(1.0), is_edge), 0.0, 0.0);
}

fn inside(pixel: vec2i) -> vec2i {
    return clamp(pixel, vec2i(0), vec2i(textureDimensions(display)) - 1);
}

// The edges of a pixel, left (r) and above (g), the left one of the pixel above (b), and the upper one of the pixel to the
// left (a): all that meets in its upper left corner, so that a step along an edge is one lookup.
@fragment
fn fs_around(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = textureLoad(edges, pixel, 0).rg;
    let above = textureLoad(edges, inside(pixel - vec2i(0, 1)), 0).r;
    return vec4f(here, above, textureLoad(edges, inside(pixel - vec2i(1, 0)), 0).g);
}

fn around_at(pixel: vec2i) -> vec4f {
    return textureLoad(around, inside(pixel), 0);
}

// What meets in the corner, seen along a row or a column: the edge along it, what crosses on this side, what crosses on the
// other side, and the edge along it before the corner.
fn along_at(pixel: vec2i, along: vec2i) -> vec4f {
    let found = around_at(pixel);
    return select(found.rgab, found.grba, along.x != 0);
}

// One end of an edge: how many pixels it is away, and which edges cross it there, on this side and on the other.
struct End {
    distance: i32,
    crossing: vec2f,
}

// Follows the edge on the near side of `pixel` towards -`along` (`ahead` 0) or +`along` (`ahead` 1).
fn end_of_edge(pixel: vec2i, along: vec2i, ahead: i32) -> End {
    let step = along * (2 * ahead - 1);
    var end = End(0, vec2f(0.0));
    for (var i = 0; i < i32(smaa.reach_px); i++) {
        let corner = along_at(pixel + step * i + along * ahead, along);
        end.distance = i;
        end.crossing = corner.yz;
        if corner.y + corner.z > 0.0 || select(corner.w, corner.x, ahead == 1) == 0.0 {
            return end;
        }
    }
    end.crossing = vec2f(0.0);
    return end;
}

// The area between an edge of `length` pixels and the line from a height of 1 at its end to its middle, in the pixel that
// is `distance` pixels from this end.
fn area_under(distance: f32, length: f32) -> f32 {
    let a = min(distance, 0.5 * length);
    let b = min(distance + 1.0, 0.5 * length);
    return (b - a) * (1.0 - (a + b) / length);
}

// Where a line begins that stands for an end of an edge: half a pixel to the side to which what crosses goes on.
fn height(crossing: vec2f) -> f32 {
    return 0.5 * (crossing.y - crossing.x);
}

// How much the pixel takes of the one on the other side of its edge along a row (or a column), and that one of it.
fn straight(pixel: vec2i, along: vec2i) -> vec2f {
    let across = along.yx;
    let first = end_of_edge(pixel, along, 0);
    let second = end_of_edge(pixel, along, 1);
    let distances = vec2f(f32(first.distance), f32(second.distance));
    let length = distances.x + distances.y + 1.0;
    var heights = vec2f(height(first.crossing), height(second.crossing));
    // Where an end is crossed to both sides, the line begins opposite to its other end.
    let both = vec2f(first.crossing.x * first.crossing.y, second.crossing.x * second.crossing.y);
    heights = select(heights, -heights.yx, both > vec2f(0.5));
    var areas = abs(heights) * vec2f(area_under(distances.x, length), area_under(distances.y, length));
    if heights.x * heights.y > 0.0 {
        areas = mix(sqrt(0.5 * areas), areas, min(length / SMOOTHED_PX, 1.0));
    }
    let is_other = heights > vec2f(0.0);
    var shares = vec2f(dot(areas, select(vec2f(1.0), vec2f(0.0), is_other)),
        dot(areas, select(vec2f(0.0), vec2f(1.0), is_other)));
    // What crosses the nearer end and goes on is the side of a corner.
    let is_nearer = select(vec2f(0.0), vec2f(1.0), distances <= distances.yx);
    let rounding = (1.0 - smaa.corners) * is_nearer / (is_nearer.x + is_nearer.y);
    let start = pixel - along * first.distance;
    let stop = pixel + along * (second.distance + 1);
    let here = vec2f(along_at(start + across, along).y, along_at(stop + across, along).y);
    let there = vec2f(along_at(start - across, along).z, along_at(stop - across, along).z);
    shares *= max(1.0 - vec2f(dot(rounding, here), dot(rounding, there)), vec2f(0.0));
    return shares;
}

// The area of a unit square, whose lower left corner is `corner`, below a line that rises, from one place to another.
fn area_below(corner: vec2f, line: vec4f) -> f32 {
    let slope = (line.w - line.y) / (line.z - line.x);
    let left = line.y + slope * (corner.x - line.x) - corner.y;
    // The integral over the width of the height, limited to that of the square.
    let heights = max(vec4f(left + slope, left, left + slope - 1.0, left - 1.0), vec4f(0.0));
    return dot(heights * heights, vec4f(0.5, -0.5, -0.5, 0.5)) / slope;
}

// A step of a staircase: the edge above a pixel, and the one on its left (`side` 1) or right (`side` -1).
fn stair_at(pixel: vec2i, side: i32) -> vec2f {
    let found = around_at(pixel + vec2i(select(0, 1, side < 0), 0));
    return select(found.gr, found.ar, side < 0);
}

// One end of a staircase: how many steps follow `pixel`, and whether an edge above one more ends it; all steps: no end.
fn end_of_stairs(pixel: vec2i, step: vec2i, side: i32) -> vec2i {
    for (var i = 0; i < DIAGONAL_REACH; i++) {
        let found = stair_at(pixel + step * (i + 1), side);
        if found.x * found.y == 0.0 {
            return vec2i(i, i32(found.x));
        }
    }
    return vec2i(DIAGONAL_REACH, 0);
}

// Where a line goes through an end of a staircase: through one corner of the step or the other, by what goes on there
// along a row or a column; between them where nothing does, or both.
fn place_of_end(is_inner: bool, is_outer: bool) -> vec2f {
    if is_inner == is_outer {
        return select(vec2f(0.5, 0.0), vec2f(1.0, 0.5), is_inner);
    }
    return select(vec2f(1.0, 0.0), vec2f(1.0, 1.0), is_outer);
}

// As `straight`, for a staircase that rises to the right (`side` 1) or to the left (-1).
fn diagonal(pixel: vec2i, side: i32) -> vec2f {
    let down = vec2i(-side, 1);
    let lower_end = end_of_stairs(pixel, down, side);
    let upper_end = end_of_stairs(pixel, -down, side);
    // Without an edge at its side the pixel is the lowest step; else an edge along a row alone may be one more.
    let goes_down = i32(stair_at(pixel, side).y);
    let below = (lower_end.x + lower_end.y) * goes_down;
    let above = upper_end.x;
    if below + above < DIAGONAL_MIN {
        return vec2f(0.0);
    }
    // What goes on at the ends, along a column and along a row.
    let lower = around_at(pixel + down * below + vec2i(select(0, 1, side < 0), 0));
    let upper = around_at(pixel - down * above + vec2i(select(0, 1, side > 0), 0));
    let below_on = select(lower.ra, lower.rg, side < 0) * select(0.0, 1.0, lower_end.x < DIAGONAL_REACH);
    let above_on = select(upper.bg, upper.ba, side < 0) * select(0.0, 1.0, upper_end.x < DIAGONAL_REACH);
    let first = place_of_end(below_on.x > 0.0, below_on.y > 0.0);
    let second = place_of_end(above_on.y > 0.0, above_on.x > 0.0) + f32(below + above + 1);
    let corner = vec2f(f32(below)) + vec2f(1.0, 0.0);
    let line = vec4f(first, second);
    return vec2f(1.0 - area_below(corner, line), area_below(corner + vec2f(0.0, 1.0), line));
}

// How much the pixel takes of the one above it, that of it, the pixel of the one to its left, and that of it.
@fragment
fn fs_weights(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let found = textureLoad(around, pixel, 0).rg;
    var shares = vec4f(0.0);
    var is_diagonal = false;
    if found.g > 0.0 {
        // A staircase has edges along rows and columns; it is enough to follow it from the former.
        var above = diagonal(pixel, 1) + diagonal(pixel, -1);
        is_diagonal = above.x + above.y > 0.0;
        if !is_diagonal {
            above = straight(pixel, vec2i(1, 0));
        }
        shares = vec4f(above, 0.0, 0.0);
    }
    if found.r > 0.0 && !is_diagonal {
        shares = vec4f(shares.xy, straight(pixel, vec2i(0, 1)));
    }
    return shares;
}

fn weights_at(pixel: vec2i) -> vec4f {
    let within = inside(pixel);
    return select(vec4f(0.0), textureLoad(weights, within, 0), all(within == pixel));
}

@fragment
fn fs_smaa(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = display_at(pixel);
    let own = weights_at(pixel);
    // Of the left and the right, the upper and the lower neighbour.
    let beside = vec2f(own.b, weights_at(pixel + vec2i(1, 0)).a);
    let over = vec2f(own.r, weights_at(pixel + vec2i(0, 1)).g);
    let is_row = max(beside.x, beside.y) > max(over.x, over.y);
    let shares = select(over, beside, is_row);
    let sum = shares.x + shares.y;
    if sum < 1e-4 {
        return here;
    }
    let step = select(vec2i(0, 1), vec2i(1, 0), is_row);
    // The stronger edge counts more.
    let part = shares * shares / sum;
    return here * (1.0 - part.x - part.y) + display_at(pixel - step) * part.x + display_at(pixel + step) * part.y;
}
