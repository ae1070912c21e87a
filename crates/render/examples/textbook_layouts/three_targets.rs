//! Normal, light vector and eye vector in camera space, which one full-screen pass makes light of.
//!
//! Source: A. Ramires, "Rendering in Multiple Passes". Differences: vectors are halves and not 8-bit colours, which
//! show as rings in highlights; the light vector keeps its length, because lights have a place; the fourth channels,
//! which are 0 there, hold the diffuse colour, and specular intensity and power are uniforms as there. A light vector
//! is that of one light, so there are as many geometry passes as lights.

use crate::content::Content;
use crate::device::{Buffers, DISPLAY, PassGeometry, Step, added_to, bind, overwritten};
use crate::layout::Layout;
use manypass::graph::{ColorLoad, DepthLoad, Export, Graph, TextureDesc};

const VECTOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth24Plus;

pub struct ThreeTargets {
    buffers: Buffers,
    geometry: wgpu::RenderPipeline,
    light: wgpu::RenderPipeline,
}

impl ThreeTargets {
    pub fn new(device: &wgpu::Device, content: &Content, aspect: f32) -> Self {
        let text = concat!(include_str!("common.wgsl"), include_str!("three_targets.wgsl"));
        let source = wgpu::ShaderSource::Wgsl(text.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("three_targets"), source });
        let geometry = Step {
            drawn: PassGeometry::Surfaces,
            vertex: "vs_geometry",
            fragment: "fs_geometry",
            targets: &[overwritten(VECTOR), overwritten(VECTOR), overwritten(VECTOR)],
            cull_mode: Some(wgpu::Face::Back),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
        };
        let light = Step {
            drawn: PassGeometry::Fullscreen,
            vertex: "vs_light",
            fragment: "fs_light",
            targets: &[added_to(DISPLAY)],
            cull_mode: None,
            depth_stencil: None,
        };
        Self {
            buffers: Buffers::new(device, content, aspect),
            geometry: geometry.pipeline(device, &module),
            light: light.pipeline(device, &module),
        }
    }
}

impl Layout for ThreeTargets {
    fn declare<'f>(&'f self, graph: &mut Graph<'f>, (width, height): (u32, u32)) -> Export {
        let desc = |format| TextureDesc::new_2d(width, height, format);
        let mut display = graph.texture("display", desc(DISPLAY));
        let mut load = ColorLoad::Clear(wgpu::Color::BLACK);
        for light in 0..self.buffers.light_count {
            // Textures of one light are done with when the next one's are written: the plan gives them the same memory.
            let targets = ["normal", "light", "eye"].map(|name| graph.texture(format!("{name}.{light}"), desc(VECTOR)));
            let depth = graph.texture(format!("depth.{light}"), desc(DEPTH));
            let mut pass = graph.pass(format!("geometry.{light}"));
            let targets = targets.map(|target| pass.color(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT)));
            pass.depth_stencil(depth, DepthLoad::Clear { depth: 1.0, stencil: 0 });
            pass.draw(move |context| {
                bind(context, &self.geometry, Some(&self.buffers.frame), &[]);
                self.buffers.draw_surfaces(context.render_pass, light);
            });

            let mut pass = graph.pass(format!("light.{light}"));
            display = pass.color(display, load);
            let [normal, towards_light, eye] = targets.map(|target| pass.read(&target));
            pass.draw(move |context| {
                let textures = [(1, normal), (2, towards_light), (3, eye)];
                bind(context, &self.light, Some(&self.buffers.frame), &textures);
                self.buffers.draw_fullscreen(context.render_pass, light);
            });
            load = ColorLoad::Keep;
        }
        graph.export(display)
    }
}
