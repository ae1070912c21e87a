// volumes.mark: draws volumes for the stencil alone, which keeps the pixels inside of them. Writes: no colour.
// Program: volumes_mark.

import package::passes::volumes::volume_vertex::{VolumeVarying, volume_varying};

@vertex
fn vs_volumes_mark(@location(0) corner: vec3f, @builtin(instance_index) instance: u32) -> VolumeVarying {
    return volume_varying(corner, instance);
}

@fragment
fn fs_volumes_mark(in: VolumeVarying) -> @location(0) vec4f {
    return vec4f(0.0);
}
