// The sampler of tables and of what passes leave of the picture. (`linear_clamp` is in `shading.wgsl`.)

// Software adapters find the mip of what is loaded for every lane, and that of what is sampled once.
@group(0) @binding(7) var nearest_clamp: sampler;
