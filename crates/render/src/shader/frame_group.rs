//! What every program finds in group 0.

/// A name of group 0. Its place in the list is its binding.
#[derive(Debug)]
pub(crate) struct FrameSlot {
    pub name: &'static str,
    pub ty: wgpu::BindingType,
}

const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

const fn texture(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension: wgpu::TextureViewDimension::D2, multisampled: false }
}

const fn slot(name: &'static str, ty: wgpu::BindingType) -> FrameSlot {
    FrameSlot { name, ty }
}

/// Group 0 of all programs: one layout, so that it is bound once a pass whatever is drawn. A stage has 16 textures, and
/// counts those of a layout that it does not read: here may be 6 at most.
pub(crate) const FRAME_GROUP: [FrameSlot; 12] = [
    slot("view", UNIFORM),
    // And images of decals.
    slot("directional_albedo", texture(wgpu::TextureSampleType::Float { filterable: true })),
    slot("linear_clamp", wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
    slot("cluster_grid", UNIFORM),
    slot("lights", texture(wgpu::TextureSampleType::Float { filterable: false })),
    slot("cluster_lights", texture(wgpu::TextureSampleType::Float { filterable: false })),
    slot("environment", UNIFORM),
    slot("nearest_clamp", wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering)),
    slot("shadow_atlas", texture(wgpu::TextureSampleType::Depth)),
    slot("shadow_compare", wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
    // The same texture again: WebGL 2 has one sampler for every texture that is bound.
    slot("shadow_depths", texture(wgpu::TextureSampleType::Float { filterable: false })),
    slot("environment_tiles", texture(wgpu::TextureSampleType::Float { filterable: true })),
];

/// What a stage has of textures on WebGL 2, and on WebGPU by default.
const STAGE_TEXTURES: usize = 16;

/// How many textures a program may have in its other groups: a layout's count, whether they are read or not.
pub(crate) const OWN_TEXTURES_MAX: usize = STAGE_TEXTURES - textures_of(&FRAME_GROUP);

const fn textures_of(slots: &[FrameSlot]) -> usize {
    let (mut count, mut at) = (0, 0);
    while at < slots.len() {
        if matches!(slots[at].ty, wgpu::BindingType::Texture { .. }) {
            count += 1;
        }
        at += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn group_0_leaves_room() {
        let is_texture = |slot: &&FrameSlot| matches!(slot.ty, wgpu::BindingType::Texture { .. });
        let count = FRAME_GROUP.iter().filter(is_texture).count();
        // A stage has 16 on WebGL 2: two are for the pass, eight for the material.
        assert!(count <= 6, "group 0 has {count} textures");
        let uniforms = FRAME_GROUP.iter().filter(|slot| slot.ty == UNIFORM).count();
        // WebGL 2 promises 12 a stage.
        assert!(uniforms <= 4, "group 0 has {uniforms} uniforms");
    }
}
