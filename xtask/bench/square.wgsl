//! effect square
//! reads: radiance
// A Gaussian as its definition has it: every texel of a square.

// The standard deviation, pixels
// = 4 in 0.1..32
@group(2) @binding(0) var<uniform> sigma_px: f32;

@fragment
fn fs_square(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let reach = i32(ceil(3.0 * sigma_px));
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var y = -reach; y <= reach; y++) {
        for (var x = -reach; x <= reach; x++) {
            let of_sigma = vec2f(vec2i(x, y)) / sigma_px;
            let weight = exp(-0.5 * dot(of_sigma, of_sigma));
            sum += radiance_at(vec2i(position.xy) + vec2i(x, y)) * weight;
            weights += weight;
        }
    }
    return sum / weights;
}
