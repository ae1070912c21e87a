// What shaders are told of the environment, of what stands for it in parts of the scene, and of probes, and the texture that has
// their texels.

// A grid of probes.
struct ProbeGrid {
    // The place of the first probe; one divided by how many metres the box fades over.
    first: vec4f,
    // How far probes are apart; what their light is multiplied by.
    spacing: vec4f,
    // How many there are along each axis; layers along Z that lie beside each other in the texture.
    counts: vec4f,
    // The corners of the light and of the distances in texels.
    corners: vec4f,
    // The middle of the box; zero.
    center: vec4f,
    // Half the box's extent; how far from a surface its light is looked up, in metres.
    half_m: vec4f,
    // One divided by how far probes are apart; one divided by how far from one side of a surface's plane the other one is.
    inverse: vec4f,
    // How far its probes were moved along each axis at the most; how far from a surface's plane a probe is wholly on one side.
    moved_m: vec4f,
}

// What is to be seen around a place.
struct Surroundings {
    // The middle of the box of those that have it; one divided by how many metres it fades over.
    center: vec4f,
    // Half its extent; what the light of its tiles is multiplied by.
    half_m: vec4f,
    // Where it is seen from; 1 if it has walls.
    place: vec4f,
    // The middle and half the extent of its walls; zeros.
    walls_center: vec4f,
    walls_half_m: vec4f,
    // The corner of its tiles in texels; zeros.
    corner: vec4f,
}

struct Environment {
    // Constant radiance, pre-exposed.
    constant: vec3f,
    padding: f32,
    // What the camera sees of the environment: radiance, pre-exposed, straight down and straight up.
    backdrop_below: vec4f,
    backdrop_above: vec4f,
    // Of a picture: what its light is multiplied by, zero, the cosine and the sine of its rotation.
    picture: vec4f,
    // The sides of its tiles in texels: the mirror's, fine, medium and coarse ones.
    tile_sides: vec4f,
    // What the picture is multiplied by as the camera sees it, and its level; one divided by the size of the texture in
    // texels.
    picture_backdrop: vec4f,
    // Of the lobe in which the camera sees suns where the picture is blurred: the square of alpha, one divided by the
    // lobe's integral times how much of them is not in the mirror's tile; zeros.
    backdrop_lobe: vec4f,
    // Strong small sources of the picture: where, with their spread (`suns.rs`), and their irradiance, pre-exposed.
    // Where there are fewer, the others have none.
    sun_directions: array<vec4f, 4>,
    sun_irradiances: array<vec4f, 4>,
    // The radiance of the first of them where it is a disc that the camera sees, pre-exposed, and the cosine of half
    // its angle.
    sun_disc: vec4f,
    // What stands for it in parts of the scene; its tiles have the sides that `surrounding_sides` has, as `tile_sides`.
    surroundings: array<Surroundings, 4>,
    surrounding_sides: vec4f,
    // Grids of probes, whose light surfaces in their boxes have in place of the environment's.
    probes: array<ProbeGrid, 4>,
}

@group(0) @binding(6) var<uniform> environment: Environment;
// A picture of the environment: what surfaces of more and more roughness reflect, without suns but in the mirror's, in
// the tiles of `environment_tiles.wgsl`. Beside them lie those of surroundings, and the texels of probes.
@group(0) @binding(11) var environment_tiles: texture_2d<f32>;
