// The one reflectance model of forward, deferred and baking.
// Specular: GGX (Walter et al. 2007), height-correlated Smith visibility (Heitz 2014), Schlick's Fresnel (1994), energy
// compensation for multiple scattering (Kulla & Conty 2017, in the form of Lagarde & Golubev 2018).
// Diffuse: Lambert, weighted by 1 - F as in glTF 2.0, appendix B.

@if(layered) import package::shaders::layer_terms::LayerTerms;
@if(contact) import package::shaders::contact::ContactOrigin;
@if(relief) import package::shaders::relief::ReliefShadows;

// Beside it, for comparison (`shading.model`): 1 Phong, 2 Blinn-Phong. It is constant when a shader runs.
override reflectance_model: u32 = 0u;
// The exponent of those lobes, 0 for that of the roughness; and what they lack of their strength, as the bits of a number.
override shininess: u32 = 0u;
override lobe_lost: u32 = 0u;
// Metres to the eye, as the bits of a number, from which lamps are reflected evenly to all sides (`lod.lighting_m`); 0
// if nowhere.
override lambert_from: u32 = 0u;

const PI: f32 = 3.14159265359;

// Everything of a surface and a direction of view that does not depend on the light.
struct Shading {
    normal: vec3f,
    // The normal of the surface as it was drawn, without that of vertices and maps: shadows depend on it.
    facet_normal: vec3f,
    // Whether that normal was found, and `normal` is the same.
    is_flat: bool,
    // How far the smooth surface lies over the triangle, see `surface_lift.wgsl`; 0 where there are no shadows.
    lift_m: f32,
    to_eye: vec3f,
    n_dot_v: f32,
    roughness_alpha: f32,
    albedo: vec3f,
    f0: vec3f,
    // Scale and bias of f0 in the directional albedo.
    dfg: vec2f,
    // 1 + f0 (1 / directional albedo - 1).
    energy_compensation: vec3f,
    // What of the reflectance of lamps is the same for all of them: see `set_lamp_terms`.
    normal_dot_eye: f32,
    alpha_squared: f32,
    eye_masking: f32,
    diffuse: vec3f,
    specular: vec3f,
    specular_grazing: vec3f,
    // Whether it lies so far away that lamps are reflected by the cheapest model.
    is_far: bool,
    @if(layered) layers: LayerTerms,
    @if(relief) relief: ReliefShadows,
    @if(contact) contact: ContactOrigin,
}

// Computes once a surface what `reflectance` would compute once a lamp.
fn set_lamp_terms(shading: ptr<function, Shading>) {
    let a2 = (*shading).roughness_alpha * (*shading).roughness_alpha;
    let n_dot_v = (*shading).n_dot_v;
    (*shading).normal_dot_eye = dot((*shading).normal, (*shading).to_eye);
    (*shading).alpha_squared = a2;
    (*shading).eye_masking = sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    (*shading).diffuse = (1.0 - (*shading).f0) * (*shading).albedo * (1.0 / PI);
    let specular = a2 * (0.5 / PI) * (*shading).energy_compensation;
    (*shading).specular = specular * (*shading).f0;
    (*shading).specular_grazing = specular - (*shading).specular;
}

// The exponent of Blinn-Phong whose highlight is as wide as that of a roughness (Walter et al. 2007, for Beckmann's
// distribution).
fn blinn_phong_exponent(roughness_alpha: f32) -> f32 {
    return 2.0 / (roughness_alpha * roughness_alpha) - 2.0;
}

// Reflectance in two parts, whose sum it is.
struct Reflectance {
    diffuse: vec3f,
    specular: vec3f,
}

// Lobes of constant colour, normalised so that at normal incidence they reflect exactly f0; diffuse light is weighted
// by 1 - f0. Phong 1975 in the form of Lafortune & Willems 1994, around the direction of reflection, whose angle is
// twice that of the half vector, so that its exponent is a fourth of Blinn's; Blinn 1977, normalised as in
// Akenine-Möller et al. 2008.
fn lobe_reflectance(shading: Shading, to_light: vec3f, n_dot_l: f32) -> Reflectance {
    let is_given = shininess > 0u;
    let exponent = select(blinn_phong_exponent(shading.roughness_alpha), f32(shininess), is_given);
    var lobe = 0.0;
    if reflectance_model == 1u {
        let reflected = 2.0 * n_dot_l * shading.normal - to_light;
        let phong_exponent = exponent * select(0.25, 1.0, is_given);
        let cosine = clamp(dot(reflected, shading.to_eye), 1e-6, 1.0);
        lobe = (phong_exponent + 2.0) / (2.0 * PI) * pow(cosine, phong_exponent);
    } else {
        let sum = to_light + shading.to_eye;
        let halfway = sum * inverseSqrt(max(dot(sum, sum), 1e-8));
        let cosine = clamp(dot(shading.normal, halfway), 1e-6, 1.0);
        let norm = (exponent + 2.0) * (exponent + 4.0) / (8.0 * PI * (exp2(-0.5 * exponent) + exponent));
        lobe = norm * pow(cosine, exponent);
    }
    return Reflectance(shading.diffuse, shading.f0 * (lobe * (1.0 - bitcast<f32>(lobe_lost))));
}

// Reflected radiance for one unit of irradiance on the surface. `n_dot_l` is not below 0.
fn reflectance(shading: Shading, to_light: vec3f, n_dot_l: f32) -> Reflectance {
    if lambert_from != 0u {
        // What would be mirrored is diffuse light as well (Lambert), so that metals stay bright.
        if shading.is_far {
            return Reflectance(shading.diffuse + shading.f0 * (1.0 / PI), vec3f(0.0));
        }
    }
    if reflectance_model != 0u {
        return lobe_reflectance(shading, to_light, n_dot_l);
    }
    // For unit vectors h = l + v has h.h = 2 + 2 l.v and v.h = |h| / 2, so the half vector itself is not needed.
    let half_squared = max(2.0 + 2.0 * dot(to_light, shading.to_eye), 1e-8);
    let n_dot_half = max(n_dot_l + shading.normal_dot_eye, 0.0);
    let cosine_squared = min(n_dot_half * n_dot_half, half_squared);
    // Schlick's Fresnel: what is left of it above f0.
    let m = max(1.0 - 0.5 * sqrt(half_squared), 0.0);
    let m2 = m * m;
    let grazing = m2 * m2 * m;
    // D = a^2 / (pi d^2) with d = 1 - (n.h)^2 + (n.h)^2 a^2, here times h.h; the square of n.h apart from 1, so that
    // a^2 is not lost beside it. V = 0.5 / (light + eye) is G / (4 n.l n.v). One division makes both; what is constant
    // in them is in `specular`.
    let a2 = shading.alpha_squared;
    let d = (half_squared - cosine_squared) + cosine_squared * a2;
    let light = shading.n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    let masking = max(light + n_dot_l * shading.eye_masking, 1e-7);
    let lobe = half_squared * half_squared / (d * d * masking);
    let specular = shading.specular + shading.specular_grazing * grazing;
    return Reflectance(shading.diffuse * (1.0 - grazing), specular * lobe);
}
