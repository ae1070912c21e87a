// Layers of materials: specular colour, clear coat, sheen, anisotropy, iridescence, and light that comes through.
// Structure and energy follow the ratified extensions of glTF 2.0; which there are is constant when a shader runs, so
// that others cost nothing.

import package::gbuffer::Surface;
import package::view::view;
import package::constants::{
    ENVIRONMENT_ROUGHNESS_FIRST, LAYER_ANISOTROPY, LAYER_CLEARCOAT, LAYER_DIFFUSE_TRANSMISSION, LAYER_GLOSSINESS, LAYER_IRIDESCENCE, LAYER_SHEEN,
    LAYER_TRANSMISSION, LAYER_VOLUME, ROUGHNESS_PERCEPTUAL_MIN,
};
import package::shaders::brdf::{PI, Shading};
import package::shaders::layer_terms::LayerTerms;
import package::shaders::film::film_fresnel;
import package::shaders::shading::dfg_at;
import package::shaders::layer_maps::{
    MAP_ANISOTROPY, MAP_CLEARCOAT, MAP_CLEARCOAT_NORMAL, MAP_CLEARCOAT_ROUGHNESS, MAP_DIFFUSE_TRANSMISSION,
    MAP_DIFFUSE_TRANSMISSION_COLOR, MAP_IRIDESCENCE, MAP_IRIDESCENCE_THICKNESS, MAP_SHEEN_COLOR, MAP_SHEEN_ROUGHNESS,
    MAP_SPECULAR, MAP_SPECULAR_COLOR, MAP_THICKNESS, MAP_TRANSMISSION, color_map, data_map, has_layer, has_map, layer_factors,
};
import package::shaders::surface_material::{bent_normal, material_factors, unplaced_direction, vertex_normal_of};
import package::shaders::surface_vertex::SurfaceVarying;

// Below this the sheen of a fibre is narrower than half floats can hold.
const SHEEN_ROUGHNESS_MIN: f32 = 0.07;
const COAT_F0: f32 = 0.04;
// How often the environment is looked up along a stretched highlight, for every sample of a picture.
const STRETCHED_LOOKUPS: u32 = 8u;

// The layers of a material at a fragment, as its factors and maps have them.
struct LayerSample {
    specular_color: vec3f,
    specular_weight: f32,
    // 1 - roughness, where that is told so.
    glossiness: f32,
    coat_weight: f32,
    coat_roughness: f32,
    coat_normal: vec3f,
    sheen_color: vec3f,
    sheen_roughness: f32,
    anisotropy: f32,
    tangent: vec3f,
    film_weight: f32,
    film_thickness_nm: f32,
    transmission: f32,
    thickness_m: f32,
    diffuse_transmission: vec4f,
}

// What makes a map's UVs of those that tangents are for: the set of the normal map, or without one that of the coat's
// or of the anisotropy's. How another set lies to it nobody says, and tangents are taken as they are.
fn tangent_rows(map: u32) -> array<vec4f, 2> {
    let row0 = layer_factors.maps[map * 2u];
    let row1 = layer_factors.maps[map * 2u + 1u];
    // No branch, because it would depend on uniforms alone.
    let is_same = row0.w == material_factors.uv_rows[4].w;
    return array(
        select(vec4f(1.0, 0.0, 0.0, 0.0), row0, is_same),
        select(vec4f(0.0, 1.0, 0.0, 0.0), row1, is_same),
    );
}

