// upscale: a frame at the picture's size, from twelve texels around each pixel, along the edge that they show.
// Source: Lottes 2021, "FidelityFX Super Resolution 1.0"; see `mod.rs` for what differs. Reads: radiance. Writes: radiance
// (rgba16float), pre-exposed, with coverage.
// Program: upscale.

import package::shaders::compressed::{compressed, expanded};

struct Upscale {
    // Texels of radiance for each pixel of the picture.
    texels_per_px: vec2f,
    // From pre-exposed radiance to what the tone curve takes.
    exposure: f32,
    // Zero.
    padding: f32,
}

@group(1) @binding(0) var<uniform> upscale: Upscale;
@group(1) @binding(1) var radiance: texture_2d<f32>;

// The window of the kernel beside no edge, and how much narrower it is along one: 1/2 and 1/4 − 0.04 of the inverse square
// of its radius in texels.
const WINDOW: f32 = 0.5;
const WINDOW_EDGE: f32 = 0.21;
// A gradient of less has no direction.
const GRADIENT_MIN: f32 = 1.0 / 32768.0;

// Where to brightness rises, and how much of an edge that is: 0 to 1 along x, and the same along y.
struct Edge {
    direction: vec2f,
    sharpness: f32,
}

// What is summed over texels.
struct Sum {
    color: vec4f,
    // Of their places, in texels from the pixel.
    place: vec2f,
    weight: f32,
}

// How the kernel lies.
struct Kernel {
    // Of unit length, across the edge.
    across: vec2f,
    // How much shorter it is across it, and along it.
    scale: vec2f,
    window: f32,
}

fn color_at(texel: vec2i) -> vec4f {
    let last = vec2i(textureDimensions(radiance)) - 1;
    return compressed(textureLoad(radiance, clamp(texel, vec2i(0), last), 0), upscale.exposure);
}

// Brightness about as it is seen.
fn brightness(color: vec4f) -> f32 {
    return sqrt(max(dot(color.rgb, vec3f(0.25, 0.5, 0.25)), 0.0));
}

// How much three texels in a row are one edge: 1 where they rise evenly, 0 where the middle one is a ridge or alone.
fn evenness(before: f32, middle: f32, after: f32) -> f32 {
    let steepest = max(abs(after - middle), abs(middle - before));
    let even = clamp(abs(after - before) / max(steepest, 1e-6), 0.0, 1.0);
    return even * even;
}

// What a texel and its four neighbours say of the edge, by the texel's share.
fn edge_of(share: f32, middle: f32, left: f32, right: f32, up: f32, down: f32) -> Edge {
    let sharpness = evenness(left, middle, right) + evenness(up, middle, down);
    return Edge(vec2f(right - left, down - up) * share, sharpness * share);
}

fn added(sum: Sum, kernel: Kernel, place: vec2f, color: vec4f) -> Sum {
    let along = vec2f(-kernel.across.y, kernel.across.x);
    let turned = vec2f(dot(place, kernel.across), dot(place, along)) * kernel.scale;
    // A polynomial in the squared distance, like sin(π x) / (π x) between its first zeros, within a window.
    let squared = min(dot(turned, turned), 1.0 / kernel.window);
    let wave = 0.4 * squared - 1.0;
    let fade = kernel.window * squared - 1.0;
    let weight = (25.0 / 16.0 * wave * wave - 9.0 / 16.0) * (fade * fade);
    return Sum(sum.color + color * weight, sum.place + place * weight, sum.weight + weight);
}

