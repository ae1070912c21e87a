//! effect dof
//! reads: radiance, depth
//! passes: fs_far_2 -> far_2 1/2, fs_far_4 -> far_4 1/4, fs_far_8 -> far_8 1/8, fs_far_disks_2 -> far_disks_2 1/2, fs_far_disks_4 -> far_disks_4 1/4, fs_far_disks_8 -> far_disks_8 1/8, fs_near_2 -> near_2 1/2, fs_near_4 -> near_4 1/4, fs_near_8 -> near_8 1/8, fs_near_disks_2 -> near_disks_2 1/2, fs_near_disks_4 -> near_disks_4 1/4, fs_near_disks_8 -> near_disks_8 1/8, fs_tile -> tile 1/16, fs_reach -> reach 1/16, fs_near_light -> near_light 1/2, fs_near_beyond -> near_beyond 1/2, fs_near_share -> near_share 1/2, fs_behind -> behind 1/2, fs_front_near -> front_near 1/2, fs_front -> front 1/2, fs_dof

// Depth of field: what is not in focus is a disk, as wide as a thin lens makes it, that has the light of its pixel and
// no more: each disk is gathered at half the size with a weight of one divided by its own area. A place shows disks that
// are nearer than its own surface over the mean of those as near as that, and those over what lies farther. What is
// gathered far from a pixel is the mean of as many texels as one lookup stands for, so that no lamp falls between two of them.
// Sources: Potmesil & Chakravarty 1981, "A Lens and Aperture Camera Model for Synthetic Image Generation"; Jimenez 2014,
// "Next Generation Post Processing in Call of Duty: Advanced Warfare" (gathering by the size of what scatters, tiles).
// Parallel rays have no lens, and stay sharp.

struct Dof {
    /// How far away is what is sharp; 0: what is in the middle of the picture, m
    // = 0 in 0..
    focus_m: f32,
    /// The focal length divided by the width of the aperture: the less the more blur, f-number
    // = 2.8 in 0.01..1024
    f_stop: f32,
    /// How high the film or sensor is; with the camera's angle of view it says the focal length, mm
    // = 24 in 1..10000
    sensor_height_mm: f32,
    /// The widest disk's radius, px
    // = 48 in 1..64
    radius_max_px: f32,
    /// How many places of a disk are looked up.
    // = 48 in 8..256
    taps: u32,
    padding_a: f32,
    padding_b: f32,
    padding_c: f32,
}

@group(2) @binding(0) var<uniform> dof: Dof;

const HALF_GOLDEN_ANGLE: f32 = 1.19998161;
const PI: f32 = 3.14159265;
// Pixels of half size along a tile.
const TILE: i32 = 8;
// So far from a tile others are that may reach it: the widest disk at half size, of tiles.
const TILES: i32 = 4;
// By how much the pixels of half the size and the mean of nine of them widen the square of a disk's radius.
const SMOOTHED: f32 = 1.5;
// From how many texels of a side on a lookup has the mean of four, and that of sixteen.
const SIDES: vec2f = vec2f(1.5, 3.0);
// By which share of it lookups that stand for many texels widen that of a disk of more than four of them.
const WIDENED: f32 = 0.07;
// So far beyond a disk the means of texels carry its light.
const SOFT: f32 = 4.0;
// So bright counts what is black, for the radius of the light of a texel.
const DARKEST: f32 = 2.5e-4;
// What has no surface counts as so far away.
const FARTHEST_M: f32 = 1e12;

fn distance_m_at(pixel: vec2i) -> f32 {
    return clamp(distance_at(clamp(pixel, vec2i(0), vec2i(view.size_px) - 1)), 1e-3, FARTHEST_M);
}