// Reads all maps, which has to be done before anything depends on the fragment.
fn layer_sample(in: SurfaceVarying, front_facing: bool) -> LayerSample {
    var out: LayerSample;
    let specular_color = color_map(in, MAP_SPECULAR_COLOR);
    out.specular_color = layer_factors.specular.rgb * specular_color.rgb;
    out.specular_weight = layer_factors.specular.a * data_map(in, MAP_SPECULAR).a;
    out.glossiness = layer_factors.refraction.z * specular_color.a;
    let tangent = in.tangent_world.xyz;
    let bitangent = cross(in.normal_world, tangent) * in.tangent_world.w;
    if has_layer(LAYER_CLEARCOAT) {
        out.coat_weight = layer_factors.coat.x * data_map(in, MAP_CLEARCOAT).r;
        out.coat_roughness = layer_factors.coat.y * data_map(in, MAP_CLEARCOAT_ROUGHNESS).g;
        out.coat_normal = vertex_normal_of(in, front_facing);
        if has_map(MAP_CLEARCOAT_NORMAL) {
            let texel = data_map(in, MAP_CLEARCOAT_NORMAL).xyz;
            let rows = tangent_rows(MAP_CLEARCOAT_NORMAL);
            out.coat_normal = bent_normal(in, front_facing, texel, layer_factors.coat.z, rows[0], rows[1]);
        }
    }
    if has_layer(LAYER_SHEEN) {
        out.sheen_color = layer_factors.sheen.rgb * color_map(in, MAP_SHEEN_COLOR).rgb;
        out.sheen_roughness = layer_factors.sheen.a * data_map(in, MAP_SHEEN_ROUGHNESS).a;
    }
    if has_layer(LAYER_ANISOTROPY) {
        var direction = vec2f(1.0, 0.0);
        out.anisotropy = layer_factors.anisotropy.x;
        if has_map(MAP_ANISOTROPY) {
            let texel = data_map(in, MAP_ANISOTROPY).rgb;
            direction = texel.rg * 2.0 - 1.0;
            out.anisotropy *= texel.b;
        }
        let cosine = layer_factors.anisotropy.y;
        let sine = layer_factors.anisotropy.z;
        var turned = vec2f(cosine * direction.x - sine * direction.y, sine * direction.x + cosine * direction.y);
        if has_map(MAP_ANISOTROPY) {
            let rows = tangent_rows(MAP_ANISOTROPY);
            turned = unplaced_direction(turned, rows[0], rows[1]);
        }
        out.tangent = tangent * turned.x + bitangent * turned.y;
    }
    if has_layer(LAYER_IRIDESCENCE) {
        out.film_weight = layer_factors.film.x * data_map(in, MAP_IRIDESCENCE).r;
        out.film_thickness_nm = mix(layer_factors.film.z, layer_factors.film.w, data_map(in, MAP_IRIDESCENCE_THICKNESS).g);
    }
    if has_layer(LAYER_TRANSMISSION) {
        out.transmission = layer_factors.coat.w * data_map(in, MAP_TRANSMISSION).r;
    }
    if has_layer(LAYER_VOLUME) {
        out.thickness_m = layer_factors.volume.w * data_map(in, MAP_THICKNESS).g * in.object_scale;
    }
    if has_layer(LAYER_DIFFUSE_TRANSMISSION) {
        let weight = layer_factors.diffuse_transmission.a * data_map(in, MAP_DIFFUSE_TRANSMISSION).a;
        let color = layer_factors.diffuse_transmission.rgb * color_map(in, MAP_DIFFUSE_TRANSMISSION_COLOR).rgb;
        out.diffuse_transmission = vec4f(color, weight);
    }
    return out;
}

// The roughness of a surface, where its glossiness tells it.
fn layered_roughness(surface: Surface, sample: LayerSample) -> f32 {
    return select(surface.roughness_perceptual, clamp(1.0 - sample.glossiness, 0.0, 1.0), has_layer(LAYER_GLOSSINESS));
}

fn greatest(color: vec3f) -> f32 {
    return max(color.r, max(color.g, color.b));
}

