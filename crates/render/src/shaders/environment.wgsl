// Light from everywhere: a constant plus soft boxes as spherical Gaussians a·exp(s (d·axis - 1)) (Wang et al. 2009,
// "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance"). Irradiance of a Gaussian is the fit of
// Hill (2016, "SG Series"), its reflection is the Gaussian widened by the lobe of GGX.

import package::shaders::brdf::PI;

// c0 of Hill's fit.
const IRRADIANCE_C0: f32 = 0.36;

// A soft box. What its integrals over a lobe or a hemisphere have in common for all pixels is computed once, by
// `environment.rs`.
struct SoftBox {
    // Axis and sharpness s.
    axis: vec4f,
    // The factors of Hill's fit that depend on s alone: scale, bias, x / (4 c0), 1 / x.
    irradiance_fit: vec4f,
    // Radiance on the axis times the Gaussian's integral over the sphere, 2 pi (1 - exp(-2 s)) / s, pre-exposed.
    power: vec3f,
    padding: f32,
}

struct Environment {
    // Constant radiance, pre-exposed.
    constant: vec3f,
    padding: f32,
    // Where there are fewer, the others have no power.
    boxes: array<SoftBox, 4>,
    // What the camera sees of the environment: radiance, pre-exposed, straight down and straight up.
    backdrop_below: vec4f,
    backdrop_above: vec4f,
}

@group(0) @binding(6) var<uniform> environment: Environment;

// What the camera sees where there is no surface, by the sine of the elevation. It is apart from the light and depends on
// no other angle, so that it stays while the camera turns around the model.
fn environment_backdrop(elevation_sin: f32) -> vec3f {
    let share = smoothstep(-1.0, 1.0, elevation_sin);
    return mix(environment.backdrop_below.rgb, environment.backdrop_above.rgb, share);
}

fn box_reflection(box: SoftBox, direction: vec3f, lobe_sharpness: f32) -> vec3f {
    let sharpness = box.axis.w * lobe_sharpness / (box.axis.w + lobe_sharpness);
    // The integral over the sphere is kept.
    let peak = sharpness / (1.0 - exp(-2.0 * sharpness));
    return box.power * (peak * exp(sharpness * (dot(direction, box.axis.xyz) - 1.0)));
}

fn box_irradiance(box: SoftBox, normal: vec3f) -> vec3f {
    let fit = box.irradiance_fit;
    let mu = dot(box.axis.xyz, normal);
    let x0 = IRRADIANCE_C0 * mu;
    let n = x0 + fit.z;
    let y = select(clamp(mu, 0.0, 1.0), n * n * fit.w, abs(x0) <= fit.z);
    return box.power * max(fit.x * y + fit.y, 0.0);
}

// Radiance averaged over the lobe of GGX about `direction`; the lobe is the Gaussian of sharpness 2 / alpha². Boxes are
// named one by one: an index that is no constant costs software adapters a load for every pixel.
fn environment_reflection(direction: vec3f, roughness_alpha: f32) -> vec3f {
    // Warped from the half vector to the reflected direction at normal incidence: a quarter of 2 / alpha².
    let lobe_sharpness = 0.5 / max(roughness_alpha * roughness_alpha, 1e-6);
    let sum = box_reflection(environment.boxes[0], direction, lobe_sharpness)
        + box_reflection(environment.boxes[1], direction, lobe_sharpness)
        + box_reflection(environment.boxes[2], direction, lobe_sharpness)
        + box_reflection(environment.boxes[3], direction, lobe_sharpness);
    return environment.constant + sum * (0.5 / PI);
}

fn environment_irradiance(normal: vec3f) -> vec3f {
    return environment.constant * PI
        + box_irradiance(environment.boxes[0], normal)
        + box_irradiance(environment.boxes[1], normal)
        + box_irradiance(environment.boxes[2], normal)
        + box_irradiance(environment.boxes[3], normal);
}
