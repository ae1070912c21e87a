//! effect own_pass
//! reads: radiance, depth, normal, base_color, material
//! passes: fs_own_pass

// Lines where depth or direction changes, and darker corners.
// Source: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes".

struct Style {
    /// Colour of the lines, linear Rec. 709
    // = 0.9, 0.7, 0.4 in 0..
    line_color: vec3f,
    /// How much light the corners lose, share
    // = 0.6 in 0..1
    vignette: f32,
    /// A crease is a line where the cosine between two normals is below this.
    // = 0.8 in -1..1
    crease_cos: f32,
    /// An edge is a line where distances differ by more than this, share of the nearer
    // = 0.05 in 0..1
    step_share: f32,
    padding: vec2f,
}

@group(2) @binding(0) var<uniform> style: Style;

fn clamped(pixel: vec2i) -> vec2i {
    return clamp(pixel, vec2i(0), vec2i(view.size_px) - 1);
}

// Whether there is a line between two pixels.
fn differs(a: vec2i, b: vec2i) -> bool {
    let near_m = min(distance_at(a), distance_at(b));
    let far_m = max(distance_at(a), distance_at(b));
    if near_m >= DISTANCE_BACKGROUND_M {
        return false;
    }
    let is_crease = dot(surface_at(a).normal_world, surface_at(b).normal_world) < style.crease_cos;
    return is_crease || far_m - near_m > style.step_share * near_m;
}

@fragment
fn fs_own_pass(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let here = radiance_at(pixel);
    // Roberts' cross: two diagonals are enough to see a line of any direction.
    let corner = clamped(pixel + 1);
    let is_line = differs(pixel, corner) || differs(vec2i(corner.x, pixel.y), vec2i(pixel.x, corner.y));
    let color = select(here.rgb, style.line_color * view.pre_exposure, is_line);
    let from_middle = 2.0 * uv_from_pixel(position.xy) - 1.0;
    return vec4f(color * (1.0 - style.vignette * 0.5 * dot(from_middle, from_middle)), here.a);
}
