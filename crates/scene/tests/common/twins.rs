//! Compares the surfaces of two scenes, whatever the order of their vertices and triangles.

use glam::{Vec2, Vec3};
use manypass_scene::Scene;

/// A corner of a triangle in the world: its place, its normal and its first texture coordinates, with their transform.
type Corner = (Vec3, Vec3, Vec2);

/// All triangles, each beginning with the corner that comes first in space.
fn triangles(scene: &Scene) -> Vec<[Corner; 3]> {
    let mut triangles = Vec::new();
    for id in scene.visible_nodes() {
        let node = scene.node(id);
        let Some(mesh) = node.mesh else { continue };
        let normals_from_object = node.world_from_object.inverse().transpose();
        for primitive in &scene.meshes[mesh].primitives {
            let material = primitive.material.map(|material| &scene.materials[material]);
            let transform = material.and_then(|material| material.base_color_texture).map(|texture| texture.transform);
            let corner = |index: u32| {
                let index = index as usize;
                let position = node.world_from_object.transform_point3(primitive.positions[index].into());
                let normal = normals_from_object.transform_vector3(primitive.normals[index].into()).normalize();
                let uv = primitive.uv0.get(index).map_or(Vec2::ZERO, |uv| Vec2::from(*uv));
                (position, normal, transform.map_or(uv, |transform| transform.offset + uv * transform.scale))
            };
            for indices in primitive.indices.as_chunks::<3>().0 {
                triangles.push(indices.map(corner));
            }
        }
    }
    triangles
}

fn distance(a: &[Corner; 3], b: &[Corner; 3]) -> [f32; 3] {
    let far = |shift: usize| {
        (0..3).fold([0.0_f32; 3], |[position, normal, uv], i| {
            let ((p, n, t), (q, m, u)) = (a[i], b[(i + shift) % 3]);
            [position.max(p.distance(q)), normal.max(n.distance(m)), uv.max(t.distance(u))]
        })
    };
    [far(0), far(1), far(2)].into_iter().min_by(|a, b| a.iter().sum::<f32>().total_cmp(&b.iter().sum())).unwrap()
}

/// Every triangle of `packed` is one of `plain`, and the other way round, within `tolerance`: metres, lengths of a
/// difference of normals, units of texture coordinates.
#[track_caller]
pub fn assert_same(packed: &Scene, plain: &Scene, tolerance: [f32; 3]) {
    let (packed, plain) = (triangles(packed), triangles(plain));
    assert_eq!(packed.len(), plain.len());
    // Sorted by one coordinate of the centre, so that only neighbours need be compared.
    let key =
        |triangle: &[Corner; 3]| triangle.iter().map(|corner| corner.0.dot(Vec3::new(1.0, 0.37, 0.19))).sum::<f32>();
    let reach = 6.0 * tolerance[0];
    for (from, to) in [(&packed, &plain), (&plain, &packed)] {
        let mut sorted: Vec<(f32, &[Corner; 3])> = to.iter().map(|triangle| (key(triangle), triangle)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        for triangle in from {
            let at = key(triangle);
            let first = sorted.partition_point(|(key, _)| *key < at - reach);
            let near = sorted[first..].iter().take_while(|(key, _)| *key <= at + reach);
            let is_there = near
                .map(|(_, other)| distance(triangle, other))
                .any(|found| found.iter().zip(tolerance).all(|(found, tolerance)| *found <= tolerance));
            assert!(is_there, "{triangle:?} is in one scene alone");
        }
    }
}
