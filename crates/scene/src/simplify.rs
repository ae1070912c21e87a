//! Coarser forms of meshes, made by collapsing edges where that changes shape, normals and texture coordinates least.
//!
//! Source: quadric error metrics (Garland & Heckbert 1997), with attributes (Hoppe 1999), as meshoptimizer has them. An
//! edge collapses onto one of its ends, so that every level is another list of triangles between the vertices that are
//! there already: skins, colours and all else of a vertex stay as they are, and a level takes no memory but its
//! indices.

mod stored;
mod wanted;

use crate::{Cache, Mesh, Primitive, PrimitiveLevel, Scene};
use glam::Vec2;
use meshoptimizer_rs::{
    Attributes, Error, Limits, Positions, SimplifyOptions, SimplifySettings, VertexFlags, Workspace, simplify_scale,
    simplify_with_attributes,
};
use std::collections::HashMap;
use std::sync::Arc;
use wanted::{TRIANGLES_MIN, is_wanted};

/// Each level has so much of the triangles of the one before, if that is possible.
const SHARE: f32 = 0.5;
/// What leaves more of them is no level.
const SHARE_MAX: f32 = 0.8;
/// The last level may differ by so much of the mesh's size.
const ERROR_MAX: f32 = 0.1;
/// What a vertex counts: normals, texture coordinates and colours. Errors are shares of the mesh's size: where that is
/// 40 pixels, a turn of a normal by 1.4 degrees counts as much as one pixel. With half of that, a switch at a pixel was
/// seen by a FLIP of more than 0.02.
const NORMAL_WEIGHT: f32 = 1.0;
const COLOR_WEIGHT: f32 = 0.25;
/// Texture coordinates that are as far apart as the mesh's reach count as much as positions that are.
const UV_WEIGHT: f32 = 1.0;
/// Normals, two sets of texture coordinates, colours.
const COMPONENTS: usize = 3 + 2 + 2 + 4;

/// The bits of a position, which tell whether two vertices lie at one place.
type Place = [u32; 3];

fn place(position: &[f32; 3]) -> Place {
    // Both zeros are one place.
    position.map(|x| (x + 0.0).to_bits())
}

impl Scene {
    /// Gives every mesh of triangles coarser levels ([`Primitive::levels`]), each of about half the triangles of the
    /// one before; those that have some keep them. Meshes with morph targets have none, because no level knows where
    /// they move. Says what could not be simplified; those meshes stay as they are.
    pub fn simplify(&mut self) -> Vec<String> {
        self.simplify_with(None)
    }

    /// As [`Self::simplify`]. What `cache` has of the same meshes is taken from there, and what it lacks is put there.
    pub fn simplify_with(&mut self, cache: Option<&dyn Cache>) -> Vec<String> {
        let wanted: Vec<usize> =
            (0..self.meshes.len()).filter(|mesh| self.meshes[*mesh].primitives.iter().any(is_wanted)).collect();
        let mut warnings = Vec::new();
        for (mesh, made) in levels_from(cache, &self.meshes, &wanted) {
            match made {
                Ok(levels) if levels.iter().any(|levels| !levels.is_empty()) => {
                    let primitives = &mut Arc::make_mut(&mut self.meshes[mesh]).primitives;
                    let of_primitives = primitives.iter_mut().zip(levels);
                    of_primitives
                        .filter(|(_, levels)| !levels.is_empty())
                        .for_each(|(primitive, levels)| primitive.levels = levels);
                }
                Ok(_) => {}
                Err(error) => {
                    warnings.push(format!("mesh {mesh} \"{}\" cannot be simplified: {error}", self.meshes[mesh].name))
                }
            }
        }
        warnings
    }
}

type LevelsResult = Result<Vec<Vec<PrimitiveLevel>>, Error>;

