// The one reflectance model of forward, deferred and baking.
// Specular: GGX (Walter et al. 2007), height-correlated Smith visibility (Heitz 2014), Schlick's Fresnel (1994), energy
// compensation for multiple scattering (Kulla & Conty 2017, in the form of Lagarde & Golubev 2018).
// Diffuse: Lambert, weighted by 1 - F as in glTF 2.0, appendix B.

// Beside it, for comparison (`shading.model`): 1 Phong, 2 Blinn-Phong. It is constant when a shader runs.
override reflectance_model: u32 = 0u;

const PI: f32 = 3.14159265359;

// Everything of a surface and a direction of view that does not depend on the light.
struct Shading {
    normal: vec3f,
    // The normal of the surface as it was drawn, without that of vertices and maps: shadows depend on it.
    facet_normal: vec3f,
    to_eye: vec3f,
    n_dot_v: f32,
    roughness_alpha: f32,
    albedo: vec3f,
    f0: vec3f,
    // Scale and bias of f0 in the directional albedo.
    dfg: vec2f,
    // 1 + f0 (1 / directional albedo - 1).
    energy_compensation: vec3f,
}

fn fresnel_schlick(f0: vec3f, v_dot_h: f32) -> vec3f {
    let m = clamp(1.0 - v_dot_h, 0.0, 1.0);
    let m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

fn distribution_ggx(n_dot_h: f32, roughness_alpha: f32) -> f32 {
    let a2 = roughness_alpha * roughness_alpha;
    // Written with 1 - n.h squared apart, so that a2 is not lost beside 1.
    let d = (1.0 - n_dot_h * n_dot_h) + n_dot_h * n_dot_h * a2;
    return a2 / (PI * d * d);
}

// G / (4 n.l n.v).
fn visibility_smith(n_dot_l: f32, n_dot_v: f32, roughness_alpha: f32) -> f32 {
    let a2 = roughness_alpha * roughness_alpha;
    let light = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    let eye = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    return 0.5 / max(light + eye, 1e-7);
}

// The exponent of Blinn-Phong whose highlight is as wide as that of a roughness (Walter et al. 2007, for Beckmann's distribution).
fn blinn_phong_exponent(roughness_alpha: f32) -> f32 {
    return 2.0 / (roughness_alpha * roughness_alpha) - 2.0;
}

// Lobes of constant colour, normalised so that at normal incidence they reflect exactly f0; diffuse light is weighted by
// 1 - f0. Phong 1975 in the form of Lafortune & Willems 1994, around the direction of reflection, whose angle is twice that of the
// half vector, so that its exponent is a fourth of Blinn's; Blinn 1977, normalised as in Akenine-Möller et al. 2008.
fn lobe_times_n_dot_l(shading: Shading, to_light: vec3f, n_dot_l: f32) -> vec3f {
    let exponent = blinn_phong_exponent(shading.roughness_alpha);
    var lobe = 0.0;
    if reflectance_model == 1u {
        let reflected = 2.0 * n_dot_l * shading.normal - to_light;
        let phong_exponent = 0.25 * exponent;
        let cosine = clamp(dot(reflected, shading.to_eye), 1e-6, 1.0);
        lobe = (phong_exponent + 2.0) / (2.0 * PI) * pow(cosine, phong_exponent);
    } else {
        let halfway = normalize(to_light + shading.to_eye);
        let cosine = clamp(dot(shading.normal, halfway), 1e-6, 1.0);
        let norm = (exponent + 2.0) * (exponent + 4.0) / (8.0 * PI * (exp2(-0.5 * exponent) + exponent));
        lobe = norm * pow(cosine, exponent);
    }
    return ((1.0 - shading.f0) * shading.albedo * (1.0 / PI) + shading.f0 * lobe) * n_dot_l;
}

// Reflected radiance for one unit of irradiance on a plane across the light's direction; n.l is included.
fn brdf_times_n_dot_l(shading: Shading, to_light: vec3f) -> vec3f {
    let n_dot_l = dot(shading.normal, to_light);
    if n_dot_l <= 0.0 {
        return vec3f(0.0);
    }
    if reflectance_model != 0u {
        return lobe_times_n_dot_l(shading, to_light, n_dot_l);
    }
    // For unit vectors |l + v|^2 = 2 + 2 l.v, and v.h = |l + v| / 2, so the half vector itself is not needed.
    let half_length_squared = max(2.0 + 2.0 * dot(to_light, shading.to_eye), 1e-8);
    let inverse_half_length = inverseSqrt(half_length_squared);
    let n_dot_h = min((n_dot_l + dot(shading.normal, shading.to_eye)) * inverse_half_length, 1.0);
    let v_dot_h = 0.5 * half_length_squared * inverse_half_length;
    let fresnel = fresnel_schlick(shading.f0, v_dot_h);
    let specular = distribution_ggx(max(n_dot_h, 0.0), shading.roughness_alpha)
        * visibility_smith(n_dot_l, shading.n_dot_v, shading.roughness_alpha);
    let diffuse = (1.0 - fresnel) * shading.albedo * (1.0 / PI);
    return (diffuse + specular * fresnel * shading.energy_compensation) * n_dot_l;
}
