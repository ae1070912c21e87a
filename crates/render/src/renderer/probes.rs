//! Probes of a frame: their texels beside the tiles of the environment.

use crate::environment::EnvironmentUniform;
use crate::gpu::Gpu;
use crate::probes::{PROBE_BASES, PROBE_GRIDS, ProbeLayout, ProbesUniform, ProbesUniforms, bases, grid_texels};
use crate::shader::program::Constant;
use bytemuck::Zeroable as _;
use half::f16;
use manypass_scene::probes::{Probe, ProbeGrid};
use std::sync::Arc;

/// The texels of probes that are on the device.
#[derive(Debug, Default)]
pub(super) struct ProbeTexels {
    /// What was written of each grid, and what its light was divided by.
    written: Vec<(Arc<Vec<Probe>>, f32)>,
}

/// The grids of a frame.
#[derive(Clone, Debug)]
pub(super) struct PlacedProbes {
    /// For radiance that is not pre-exposed.
    uniforms: ProbesUniforms,
    count: u32,
    bases: u32,
}

impl PlacedProbes {
    fn new(layout: &ProbeLayout, grids: &[&ProbeGrid], corner: [u32; 2], scale: impl Fn(usize) -> f32) -> Self {
        let mut uniforms = ProbesUniforms::zeroed();
        for (at, (uniform, (grid, place))) in uniforms.iter_mut().zip(grids.iter().zip(&layout.places)).enumerate() {
            *uniform = ProbesUniform::new(grid, place, corner, scale(at));
        }
        Self { uniforms, count: grids.len() as u32, bases: bases(grids) }
    }

    /// Of a frame that is planned only.
    pub fn of_plan(layout: &ProbeLayout, grids: &[&ProbeGrid]) -> Self {
        Self::new(layout, grids, [0, 0], |_| 1.0)
    }

    /// Puts them into the uniform of a view's environment, whose radiance is pre-exposed.
    pub fn place(&self, uniform: &mut EnvironmentUniform, pre_exposure: f32) {
        uniform.probes = self.uniforms;
        for of in &mut uniform.probes {
            of.spacing.w *= pre_exposure;
        }
    }

    /// What pipelines know of them.
    pub fn constants(&self) -> impl Iterator<Item = Constant> + use<> {
        let constants = [(PROBE_GRIDS, self.count), (PROBE_BASES, self.bases)];
        constants.into_iter().filter(|(_, value)| *value > 0)
    }
}

impl ProbeTexels {
    /// Writes what is new of the texels of grids behind a corner of a texture.
    pub fn write(
        &mut self,
        gpu: &Gpu,
        (texture, corner): (&wgpu::Texture, [u32; 2]),
        layout: &ProbeLayout,
        grids: &[&ProbeGrid],
    ) -> PlacedProbes {
        let is_same = |((written, _), grid): (&(Arc<Vec<Probe>>, f32), &&ProbeGrid)| {
            grid.probes.as_ref().is_some_and(|probes| Arc::ptr_eq(probes, written))
        };
        if self.written.len() != grids.len() || !self.written.iter().zip(grids).all(is_same) {
            self.written.clear();
            for (grid, place) in grids.iter().zip(&layout.places) {
                let Some(probes) = &grid.probes else { continue };
                let texels = grid_texels(grid, place, probes);
                for ((width, height, texels), [x, y]) in
                    [(texels.light, place.light), (texels.distances, place.distances)]
                {
                    write(gpu, texture, [corner[0] + x, corner[1] + y], (width, height), &texels);
                }
                self.written.push((probes.clone(), texels.scale));
            }
        }
        PlacedProbes::new(layout, grids, corner, |at| self.written.get(at).map_or(0.0, |(_, scale)| *scale))
    }
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, [x, y]: [u32; 2], (width, height): (u32, u32), texels: &[[f16; 4]]) {
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x, y, z: 0 },
            aspect: wgpu::TextureAspect::All,
        },
        bytemuck::cast_slice(texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * size_of::<[f16; 4]>() as u32),
            rows_per_image: None,
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
}