/// The levels of the wanted meshes, all from a cache or made anew.
fn levels_from(cache: Option<&dyn Cache>, meshes: &[Arc<Mesh>], wanted: &[usize]) -> Vec<(usize, LevelsResult)> {
    let cache = cache.filter(|_| !wanted.is_empty()).map(|cache| (cache, stored::name_of(meshes, wanted)));
    let entry = cache.as_ref().and_then(|(cache, name)| cache.get(name));
    if let Some(known) = entry.and_then(|entry| stored::levels_of(&entry, meshes, wanted)) {
        return wanted.iter().copied().zip(known.into_iter().map(Ok)).collect();
    }
    let made = levels_of_all(meshes, wanted);
    let whole: Option<Vec<_>> = made.iter().map(|(_, made)| made.as_ref().ok()).collect();
    // What fails shall say so again.
    if let (Some((cache, name)), Some(whole)) = (cache, whole) {
        cache.put(&name, &stored::entry(whole.into_iter()));
    }
    made
}

#[cfg(target_arch = "wasm32")]
fn levels_of_all(meshes: &[Arc<Mesh>], wanted: &[usize]) -> Vec<(usize, LevelsResult)> {
    let mut workspace = workspace();
    wanted.iter().map(|mesh| (*mesh, levels_of(&meshes[*mesh], &mut workspace))).collect()
}

/// The levels of the wanted meshes, of several at a time.
#[cfg(not(target_arch = "wasm32"))]
fn levels_of_all(meshes: &[Arc<Mesh>], wanted: &[usize]) -> Vec<(usize, LevelsResult)> {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let next = AtomicUsize::new(0);
    let work = || {
        let (mut workspace, mut made) = (workspace(), Vec::new());
        while let Some(mesh) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
            made.push((*mesh, levels_of(&meshes[*mesh], &mut workspace)));
        }
        made
    };
    let helpers = std::thread::available_parallelism().map_or(1, usize::from).min(4).min(wanted.len());
    let mut all = std::thread::scope(|scope| {
        let spawn = |_| std::thread::Builder::new().spawn_scoped(scope, work).ok();
        let spawned: Vec<_> = (1..helpers).filter_map(spawn).collect();
        let mut all = work();
        spawned.into_iter().for_each(|helper| all.extend(helper.join().unwrap_or_default()));
        all
    });
    // Whichever was done first, warnings stand in the order of the meshes.
    all.sort_by_key(|(mesh, _)| *mesh);
    all
}

/// At most 1 GiB and, for a million triangles, a hundredfold of the work that they take.
fn workspace() -> Workspace {
    Workspace::new(Limits::default())
}

/// The levels of every primitive of a mesh.
fn levels_of(mesh: &Mesh, workspace: &mut Workspace) -> LevelsResult {
    // Where primitives meet, no gap may open between different levels of them.
    let mut owners: HashMap<Place, usize> = HashMap::new();
    let mut shared: Vec<Place> = Vec::new();
    if mesh.primitives.len() > 1 {
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            for position in &primitive.positions {
                if *owners.entry(place(position)).or_insert(index) != index {
                    shared.push(place(position));
                }
            }
        }
    }
    let shared = shared.into_iter().collect();
    let made = mesh.primitives.iter().map(|primitive| {
        if is_wanted(primitive) { levels_of_primitive(primitive, &shared, workspace) } else { Ok(Vec::new()) }
    });
    made.collect()
}

fn levels_of_primitive(
    primitive: &Primitive,
    shared: &std::collections::HashSet<Place>,
    workspace: &mut Workspace,
) -> Result<Vec<PrimitiveLevel>, Error> {
    let positions = Positions::from_packed(&primitive.positions);
    let count = primitive.positions.len();
    let flags = flags(primitive, shared);
    let values = attributes(primitive);
    let attributes = Attributes::from_interleaved(&values, count, COMPONENTS, COMPONENTS, 0)?;
    let options = SimplifyOptions::ERROR_ABSOLUTE | SimplifyOptions::PERMISSIVE;
    let most_m = ERROR_MAX * simplify_scale(positions)?;
    let all = || (0..count as u32).collect();
    let mut indices: Vec<u32> = if primitive.indices.is_empty() { all() } else { primitive.indices.clone() };
    indices.truncate(indices.len() / 3 * 3);
    let (mut levels, mut error_m) = (Vec::new(), 0.0);
    while indices.len() >= 6 * TRIANGLES_MIN {
        let target_index_count = (indices.len() as f32 / 3.0 * SHARE) as usize * 3;
        let settings = SimplifySettings { target_index_count, target_error: most_m, options };
        let made =
            simplify_with_attributes(&indices, positions, attributes, &WEIGHTS, Some(&flags), settings, workspace)?;
        // Of a level that is made from another one, errors add up at most.
        error_m += made.error;
        if made.indices.len() < 3 * TRIANGLES_MIN
            || made.indices.len() as f32 > SHARE_MAX * indices.len() as f32
            || error_m > most_m
        {
            break;
        }
        indices = made.indices;
        levels.push(PrimitiveLevel { indices: indices.clone(), error_m });
    }
    Ok(levels)
}

