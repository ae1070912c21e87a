// glass.distances: how far away what lies behind surfaces that light comes through is, before `glass.backs` draws the
// backs of bodies over it.
// Reads: linear_depth. Writes: glass (rgba32float): no back; the distance.
// Program: glass_distances.

@group(1) @binding(0) var linear_depth: texture_2d<f32>;

@fragment
fn fs_glass_distances(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(0.0, 0.0, 0.0, textureLoad(linear_depth, vec2i(position.xy), 0).r);
}