// Changes what shading has of the surface alone into what the layers make of it.
fn set_layers(shading: ptr<function, Shading>, surface: Surface, sample: LayerSample) {
    var terms: LayerTerms;
    let roughness = max(surface.roughness_perceptual, ROUGHNESS_PERCEPTUAL_MIN);
    terms.base_color = surface.base_color;
    terms.metallic = surface.metallic;
    terms.ior = layer_factors.refraction.y;
    terms.dispersion = layer_factors.refraction.w;
    let f0_dielectric = min(layer_factors.refraction.x * sample.specular_color, vec3f(1.0)) * sample.specular_weight;
    terms.f0_dielectric = greatest(f0_dielectric);
    terms.f90_dielectric = sample.specular_weight;
    terms.f90 = mix(sample.specular_weight, 1.0, surface.metallic);
    var f0 = mix(f0_dielectric, surface.base_color, surface.metallic);
    terms.f0_bare = f0;
    if has_layer(LAYER_IRIDESCENCE) {
        terms.film_weight = sample.film_weight;
        terms.film_ior = layer_factors.film.y;
        terms.film_thickness_nm = sample.film_thickness_nm;
        // As the reflectance at normal incidence by which Schlick's curve reaches what the film reflects towards the
        // eye.
        let n_dot_v = clamp((*shading).n_dot_v, 0.0, 1.0);
        let seen = film_fresnel(n_dot_v, f0, terms.film_ior, terms.film_thickness_nm);
        let grazing = min(pow(1.0 - n_dot_v, 5.0), 0.9999);
        let f0_film = (seen - terms.f90 * grazing) / (1.0 - grazing);
        f0 = mix(f0, clamp(f0_film, vec3f(0.0), vec3f(1.0)), terms.film_weight);
        terms.f0_dielectric = mix(terms.f0_dielectric, greatest(f0), terms.film_weight);
    }
    (*shading).f0 = f0;
    if has_layer(LAYER_ANISOTROPY) {
        let alpha = (*shading).roughness_alpha;
        terms.alpha_along = mix(alpha, 1.0, sample.anisotropy * sample.anisotropy);
        // As wide as the surface is rough across, but so that those of all samples leave no gaps along it, and are not
        // the mirror's where it is stretched: suns are no part of others.
        let samples = exp2(2.0 * view.mip_gain);
        let gap = terms.alpha_along / (f32(STRETCHED_LOOKUPS) * samples);
        let mirror = min(terms.alpha_along, ENVIRONMENT_ROUGHNESS_FIRST * ENVIRONMENT_ROUGHNESS_FIRST);
        terms.alpha_lookup = max(alpha, max(gap, mirror));
        // The table is that of round lobes; what stretched ones reflect lies between those as rough as either
        // direction.
        (*shading).dfg = mix((*shading).dfg, dfg_at((*shading).n_dot_v, sqrt(terms.alpha_along)).xy, 0.6);
    }
    let single = max((*shading).dfg.x + (*shading).dfg.y, 1e-3);
    (*shading).energy_compensation = 1.0 + f0 * (1.0 / single - 1.0);
    if has_layer(LAYER_ANISOTROPY) {
        // Along the surface, and of length 1.
        let normal = (*shading).normal;
        let along = sample.tangent - normal * dot(normal, sample.tangent);
        let fallback = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(normal.x) > 0.9);
        let length_squared = dot(along, along);
        terms.tangent = select(normalize(cross(normal, fallback)), along * inverseSqrt(max(length_squared, 1e-30)),
            length_squared > 1e-12);
        terms.bitangent = cross(normal, terms.tangent);
    }
    terms.through = 1.0;
    if has_layer(LAYER_SHEEN) {
        let sheen_roughness = max(sample.sheen_roughness, SHEEN_ROUGHNESS_MIN);
        terms.sheen_color = sample.sheen_color;
        terms.sheen_alpha = sheen_roughness * sheen_roughness;
        terms.sheen_albedo = dfg_at((*shading).n_dot_v, sheen_roughness).z;
        terms.through = 1.0 - greatest(sample.sheen_color) * terms.sheen_albedo;
    }
    if has_layer(LAYER_CLEARCOAT) {
        let coat_roughness = max(sample.coat_roughness, ROUGHNESS_PERCEPTUAL_MIN);
        terms.coat_normal = sample.coat_normal;
        terms.coat_n_dot_v = max(dot(sample.coat_normal, (*shading).to_eye), 1e-4);
        terms.coat_weight = sample.coat_weight;
        terms.coat_alpha = coat_roughness * coat_roughness;
        let dfg = dfg_at(terms.coat_n_dot_v, coat_roughness);
        terms.coat_albedo = (COAT_F0 * dfg.x + dfg.y) * sample.coat_weight;
    }
    terms.transmission = sample.transmission;
    terms.absorption = layer_factors.volume.rgb;
    terms.thickness_m = sample.thickness_m;
    terms.diffuse_transmission = sample.diffuse_transmission;
    (*shading).layers = terms;
}