/// What counts is in the values themselves.
const WEIGHTS: [f32; COMPONENTS] = [1.0; COMPONENTS];

/// Normals, texture coordinates and colours of every vertex, each times what it counts.
fn attributes(primitive: &Primitive) -> Vec<f32> {
    let extent = |uvs: &[[f32; 2]]| {
        let bounds = uvs
            .iter()
            .map(|uv| Vec2::from(*uv))
            .fold((Vec2::MAX, Vec2::MIN), |(low, high), uv| (low.min(uv), high.max(uv)));
        (bounds.1 - bounds.0).max_element()
    };
    let uv_weight = |uvs: &[[f32; 2]]| UV_WEIGHT / extent(uvs).max(1e-6);
    let (uv0_weight, uv1_weight) = (uv_weight(&primitive.uv0), uv_weight(&primitive.uv1));
    let mut values = Vec::with_capacity(primitive.positions.len() * COMPONENTS);
    for i in 0..primitive.positions.len() {
        values.extend(primitive.normals.get(i).copied().unwrap_or_default().map(|x| NORMAL_WEIGHT * x));
        values.extend(primitive.uv0.get(i).copied().unwrap_or_default().map(|x| uv0_weight * x));
        values.extend(primitive.uv1.get(i).copied().unwrap_or_default().map(|x| uv1_weight * x));
        values.extend(primitive.colors.get(i).copied().unwrap_or_default().map(|x| COLOR_WEIGHT * x));
    }
    values
}

