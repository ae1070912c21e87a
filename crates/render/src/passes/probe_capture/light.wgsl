// probe_capture.light: what is to be seen around a probe as its light.
// Reads: probe_sides (the six sides beside each other), probe_columns (`sums.wgsl`). Writes: how far the probe was moved, and
// how wide its small source is; then six colours, or the first eight coefficients of irradiance divided by pi by the
// polynomials below, beside which the ninth, the source's light and its direction lie in the fourth components.
// Program: probe_light.

import package::constants::{HALF_LARGEST, PROBE_FACE_SIDE};
import package::shaders::brdf::PI;
import package::shaders::cube_sides::{CubeSides, texel_of_direction};
import package::shaders::octahedral::octahedral_from_direction;

struct ProbeCapture {
    // How far the probe was moved; what radiance is multiplied by.
    place: vec4f,
    // 1 if light is six colours; zeros.
    basis: vec4f,
    // The axes of the sides.
    sides: CubeSides,
    // Strong small sources of the environment: where, with the square of half their half angle, and their irradiance.
    sun_directions: array<vec4f, 4>,
    sun_irradiances: array<vec4f, 4>,
}

@group(1) @binding(0) var probe_sides: texture_2d<f32>;
@group(1) @binding(1) var probe_columns: texture_2d<f32>;
@group(1) @binding(2) var<uniform> probe_capture: ProbeCapture;

// The columns of all six sides.
const COLUMNS: u32 = 6u * PROBE_FACE_SIDE;

// So many normals are looked at for the window.
const NORMALS: u32 = 64u;

// Under it even the light of a single point is nowhere below 0.
const WINDOW_MAX: f32 = 0.16;

// Of a direction 1, y, z, x, xy, yz, 3 z² - 1, xz, x² - y²; and the coefficients of light by these.
var<private> basis: array<f32, 9>;
var<private> light: array<vec3f, 9>;

fn find_basis(d: vec3f) {
    basis = array<f32, 9>(
        1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, d.x * d.x - d.y * d.y
    );
}

fn add_light(direction: vec3f, share: vec3f) {
    find_basis(direction);
    for (var i = 0u; i < 9u; i++) {
        light[i] += share * basis[i];
    }
}

// Directions that are spread evenly, on a spiral that turns by the golden angle.
fn spread_direction(index: u32) -> vec3f {
    let y = 1.0 - f32(2u * index + 1u) / f32(NORMALS);
    let radius = sqrt(max(1.0 - y * y, 0.0));
    let angle = f32(index) * 2.3999632;
    return vec3f(radius * cos(angle), y, radius * sin(angle));
}

// The least of any colour over all normals under a window.
fn least_light(strength: f32) -> f32 {
    var least = 1e30;
    for (var i = 0u; i < NORMALS; i++) {
        find_basis(spread_direction(i));
        let first = light[1] * basis[1] + light[2] * basis[2] + light[3] * basis[3];
        let second = light[4] * basis[4] + light[5] * basis[5] + light[6] * basis[6] + light[7] * basis[7]
            + light[8] * basis[8];
        let all = light[0] + first / (1.0 + strength) + second / (1.0 + 2.0 * strength);
        least = min(least, min(all.r, min(all.g, all.b)));
    }
    return least;
}

// The strength of the weakest window under which irradiance is nowhere below 0 (after Sloan 2017, "Deringing Spherical
// Harmonics"); the twin of `Harmonics::window_strength`.
fn window_strength() -> f32 {
    let below = -1e-4 * max(light[0].r, max(light[0].g, light[0].b));
    if least_light(0.0) >= below {
        return 0.0;
    }
    var weak = 0.0;
    var strong = WINDOW_MAX;
    for (var i = 0u; i < 8u; i++) {
        let middle = 0.5 * (weak + strong);
        let is_dark = least_light(middle) < below;
        weak = select(weak, middle, is_dark);
        strong = select(middle, strong, is_dark);
    }
    return strong;
}

// The share of a sun that reaches the probe past what is around it.
fn sun_share(direction: vec3f) -> f32 {
    let middle = texel_of_direction(probe_capture.sides, direction);
    let side = f32(PROBE_FACE_SIDE);
    // Texels of the same side alone.
    let first = floor(middle.x / side) * side;
    var share = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let beside = middle + vec2f(vec2u(i & 1u, i >> 1u)) - 0.5;
        let texel = clamp(beside, vec2f(first, 0.0), vec2f(first + side - 1.0, side - 1.0));
        share += select(0.0, 0.25, textureLoad(probe_sides, vec2i(texel), 0).a < 0.0);
    }
    return share;
}

