// What both layouts share: the camera, the vertices of surfaces and lights, and Blinn-Phong's reflectance.

struct Frame {
    clip_from_world: mat4x4f,
    view_from_world: mat4x4f,
    eye_world: vec4f,
    // Radiance that comes from everywhere alike.
    ambient: vec4f,
    // Specular intensity and power of everything, where a layout has no place for them.
    specular: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;

struct SurfaceVertex {
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) diffuse: vec3f,
    @location(3) emission: vec3f,
    // Intensity and power.
    @location(4) specular: vec2f,
}

// The same for all vertices of an instance.
struct LightVertex {
    // The range in metres is the fourth.
    @location(5) position_world: vec4f,
    // In candela; the fourth is 1 for the first light and 0 for all others.
    @location(6) intensity: vec4f,
}

// Blinn 1977, normalised so that at normal incidence it reflects exactly the intensity (Akenine-Möller et al. 2008).
// Radiance for one unit of irradiance on a plane across the light's direction.
fn blinn_phong(normal: vec3f, to_light: vec3f, to_eye: vec3f, diffuse: vec3f, intensity: f32, power: f32) -> vec3f {
    let n_dot_l = dot(normal, to_light);
    if n_dot_l <= 0.0 {
        return vec3f(0.0);
    }
    let pi = 3.14159265;
    let n_dot_h = max(dot(normal, normalize(to_light + to_eye)), 1e-6);
    let norm = (power + 2.0) * (power + 4.0) / (8.0 * pi * (exp2(-0.5 * power) + power));
    return ((1.0 - intensity) / pi * diffuse + intensity * norm * pow(n_dot_h, power)) * n_dot_l;
}

// The window of KHR_lights_punctual.
fn attenuation(distance_squared: f32, range_m: f32) -> f32 {
    let ratio_squared = distance_squared / (range_m * range_m);
    return clamp(1.0 - ratio_squared * ratio_squared, 0.0, 1.0) / max(distance_squared, 1e-6);
}

// A triangle that covers the picture.
fn clip_of_corner(index: u32) -> vec4f {
    return vec4f(f32(index / 2u) * 4.0 - 1.0, f32(index % 2u) * 4.0 - 1.0, 0.0, 1.0);
}
