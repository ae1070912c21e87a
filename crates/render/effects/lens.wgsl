//! effect lens
//! reads: radiance
//! passes: fs_lens

// The faults of a lens: radial distortion, chromatic aberration and vignetting. Depth and normals are not distorted, so
// effects that read them come before this one.
// Source: Brown 1966, "Decentering Distortion of Lenses" (the radial part: a point that a perfect lens draws at the
// distance r from the middle is drawn at r (1 + k1 r² + k2 r⁴)), with the corners at r = 1. The k1 and k2 of OpenCV,
// whose r is the tangent of the angle to the axis, are these divided by the second and fourth power of the tangent at the corners.

struct Lens {
    /// Radial distortion: below 0 barrel, above 0 pincushion, r at the corners
    // = -0.1 in -0.2..1
    k1: f32,
    /// Radial distortion of higher order, strongest near the corners, r at the corners
    // = 0 in -0.05..1
    k2: f32,
    /// The share of the zoom that just fills the frame, share
    // = 1 in 0..1
    fill: f32,
    /// Chromatic aberration: how much farther out red is drawn than blue, share
    // = 0.004 in -0.1..0.1
    chromatic: f32,
    /// The number of samples of the spectrum.
    // = 9 in 3..64
    taps: u32,
    /// Vignetting: 1 is the fourth power of the cosine of the angle to the axis, power
    // = 0 in 0..8
    vignette: f32,
    padding_a: f32,
    padding_b: f32,
}

@group(2) @binding(0) var<uniform> lens: Lens;

// So many steps of Newton's method find where a point was before the distortion, within 0.001 px.
const STEPS: u32 = 6u;

// How far out a point is drawn, of how far it would be; `r2` is the square of that distance.
fn stretch(r2: f32) -> f32 {
    return 1.0 + (lens.k1 + lens.k2 * r2) * r2;
}

// Where the point was that is drawn at `distorted`, of its place there. Distances grow in this range of k1 and k2.
fn undistorted(distorted: f32) -> f32 {
    var r = distorted;
    for (var i = 0u; i < STEPS; i++) {
        let r2 = r * r;
        let slope = max(1.0 + (3.0 * lens.k1 + 5.0 * lens.k2 * r2) * r2, 0.05);
        r = clamp(r - (r * stretch(r2) - distorted) / slope, 0.0, 2.0);
    }
    return r;
}

// By what places are multiplied so that all of the picture's border comes from inside the frame, and some from its edge.
fn zoom(half_size: vec2f) -> f32 {
    let nearest = min(half_size.x, half_size.y) * min(half_size.x, half_size.y);
    // The least stretch of the border, whose squares of distances are from `nearest` to 1.
    let turn = clamp(-0.5 * lens.k1 / select(1.0, lens.k2, abs(lens.k2) > 1e-6), nearest, 1.0);
    let least = min(min(stretch(nearest), stretch(1.0)), stretch(turn));
    return mix(1.0, least / (1.0 + 0.5 * abs(lens.chromatic)), lens.fill);
}

@fragment
fn fs_lens(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let half_size = view.size_px / length(view.size_px);
    let drawn_at = (position.xy * view.inverse_size_px * 2.0 - 1.0) * half_size * zoom(half_size);
    let distance = length(drawn_at);
    let place = drawn_at * (undistorted(distance) / max(distance, 1e-6));
    let taps = select(1u, lens.taps, abs(lens.chromatic) > 1e-6);
    var sum = vec4f(0.0);
    var weights = vec4f(0.0);
    for (var i = 0u; i < taps; i++) {
        // From the blue end (-1) to the red one (1); each channel has its part of it, which fades to both sides.
        let color = (2.0 * f32(i) + 1.0) / f32(taps) - 1.0;
        let uv = place * (1.0 - 0.5 * lens.chromatic * color) / half_size * 0.5 + 0.5;
        let weight = max(1.0 - abs(vec3f(1.0, 0.0, -1.0) - color), vec3f(0.02));
        let found = textureSampleLevel(radiance, linear_clamp, uv, 0.0);
        let is_inside = all((uv >= vec2f(0.0)) & (uv <= vec2f(1.0)));
        sum += select(vec4f(0.0), found, is_inside) * weight.rgbg;
        weights += weight.rgbg;
    }
    // The tangent of the angle to the axis.
    let plane = place / half_size * view.view_from_ndc_scale * (1.0 - view.orthographic);
    let cos2 = 1.0 / (1.0 + dot(plane, plane));
    let color = sum / weights;
    return vec4f(color.rgb * pow(cos2, 2.0 * lens.vignette), color.a);
}