// What the clear coat lets through.
fn below_coat(terms: LayerTerms) -> f32 {
    return 1.0 - terms.coat_albedo;
}

fn ggx_visibility(n_dot_l: f32, n_dot_v: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let light = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    let eye = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    return 0.5 / max(light + eye, 1e-7);
}

// Distribution times visibility. The square of n.h is apart from 1, so that the square of alpha is not lost beside it.
fn ggx_lobe(normal: vec3f, to_light: vec3f, to_eye: vec3f, n_dot_v: f32, alpha: f32) -> f32 {
    let sum = to_light + to_eye;
    let half_squared = max(dot(sum, sum), 1e-8);
    let n_dot_l = max(dot(normal, to_light), 0.0);
    let n_dot_half = max(dot(normal, sum), 0.0);
    let cosine_squared = min(n_dot_half * n_dot_half, half_squared);
    let a2 = alpha * alpha;
    let d = (half_squared - cosine_squared) + cosine_squared * a2;
    return a2 * half_squared * half_squared / (PI * d * d) * ggx_visibility(n_dot_l, n_dot_v, alpha);
}

// The same stretched along the tangent (Burley 2012; visibility after Heitz 2014).
fn anisotropic_lobe(shading: Shading, to_light: vec3f, n_dot_l: f32) -> f32 {
    let sum = to_light + shading.to_eye;
    let halfway = sum * inverseSqrt(max(dot(sum, sum), 1e-8));
    let along = shading.layers.alpha_along;
    let across = shading.roughness_alpha;
    let tangent = shading.layers.tangent;
    let bitangent = shading.layers.bitangent;
    let stretched = vec3f(
        across * dot(tangent, halfway),
        along * dot(bitangent, halfway),
        along * across * dot(shading.normal, halfway),
    );
    let ratio = along * across / max(dot(stretched, stretched), 1e-12);
    let distribution = along * across * ratio * ratio / PI;
    let eye = vec3f(along * dot(tangent, shading.to_eye), across * dot(bitangent, shading.to_eye), shading.n_dot_v);
    let light = vec3f(along * dot(tangent, to_light), across * dot(bitangent, to_light), n_dot_l);
    return distribution * 0.5 / max(n_dot_l * length(eye) + shading.n_dot_v * length(light), 1e-7);
}

// Estevez & Kulla 2017, "Production Friendly Microfacet Sheen BRDF": the fit of shadowing.
fn sheen_shadowing_curve(cosine: f32, alpha: f32) -> f32 {
    let share = (1.0 - alpha) * (1.0 - alpha);
    let a = mix(21.5473, 25.3245, share);
    let b = mix(3.82987, 3.32435, share);
    let c = mix(0.19823, 0.16801, share);
    let d = mix(-1.97760, -1.27393, share);
    let e = mix(-4.32054, -4.85967, share);
    return a / (1.0 + b * pow(max(cosine, 1e-6), c)) + d * cosine + e;
}

fn sheen_shadowing(cosine: f32, alpha: f32) -> f32 {
    let low = sheen_shadowing_curve(cosine, alpha);
    let high = 2.0 * sheen_shadowing_curve(0.5, alpha) - sheen_shadowing_curve(1.0 - cosine, alpha);
    return exp(select(high, low, cosine < 0.5));
}

// Distribution times visibility of fibres; `resources/directional_albedo.rs` integrates the same.
fn sheen_lobe(n_dot_l: f32, n_dot_v: f32, n_dot_half: f32, alpha: f32) -> f32 {
    let sine_squared = max(1.0 - n_dot_half * n_dot_half, 1e-4);
    let distribution = (2.0 + 1.0 / alpha) * pow(sine_squared, 0.5 / alpha) / (2.0 * PI);
    let shadowing = 1.0 + sheen_shadowing(n_dot_v, alpha) + sheen_shadowing(n_dot_l, alpha);
    return distribution / max(shadowing * 4.0 * n_dot_l * n_dot_v, 1e-5);
}

