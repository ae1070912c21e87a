// How far the smooth surface that vertex normals describe lies over the triangle that was drawn.
// Source: the mean height of the vertices' planes over a point, weighted as the point lies between them (Hanika 2021,
// "Hacking the Shadow Terminator"). It is the interpolated distance of the planes from the eye less that of the point
// along the interpolated normal, so that no fragment has to know the vertices.

import package::view::{view, pixel_height_m};
import package::shaders::surface_vertex::SurfaceVarying;

// Of the planes' mean height: a ball lies at half of it, at any point of a chord.
const LIFT_SHARE: f32 = 0.5;
// How much shorter the square of an interpolated normal is at least where normals differ: in the middle of an edge whose
// normals lie 0.63 degrees apart. Below that it is rounding.
const BEND_MIN: f32 = 3e-5;

// Pixels; 0 where the surface is flat or lies below the triangle.
fn lift_px_of(in: SurfaceVarying, front_facing: bool) -> f32 {
    let from_eye = in.position_world - view.world_from_view[3].xyz;
    let height_m = (in.plane_m - dot(from_eye, in.normal_world)) * select(-1.0, 1.0, front_facing);
    let distance_m = -(view.view_from_world * vec4f(in.position_world, 1.0)).z;
    let is_bent = 1.0 - dot(in.normal_world, in.normal_world) > BEND_MIN;
    return select(0.0, LIFT_SHARE * max(height_m, 0.0) / max(pixel_height_m(distance_m), 1e-30), is_bent);
}
