// What reflectance needs of a surface at a place, whose surroundings are known from then on.

import package::gbuffer::Surface;
import package::shaders::brdf::{Shading, lambert_from};
import package::shaders::environment::enter_surroundings;
import package::shaders::shading::shading_from_surface;
import package::view::{view, direction_to_eye_world};

fn shading_at(surface: Surface, position_world: vec3f) -> Shading {
    enter_surroundings(position_world);
    var shading = shading_from_surface(surface, direction_to_eye_world(position_world));
    if lambert_from != 0u {
        shading.is_far = distance(position_world, view.world_from_view[3].xyz) >= bitcast<f32>(lambert_from);
    }
    return shading;
}