// The radius of the disk of a pixel, in pixels; below 0 in front of what is sharp.
fn radius_at(pixel: vec2i) -> f32 {
    let sensor_m = 0.001 * dof.sensor_height_mm;
    let focal_m = 0.5 * sensor_m / view.view_from_ndc_scale.y;
    let middle_m = distance_m_at(vec2i(0.5 * view.size_px));
    // What is nearer than the focal length cannot be brought into focus.
    let focus_m = max(select(middle_m, dof.focus_m, dof.focus_m > 0.0), 1.01 * focal_m);
    let aperture_m = focal_m / dof.f_stop;
    let diameter_m = aperture_m * focal_m * (1.0 / focus_m - 1.0 / distance_m_at(pixel)) / (1.0 - focal_m / focus_m);
    let radius_px = 0.5 * diameter_m / sensor_m * view.size_px.y * (1.0 - view.orthographic);
    return clamp(radius_px, -dof.radius_max_px, dof.radius_max_px);
}

// 1 for a pixel of the layer before what is sharp, or else of the other one; 0 for what is not in the picture.
fn share_of(pixel: vec2i, radius_px: f32, is_near: bool) -> f32 {
    return select(0.0, 1.0, all(pixel < vec2i(view.size_px)) & ((radius_px < 0.0) == is_near));
}

// Radiance of a layer at half the size: all that there is of it, so that no light is lost and none is added.
fn layer_at(position: vec2f, is_near: bool) -> vec4f {
    let first = 2 * vec2i(position);
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let pixel = first + vec2i(i & 1, i >> 1u);
        sum += 0.25 * share_of(pixel, radius_at(pixel), is_near) * radiance_at(pixel);
    }
    return sum;
}

// The disks of a layer at half the size: how bright they are, that times their radius in pixels of that size, how much of
// the texel is of the layer, and that times their radius. Light goes by the radius of what is bright, because that spreads
// most of it; what a texel covers goes by the mean.
fn disks_at(position: vec2f, is_near: bool) -> vec4f {
    let first = 2 * vec2i(position);
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let pixel = first + vec2i(i & 1, i >> 1u);
        let radius_px = radius_at(pixel);
        let color = radiance_at(pixel);
        let brightness = clamp(max(max(color.r, color.g), color.b), 0.0, 1000.0) + DARKEST;
        let radius = 0.5 * abs(radius_px);
        sum += 0.25 * share_of(pixel, radius_px, is_near) * vec4f(brightness, brightness * radius, 1.0, radius);
    }
    return sum;
}

// A texture at half its size: of 4 by 4 texels, the middle ones three times as much (Burt & Adelson 1983), so that light
// stays where it is.
fn halved(image: texture_2d<f32>, position: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(image));
    let middle = 2.0 * position;
    return 0.25 * (textureSampleLevel(image, linear_clamp, (middle - 0.75) / size, 0.0)
        + textureSampleLevel(image, linear_clamp, (middle + 0.75) / size, 0.0)
        + textureSampleLevel(image, linear_clamp, (middle + vec2f(0.75, -0.75)) / size, 0.0)
        + textureSampleLevel(image, linear_clamp, (middle + vec2f(-0.75, 0.75)) / size, 0.0));
}

@fragment
fn fs_far_2(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return layer_at(position.xy, false);
}

@fragment
fn fs_far_4(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(far_2, position.xy);
}

@fragment
fn fs_far_8(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(far_4, position.xy);
}

@fragment
fn fs_far_disks_2(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return disks_at(position.xy, false);
}

@fragment
fn fs_far_disks_4(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(far_disks_2, position.xy);
}

@fragment
fn fs_far_disks_8(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(far_disks_4, position.xy);
}

@fragment
fn fs_near_2(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return layer_at(position.xy, true);
}

@fragment
fn fs_near_4(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(near_2, position.xy);
}

@fragment
fn fs_near_8(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(near_4, position.xy);
}

@fragment
fn fs_near_disks_2(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return disks_at(position.xy, true);
}

@fragment
fn fs_near_disks_4(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(near_disks_2, position.xy);
}

@fragment
fn fs_near_disks_8(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return halved(near_disks_4, position.xy);
}

fn inside(pixel: vec2i, image: texture_2d<f32>) -> vec2i {
    return clamp(pixel, vec2i(0), vec2i(textureDimensions(image)) - 1);
}

// What is gathered of a place: light of the layer, how much of the place is of it, and the radii by which both spread, in
// pixels of half size.
struct Place {
    light: vec4f,
    share: f32,
    light_radius: f32,
    radius: f32,
}

