//! effect copy
//! reads: radiance
// What a pass costs that does nothing: it reads every pixel once, and writes it.

@fragment
fn fs_copy(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return radiance_at(vec2i(position.xy));
}
