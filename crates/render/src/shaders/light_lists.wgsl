// Sums of light over other lists than those of clusters: of a tile, of an object, of a single light.
// One light's contribution is that of `lights.wgsl`, here as everywhere.

import package::constants::DATA_WIDTH;
import package::shaders::brdf::Shading;
import package::shaders::light_table::{cluster_at, cluster_grid, cluster_light_at, table_rows};
import package::shaders::lights::{
    LightSums, cluster_index_at, directional_radiance, global_light_sums, punctual_radiance,
};

// What `LightReaches` holds: see `lights/reaches.rs`.
@if(tiled) @group(1) @binding(4) var light_reaches: texture_2d<f32>;
@if(tiled) @group(1) @binding(5) var tile_depth: texture_2d<f32>;

// One light that has a range.
fn single_light_sums(light: u32, position_world: vec3f, shading: Shading) -> LightSums {
    var sums: LightSums;
    punctual_radiance(light, position_world, shading, table_rows(), &sums);
    return sums;
}

// Lights of the tile's list that its bounds spare; counted only where pairs are.
@if(tiled) var<private> passed_over: f32;

// Those, and the lights of the tile's list that reach the distances at which the tile has surfaces.
@if(tiled) fn tile_light_sums(position_px: vec2f, distance_m: f32, position_world: vec3f, shading: Shading) -> LightSums {
    let rows = table_rows();
    var sums = global_light_sums(position_px, position_world, shading, rows);
    let tile = min(vec2u(position_px) / cluster_grid.size.w, cluster_grid.size.xy - 1u);
    let bounds_m = textureLoad(tile_depth, vec2i(tile), 0).rg;
    let list = cluster_at(cluster_index_at(position_px, distance_m));
    for (var entry = list.first; entry < list.end; entry++) {
        let light = cluster_light_at(entry, rows);
        let at = light - cluster_grid.global_count;
        let reach_m = textureLoad(light_reaches, vec2i(i32(at % DATA_WIDTH), i32(at / DATA_WIDTH)), 0).rg;
        if (reach_m.x > bounds_m.y) | (reach_m.y < bounds_m.x) {
            sums.visited += 1.0;
            passed_over += 1.0;
        } else {
            punctual_radiance(light, position_world, shading, rows, &sums);
        }
    }
    return sums;
}

// So many of the lights that reach an object, from the one with the number `first` on: those that are in no list, and then those
// of its own list, which lie behind the lists of clusters.
fn object_light_sums(
    object_id: u32,
    first: u32,
    most: u32,
    position_world: vec3f,
    shading: Shading,
) -> LightSums {
    var sums: LightSums;
    let list = cluster_at(cluster_grid.size.x * cluster_grid.size.y * cluster_grid.size.z + object_id);
    let rows = table_rows();
    let end = min(first + most, cluster_grid.global_count + list.end - list.first);
    for (var i = first; i < end; i++) {
        if i < cluster_grid.directional_count {
            directional_radiance(i, position_world, shading, rows, &sums);
        } else {
            let is_global = i < cluster_grid.global_count;
            let entry = select(list.first + i - cluster_grid.global_count, list.first, is_global);
            let light = select(cluster_light_at(entry, rows), i, is_global);
            punctual_radiance(light, position_world, shading, rows, &sums);
        }
    }
    return sums;
}
