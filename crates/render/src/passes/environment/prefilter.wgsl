// environment.prefilter: what a surface of one roughness reflects, seen along its normal, as an octahedral map.
// Source: filtered samples (Colbert & Křivánek 2007) of GGX (Walter et al. 2007), seen along the normal (Karis 2013),
// on a spiral that turns by the golden angle, see `lobe.rs`; of lobes wider than that of roughness 0.5 the sum over all
// directions.
// Reads: source (halves of the environment without suns), lobe (the samples of each level, a row each). Writes: a tile.
// Program: environment_prefilter.

import package::shaders::octahedral::direction_from_octahedral_border;

struct EnvironmentPrefilter {
    // The first texel of the tile behind its border, and one divided by its side in texels; zero.
    corner: vec4f,
    // The row of the samples, and their number; zeros.
    samples: vec4u,
    // For all directions: the square of alpha, less what the source is blurred by, and the level of the source; zeros.
    scales: vec4f,
}

@group(1) @binding(0) var source: texture_cube<f32>;
@group(1) @binding(1) var linear_clamp: sampler;
@group(1) @binding(2) var lobe: texture_2d<f32>;
@group(1) @binding(3) var<uniform> environment_prefilter: EnvironmentPrefilter;

// 1 if the samples are all directions.
override is_of_sphere: u32 = 0u;

@fragment
fn fs_environment_prefilter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let samples = environment_prefilter.samples;
    let tile = environment_prefilter.corner;
    let normal = direction_from_octahedral_border(2.0 * (position.xy - tile.xy) * tile.z - 1.0);
    let up = select(vec3f(0.0, 0.0, 1.0), vec3f(0.0, 1.0, 0.0), abs(normal.y) < 0.9);
    let tangent = normalize(cross(up, normal));
    let bitangent = cross(normal, tangent);
    let a2 = environment_prefilter.scales.x;
    var sum = vec3f(0.0);
    var weights = 0.0;
    // How long the loop is depends on more than uniforms, see docs/decisions/006.
    let count = select(0u, samples.y, position.x >= 0.0);
    for (var i = 0u; i < count; i++) {
        let sample = textureLoad(lobe, vec2i(i32(i), i32(samples.x)), 0);
        var direction = sample.xyz;
        var weight = sample.w;
        var level = sample.w;
        if is_of_sphere != 0u {
            let n_dot_l = max(dot(normal, direction), 0.0);
            // Seen along the normal, the square of the half vector's cosine is (1 + n.l) / 2.
            let d = 1.0 - 0.5 * (1.0 + n_dot_l) * (1.0 - a2);
            weight *= n_dot_l / (d * d);
            level = environment_prefilter.scales.y;
        } else {
            weight = sample.z;
            let z = sqrt(max(1.0 - dot(sample.xy, sample.xy), 0.0));
            direction = tangent * sample.x + bitangent * sample.y + normal * z;
        }
        sum += textureSampleLevel(source, linear_clamp, direction, level).rgb * weight;
        weights += weight;
    }
    return vec4f(sum / max(weights, 1e-12), 1.0);
}
