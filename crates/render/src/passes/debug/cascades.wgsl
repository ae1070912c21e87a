// Which cascade shows a place's shadow of parallel light: the first, as in `shaders/shadows.wgsl`, which also blends it
// with the next where it ends.

import package::shaders::light_table::{LIGHT_SHADOW, cluster_grid, light_part, light_place, table_rows};
import package::shaders::shadows::{shadow_tile, within_cascade};

// Counted from 1, of the first light that has one there; 0 where none does.
fn cascade_number(position_world: vec3f) -> f32 {
    let rows = table_rows();
    // Depends on more than uniforms, see docs/decisions/006.
    let light_count = select(0u, cluster_grid.directional_count, position_world.x < 3e38);
    for (var light = 0u; light < light_count; light++) {
        let shadow = light_part(light_place(light, rows), LIGHT_SHADOW);
        let count = u32(shadow.y);
        for (var i = 0u; i < count; i++) {
            if within_cascade(shadow_tile(u32(shadow.x) + i), position_world) > 0.0 {
                return f32(i + 1u);
            }
        }
    }
    return 0.0;
}
