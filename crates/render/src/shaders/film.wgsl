// A thin film on a surface (Belcour & Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of
// Varying Iridescence"): interference of all orders, as colours by sums of Gaussians.

const FILM_PI: f32 = 3.14159265359;

fn schlick(f0: vec3f, cosine: f32) -> vec3f {
    return f0 + (1.0 - f0) * pow(clamp(1.0 - cosine, 0.0, 1.0), 5.0);
}

// Two times the cosine's integral over all wavelengths that the eye sees: the colour matching functions' Fourier
// transforms at an optical path difference, as Gaussians, in linear Rec. 709.
fn film_sensitivity(path_nm: f32, shift: vec3f) -> vec3f {
    let phase = 2.0 * FILM_PI * path_nm * 1e-9;
    let value = vec3f(5.4856e-13, 4.4201e-13, 5.2481e-13);
    let position = vec3f(1.6810e+06, 1.7953e+06, 2.2084e+06);
    let variance = vec3f(4.3278e+09, 9.3046e+09, 6.6121e+09);
    var xyz = value * sqrt(2.0 * FILM_PI * variance) * cos(position * phase + shift) * exp(-phase * phase * variance);
    xyz.x += 9.7470e-14 * sqrt(2.0 * FILM_PI * 4.5282e+09) * cos(2.2399e+06 * phase + shift.x)
        * exp(-4.5282e+09 * phase * phase);
    xyz = xyz / 1.0685e-7;
    return vec3f(
        dot(vec3f(3.2404542, -1.5371385, -0.4985314), xyz),
        dot(vec3f(-0.9692660, 1.8760108, 0.0415560), xyz),
        dot(vec3f(0.0556434, -0.2040259, 1.0572252), xyz),
    );
}

// What a film of a refractive index and a thickness reflects, on a surface of reflectance `f0` at normal incidence, at
// an angle of so much cosine.
fn film_fresnel(cosine: f32, f0: vec3f, film_ior: f32, thickness_nm: f32) -> vec3f {
    // A film that vanishes is air.
    let ior = mix(1.0, film_ior, smoothstep(0.0, 0.03, thickness_nm));
    let sine_squared = (1.0 - cosine * cosine) / (ior * ior);
    let cosine_within = sqrt(max(1.0 - sine_squared, 0.0));
    // Outside to film.
    let ratio = (ior - 1.0) / (ior + 1.0);
    let r0 = ratio * ratio;
    let r12 = r0 + (1.0 - r0) * pow(clamp(1.0 - cosine, 0.0, 1.0), 5.0);
    let t121 = 1.0 - r12;
    // Film to surface, whose index is that of its reflectance.
    let root = sqrt(clamp(f0, vec3f(0.0), vec3f(0.9999)));
    let base_ior = (1.0 + root) / (1.0 - root);
    let base_ratio = (base_ior - ior) / (base_ior + ior);
    let r23 = schlick(base_ratio * base_ratio, cosine_within);
    let phase12 = select(0.0, FILM_PI, ior < 1.0);
    let phase21 = FILM_PI - phase12;
    let shift = vec3f(phase21) + select(vec3f(0.0), vec3f(FILM_PI), base_ior < vec3f(ior));
    // The difference of the paths of two neighbouring orders.
    let path_nm = 2.0 * ior * thickness_nm * cosine_within;
    let r123 = clamp(r12 * r23, vec3f(1e-5), vec3f(0.9999));
    let amplitude = sqrt(r123);
    let rs = t121 * t121 * r23 / (1.0 - r123);
    var sum = r12 + rs;
    let first = (rs - t121) * amplitude;
    sum += 2.0 * first * film_sensitivity(path_nm, shift);
    sum += 2.0 * first * amplitude * film_sensitivity(2.0 * path_nm, 2.0 * shift);
    return clamp(sum, vec3f(0.0), vec3f(1.0));
}