/// Vertices stay where other primitives have some, and along seams of textures and colours. Edges between normals may
/// go: their weight says how much that costs.
fn flags(primitive: &Primitive, shared: &std::collections::HashSet<Place>) -> Vec<VertexFlags> {
    type AttributeBits = ([Option<[u32; 2]>; 2], Option<[u32; 4]>);
    let seen_at = |i: usize| -> AttributeBits {
        let uv = |uvs: &[[f32; 2]]| uvs.get(i).map(|uv| uv.map(f32::to_bits));
        ([uv(&primitive.uv0), uv(&primitive.uv1)], primitive.colors.get(i).map(|color| color.map(f32::to_bits)))
    };
    let mut first: HashMap<Place, (usize, bool)> = HashMap::new();
    for (i, position) in primitive.positions.iter().enumerate() {
        let (known, differs) = first.entry(place(position)).or_insert((i, false));
        *differs |= seen_at(*known) != seen_at(i);
    }
    let flag = |position: &[f32; 3]| {
        let place = place(position);
        if shared.contains(&place) {
            VertexFlags::LOCK
        } else if first.get(&place).is_some_and(|(_, differs)| *differs) {
            VertexFlags::PROTECT
        } else {
            VertexFlags::EMPTY
        }
    };
    primitive.positions.iter().map(flag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Topology, primitives};
    use glam::Vec3;

    fn scene_of(primitives: Vec<Primitive>) -> Scene {
        Scene { meshes: vec![Mesh { primitives, ..Mesh::default() }.into()], ..Scene::default() }
    }

    /// How far the middles of a level's triangles are from the surface of a ball, at most.
    fn farthest_from_ball_m(primitive: &Primitive, indices: &[u32], radius_m: f32) -> f32 {
        let corner = |index: &u32| Vec3::from(primitive.positions[*index as usize]);
        let distance_m = |triangle: &[u32]| {
            let middle: Vec3 = triangle.iter().map(corner).sum::<Vec3>() / 3.0;
            (middle.length() - radius_m).abs()
        };
        indices.chunks_exact(3).map(distance_m).fold(0.0, f32::max)
    }

    #[test]
    fn levels_halve_and_say_how_far_they_are_off() {
        let mut scene = scene_of(vec![primitives::uv_sphere(2.0, 96, 48)]);
        assert_eq!(scene.simplify(), [""; 0]);
        let primitive = &scene.meshes[0].primitives[0];
        assert!(primitive.levels.len() >= 5, "{}", primitive.levels.len());
        let (mut count, mut error_m) = (primitive.indices.len(), 0.0);
        for level in &primitive.levels {
            println!(
                "{} triangles, {} m, found {}",
                level.indices.len() / 3,
                level.error_m,
                farthest_from_ball_m(primitive, &level.indices, 2.0)
            );
            assert!(level.indices.len() as f32 <= SHARE_MAX * count as f32 && level.error_m >= error_m);
            assert!(level.indices.iter().all(|index| (*index as usize) < primitive.positions.len()));
            // Quadrics are means over what is near: here the farthest triangle is off by up to 1.6 times as much.
            assert!(farthest_from_ball_m(primitive, &level.indices, 2.0) <= 2.0 * level.error_m);
            (count, error_m) = (level.indices.len(), level.error_m);
        }
        // Once more changes nothing.
        let before = Arc::as_ptr(&scene.meshes[0]);
        scene.simplify();
        assert_eq!(Arc::as_ptr(&scene.meshes[0]), before);
    }

    type Entries = HashMap<String, Vec<u8>>;

    /// What was put there, and how often something was looked for and found.
    #[derive(Debug, Default)]
    struct MemoryCache(std::sync::Mutex<(Entries, [u32; 2])>);

    impl Cache for MemoryCache {
        fn get(&self, name: &str) -> Option<Vec<u8>> {
            let (kept, [asked, found]) = &mut *self.0.lock().unwrap();
            let entry = kept.get(name).cloned();
            (*asked, *found) = (*asked + 1, *found + u32::from(entry.is_some()));
            entry
        }

        fn put(&self, name: &str, bytes: &[u8]) {
            self.0.lock().unwrap().0.insert(name.to_owned(), bytes.to_vec());
        }
    }

    #[test]
    fn levels_of_a_cache_are_those_that_were_made() {
        let kept = MemoryCache::default();
        let scene = |segments: u32| {
            let mut scene = scene_of(vec![primitives::uv_sphere(2.0, 2 * segments, segments)]);
            scene.meshes.push(scene_of(vec![primitives::cube(Vec3::ONE)]).meshes.remove(0));
            scene
        };
        let simplified = |segments: u32| {
            let mut scene = scene(segments);
            assert_eq!(scene.simplify_with(Some(&kept)), [""; 0]);
            scene.meshes
        };
        let mut plain = scene(32);
        plain.simplify();
        for (asked, found) in [(1, 0), (2, 1)] {
            assert!(simplified(32) == plain.meshes);
            assert_eq!(kept.0.lock().unwrap().1, [asked, found]);
        }
        // Another mesh is another entry, and a broken entry none.
        simplified(33);
        assert_eq!(kept.0.lock().unwrap().1, [3, 1]);
        kept.0.lock().unwrap().0.values_mut().for_each(|entry| entry[40] ^= 1);
        assert!(simplified(32) == plain.meshes);
        assert!(simplified(32) == plain.meshes);
        assert_eq!(kept.0.lock().unwrap().1, [5, 3]);
        // What has nothing to simplify asks nobody.
        let mut cube = scene_of(vec![primitives::cube(Vec3::ONE)]);
        cube.simplify_with(Some(&kept));
        assert_eq!(kept.0.lock().unwrap().1, [5, 3]);
    }

    #[test]
    fn a_flat_surface_costs_nothing_and_its_texture_does() {
        let grid = |bend: f32| {
            let mut primitive = Primitive::default();
            for i in 0..33 * 33 {
                let (x, y) = ((i % 33) as f32 / 32.0, (i / 33) as f32 / 32.0);
                primitive.positions.push([x, 0.0, y]);
                primitive.normals.push([0.0, 1.0, 0.0]);
                primitive.uv0.push([x + bend * (9.0 * x).sin() * (8.0 * y).cos(), y]);
            }
            for i in 0..32 * 32 {
                let at = (i / 32 * 33 + i % 32) as u32;
                primitive.indices.extend([at, at + 33, at + 1, at + 1, at + 33, at + 34]);
            }
            scene_of(vec![primitive])
        };
        let last = |mut scene: Scene| {
            scene.simplify();
            scene.meshes[0].primitives[0].levels.last().map(|level| (level.indices.len() / 3, level.error_m))
        };
        let (triangles, error_m) = last(grid(0.0)).unwrap();
        assert!(triangles < 100 && error_m < 5e-3, "{triangles} triangles, {error_m} m");
        let (_, bent_error_m) = last(grid(0.1)).unwrap();
        assert!(bent_error_m > 1e-2, "{bent_error_m} m");
    }

    #[test]
    fn no_gap_opens_between_primitives() {
        // Two halves of one ball.
        let ball = primitives::uv_sphere(1.0, 64, 32);
        let half = |is_upper: bool| {
            let is_there = |triangle: &&[u32]| {
                let height: f32 = triangle.iter().map(|index| ball.positions[*index as usize][1]).sum();
                (height > 0.0) == is_upper
            };
            let indices = ball.indices.chunks_exact(3).filter(is_there).flatten().copied().collect();
            Primitive { indices, ..ball.clone() }
        };
        let mut scene = scene_of(vec![half(true), half(false)]);
        // Every vertex is in both, but those alone that both draw may stay.
        let compact = |primitive: &mut Primitive| {
            let used: std::collections::BTreeSet<u32> = primitive.indices.iter().copied().collect();
            let new: HashMap<u32, u32> = used.iter().copied().zip(0..).collect();
            primitive.indices.iter_mut().for_each(|index| *index = new[index]);
            let pick = |values: &[[f32; 3]]| used.iter().map(|at| values[*at as usize]).collect::<Vec<_>>();
            (primitive.positions, primitive.normals) = (pick(&primitive.positions), pick(&primitive.normals));
            (primitive.uv0, primitive.tangents) = (Vec::new(), Vec::new());
        };
        Arc::make_mut(&mut scene.meshes[0]).primitives.iter_mut().for_each(compact);
        scene.simplify();
        let equator = |primitive: &Primitive, indices: &[u32]| {
            let is_on = |position: &&[f32; 3]| position[1].abs() < 1e-4;
            let positions = indices.iter().map(|index| &primitive.positions[*index as usize]);
            positions.filter(is_on).map(place).collect::<std::collections::BTreeSet<Place>>()
        };
        for primitive in &scene.meshes[0].primitives {
            let all = equator(primitive, &primitive.indices);
            assert!(all.len() >= 64 && primitive.levels.len() >= 2, "{} {}", all.len(), primitive.levels.len());
            for level in &primitive.levels {
                assert_eq!(equator(primitive, &level.indices), all);
            }
        }
    }

    #[test]
    fn what_is_broken_or_moved_by_targets_stays_as_it_is() {
        let ball = primitives::uv_sphere(1.0, 64, 32);
        let mut broken = ball.clone();
        broken.positions[7] = [f32::NAN; 3];
        let warnings = scene_of(vec![broken]).simplify();
        assert!(warnings[0].starts_with("mesh 0 \"\" cannot be simplified: "), "{warnings:?}");
        let mut morphed = ball.clone();
        morphed.morph_targets.push(Default::default());
        let mut lines = ball.clone();
        lines.topology = Topology::Lines;
        let mut scene = scene_of(vec![morphed, lines, primitives::cube(Vec3::ONE)]);
        assert_eq!(scene.simplify(), [""; 0]);
        assert!(scene.meshes[0].primitives.iter().all(|primitive| primitive.levels.is_empty()));
    }
}
