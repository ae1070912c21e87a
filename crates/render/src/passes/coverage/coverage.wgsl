// coverage: begins `radiance` where no surface glows: black, and covered where there is an opaque surface.
// Reads: depth. Writes: radiance (alpha = coverage).
// Program: coverage.

@fragment
fn fs_coverage() -> @location(0) vec4f {
    return vec4f(0.0, 0.0, 0.0, 1.0);
}