fn place_of(light: vec4f, disks: vec4f) -> Place {
    let radii = disks.yw / max(disks.xz, vec2f(1e-6));
    return Place(light, disks.z, radii.x, radii.y);
}

// The widest disk before what is sharp, of a tile, and the smallest one behind it.
@fragment
fn fs_tile(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = TILE * vec2i(position.xy);
    var widest = 0.0;
    var smallest = 1000.0;
    for (var y = 0; y < TILE; y++) {
        for (var x = 0; x < TILE; x++) {
            let texel = inside(first + vec2i(x, y), near_disks_2);
            let near = place_of(vec4f(0.0), textureLoad(near_disks_2, texel, 0));
            widest = max(widest, max(near.light_radius, near.radius));
            let far = place_of(vec4f(0.0), textureLoad(far_disks_2, texel, 0));
            smallest = min(smallest, select(1000.0, min(far.light_radius, far.radius), far.share > 0.0));
        }
    }
    return vec4f(widest, smallest, 0.0, 1.0);
}

// The widest such disk that reaches a tile, and the smallest one behind within the reach of any.
@fragment
fn fs_reach(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2i(position.xy);
    var widest = 0.0;
    var smallest = 1000.0;
    for (var y = -TILES; y <= TILES; y++) {
        for (var x = -TILES; x <= TILES; x++) {
            let found = textureLoad(tile, inside(here + vec2i(x, y), tile), 0);
            let between = length(max(vec2f(abs(vec2i(x, y))) - 1.0, vec2f(0.0)) * f32(TILE));
            widest = max(widest, select(0.0, found.r, found.r + SOFT > between));
            smallest = min(smallest, select(1000.0, found.g, found.g + SOFT > between));
        }
    }
    return vec4f(widest, smallest, 0.0, 1.0);
}

// The square of the radius to gather of a disk, so that it is as wide as it shall be after the mean of texels that follows.
fn gathered(radius: f32) -> f32 {
    let square = radius * radius;
    return max(square - SMOOTHED - WIDENED * max(square - 16.0, 0.0), 1.0);
}

// How much of a blurred picture is mixed with the sharp one. The least blur at half the size is wider than a small disk;
// so much of it is as wide in the mean. What is less blurred than a pixel is wide stays as it is.
fn blurred(radius: f32) -> f32 {
    return clamp((radius * radius - 0.0625) / (SMOOTHED + 1.0), 0.0, 1.0);
}

// How much of a difference in radius is one in distance, from 0 to 1.
fn apart(difference: vec2f, radius: f32) -> vec2f {
    return clamp(difference / (0.1 + 0.08 * radius) - 0.5, vec2f(0.0), vec2f(1.0));
}

// The radius of the surface of a texel: half way to that of the farthest beside it, because of a lamp or an edge half is
// before what it covers and half is a surface of its own. With it the least share of any of them.
fn own_of(disks: texture_2d<f32>, pixel: vec2i, is_near: bool) -> Place {
    let own = place_of(vec4f(0.0), textureLoad(disks, pixel, 0));
    var least = own.share;
    var farthest = own.radius;
    for (var i = 0; i < 4; i++) {
        let beside = inside(pixel + vec2i(2 * (i & 1) - 1, (i & 2) - 1), disks);
        let other = place_of(vec4f(0.0), textureLoad(disks, beside, 0));
        let farther = select(max(farthest, other.radius), min(farthest, other.radius), is_near);
        farthest = select(farthest, farther, (own.share > 0.0) & (other.share > 0.0));
        least = min(least, other.share);
    }
    return Place(vec4f(least), own.share, own.light_radius, 0.5 * (own.radius + farthest));
}

// Whether a texel and what is beside it are in front of what is sharp. There it is a surface of its own, before which only
// nearer ones are; elsewhere all that is in front is before what is shown.
fn is_within(near: Place) -> bool {
    return near.light.x > 0.5;
}

// A lookup of a disk: it stands for half a ring of places.
struct Tap {
    place: vec2f,
    // The squares of the radii of the ring.
    inner: f32,
    outer: f32,
}

