//! Prepared draws, encoded into a pass or a bundle.

use super::prepared::{Chunk, Command, Vertices};
use crate::record::{Frame, PreparedView};
use crate::resources::Geometry;
use std::ops::Range;

/// What commands are encoded into: a pass, or a bundle.
pub(super) trait Encoder<'e> {
    fn pipeline(&mut self, pipeline: &'e wgpu::RenderPipeline);
    fn group(&mut self, index: u32, group: &'e wgpu::BindGroup);
    fn vertices(&mut self, slot: u32, buffer: wgpu::BufferSlice<'e>);
    fn indices(&mut self, buffer: wgpu::BufferSlice<'e>);
    fn draw(&mut self, elements: Range<u32>, instances: Range<u32>, is_indexed: bool);
}

macro_rules! encoders {
    ($life:lifetime: $($encoder:ty),*) => {
        $(impl<$life> Encoder<$life> for $encoder {
            fn pipeline(&mut self, pipeline: &$life wgpu::RenderPipeline) {
                self.set_pipeline(pipeline);
            }

            fn group(&mut self, index: u32, group: &$life wgpu::BindGroup) {
                self.set_bind_group(index, group, &[]);
            }

            fn vertices(&mut self, slot: u32, buffer: wgpu::BufferSlice<$life>) {
                self.set_vertex_buffer(slot, buffer);
            }

            fn indices(&mut self, buffer: wgpu::BufferSlice<$life>) {
                self.set_index_buffer(buffer, wgpu::IndexFormat::Uint32);
            }

            fn draw(&mut self, elements: Range<u32>, instances: Range<u32>, is_indexed: bool) {
                if is_indexed {
                    self.draw_indexed(elements, 0, instances);
                } else {
                    <$encoder>::draw(self, elements, instances);
                }
            }
        })*
    };
}

encoders!('e: wgpu::RenderPass<'_>, wgpu::RenderBundleEncoder<'e>);

/// Encodes a chunk, whatever was bound before.
pub(super) fn encode<'e>(
    chunk: &'e Chunk,
    encoder: &mut impl Encoder<'e>,
    frame: &'e Frame<'_>,
    view: &'e PreparedView,
) {
    let geometry = &frame.resources.geometry;
    encoder.group(0, &view.group);
    for command in &chunk.commands {
        match command {
            Command::Bound(bound) => {
                encoder.pipeline(&bound.pipeline.pipeline);
                bound.pass.iter().for_each(|group| encoder.group(1, group));
                bound.object.iter().for_each(|group| encoder.group(3, group));
            }
            Command::Material(group) => encoder.group(2, group),
            Command::Vertices(vertices) => bind_vertices(encoder, geometry, vertices, &view.instances),
            Command::IndexPage(page) => {
                if let Some(buffer) = geometry.indices.buffer(*page as usize) {
                    encoder.indices(buffer.slice(..));
                }
            }
            Command::Draw { elements, instances, is_indexed } => {
                encoder.draw(elements.clone(), instances.clone(), *is_indexed);
            }
        }
    }
}

/// Binds vertices, then skins if there are some, then instances: as the buffers of pipelines follow each other.
fn bind_vertices<'e>(
    encoder: &mut impl Encoder<'e>,
    geometry: &'e Geometry,
    vertices: &Vertices,
    instances: &'e wgpu::Buffer,
) {
    let mut slot = 0;
    let mut bind = |buffer: Option<wgpu::BufferSlice<'e>>| {
        if let Some(buffer) = buffer {
            encoder.vertices(slot, buffer);
            slot += 1;
        }
    };
    match vertices {
        Vertices::Page(page) => bind(geometry.vertices.buffer(*page as usize).map(|buffer| buffer.slice(..))),
        Vertices::Apart(places) => {
            bind(geometry.vertices.slice(&places.0));
            bind(places.1.as_ref().and_then(|skin| geometry.skins.slice(skin)));
        }
    }
    bind(Some(instances.slice(..)));
}
