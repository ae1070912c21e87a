//! effect ascii
//! reads: display

// The picture in letters, of more ink where it is brighter. Shows whole numbers: a letter is 25 bits of one, five rows
// of five, and `u32` settings are counted and never between.

struct Letters {
    /// The colour of letters, linear Rec. 709
    // = 0.4, 1, 0.5 in 0..1
    ink: vec3f,
    /// How large a dot of a letter is, px
    // = 1 in 1..16
    dot_px: u32,
    /// How much letters have the colour of the picture instead, share
    // = 0.5 in 0..1
    colored: f32,
}

@group(2) @binding(0) var<uniform> letters: Letters;

// Nothing, and . : - + o X 0 #
const LETTERS = array(0u, 131072u, 131200u, 14336u, 145536u, 469440u, 18157905u, 15324974u, 11512810u);

@fragment
fn fs_ascii(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // A letter and a gap of one dot.
    let at = vec2u(position.xy) / letters.dot_px;
    let place = at % 6u;
    let side_px = 6u * letters.dot_px;
    let first = vec2i(vec2u(position.xy) / side_px * side_px);
    var sum = vec4f(0.0);
    for (var i = 0; i < 16; i++) {
        sum += display_at(first + (vec2i(i & 3, i >> 2u) * 2 + 1) * i32(side_px) / 8);
    }
    let mean = sum / 16.0;
    let tone = sqrt(clamp(dot(mean.rgb, vec3f(0.2126, 0.7152, 0.0722)), 0.0, 1.0));
    let bit = select(0u, (LETTERS[u32(tone * 8.99)] >> (place.y * 5u + place.x)) & 1u, all(place < vec2u(5u)));
    let hue = mean.rgb / max(max(mean.r, mean.g), max(mean.b, 1e-3));
    return vec4f(f32(bit) * mix(letters.ink, hue, letters.colored) * mean.a, mean.a);
}
