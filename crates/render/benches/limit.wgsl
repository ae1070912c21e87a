// The bare loop over lights: what no way of lighting can beat that visits a pair of pixel and light at all.
// The reflectance of shaders/brdf.wgsl and the falloff of KHR_lights_punctual, with all that is the same for every
// light of a pixel taken out of the loop. There are no lists, no branches, no G-buffer.

const PI: f32 = 3.14159265359;

struct Size {
    width: f32,
    height: f32,
    light_count: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> size: Size;
// Two texels a light: position and 1 / range²; intensity times colour.
@group(0) @binding(1) var lights: texture_2d<f32>;

@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index / 2u) * 4.0 - 1.0, f32(index % 2u) * 4.0 - 1.0, 0.0, 1.0);
}

// With F = f0 + (1 - f0) m the sum over lights of E ((1 - F) albedo / pi + s F c) n.l falls into three sums that do not
// know the material's colours: of E n.l (1 - m), E n.l s, and E n.l s m.
@fragment
fn fs_lights(@builtin(position) position_px: vec4f) -> @location(0) vec4f {
    let uv = position_px.xy / vec2f(size.width, size.height);
    // A surface that is another one in every pixel.
    let position = vec3f(16.0 * uv.x - 8.0, 0.3 * sin(9.0 * uv.x) * cos(7.0 * uv.y), 9.0 * uv.y - 4.5);
    let normal = normalize(vec3f(0.4 * sin(23.0 * uv.x), 1.0, 0.4 * cos(19.0 * uv.y)));
    let to_eye = normalize(vec3f(0.0, 6.0, 8.0) - position);
    let albedo = vec3f(0.2 + 0.6 * uv.x, 0.2 + 0.6 * uv.y, 0.8 - 0.6 * uv.x);
    let f0 = mix(vec3f(0.04), albedo, uv.y);
    let roughness_perceptual = 0.25 + 0.7 * uv.x;
    let energy_compensation = 1.0 + 0.5 * f0 * roughness_perceptual;

    let roughness_alpha = roughness_perceptual * roughness_perceptual;
    let a2 = roughness_alpha * roughness_alpha;
    let one_less_a2 = 1.0 - a2;
    let n_dot_v = max(dot(normal, to_eye), 1e-4);
    let eye_term = sqrt(n_dot_v * n_dot_v * one_less_a2 + a2);
    var diffuse = vec3f(0.0);
    var specular = vec3f(0.0);
    var specular_grazing = vec3f(0.0);
    // The count is mixed with what varies, because drivers compile a shader anew for each value of a uniform in a
    // condition.
    let end = select(0u, 2u * size.light_count, position_px.x >= 0.0);
    for (var at = 0u; at < end; at += 2u) {
        let place = textureLoad(lights, vec2u(at, 0u), 0);
        let color = textureLoad(lights, vec2u(at + 1u, 0u), 0).rgb;
        let towards = place.xyz - position;
        let distance_squared = dot(towards, towards);
        let inverse_distance = inverseSqrt(distance_squared);
        let ratio_squared = distance_squared * place.w;
        let window = max(1.0 - ratio_squared * ratio_squared, 0.0);
        let n_dot_l = max(dot(normal, towards) * inverse_distance, 0.0);
        let irradiance = window * inverse_distance * inverse_distance * n_dot_l;
        let half_length_squared = max(2.0 + 2.0 * dot(to_eye, towards) * inverse_distance, 1e-8);
        let inverse_half_length = inverseSqrt(half_length_squared);
        let n_dot_h = min((n_dot_l + n_dot_v) * inverse_half_length, 1.0);
        let one_less_v_dot_h = 1.0 - 0.5 * half_length_squared * inverse_half_length;
        let d = 1.0 - n_dot_h * n_dot_h * one_less_a2;
        let light_term = n_dot_v * sqrt(n_dot_l * n_dot_l * one_less_a2 + a2);
        // D and V without a² / 2 pi.
        let lobe = irradiance / (d * d * (light_term + n_dot_l * eye_term));
        let m2 = one_less_v_dot_h * one_less_v_dot_h;
        let m = m2 * m2 * one_less_v_dot_h;
        diffuse += color * (irradiance - irradiance * m);
        specular += color * lobe;
        specular_grazing += color * (lobe * m);
    }
    let lobes = f0 * specular + (1.0 - f0) * specular_grazing;
    let radiance = (1.0 - f0) * albedo * (1.0 / PI) * diffuse + 0.5 * a2 / PI * energy_compensation * lobes;
    return vec4f(radiance, 1.0);
}
