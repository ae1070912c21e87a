// What the passes of light in fog have in common that have one ray for four pixels.

// Pixels along a texel's side.
const SIDE: i32 = 2;

// How much a ray that ends at one distance tells of one that ends at another: a tenth of the distance farther off,
// hardly anything; but something must count.
fn likeness(distance_m: f32, other_m: f32) -> f32 {
    let unlike = abs(other_m - distance_m) / max(min(other_m, distance_m), 1e-6);
    return exp(-min(20.0 * unlike, 80.0)) + 1e-4;
}
