// Light from the environment on a surface: split-sum specular (Karis 2013) with multiple scattering, and Lambert.

import package::gbuffer::Surface;
import package::shaders::brdf::{Shading, PI};
import package::shaders::environment::{environment_irradiance, environment_reflection};

fn ambient_radiance(surface: Surface, shading: Shading) -> vec3f {
    let specular_albedo = (shading.f0 * shading.dfg.x + shading.dfg.y) * shading.energy_compensation;
    let reflected = reflect(-shading.to_eye, shading.normal);
    let specular = environment_reflection(reflected, shading.roughness_alpha) * specular_albedo;
    let diffuse = environment_irradiance(shading.normal) * (1.0 / PI) * shading.albedo * (1.0 - specular_albedo);
    return (diffuse + specular) * surface.occlusion;
}