// What is reflected and comes through of one unit of irradiance on a plane across the direction of light, by the lobes
// that pictures of the environment hold differently.
struct LayeredReflectance {
    diffuse: vec3f,
    specular: vec3f,
    coat: f32,
}

fn layered_reflectance(shading: Shading, to_light: vec3f) -> LayeredReflectance {
    var out: LayeredReflectance;
    let terms = shading.layers;
    let side = dot(shading.normal, to_light);
    let n_dot_l = max(side, 0.0);
    // Light from behind enters as light from the mirrored direction would.
    let mirrored = to_light - 2.0 * min(side, 0.0) * shading.normal;
    let halfway = normalize(mirrored + shading.to_eye + shading.normal * 1e-6);
    let v_dot_half = clamp(dot(shading.to_eye, halfway), 0.0, 1.0);
    let grazing = pow(1.0 - v_dot_half, 5.0);
    var fresnel = terms.f0_bare + (terms.f90 - terms.f0_bare) * grazing;
    var fresnel_dielectric = terms.f0_dielectric + (terms.f90_dielectric - terms.f0_dielectric) * grazing;
    if has_layer(LAYER_IRIDESCENCE) {
        let film = film_fresnel(v_dot_half, terms.f0_bare, terms.film_ior, terms.film_thickness_nm);
        fresnel = mix(fresnel, film, terms.film_weight);
        fresnel_dielectric = mix(fresnel_dielectric, greatest(film), terms.film_weight);
    }
    var lobe = ggx_lobe(shading.normal, to_light, shading.to_eye, shading.n_dot_v, shading.roughness_alpha);
    if has_layer(LAYER_ANISOTROPY) {
        lobe = anisotropic_lobe(shading, to_light, n_dot_l);
    }
    out.specular = fresnel * shading.energy_compensation * (lobe * n_dot_l);
    let entering = 1.0 - fresnel_dielectric;
    let scattered = 1.0 - terms.transmission;
    out.diffuse = shading.albedo * (entering * scattered * n_dot_l * (1.0 / PI));
    if has_layer(LAYER_DIFFUSE_TRANSMISSION) {
        let behind = max(-side, 0.0) * (1.0 / PI) * entering * scattered * (1.0 - terms.metallic);
        let passed = terms.diffuse_transmission.rgb * exp(-terms.absorption * terms.thickness_m);
        out.diffuse = mix(out.diffuse, passed * behind, terms.diffuse_transmission.a);
    }
    if has_layer(LAYER_TRANSMISSION) {
        // Light from behind as a lobe of its own; refraction widens it by the index.
        let alpha = max(shading.roughness_alpha * clamp(2.0 * terms.ior - 2.0, 0.0, 1.0),
            ROUGHNESS_PERCEPTUAL_MIN * ROUGHNESS_PERCEPTUAL_MIN);
        let through = ggx_lobe(shading.normal, mirrored, shading.to_eye, shading.n_dot_v, alpha) * max(-side, 0.0);
        let passed = terms.base_color * exp(-terms.absorption * terms.thickness_m);
        out.diffuse += passed * (through * terms.transmission * entering * (1.0 - terms.metallic));
    }
    if has_layer(LAYER_SHEEN) {
        let n_dot_half = clamp(dot(shading.normal, halfway), 0.0, 1.0);
        let sheen = sheen_lobe(max(n_dot_l, 1e-3), shading.n_dot_v, n_dot_half, terms.sheen_alpha) * n_dot_l;
        out.diffuse = out.diffuse * terms.through + terms.sheen_color * sheen;
        out.specular *= terms.through;
    }
    if has_layer(LAYER_CLEARCOAT) {
        let coat_n_dot_l = max(dot(terms.coat_normal, to_light), 0.0);
        let coat_lobe = ggx_lobe(terms.coat_normal, to_light, shading.to_eye, terms.coat_n_dot_v, terms.coat_alpha);
        let coat_fresnel = COAT_F0 + (1.0 - COAT_F0) * grazing;
        out.coat = terms.coat_weight * coat_fresnel * coat_lobe * coat_n_dot_l;
        out.diffuse *= below_coat(terms);
        out.specular *= below_coat(terms);
    }
    return out;
}
