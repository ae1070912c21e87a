//! effect tilt_shift
//! reads: display
//! passes: fs_rows -> rows, fs_columns

// Sharp along one row and blurred above and below it, as pictures of models are. Shows the word `passes`: the first
// writes the texture `rows`, which the second finds under that name.

struct Tilt {
    /// The height of what is sharp, share of the picture from its top
    // = 0.55 in 0..1
    row: f32,
    /// How much of the height is sharp, share
    // = 0.1 in 0..1
    sharp: f32,
    /// How far the blur reaches where it is most, share of the height
    // = 0.03 in 0..0.2
    blur: f32,
}

@group(2) @binding(0) var<uniform> tilt: Tilt;

// The mean of 17 places along a line, those in the middle with more weight.
fn blurred(image: texture_2d<f32>, position: vec2f, along: vec2f) -> vec4f {
    let uv = uv_at(position);
    let off = max(abs(uv.y - tilt.row) - 0.5 * tilt.sharp, 0.0);
    let step = along * tilt.blur * 2.0 * off * drawn.size_px.y * drawn.inverse_size_px / 8.0;
    var sum = vec4f(0.0);
    for (var i = -8; i <= 8; i++) {
        sum += (9.0 - abs(f32(i))) / 81.0 * textureSampleLevel(image, linear_clamp, uv + f32(i) * step, 0.0);
    }
    return sum;
}

@fragment
fn fs_rows(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return blurred(display, position.xy, vec2f(1.0, 0.0));
}

@fragment
fn fs_columns(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return blurred(rows, position.xy, vec2f(0.0, 1.0));
}
