// Light from everywhere: a constant plus soft boxes as spherical Gaussians a·exp(s (d·axis - 1)) (Wang et al. 2009,
// "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance"). Irradiance of a Gaussian is the fit of
// Hill (2016, "SG Series"), its reflection is the Gaussian widened by the lobe of GGX.

import package::shaders::brdf::PI;

struct Environment {
    // Constant radiance, pre-exposed.
    constant: vec3f,
    box_count: u32,
    // Axis and sharpness.
    axes: array<vec4f, 6>,
    // Radiance on the axis, pre-exposed.
    amplitudes: array<vec4f, 6>,
    // What the camera sees of the environment: radiance, pre-exposed, straight down and straight up.
    backdrop_below: vec4f,
    backdrop_above: vec4f,
}

@group(0) @binding(7) var<uniform> environment: Environment;

// The number of boxes; 0 for a direction that is none. Mesa 22's software adapter copies a shader for every draw, and
// keeps the copies, where a branch depends on uniforms alone. In a condition of two parts the other one comes first:
// the adapter gives up at the first that is no uniform, and crashes where it has met a uniform before.
fn box_count_for(direction: vec3f) -> u32 {
    return select(0u, environment.box_count, dot(direction, direction) > 0.0);
}

// What the camera sees where there is no surface, by the sine of the elevation. It is apart from the light and depends on
// no other angle, so that it stays while the camera turns around the model.
fn environment_backdrop(elevation_sin: f32) -> vec3f {
    let share = smoothstep(-1.0, 1.0, elevation_sin);
    return mix(environment.backdrop_below.rgb, environment.backdrop_above.rgb, share);
}

// Radiance averaged over the lobe of GGX about `direction`; the lobe is the Gaussian of sharpness 2 / alpha².
fn environment_reflection(direction: vec3f, roughness_alpha: f32) -> vec3f {
    let box_count = box_count_for(direction);
    // Warped from the half vector to the reflected direction at normal incidence: a quarter of 2 / alpha².
    let lobe_sharpness = 0.5 / max(roughness_alpha * roughness_alpha, 1e-6);
    var radiance = environment.constant;
    for (var i = 0u; i < box_count; i++) {
        let lobe = environment.axes[i];
        let sharpness = lobe.w * lobe_sharpness / (lobe.w + lobe_sharpness);
        // The integral over the sphere is kept: 2 pi a / s (1 - exp(-2 s)).
        let before = (1.0 - exp(-2.0 * lobe.w)) / lobe.w;
        let after = (1.0 - exp(-2.0 * sharpness)) / sharpness;
        radiance += environment.amplitudes[i].rgb * (before / after)
            * exp(sharpness * (dot(direction, lobe.xyz) - 1.0));
    }
    return radiance;
}

fn environment_irradiance(normal: vec3f) -> vec3f {
    let box_count = box_count_for(normal);
    var irradiance = environment.constant * PI;
    for (var i = 0u; i < box_count; i++) {
        let lobe = environment.axes[i];
        let mu = dot(lobe.xyz, normal);
        let c0 = 0.36;
        let c1 = 1.0 / (4.0 * c0);
        let em = exp(-lobe.w);
        let em2 = em * em;
        let r = 1.0 / lobe.w;
        let scale = 1.0 + 2.0 * em2 - r;
        let bias = (em - em2) * r - em2;
        let x = sqrt(max(1.0 - scale, 0.0));
        let x0 = c0 * mu;
        let x1 = c1 * x;
        let n = x0 + x1;
        let y = select(clamp(mu, 0.0, 1.0), n * n / max(x, 1e-6), abs(x0) <= x1);
        let integral = 2.0 * PI * (1.0 - em2) * r;
        irradiance += environment.amplitudes[i].rgb * max(scale * y + bias, 0.0) * integral;
    }
    return irradiance;
}
