//! Scenes of a few surfaces, and what a bake found of them.
#![allow(dead_code, reason = "each test uses some of it")]

use glam::Vec3;
use manypass_bake::{BakeSettings, BakedMaps, DistantLight, LayoutSettings};
use manypass_scene::material::Specular;
use manypass_scene::{Material, Mesh, Node, Primitive, Scene, TexturedFactor};
use std::sync::Arc;

/// A surface that scatters `reflectance` of all light, and gives `emission`.
pub fn matte(reflectance: f32, emission: f32) -> Material {
    Material {
        base_color_factor: Vec3::splat(reflectance).extend(1.0),
        metallic_factor: 0.0,
        emissive_factor: Vec3::splat(emission),
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        ..Material::default()
    }
}

/// Puts a primitive into a scene, by a node of its own.
pub fn add(scene: &mut Scene, mut primitive: Primitive, material: Material, node: Node) {
    primitive.material = Some(scene.materials.len());
    scene.materials.push(material);
    let mesh = scene.meshes.len();
    scene.meshes.push(Arc::new(Mesh { primitives: vec![primitive], ..Mesh::default() }));
    scene.add_node(None, Node { mesh: Some(mesh), ..node });
    scene.update_transforms();
}

/// Settings of a bake.
pub fn settings(texels_per_m: f32, samples: u32, bounces: u32) -> BakeSettings {
    let layout = LayoutSettings { texels_per_m, ..LayoutSettings::default() };
    BakeSettings { layout, samples, bounces, ..BakeSettings::default() }
}

/// What a bake finds.
pub fn bake(scene: &Scene, around: Option<&dyn DistantLight>, settings: &BakeSettings) -> BakedMaps {
    manypass_bake::bake(scene, around, settings, &()).expect("it bakes")
}

/// The texels within the triangles of a primitive by the middle of each triangle, weighted by nothing: their mean.
pub fn mean(maps: &BakedMaps, which: usize) -> f32 {
    let of = &maps.layout.unwrapped[which];
    let centers = of.indices.chunks_exact(3).map(|corners| {
        let uv = corners.iter().map(|corner| of.vertices[*corner as usize].1).sum::<glam::Vec2>() / 3.0;
        at(maps, of.page, uv)
    });
    let centers: Vec<f32> = centers.collect();
    centers.iter().sum::<f32>() / centers.len() as f32
}

/// The red of the texel at a place.
pub fn at(maps: &BakedMaps, page: u32, uv: glam::Vec2) -> f32 {
    maps.light[texel(maps, page, uv)][0]
}

/// The texel at a place.
pub fn texel(maps: &BakedMaps, page: u32, uv: glam::Vec2) -> usize {
    let (width, height) = (maps.layout.width as usize, maps.layout.height as usize);
    let (x, y) = ((uv.x * width as f32) as usize, (uv.y * height as f32) as usize);
    (page as usize * height + y.min(height - 1)) * width + x.min(width - 1)
}