@fragment
fn fs_upscale(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let place = position.xy * upscale.texels_per_px - 0.5;
    let first = vec2i(floor(place));
    let between = place - floor(place);
    // Rows from above, of 4 × 4 texels without their corners: the four around the pixel are 11, 12, 21 and 22.
    let c01 = color_at(first + vec2i(0, -1));
    let c02 = color_at(first + vec2i(1, -1));
    let c10 = color_at(first + vec2i(-1, 0));
    let c11 = color_at(first);
    let c12 = color_at(first + vec2i(1, 0));
    let c13 = color_at(first + vec2i(2, 0));
    let c20 = color_at(first + vec2i(-1, 1));
    let c21 = color_at(first + vec2i(0, 1));
    let c22 = color_at(first + vec2i(1, 1));
    let c23 = color_at(first + vec2i(2, 1));
    let c31 = color_at(first + vec2i(0, 2));
    let c32 = color_at(first + vec2i(1, 2));

    let shares = vec4f(
        (1.0 - between.x) * (1.0 - between.y),
        between.x * (1.0 - between.y),
        (1.0 - between.x) * between.y,
        between.x * between.y,
    );
    let b11 = brightness(c11);
    let b12 = brightness(c12);
    let b21 = brightness(c21);
    let b22 = brightness(c22);
    let e11 = edge_of(shares.x, b11, brightness(c10), b12, brightness(c01), b21);
    let e12 = edge_of(shares.y, b12, b11, brightness(c13), brightness(c02), b22);
    let e21 = edge_of(shares.z, b21, brightness(c20), b22, b11, brightness(c31));
    let e22 = edge_of(shares.w, b22, b21, brightness(c23), b12, brightness(c32));
    let gradient = e11.direction + e12.direction + e21.direction + e22.direction;
    let steepness = dot(gradient, gradient);
    let across = select(vec2f(1.0, 0.0), gradient * inverseSqrt(max(steepness, 1e-12)), steepness > GRADIENT_MIN);
    let half_sharpness = 0.5 * (e11.sharpness + e12.sharpness + e21.sharpness + e22.sharpness);
    let sharpness = half_sharpness * half_sharpness;
    // A diagonal's texels lie apart by √2.
    let stretch = 1.0 / max(abs(across.x), abs(across.y));
    let scale = vec2f(1.0 + (stretch - 1.0) * sharpness, 1.0 - 0.5 * sharpness);
    let kernel = Kernel(across, scale, mix(WINDOW, WINDOW_EDGE, sharpness));

    var sum = Sum(vec4f(0.0), vec2f(0.0), 0.0);
    sum = added(sum, kernel, vec2f(0.0, -1.0) - between, c01);
    sum = added(sum, kernel, vec2f(1.0, -1.0) - between, c02);
    sum = added(sum, kernel, vec2f(-1.0, 0.0) - between, c10);
    sum = added(sum, kernel, vec2f(0.0, 0.0) - between, c11);
    sum = added(sum, kernel, vec2f(1.0, 0.0) - between, c12);
    sum = added(sum, kernel, vec2f(2.0, 0.0) - between, c13);
    sum = added(sum, kernel, vec2f(-1.0, 1.0) - between, c20);
    sum = added(sum, kernel, vec2f(0.0, 1.0) - between, c21);
    sum = added(sum, kernel, vec2f(1.0, 1.0) - between, c22);
    sum = added(sum, kernel, vec2f(2.0, 1.0) - between, c23);
    sum = added(sum, kernel, vec2f(0.0, 2.0) - between, c31);
    sum = added(sum, kernel, vec2f(1.0, 2.0) - between, c32);
    let mean = sum.color / sum.weight;
    let aside = sum.place / sum.weight;
    // The mean is of a place beside the pixel: what rises evenly is taken back to the pixel by how it rises.
    let rise_x = 0.5 * ((c12 - c10) * shares.x + (c13 - c11) * shares.y + (c22 - c20) * shares.z + (c23 - c21) * shares.w);
    let rise_y = 0.5 * ((c21 - c01) * shares.x + (c22 - c02) * shares.y + (c31 - c11) * shares.z + (c32 - c12) * shares.w);
    let centred = mean - rise_x * aside.x - rise_y * aside.y;
    let least = min(min(c11, c12), min(c21, c22));
    let most = max(max(c11, c12), max(c21, c22));
    return expanded(clamp(centred, least, most), upscale.exposure);
}