// No loop whose length differs from pixel to pixel stands within a branch, because Mesa's software adapter crashes there:
// none is as long as 0.
// The lookups of a disk about a place, in pixels of half size: two on each ring, across from each other, so that the disk
// stays where it is; no more than it has texels. All places have the same ones, so that each disk is met by as many. With
// `is_even` each stands for as many texels as the others; else they are denser towards the middle, because smaller disks
// may be there.
struct Taps {
    middle: vec2f,
    radius: f32,
    is_even: bool,
    count: u32,
    // From which lookup on they stand for so many texels that they look up the mean of four, and that of sixteen.
    first_4: u32,
    first_8: u32,
}

fn taps_of(middle: vec2f, radius: f32, is_even: bool, is_wanted: bool) -> Taps {
    let square = radius * radius;
    let most = 2u * min((dof.taps + 1u) / 2u, u32(4.0 + 1.5 * square));
    let count = select(0u, most, is_wanted);
    // The share of the lookups that stand for fewer texels than the square of a side, by the derivative of what `tap_at` has.
    let shares = SIDES * SIDES * f32(count) / (PI * square);
    let even = step(vec2f(1.0), shares);
    let uneven = min(shares * shares / 2.25, vec2f(1.0));
    let first = vec2u(select(uneven, even, is_even) * f32(count));
    return Taps(middle, radius, is_even, count, first.x, max(first.x, first.y));
}

// One of them, turned for every sample of a still.
fn tap_at(taps: Taps, i: u32) -> Tap {
    let ring = f32(i / 2u);
    let shares = 2.0 * vec2f(ring, ring + 1.0) / f32(taps.count);
    // The squares of radii that go with the square root, or with the power of 3/4, of the count.
    let squares = taps.radius * taps.radius * select(shares * sqrt(shares), shares, taps.is_even);
    let angle = ring * HALF_GOLDEN_ANGLE + PI * (f32(i & 1u) + fract(0.618034 * f32(view.sample_index)));
    let place = taps.middle + sqrt(0.5 * (squares.x + squares.y)) * vec2f(cos(angle), sin(angle));
    // What would lie outside of the picture is mirrored by its edges, as is the light that goes there.
    let edge = 0.5 * view.size_px;
    return Tap(edge - abs(edge - abs(place)), squares.x, squares.y);
}

// The share of a disk that falls onto one of two halves of a ring around its middle.
fn ring_share(tap: Tap, radius: f32) -> f32 {
    let square = gathered(radius);
    return 0.5 * (min(tap.outer, square) - min(tap.inner, square)) / square;
}

// What a lookup finds in a layer at 1/2, 1/4 or 1/8 of the size, as `scale` says.
fn place_at(layer: texture_2d<f32>, disks: texture_2d<f32>, tap: Tap, scale: f32) -> Place {
    return place_of(sampled(layer, scale * tap.place), sampled(disks, scale * tap.place));
}

// The mean of disks as near as a surface, and what lies farther where they leave something.
struct Back {
    light: vec4f,
    covered: f32,
    farther: vec4f,
    weight: f32,
}

// What lookups between two counts find in a layer, behind a surface; `side` is -1 in front of what is sharp, where larger
// disks are nearer.
fn added_behind(
    before: Back,
    layer: texture_2d<f32>,
    disks: texture_2d<f32>,
    scale: f32,
    taps: Taps,
    between: vec2u,
    own: vec2f,
) -> Back {
    var back = before;
    let radius = max(own.x, 0.0);
    for (var i = between.x; i < between.y; i++) {
        let tap = tap_at(taps, i);
        let other = place_at(layer, disks, tap, scale);
        let beyond = own.y * (vec2f(other.light_radius, other.radius) - own.x);
        let is_farther = apart(beyond, radius);
        let is_same = (1.0 - is_farther) * (1.0 - apart(-beyond, radius));
        back.light += other.light * (ring_share(tap, other.light_radius) * is_same.x);
        back.covered += other.share * (ring_share(tap, other.radius) * is_same.y);
        back.farther += other.light * is_farther.x;
        back.weight += other.share * is_farther.y;
    }
    return back;
}

