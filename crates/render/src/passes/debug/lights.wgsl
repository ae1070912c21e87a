// How many lights are visited for a pixel: those that every pixel visits, and those of its cluster's list.

import package::view::distance_from_depth_ndc;
import package::shaders::light_table::{cluster_at, cluster_grid};
import package::shaders::light_lists::cluster_index_at;
import package::shaders::surface_vertex::{SurfaceVarying, is_without_normals};
import package::shaders::surface_material::material_factors;

fn visited_lights(in: SurfaceVarying) -> f32 {
    // As the deferred path has it, so that the slice is the same.
    let distance_m = distance_from_depth_ndc(in.position_clip.xy, in.position_clip.z);
    let list = cluster_at(cluster_index_at(in.position_clip.xy, distance_m));
    let is_unlit = (material_factors.shading_model < 0.25) | is_without_normals(in.object);
    return select(f32(cluster_grid.global_count + list.end - list.first), 0.0, is_unlit);
}

// So many slices have colours of their own; then these begin again.
const SLICE_COLORS: u32 = 8u;

// The slice along the view axis of a pixel's cluster.
fn cluster_slice(in: SurfaceVarying) -> f32 {
    let distance_m = distance_from_depth_ndc(in.position_clip.xy, in.position_clip.z);
    let index = cluster_index_at(in.position_clip.xy, distance_m);
    let slice = index / max(cluster_grid.size.x * cluster_grid.size.y, 1u);
    return f32(slice % SLICE_COLORS);
}
