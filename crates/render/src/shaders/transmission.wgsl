// What lies behind a surface that light comes through: the picture without such surfaces, blurred by its mips where the
// surface is rough, seen where the refracted ray leaves the volume (KHR_materials_transmission and
// KHR_materials_volume); and the environment where the ray leaves the picture.

import package::view::view;
import package::constants::{LAYER_DISPERSION, LAYER_VOLUME, ROUGHNESS_PERCEPTUAL_MIN};
import package::shaders::brdf::Shading;
import package::shaders::environment::environment_reflection;
import package::shaders::layer_maps::has_layer;
import package::shaders::shading::linear_clamp;

// Radiance and coverage of what lies behind, with its mips.
@group(1) @binding(2) var behind: texture_2d<f32>;

// 1 if what is asked is how much of the background comes through, of which `behind` has that up to there: by channel, and
// as coverage says.
override shows_transmittance: u32 = 0u;

// A cubic B-spline of four by four texels by four samples (Sigg & Hadwiger 2005, GPU Gems 2), because squares of coarse
// mips show.
fn behind_at_mip(uv: vec2f, mip: f32) -> vec4f {
    // The branch depends on more than uniforms, see ARCHITECTURE.md.
    if (uv.x > -1.0) & (mip < 0.5) {
        // As sharp as it is.
        return textureSampleLevel(behind, linear_clamp, uv, 0.0);
    }
    let size = vec2f(textureDimensions(behind, i32(mip)));
    let texel = uv * size - 0.5;
    let first = floor(texel);
    let f = texel - first;
    let f2 = f * f;
    let f3 = f2 * f;
    let w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
    let w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    let w3 = f3 / 6.0;
    let w2 = 1.0 - w0 - w1 - w3;
    let low = w0 + w1;
    let high = w2 + w3;
    let at_low = (first - 0.5 + w1 / low) / size;
    let at_high = (first + 1.5 + w3 / high) / size;
    let above = textureSampleLevel(behind, linear_clamp, at_low, mip) * low.x
        + textureSampleLevel(behind, linear_clamp, vec2f(at_high.x, at_low.y), mip) * high.x;
    let below = textureSampleLevel(behind, linear_clamp, vec2f(at_low.x, at_high.y), mip) * low.x
        + textureSampleLevel(behind, linear_clamp, at_high, mip) * high.x;
    return above * low.y + below * high.y;
}

fn behind_at(uv: vec2f, mip: f32) -> vec4f {
    let finer = floor(mip);
    return mix(behind_at_mip(uv, finer), behind_at_mip(uv, finer + 1.0), mip - finer);
}

// What is seen through the surface with a refractive index: radiance and coverage.
fn seen_through(shading: Shading, position_world: vec3f, ior: f32) -> vec4f {
    let terms = shading.layers;
    var ray = -shading.to_eye;
    var length_m = 0.0;
    if has_layer(LAYER_VOLUME) {
        let refracted = refract(-shading.to_eye, shading.normal, 1.0 / ior);
        ray = refracted;
        length_m = terms.thickness_m;
    }
    let clip = view.clip_from_world * vec4f(position_world + ray * length_m, 1.0);
    let uv = clip.xy / max(clip.w, 1e-6) * vec2f(0.5, -0.5) + 0.5;
    // A thin wall refracts twice, and not at all; rough ones blur by their index.
    // Smooth ones do not: the least roughness of highlights is none here.
    let roughness = (sqrt(shading.roughness_alpha) - ROUGHNESS_PERCEPTUAL_MIN) / (1.0 - ROUGHNESS_PERCEPTUAL_MIN);
    let mip_last = floor(log2(max(view.size_px.x, view.size_px.y)) + 1e-3);
    let blur = max(roughness, 0.0) * clamp(2.0 * ior - 2.0, 0.0, 1.0);
    let mip = clamp(log2(view.size_px.x) * blur, 0.0, max(mip_last - 1.0, 0.0));
    let seen = behind_at(clamp(uv, vec2f(0.0), vec2f(1.0)), mip);
    let beyond = max(abs(uv - 0.5) - 0.5, vec2f(0.0));
    let outside = smoothstep(0.0, 0.1, max(beyond.x, beyond.y));
    var around = vec4f(environment_reflection(ray, shading.roughness_alpha * blur), 1.0);
    if shows_transmittance != 0u {
        around = vec4f(0.0);
    }
    let absorbed = exp(-terms.absorption * length_m);
    let found = mix(seen, around, outside);
    return vec4f(found.rgb * absorbed, found.a);
}

// What is seen through the surface, every colour as it is refracted.
fn seen_behind(shading: Shading, position_world: vec3f) -> vec4f {
    let terms = shading.layers;
    if !has_layer(LAYER_DISPERSION) {
        return seen_through(shading, position_world, terms.ior);
    }
    // The indices of red and blue (KHR_materials_dispersion).
    let spread = (terms.ior - 1.0) * 0.025 * terms.dispersion;
    let red = seen_through(shading, position_world, max(terms.ior - spread, 1.0));
    let green = seen_through(shading, position_world, terms.ior);
    let blue = seen_through(shading, position_world, terms.ior + spread);
    return vec4f(red.r, green.g, blue.b, (red.a + green.a + blue.a) / 3.0);
}
