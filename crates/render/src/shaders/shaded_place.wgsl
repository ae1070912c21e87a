// What reflectance needs of a surface at a place, whose surroundings are known from then on.

import package::gbuffer::Surface;
import package::shaders::brdf::Shading;
import package::shaders::environment::enter_surroundings;
import package::shaders::shading::shading_from_surface;
import package::view::direction_to_eye_world;

fn shading_at(surface: Surface, position_world: vec3f) -> Shading {
    enter_surroundings(position_world);
    return shading_from_surface(surface, direction_to_eye_world(position_world));
}
