// Strong small sources of a picture of the environment, which are taken out of it where it is blurred.

struct EnvironmentSun {
    // Where it is, and the cosine of the angle that holds it.
    direction: vec4f,
    // The radiance of its surroundings; w is 0.
    surroundings: vec4f,
}

fn sun_cut(sun: EnvironmentSun, direction: vec3f, radiance: vec3f) -> vec3f {
    let is_within = dot(sun.direction.xyz, direction) > sun.direction.w;
    return select(radiance, min(radiance, sun.surroundings.rgb), is_within);
}

// What the lobe of GGX has of a disc of light, divided by what it has of a point in its middle. `n_dot_h_squared` is that of the middle, and
// `spread` the square of half the disc's half angle, by which half vectors go. On the plane of tangents the lobe is an even sphere seen from its
// pole, and a disc is a cap of that sphere, so that this is exact there.
fn disc_share(alpha: f32, n_dot_h_squared: f32, spread: f32) -> f32 {
    let a2 = max(alpha * alpha, 1e-8);
    let tangent_squared = max(1.0 - n_dot_h_squared, 0.0) / max(n_dot_h_squared, 1e-4);
    let height = a2 + tangent_squared;
    let x = height - spread;
    let root = sqrt(x * x + 4.0 * spread * a2);
    let outside = 2.0 * height * height / (root * (root + max(x, 0.0)));
    let inside = (root - min(x, 0.0)) * height * height / (2.0 * max(spread, 1e-12) * a2 * root);
    return select(outside, inside, x < 0.0);
}
