// What shading needs of a material's layers at a surface, and does not depend on the light. `layers.wgsl` makes and
// uses it.

struct LayerTerms {
    base_color: vec3f,
    metallic: f32,
    // Reflectance at grazing angles.
    f90: f32,
    // Of what is not metal, at normal incidence and at grazing angles: the greatest of its colours.
    f0_dielectric: f32,
    f90_dielectric: f32,
    // Without the film.
    f0_bare: vec3f,
    film_weight: f32,
    film_ior: f32,
    film_thickness_nm: f32,
    // Where highlights are stretched along, and across, and how rough the surface is along it.
    tangent: vec3f,
    bitangent: vec3f,
    alpha_along: f32,
    // How rough what is looked up of the environment is.
    alpha_lookup: f32,
    coat_normal: vec3f,
    coat_n_dot_v: f32,
    coat_weight: f32,
    coat_alpha: f32,
    coat_albedo: f32,
    sheen_color: vec3f,
    sheen_alpha: f32,
    sheen_albedo: f32,
    // What sheen and coat let through of what lies below.
    through: f32,
    transmission: f32,
    diffuse_transmission: vec4f,
    ior: f32,
    dispersion: f32,
    absorption: vec3f,
    thickness_m: f32,
}
