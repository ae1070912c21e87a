//! effect blur
//! reads: radiance
//! passes: fs_along_x -> rows, fs_along_y

// A Gaussian blur of any radius, rows first and then columns. Texels are taken in pairs by one filtered lookup between
// them (Rákos 2010, "Efficient Gaussian blur with linear sampling").

struct Blur {
    /// The standard deviation of the Gaussian, pixels
    // = 4 in 0.1..32
    sigma_px: f32,
    padding_a: f32,
    /// The share of the standard deviation along rows and along columns; 0 for columns blurs horizontally alone, share
    // = 1, 1 in 0..1
    direction: vec2f,
}

@group(2) @binding(0) var<uniform> blur: Blur;

// The standard deviation along one direction; of a tenth of a pixel it leaves the picture as it is.
fn sigma_along(share: f32) -> f32 {
    return max(blur.sigma_px * share, 0.1);
}

fn weight(distance_px: f32, sigma_px: f32) -> f32 {
    let of_sigma = distance_px / sigma_px;
    return exp(-0.5 * of_sigma * of_sigma);
}

fn sampled(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    return textureSampleLevel(image, linear_clamp, uv, 0.0);
}

// Of the texels 2i + 1 and 2i + 2 to one side: their weight, and where between them a lookup mixes them by it.
fn pair(i: i32, sigma_px: f32) -> vec2f {
    let near = f32(2 * i + 1);
    let weights = vec2f(weight(near, sigma_px), weight(near + 1.0, sigma_px));
    let sum = weights.x + weights.y;
    return vec2f(sum, near + weights.y / max(sum, 1e-20));
}

// So many pairs reach to 3 standard deviations.
fn pairs(sigma_px: f32) -> i32 {
    return i32(ceil(1.5 * sigma_px));
}

@fragment
fn fs_along_x(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = uv_at(position.xy);
    let sigma_px = sigma_along(blur.direction.x);
    let count = pairs(sigma_px);
    var sum = sampled(radiance, uv);
    var weights = 1.0;
    for (var i = 0; i < count; i++) {
        let found = pair(i, sigma_px);
        let step = vec2f(found.y * drawn.inverse_size_px.x, 0.0);
        sum += (sampled(radiance, uv - step) + sampled(radiance, uv + step)) * found.x;
        weights += 2.0 * found.x;
    }
    return sum / weights;
}

@fragment
fn fs_along_y(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = uv_at(position.xy);
    let sigma_px = sigma_along(blur.direction.y);
    let count = pairs(sigma_px);
    var sum = sampled(rows, uv);
    var weights = 1.0;
    for (var i = 0; i < count; i++) {
        let found = pair(i, sigma_px);
        let step = vec2f(0.0, found.y * drawn.inverse_size_px.y);
        sum += (sampled(rows, uv - step) + sampled(rows, uv + step)) * found.x;
        weights += 2.0 * found.x;
    }
    return sum / weights;
}
