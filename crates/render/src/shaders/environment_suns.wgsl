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

// What the round lobe of GGX has of a disc of light, divided by what it has of a point in its middle. `n_dot_h_squared`
// is that of the middle, and `spread` the square of half the disc's half angle, by which half vectors go. On the plane
// of tangents the lobe is an even sphere seen from its pole, and a disc is a cap of that sphere, so that this is exact
// there.
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

// The same of a lobe that is stretched so far that it is even over the width of the disc: the mean of 1 / (y² +
// height)² across it, divided by that in the middle, which is `across` from the lobe's axis on the plane of tangents. A
// disc has light across it as a semicircle is high, whose mean of 1 / (w - y) is 2 / (w + sqrt(w² - spread)); this is
// the imaginary part of a derivative of that at w = across - i sqrt(height).
fn strip_share(across: f32, height: f32, spread: f32) -> f32 {
    let square = across * across + height;
    let scale = 1.0 / max(spread, 1e-12);
    let y = abs(across) * sqrt(scale);
    let s = sqrt(max(height * scale, 1e-6));
    // sqrt(w² - 1) = root.x - i root.y.
    let real = y * y - s * s - 1.0;
    let size = max(length(vec2f(real, 2.0 * y * s)), 1e-6);
    let large = sqrt(0.5 * (size + abs(real)));
    let small = y * s / large;
    let root = select(vec2f(small, large), vec2f(large, small), real > 0.0);
    let below = vec2f(y, s) + root;
    let mean = 2.0 * below / dot(below, below);
    let slope = (mean.x * root.x - mean.y * root.y) / size;
    let near = (y * y + s * s) * (y * y + s * s) * (mean.y - s * slope) / (2.0 * s * s * s);
    // Where the disc is small, what is left of differences is little; its second moment says enough there.
    let far = 1.0 + spread * (3.0 * across * across / max(square * square, 1e-24) - 0.5 / max(square, 1e-12));
    return select(near, far, square > 36.0 * spread);
}
