//! effect dof
//! reads: radiance, depth
//! passes: fs_small -> small 1/2, fs_circles -> circles 1/2, fs_tile -> tile 1/16, fs_reach -> reach 1/16, fs_far -> far 1/2, fs_near -> near 1/2, fs_dof

// Depth of field: each point out of focus becomes the circle of confusion of a thin lens. The background is gathered at
// half the size from pixels as blurred as itself, so that nothing sharp bleeds into it. The foreground spreads over
// everything behind it.
// Sources: Potmesil & Chakravarty 1981, "A Lens and Aperture Camera Model for Synthetic Image Generation"; Jimenez 2014,
// "Next Generation Post Processing in Call of Duty: Advanced Warfare" (gathering by the size of what scatters, tiles).
// Parallel rays have no lens, and stay sharp.

struct Dof {
    /// The focus distance; 0: that of the picture's middle, m
    // = 0 in 0..
    focus_m: f32,
    /// The focal length divided by the aperture diameter; a smaller number blurs more, f-number
    // = 2.8 in 0.01..1024
    f_stop: f32,
    /// The height of the sensor; with the camera's field of view it gives the focal length, mm
    // = 24 in 1..10000
    sensor_height_mm: f32,
    /// The largest radius of a circle of confusion, px
    // = 48 in 1..64
    radius_max_px: f32,
    /// The number of samples of a circle of confusion.
    // = 48 in 8..256
    taps: u32,
    padding_a: f32,
    padding_b: f32,
    padding_c: f32,
}

@group(2) @binding(0) var<uniform> dof: Dof;

const GOLDEN_ANGLE: f32 = 2.39996323;
// Pixels of half size along a tile.
const TILE: i32 = 8;
// So far from a tile others are that may reach it: the widest disk at half size, of tiles.
const TILES: i32 = 4;
// By how much the pixels of half the size and the mean of nine of them widen the square of a disk's radius.
const SMOOTHED: f32 = 2.3;
// So much brighter than the disk of a pixel is a smaller one behind what is sharp, at most.
const DENSER_MAX: f32 = 4.0;
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

// How much of a pixel a disk of half the size is made of, by the radii of four of them: of those that are about as blurred
// as the nearest of them.
fn shares_of(radii: vec4f) -> vec4f {
    let nearest = min(min(radii.x, radii.y), min(radii.z, radii.w));
    return clamp(vec4f(2.0 + 0.25 * abs(nearest) + nearest) - radii, vec4f(0.0), vec4f(1.0));
}

fn radii_from(first: vec2i) -> vec4f {
    return vec4f(
        radius_at(first),
        radius_at(first + vec2i(1, 0)),
        radius_at(first + vec2i(0, 1)),
        radius_at(first + 1),
    );
}

// The radius at half size: that of the nearest of four pixels, in pixels of that size; and how much of the texel is so
// blurred, which is as much light as its disk has.
@fragment
fn fs_circles(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let radii = radii_from(2 * vec2i(position.xy));
    let nearest = min(min(radii.x, radii.y), min(radii.z, radii.w));
    return vec4f(0.5 * nearest, dot(shares_of(radii), vec4f(0.25)), 0.0, 1.0);
}

// The mean of those of four pixels that are about as blurred as the nearest of them.
@fragment
fn fs_small(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = 2 * vec2i(position.xy);
    let shares = shares_of(radii_from(first));
    let sum = radiance_at(first) * shares.x + radiance_at(first + vec2i(1, 0)) * shares.y
        + radiance_at(first + vec2i(0, 1)) * shares.z + radiance_at(first + 1) * shares.w;
    return sum / dot(shares, vec4f(1.0));
}

fn inside(pixel: vec2i, image: texture_2d<f32>) -> vec2i {
    return clamp(pixel, vec2i(0), vec2i(textureDimensions(image)) - 1);
}

// The widest disk before what is sharp, of a tile.
@fragment
fn fs_tile(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = TILE * vec2i(position.xy);
    var widest = 0.0;
    for (var y = 0; y < TILE; y++) {
        for (var x = 0; x < TILE; x++) {
            widest = max(widest, -textureLoad(circles, inside(first + vec2i(x, y), circles), 0).r);
        }
    }
    return vec4f(widest, 0.0, 0.0, 1.0);
}

// The widest such disk that reaches a tile.
@fragment
fn fs_reach(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2i(position.xy);
    var widest = 0.0;
    for (var y = -TILES; y <= TILES; y++) {
        for (var x = -TILES; x <= TILES; x++) {
            let found = textureLoad(tile, inside(here + vec2i(x, y), tile), 0).r;
            let between = max(vec2f(abs(vec2i(x, y))) - 1.0, vec2f(0.0)) * f32(TILE);
            widest = max(widest, select(0.0, found, found > length(between)));
        }
    }
    return vec4f(widest, 0.0, 0.0, 1.0);
}