// A surface in front of what is sharp as blurred as it is, and what lies behind it in its layer. A pass has room for the
// textures of one layer: three hold what `fs_behind` needs of this one.
fn near_back(position: vec2f, pixel: vec2i) -> Back {
    let near = own_of(near_disks_2, pixel, true);
    let own = vec2f(near.radius, -1.0);
    let taps = taps_of(position, sqrt(gathered(near.radius)), true, is_within(near));
    var back = Back(vec4f(0.0), 0.0, vec4f(0.0), 0.0);
    back = added_behind(back, near_2, near_disks_2, 1.0, taps, vec2u(0u, taps.first_4), own);
    back = added_behind(back, near_4, near_disks_4, 0.5, taps, vec2u(taps.first_4, taps.first_8), own);
    return added_behind(back, near_8, near_disks_8, 0.25, taps, vec2u(taps.first_8, taps.count), own);
}

// The light of such a surface; elsewhere what there is of the layer.
@fragment
fn fs_near_light(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let back = near_back(position.xy, pixel);
    let light = select(textureLoad(near_2, pixel, 0), back.light, is_within(own_of(near_disks_2, pixel, true)));
    return vec4f(half_float_clamped(light.rgb), light.a);
}

// The mean of what lies behind it.
@fragment
fn fs_near_beyond(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let back = near_back(position.xy, vec2i(position.xy));
    let mean = back.farther / max(back.weight, 1e-3);
    return vec4f(half_float_clamped(mean.rgb), mean.a);
}

// How much it covers, and how much that is the mean of.
@fragment
fn fs_near_share(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let back = near_back(position.xy, vec2i(position.xy));
    return vec4f(back.covered, back.weight, 0.0, 1.0);
}

// A surface as blurred as it is, and where it leaves something or is left out, what lies behind it.
@fragment
fn fs_behind(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let near = own_of(near_disks_2, pixel, true);
    let far = own_of(far_disks_2, pixel, false);
    let shows_far = !is_within(near);
    let in_front = textureLoad(near_light, pixel, 0);
    let shares = textureLoad(near_share, pixel, 0);
    let beyond = textureLoad(near_beyond, pixel, 0) * max(shares.y, 1e-3);
    var back = Back(select(in_front, vec4f(0.0), shows_far), shares.x, beyond, shares.y);
    // All of what is far lies behind what is in front.
    let own = vec2f(select(-1000.0, far.radius, shows_far & (far.share > 0.0)), 1.0);
    // Something sharp, too, knows what is around it, because pixels between are interpolated.
    let radius = max(sqrt(gathered(select(near.radius, far.radius, own.x >= 0.0))), 1.5);
    let taps = taps_of(position.xy, radius, true, back.covered < 0.98);
    back = added_behind(back, far_2, far_disks_2, 1.0, taps, vec2u(0u, taps.first_4), own);
    back = added_behind(back, far_4, far_disks_4, 0.5, taps, vec2u(taps.first_4, taps.first_8), own);
    back = added_behind(back, far_8, far_disks_8, 0.25, taps, vec2u(taps.first_8, taps.count), own);
    let left = max(1.0 - back.covered, 0.0);
    if back.weight > 1e-3 {
        let light = back.light / max(back.covered, 1.0) + back.farther * (left / back.weight);
        return vec4f(half_float_clamped(light.rgb), light.a);
    }
    let here = (in_front + textureLoad(far_2, pixel, 0)) / max(near.share + far.share, 1e-3);
    let light = select(here, back.light / max(back.covered, 1e-4), back.covered > 1e-3);
    return vec4f(half_float_clamped(light.rgb), light.a);
}

// Light before a surface, and how much that covers of it.
struct Cover {
    light: vec3f,
    covered: f32,
}

// One before the other.
fn over(first: Cover, second: Cover) -> Cover {
    let before = min(first.covered, 1.0);
    let light = first.light / max(first.covered, 1.0);
    let after = min(second.covered, 1.0);
    return Cover(light + second.light / max(second.covered, 1.0) * (1.0 - before), before + after * (1.0 - before));
}

