// motion.background: how far what lies infinitely far away moved: by the camera's rotation alone.
// Writes: motion (rg32float, pixels).
// Program: motion_background.

import package::view::{view, ray_direction_world_from_pixel};
import package::passes::motion::spaces::{motion, motion_px};

@fragment
fn fs_motion_background(@builtin(position) position: vec4f) -> @location(0) vec2f {
    let direction = vec4f(ray_direction_world_from_pixel(position.xy), 0.0);
    let moved_px = motion_px(motion.clip_from_world * direction, motion.previous_clip_from_world * direction);
    // Parallel rays all end in one point at infinity; nothing there moves.
    return select(moved_px, vec2f(0.0), view.orthographic > 0.5);
}