// From where a pixel begins to turn around its disk, another for every sample of a still (Jimenez 2014).
fn turn_at(position_px: vec2f) -> f32 {
    let noise = fract(52.9829189 * fract(dot(floor(position_px), vec2f(0.06711056, 0.00583715))));
    return 6.2831853 * fract(noise + 0.618034 * f32(view.sample_index));
}

// The radius to gather of a disk, so that it is as wide as it shall be after the mean of texels that follows.
fn gathered(radius: f32) -> f32 {
    return sqrt(max(radius * radius - SMOOTHED, 1.0));
}

// How much of a blurred picture is mixed with the sharp one. The least blur at half the size is wider than a small disk;
// so much of it is as wide in the mean. What is less blurred than a pixel is wide stays as it is.
fn blurred(radius: f32) -> f32 {
    return clamp((radius * radius - 0.0625) / (SMOOTHED + 1.0), 0.0, 1.0);
}

fn direction(i: u32, turn: f32) -> vec2f {
    let angle = f32(i) * GOLDEN_ANGLE + turn;
    return vec2f(cos(angle), sin(angle));
}

// What is sharp or behind it, each as blurred as it is; where something is in front, what surrounds that.
@fragment
fn fs_far(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let disk = textureLoad(circles, pixel, 0);
    let own = disk.r;
    let here = textureLoad(small, pixel, 0);
    let turn = turn_at(position.xy);
    // Something sharp, too, knows what is around it, because pixels between are interpolated.
    let radius = max(gathered(abs(own)), 1.5);
    let is_behind = own > 0.25;
    var weights = select(0.0, disk.g, is_behind);
    var sum = here * weights;
    for (var i = 0u; i < dof.taps; i++) {
        let distance = radius * sqrt((f32(i) + 0.5) / f32(dof.taps));
        let place = inside(vec2i(floor(position.xy + distance * direction(i, turn))), circles);
        let found = textureLoad(circles, place, 0);
        let other = found.r;
        // Behind: as far as its own disk reaches. In front: whatever is not in front.
        let reaches = clamp(other - distance + 1.0, 0.0, 1.0) * step(0.25, other);
        // A smaller disk leaves more light in each of its pixels; so much more that chance does not show.
        let density = clamp(pow(radius / (max(other, 0.0) + 0.5), 2.0), 1.0, DENSER_MAX);
        let weight = select(reaches * density, step(-0.25, other), own < -0.25) * found.g;
        sum += textureLoad(small, place, 0) * weight;
        weights += weight;
    }
    return select(here, sum / max(weights, 1e-4), weights > 1e-3);
}

// What is in front of what is sharp, and how much it covers.
@fragment
fn fs_near(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let widest = textureLoad(reach, inside(pixel / TILE, reach), 0).r;
    if widest < 0.25 {
        return vec4f(0.0);
    }
    let turn = turn_at(position.xy);
    let radius = max(widest, 1.0);
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var i = 0u; i < dof.taps; i++) {
        // Denser towards the middle, because disks of other sizes may be there; each stands for a ring.
        let part = (f32(i) + 0.5) / f32(dof.taps);
        let distance = radius * part;
        let place = inside(vec2i(floor(position.xy + distance * direction(i, turn))), circles);
        let found = textureLoad(circles, place, 0);
        let other = -found.r;
        let size = gathered(other);
        // What this disk leaves in a pixel: its light is spread over its area.
        let ring = 2.0 * radius * radius * part / f32(dof.taps) / (size * size);
        let weight = ring * clamp(size - distance + 0.5, 0.0, 1.0) * blurred(max(other, 0.0)) * found.g;
        sum += textureLoad(small, place, 0) * weight;
        weights += weight;
    }
    // In the middle of what is in front nothing behind it shows, whatever chance left between the places.
    let covered = min(weights, 1.0);
    return sum / max(weights, 1e-4) * covered;
}

// The mean of nine texels, by four lookups, which smooths what chance left.
fn smoothed(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    let step = 0.5 / vec2f(textureDimensions(image));
    return 0.25 * (textureSampleLevel(image, linear_clamp, uv - step, 0.0)
        + textureSampleLevel(image, linear_clamp, uv + step, 0.0)
        + textureSampleLevel(image, linear_clamp, uv + vec2f(step.x, -step.y), 0.0)
        + textureSampleLevel(image, linear_clamp, uv + vec2f(-step.x, step.y), 0.0));
}

@fragment
fn fs_dof(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let uv = uv_at(position.xy);
    let here = radiance_at(pixel);
    let behind = mix(here, smoothed(far, uv), blurred(0.5 * radius_at(pixel)));
    let front = smoothed(near, uv);
    return vec4f(half_float_clamped(behind.rgb * (1.0 - front.a) + front.rgb), behind.a * (1.0 - front.a) + front.a);
}