// What lookups between two counts find in a layer, before a surface; `own` is as in `added_behind`.
fn added_before(
    before: Cover,
    layer: texture_2d<f32>,
    disks: texture_2d<f32>,
    scale: f32,
    taps: Taps,
    between: vec2u,
    own: vec2f,
) -> Cover {
    var cover = before;
    for (var i = between.x; i < between.y; i++) {
        let tap = tap_at(taps, i);
        let other = place_at(layer, disks, tap, scale);
        let is_nearer = apart(own.y * (own.x - vec2f(other.light_radius, other.radius)), max(own.x, 0.0));
        let weight = ring_share(tap, other.light_radius) * blurred(other.light_radius) * is_nearer.x;
        cover.light += other.light.rgb * weight;
        cover.covered += other.share * ring_share(tap, other.radius) * blurred(other.radius) * is_nearer.y;
    }
    return cover;
}

// What of the layer in front of what is sharp lies before the surface of a pixel, and how much it covers.
@fragment
fn fs_front_near(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let reached = textureLoad(reach, inside(pixel / TILE, reach), 0);
    let near = own_of(near_disks_2, pixel, true);
    // Before a surface that is in front itself, only what is nearer.
    let own = vec2f(select(-1000.0, near.radius, is_within(near)), -1.0);
    let taps = taps_of(position.xy, max(reached.r, 1.0), false, reached.r >= 0.25);
    var front = Cover(vec3f(0.0), 0.0);
    front = added_before(front, near_2, near_disks_2, 1.0, taps, vec2u(0u, taps.first_4), own);
    front = added_before(front, near_4, near_disks_4, 0.5, taps, vec2u(taps.first_4, taps.first_8), own);
    front = added_before(front, near_8, near_disks_8, 0.25, taps, vec2u(taps.first_8, taps.count), own);
    return vec4f(half_float_clamped(front.light), front.covered);
}

// The same of both layers: behind what is sharp, too, something may be in front of something else.
@fragment
fn fs_front(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let reached = textureLoad(reach, inside(pixel / TILE, reach), 0);
    let near = own_of(near_disks_2, pixel, true);
    let far = own_of(far_disks_2, pixel, false);
    let is_before = apart(vec2f(far.radius - reached.g), far.radius).x > 0.0;
    let own = vec2f(far.radius, 1.0);
    let is_wanted = is_before & (far.share > 0.0) & !is_within(near);
    let taps = taps_of(position.xy, sqrt(gathered(far.radius)), false, is_wanted);
    var nearer = Cover(vec3f(0.0), 0.0);
    nearer = added_before(nearer, far_2, far_disks_2, 1.0, taps, vec2u(0u, taps.first_4), own);
    nearer = added_before(nearer, far_4, far_disks_4, 0.5, taps, vec2u(taps.first_4, taps.first_8), own);
    nearer = added_before(nearer, far_8, far_disks_8, 0.25, taps, vec2u(taps.first_8, taps.count), own);
    let first = textureLoad(front_near, pixel, 0);
    let front = over(Cover(first.rgb, first.a), nearer);
    return vec4f(half_float_clamped(front.light), front.covered);
}

fn sampled(image: texture_2d<f32>, place: vec2f) -> vec4f {
    return textureSampleLevel(image, linear_clamp, place / vec2f(textureDimensions(image)), 0.0);
}

// The mean of nine texels, by four lookups, which smooths what is left between lookups.
fn smoothed(image: texture_2d<f32>, position: vec2f) -> vec4f {
    let place = 0.5 * position;
    return 0.25 * (sampled(image, place - 0.5) + sampled(image, place + 0.5)
        + sampled(image, place + vec2f(0.5, -0.5)) + sampled(image, place + vec2f(-0.5, 0.5)));
}

@fragment
fn fs_dof(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    let back = mix(here, smoothed(behind, position.xy), blurred(0.5 * radius_at(pixel)));
    let before = smoothed(front, position.xy);
    return vec4f(half_float_clamped(back.rgb * (1.0 - before.a) + before.rgb), back.a * (1.0 - before.a) + before.a);
}
