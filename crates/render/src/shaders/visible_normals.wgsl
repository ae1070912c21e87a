// Normals of a rough mirror's facets that the eye sees, in the space of tangents and normal.
// Source: GGX, Heitz 2018, "Sampling the GGX Distribution of Visible Normals", by the caps of Dupuy & Benyoub 2023,
// "Sampling Visible GGX Normals with Spherical Caps".

import package::shaders::brdf::PI;

// One of them; `noise` is two numbers from 0 up to 1.
fn visible_normal(to_eye: vec3f, alpha: f32, noise: vec2f) -> vec3f {
    let stretched = normalize(vec3f(alpha * to_eye.xy, to_eye.z));
    let turn = 2.0 * PI * noise.x;
    let height = 1.0 - noise.y * (1.0 + stretched.z);
    let across = sqrt(clamp(1.0 - height * height, 0.0, 1.0));
    let cap = vec3f(across * cos(turn), across * sin(turn), height) + stretched;
    return normalize(vec3f(alpha * cap.xy, max(cap.z, 1e-6)));
}

// How likely by solid angle the direction is in which it reflects the line of sight; `a2` is the square of alpha, above 0.
fn reflected_likelihood(normal: vec3f, to_eye: vec3f, a2: f32) -> f32 {
    let lobe = normal.z * normal.z * (a2 - 1.0) + 1.0;
    let masking = to_eye.z + sqrt(a2 + (1.0 - a2) * to_eye.z * to_eye.z);
    return a2 / (2.0 * PI * max(lobe * lobe * masking, 1e-20));
}
