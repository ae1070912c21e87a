//! The ground of a frame: its map on the device, and whether that is still right.

use super::Renderer;
use super::ask::ViewRequest;
use super::next::NextState;
use super::visible::{FrameScene, VisibleSet};
use crate::draws::Tile;
use crate::environment::Environment;
use crate::environment::studio::key_of_fill;
use crate::gpu::{Gpu, destroy};
use crate::ground::{Ground, GroundLight, GroundMap, map_under, side_texels};
use crate::record::InstanceTable;
use crate::request::FrameRequest;
use manypass_graph::TextureDesc;
use manypass_scene::EnvironmentLight;

/// What the renderer keeps of the ground.
#[derive(Debug)]
pub(super) struct GroundState {
    /// What the texture was drawn from.
    pub drawn: Option<(GroundMap, u64)>,
    pub texture: Option<wgpu::TextureView>,
    /// Of what the map is drawn from.
    pub instances: InstanceTable,
    /// A map, what casts shadows onto it by two versions, and the number that is found for these.
    known: Option<((GroundMap, u64, u64), u64)>,
}

impl GroundState {
    pub fn new(gpu: &Gpu) -> Self {
        Self { drawn: None, texture: None, instances: InstanceTable::new(gpu), known: None }
    }
}

/// The ground of a frame.
#[derive(Debug)]
pub(super) struct FrameGround {
    pub map: GroundMap,
    /// The broad source of the scene's picture of its environment, if there is no parallel light.
    pub broad_source: Option<EnvironmentLight>,
    pub texture: wgpu::TextureView,
    /// What the texture is to be drawn from, if it does not hold the map yet.
    pub tiles: Option<Vec<Tile>>,
}

impl Renderer {
    /// The ground of the views of a frame, of which the first that has one decides on the light.
    pub(super) fn prepare_ground(
        &mut self,
        asked: &[ViewRequest],
        lit: &[VisibleSet],
        world: &FrameScene<'_>,
        next: &mut NextState,
    ) -> Option<FrameGround> {
        let version = self.shadows.version(asked);
        let has_ground = |(asked, _): &(&ViewRequest, &VisibleSet)| asked.request.settings.ground.mode != Ground::None;
        let (asked, lit) = asked.iter().zip(lit).find(has_ground)?;
        let of_table = GroundLight::of_table(&lit.lists.table);
        let broad_source = if of_table.is_none() { self.broad_source_of(asked) } else { None };
        let of_environment = light_in_environment(broad_source.as_ref(), &asked.request);
        let light = of_table.or(of_environment).map(|GroundLight { mut parallel, .. }| {
            parallel.casts_shadows &= asked.request.settings.shadows.enabled;
            parallel
        });
        let longest_px = asked.size.0.max(asked.size.1);
        let height_m = asked.request.ground_height_m;
        let map = map_under(&world.draws.bounds_world, height_m, light, side_texels(longest_px))?;
        if !next.is_run {
            return Some(FrameGround {
                map,
                broad_source,
                texture: self.drawing.tables.no_environment.clone(),
                tiles: None,
            });
        }
        let mut instances = Vec::new();
        let of = (map, world.draws.version, version);
        let mut tiles_of = || map.tiles(&world.draws, version, &mut instances);
        let known = self.ground.known.filter(|(known, _)| *known == of).map(|(_, signature)| signature);
        let (mut tiles, signature) = match known {
            Some(signature) => (None, signature),
            None => {
                let (tiles, signature) = tiles_of();
                (Some(tiles), signature)
            }
        };
        self.ground.known = Some((of, signature));
        let desc = map.texture();
        let has_other_size = |view: &mut wgpu::TextureView| view.texture().width() != desc.width;
        if let Some(former) = self.ground.texture.take_if(has_other_size) {
            destroy(&former);
            self.ground.drawn = None;
        }
        let texture = self.ground.texture.get_or_insert_with(|| create(&self.gpu, &desc)).clone();
        if next.ground == Some((map, signature)) {
            return Some(FrameGround { map, broad_source, texture, tiles: None });
        }
        next.ground = Some((map, signature));
        let tiles = tiles.take().unwrap_or_else(|| tiles_of().0);
        next.stats.uploaded_bytes += self.ground.instances.write(&self.gpu, &instances);
        next.stats.draws += tiles.iter().map(|tile| tile.draws.len() as u32).sum::<u32>();
        Some(FrameGround { map, broad_source, texture, tiles: Some(tiles) })
    }

    /// The broad source of the picture that a view has as its environment.
    fn broad_source_of(&mut self, asked: &ViewRequest) -> Option<EnvironmentLight> {
        self.computed.broad_source(asked.environment.as_ref().filter(|_| has_picture(&asked.request))?)
    }
}

fn has_picture(request: &FrameRequest) -> bool {
    request.settings.environment.source == Environment::File
}

/// The light within that from everywhere whose shadow the ground has: a broad source of the picture that a view has as
/// its environment, or the key of the faint studio.
pub(super) fn light_in_environment(broad: Option<&EnvironmentLight>, request: &FrameRequest) -> Option<GroundLight> {
    let light = match request.settings.environment.source {
        Environment::File => *broad?,
        Environment::Fill => key_of_fill(),
        _ => return None,
    };
    let source = request.environment_light(&light)?;
    Some(GroundLight::of_broad_source(&source, request.pre_exposure()))
}

fn create(gpu: &Gpu, map: &TextureDesc) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("ground.map"),
        size: wgpu::Extent3d { width: map.width, height: map.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: map.format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}