// Radiance of all directions.
fn add_sides() {
    for (var x = 0u; x < COLUMNS; x++) {
        light[0] += textureLoad(probe_columns, vec2u(x, 0u), 0).rgb;
        light[1] += textureLoad(probe_columns, vec2u(x, 1u), 0).rgb;
        light[2] += textureLoad(probe_columns, vec2u(x, 2u), 0).rgb;
        light[3] += textureLoad(probe_columns, vec2u(x, 3u), 0).rgb;
        light[4] += textureLoad(probe_columns, vec2u(x, 4u), 0).rgb;
        light[5] += textureLoad(probe_columns, vec2u(x, 5u), 0).rgb;
        light[6] += textureLoad(probe_columns, vec2u(x, 6u), 0).rgb;
        light[7] += textureLoad(probe_columns, vec2u(x, 7u), 0).rgb;
        light[8] += textureLoad(probe_columns, vec2u(x, 8u), 0).rgb;
    }
}

// Where a small source is, and the square of half its half angle; and its irradiance.
struct Source {
    direction: vec4f,
    irradiance: vec3f,
}

// Suns of the environment, but for the strongest, which is given where it is to be known for itself.
fn add_suns(has_source: bool) -> Source {
    var source = Source(vec4f(0.0, 1.0, 0.0, 0.0), vec3f(0.0));
    for (var i = 0u; i < 4u; i++) {
        let sun = probe_capture.sun_directions[i];
        let is_sun = dot(sun.xyz, sun.xyz) > 0.5;
        let irradiance = probe_capture.sun_irradiances[i].rgb * sun_share(select(source.direction.xyz, sun.xyz, is_sun));
        let found = Source(sun, select(vec3f(0.0), irradiance, is_sun));
        var weaker = found;
        if has_source & (dot(found.irradiance, vec3f(1.0)) > dot(source.irradiance, vec3f(1.0))) {
            weaker = source;
            source = found;
        }
        add_light(weaker.direction.xyz, weaker.irradiance);
    }
    return source;
}

// Of the cube that is nearest to irradiance, by the mean of squares over all normals (`AmbientCube::of`), the colour of the
// face +X, -X, +Y, -Y, +Z or -Z.
fn cube_color(face: u32) -> vec3f {
    let side = select(1.25, -1.25, (face & 1u) == 1u);
    let of_x = light[0] + light[8] - light[6] + side * light[3];
    let of_y = light[0] - light[8] - light[6] + side * light[1];
    let of_z = light[0] + 2.0 * light[6] + side * light[2];
    let color = select(select(of_z, of_y, face < 4u), of_x, face < 2u);
    return select(vec3f(0.0), max(color, vec3f(0.0)), face < 6u);
}

@fragment
fn fs_probe_light(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = u32(position.x);
    // No branch looks at it, because it would depend on uniforms alone, see docs/decisions/006.
    let is_cube = probe_capture.basis.x > 0.5;
    add_sides();
    let source = add_suns(!is_cube);
    // From radiance to irradiance divided by pi: squares of what makes each polynomial a harmonic, times what a cosine lobe
    // leaves of its order (Ramamoorthi & Hanrahan 2001).
    var scales = array<f32, 9>(
        0.0795775, 0.1591549, 0.1591549, 0.1591549, 0.2984155, 0.2984155, 0.0248680, 0.2984155, 0.0746039
    );
    for (var i = 0u; i < 9u; i++) {
        light[i] *= scales[i] * probe_capture.place.w;
    }
    if texel == 0u {
        let spread = select(min(2.0 * sqrt(source.direction.w), 0.5), 0.0, is_cube);
        return vec4f(probe_capture.place.xyz, spread);
    }
    let index = texel - 1u;
    let of_cube = vec4f(min(cube_color(index), vec3f(HALF_LARGEST)), 0.0);
    let strength = window_strength();
    let first = 1.0 / (1.0 + strength);
    let second = 1.0 / (1.0 + 2.0 * strength);
    let window = select(select(second, first, index < 4u), 1.0, index == 0u);
    let ninth = light[8] * second;
    let of_source = source.irradiance * (probe_capture.place.w / PI);
    let towards = octahedral_from_direction(source.direction.xyz);
    var others = array<f32, 8>(
        ninth.r, ninth.g, ninth.b, of_source.r, of_source.g, of_source.b, towards.x, towards.y
    );
    // Six colours are fewer.
    let at = min(index, 7u);
    let of_lobes = clamp(vec4f(light[at] * window, others[at]), vec4f(-HALF_LARGEST), vec4f(HALF_LARGEST));
    return select(of_lobes, of_cube, is_cube);
}
