//! effect pixelate
//! reads: display

// Squares of one colour each. Shows `reads: display`: the finished picture, in which `display_at` finds any pixel, and a
// setting without a struct, which is called like its variable.

/// The side of a square, px
// = 8 in 1..256
@group(2) @binding(0) var<uniform> side_px: u32;

@fragment
fn fs_pixelate(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = vec2i(vec2u(position.xy) / side_px * side_px);
    // The mean of 16 places is near enough to that of all.
    var sum = vec4f(0.0);
    for (var i = 0; i < 16; i++) {
        sum += display_at(first + (vec2i(i & 3, i >> 2u) * 2 + 1) * i32(side_px) / 8);
    }
    return sum / 16.0;
}
