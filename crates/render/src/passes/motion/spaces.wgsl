// Where a point lies in this picture and in the previous one, both without jitter.

struct Motion {
    clip_from_world: mat4x4f,
    previous_clip_from_world: mat4x4f,
    // Half the picture's size in pixels; y is negative, because pixels count downwards.
    pixel_from_ndc: vec2f,
    padding: vec2f,
}

@group(1) @binding(0) var<uniform> motion: Motion;

// In pixels of the picture, +x right, +y down; 0 for what lay behind the previous camera.
fn motion_px(clip: vec4f, previous_clip: vec4f) -> vec2f {
    let moved_ndc = clip.xy / clip.w - previous_clip.xy / previous_clip.w;
    return select(vec2f(0.0), moved_ndc * motion.pixel_from_ndc, min(clip.w, previous_clip.w) > 0.0);
}
