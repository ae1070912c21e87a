// What the passes of a surface of water know of it.

struct Water {
    // The outline in world space, one corner after the other; w is 1.
    corners: array<vec4f, 32>,
    // The plane's unit normal, away from the water; the product of the plane's points with it.
    normal: vec4f,
    // The directions of the surface's x and y in world space; zero.
    x_world: vec4f,
    y_world: vec4f,
    // Of the two copies of the map of waves: the cosine and the sine of their turn, divided by their side in metres; and
    // how far they have moved, in sides. Of a simulation the two axes of its rectangle, divided by its sides, and where that begins.
    copies: array<vec4f, 2>,
    absorption_per_m: vec3f,
    // Water's refractive index.
    ior: f32,
    scattering_per_m: vec3f,
    // What slopes of the map are multiplied by.
    steepness: f32,
    // Foam begins where the water is as shallow as that; 0 for none.
    foam_depth_m: f32,
    // How much of the light on what is below waves gather, from 0 to 1.
    caustics: f32,
    // 1 if the eye is in the water, else 0.
    from_below: f32,
    // Over how many metres waves gather it: no more than to where they are sharpest.
    focus_m: f32,
    // The scene's time, within an hour.
    time_secs: f32,
    // Of a step on the surface over which slopes change.
    step_m: f32,
    // The height of the ground, if there is one.
    ground_m: f32,
    padding_b: f32,
}

// The mean of what the surface lets through of light from everywhere: 1 less the diffuse Fresnel reflectance of 1.333
// (Walsh 1926, 0.066).
const LETS_IN: f32 = 0.934;

@group(1) @binding(9) var<uniform> water: Water;
