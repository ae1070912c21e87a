//! Shadow maps: which lights have them, where they lie in the atlas, and what is drawn into them.
//!
//! Source: Williams 1978, "Casting Curved Shadows on Curved Surfaces"; one atlas for all of them after Doghramachi 2015
//! ("Tile-Based Omnidirectional Shadows"). Every tile lasts from frame to frame, and is drawn again only if it changed what it
//! would show: the light, or a caster inside. The atlas and its tiles are the CPU's; `passes/shadows` draws them, and
//! `shaders/shadows.wgsl` reads them.

mod atlas;
mod casters;
mod dealing;
mod projection;
mod settings;
mod wanted;

pub use atlas::Square;
pub use dealing::Dealing;
pub use settings::{ShadowFilter, ShadowSettings};
pub use wanted::Viewer;

use crate::constants::TEXELS_PER_LIGHT;
use crate::draws::{Tile, WorldDraws};
use crate::lights::{LightTable, TableLight};
use crate::resources::Instance;
use atlas::Allocator;
use casters::{Caster, Casters, OfLight};
use dealing::Turns;
use manypass_scene::{LightKind, NodeId};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use wanted::Aim;

/// The smallest tile: less would be all border.
const SIDE_MIN: u32 = 16;

/// Whose tiles: those of a light, of directional light in a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct LightKey {
    /// A number that the view's name gives; 0 of lights whose tiles all views share.
    view: u64,
    node: NodeId,
}

impl LightKey {
    fn of(viewer: &Viewer<'_>, light: &TableLight) -> Self {
        let view = if light.kind == LightKind::Directional {
            let mut hasher = DefaultHasher::new();
            viewer.name.hash(&mut hasher);
            hasher.finish() | 1
        } else {
            0
        };
        Self { view, node: light.node }
    }
}

/// Which tile: one of a light's.
type TileKey = (LightKey, u8);

#[derive(Clone, Copy, Debug)]
struct Kept {
    square: Square,
    signature: u64,
}

/// Numbers of a frame's shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowCounts {
    /// Lights that cast shadows and have their tiles.
    pub lights: u32,
    /// Tiles that were drawn.
    pub tiles_drawn: u32,
    /// Tiles that were kept from the frames before.
    pub tiles_kept: u32,
    /// Lights that share the atlas by turns, and the number of turns.
    pub dealt: u32,
    /// Rounds of the atlas in which every light has its turn.
    pub rounds: u32,
    /// Lights within a surface that glows, which casts no shadow of theirs.
    pub in_emitters: u32,
}

/// What a view's table of lights has to know of its shadows.
#[derive(Debug, Default)]
pub struct ViewShadows {
    /// One for every light: the first of its tiles among the records of lights and tiles (0: it casts no shadow), their
    /// number, the radius of the light in metres, 0.
    pub of_light: Vec<[f32; 4]>,
    /// One for every light: by how much it is brighter in this frame, because it is dark in others.
    pub weights: Vec<f32>,
    /// Four texels a tile: the rows of its projection; the middle in texture coordinates, half the side, the side of a texel
    /// in metres. A tile without casters has no side.
    pub tiles: Vec<[f32; 4]>,
}

impl ViewShadows {
    /// The texels of the lights of `table` with what is known of their shadows, and after them the tiles.
    pub fn texels(&self, table: &LightTable) -> Vec<[f32; 4]> {
        let mut texels = table.texels.clone();
        let of_light = self.of_light.iter().zip(&self.weights);
        for (light, (shadow, weight)) in texels.chunks_exact_mut(TEXELS_PER_LIGHT as usize).zip(of_light) {
            light[TEXELS_PER_LIGHT as usize - 1] = *shadow;
            light[1].iter_mut().take(3).for_each(|intensity| *intensity *= weight);
        }
        texels.extend(&self.tiles);
        texels
    }
}

/// The shadows of a frame.
#[derive(Debug, Default)]
pub struct FrameShadows {
    /// Of each view, in their order.
    pub views: Vec<ViewShadows>,
    /// What is to be drawn.
    pub tiles: Vec<Tile>,
    /// Whether nothing that the atlas held is still of use.
    pub is_first: bool,
    /// The instances of the draws.
    pub(crate) instances: Vec<Instance>,
    /// Lights that the atlas has no place for; they shine through everything.
    pub beyond: Vec<NodeId>,
    /// Lights whose tiles are less than half as fine as the picture asks for.
    pub starved: Vec<NodeId>,
    /// Its numbers.
    pub counts: ShadowCounts,
}

/// Of every light that wants tiles: their records, and its weight in this frame.
type OfLights<'w> = BTreeMap<&'w LightKey, (Vec<[[f32; 4]; 4]>, f32)>;

/// A light with the tiles that it wants.
struct Wanting {
    key: LightKey,
    is_directional: bool,
    aims: Vec<Aim>,
    /// The demanded side.
    side: f32,
    of_light: OfLight,
    /// Of each tile, if anything casts a shadow into it.
    has_casters: Vec<bool>,
}

/// What lasts from frame to frame.
#[derive(Debug)]
pub struct Shadows {
    allocator: Allocator,
    tiles: BTreeMap<TileKey, Kept>,
}

impl Default for Shadows {
    fn default() -> Self {
        Self { allocator: Allocator::new(SIDE_MIN), tiles: BTreeMap::new() }
    }
}

impl Shadows {
    /// Forgets what the tiles hold, in an atlas of the side `side`, a power of two.
    pub fn reset(&mut self, side: u32) {
        self.allocator = Allocator::new(side);
        self.tiles.clear();
    }

    /// Forgets what the tiles hold, so that all are drawn.
    pub fn redraw(&mut self) {
        self.tiles.values_mut().for_each(|kept| kept.signature = 0);
    }

    /// The side of the atlas that `settings` allow, where textures have at most `limit` texels a side. A picture whose
    /// longer side is `longest_px` makes no use of more than four times as many, unless so many `lights` have small tiles.
    pub fn side(settings: &ShadowSettings, limit: u32, longest_px: u32, lights: usize) -> u32 {
        // Six of the second smallest size for each.
        let of_lights = (24.0 * lights as f32).sqrt() as u32 * SIDE_MIN;
        let used = longest_px.saturating_mul(4).max(of_lights).clamp(SIDE_MIN * 16, 1 << 20).next_power_of_two();
        let side = settings.atlas_px.next_power_of_two().min(used);
        if side <= limit { side } else { 1 << limit.max(1).ilog2() }
    }

    /// Gives every light its tiles, and says which are to be drawn. `version` rises whenever a mesh or a material changed.
    pub(crate) fn prepare(
        &mut self,
        world: &WorldDraws,
        version: u64,
        views: &[(Viewer<'_>, &LightTable)],
        settings: &ShadowSettings,
        dealing: Dealing,
    ) -> FrameShadows {
        let casters = Casters::new(world, version, dealing.pattern());
        let mut wanting = self.wanting(&casters, world, views, settings, dealing);
        wanting.sort_by(|a, b| b.side.total_cmp(&a.side).then_with(|| a.key.cmp(&b.key)));
        let mut frame = FrameShadows { is_first: self.tiles.is_empty(), ..FrameShadows::default() };
        let turns = if dealing.deals() { Some(self.turns(&wanting)) } else { None };
        let sides = match &turns {
            Some(turns) => turns.sides_in(dealing),
            None => self.sides(&wanting, if dealing.rounds.is_none() { settings.maps } else { u32::MAX }),
        };
        frame.counts.rounds = turns.as_ref().map_or(1, Turns::rounds);
        frame.counts.dealt = turns.as_ref().map_or(0, Turns::dealt);
        if turns.is_none() {
            let beyond = wanting.iter().zip(&sides).filter(|(_, side)| **side == 0);
            frame.beyond.extend(beyond.map(|(light, _)| light.key.node));
        }
        let placed = self.place(&wanting, &sides);
        let mut of_lights: OfLights<'_> = BTreeMap::new();
        for (at, (wanting, squares)) in wanting.iter().zip(&placed).enumerate() {
            let weight = turns.as_ref().map_or(1.0, |turns| turns.weight(at, dealing));
            let Some(squares) = squares else {
                of_lights.insert(&wanting.key, (Vec::new(), weight));
                continue;
            };
            frame.counts.lights += 1;
            frame.counts.in_emitters += u32::from(wanting.of_light.is_in_emitter);
            let side = squares.iter().flatten().map(|square| square.side).max();
            if side.is_some_and(|side| (side as f32) < 0.5 * wanting.side) {
                frame.starved.push(wanting.key.node);
            }
            let records = self.tiles_of(&casters, wanting, squares, &mut frame);
            of_lights.insert(&wanting.key, (records, weight));
        }
        frame.views = views.iter().map(|(viewer, table)| view_shadows(viewer, table, &of_lights, dealing)).collect();
        frame
    }

    /// The lights that want tiles.
    fn wanting(
        &self,
        casters: &Casters<'_>,
        world: &WorldDraws,
        views: &[(Viewer<'_>, &LightTable)],
        settings: &ShadowSettings,
        dealing: Dealing,
    ) -> Vec<Wanting> {
        let mut wanting: BTreeMap<LightKey, Wanting> = BTreeMap::new();
        let mut everywhere = None;
        let side_max = self.allocator.side();
        for (viewer, table) in views {
            for source in table.lights.iter().filter(|light| light.casts_shadows) {
                let light = &dealing.moved(source);
                let side = if light.kind == LightKind::Directional {
                    // Cascades are as fine as the picture if they have twice its pixels.
                    let side = 2 * viewer.size.0.max(viewer.size.1).next_power_of_two();
                    Some(side.min(side_max / 2) as f32)
                } else {
                    let most = if is_single(light) { side_max / 4 } else { side_max / 8 };
                    wanted::demand(light, viewer).map(|side| side.min(most as f32))
                };
                let Some(side) = side else { continue };
                let key = LightKey::of(viewer, light);
                match wanting.entry(key) {
                    Entry::Occupied(mut known) => known.get_mut().side = known.get().side.max(side),
                    Entry::Vacant(place) => {
                        let is_directional = light.kind == LightKind::Directional;
                        let (aims, of_light) = if is_directional {
                            let items = everywhere.get_or_insert_with(|| casters.everywhere().items).clone();
                            let aims = Aim::of_directional(light, viewer, &world.bounds_world, settings.cascades);
                            (aims, OfLight { items, is_in_emitter: false })
                        } else {
                            let range_m = light.range_m.unwrap_or(f32::INFINITY);
                            (Aim::of_local(light), casters.around(light.position, source.position, range_m))
                        };
                        // The smallest tile has the widest border.
                        let shows = |aim: &Aim| {
                            let projection = aim.projection(SIDE_MIN);
                            casters.in_tile(&of_light.items, &projection).next().is_some()
                        };
                        let has_casters = aims.iter().map(shows).collect();
                        place.insert(Wanting { key, is_directional, aims, side, of_light, has_casters });
                    }
                }
            }
        }
        wanting.into_values().collect()
    }

    /// Which lights always have their tiles, and whose turn comes when.
    fn turns(&self, wanting: &[Wanting]) -> Turns {
        let demanded: Vec<(u32, u32)> = wanting
            .iter()
            .map(|light| {
                let tiles = light.has_casters.iter().filter(|has| **has).count() as u32;
                ((light.side as u32).max(SIDE_MIN).next_power_of_two(), tiles)
            })
            .collect();
        Turns::new(&demanded, u64::from(self.allocator.side()).pow(2), SIDE_MIN)
    }

    /// The side of the tiles of every light, 0 where there is no place for them, or where there would be more than `most` of
    /// lights at a place. All are made smaller alike until they fit.
    fn sides(&self, wanting: &[Wanting], most: u32) -> Vec<u32> {
        let area = u64::from(self.allocator.side()).pow(2);
        let mut tiles = 0;
        // The demanded side, that which is there, and how many of them; none of a light beyond `most`.
        let demands: Vec<Option<(f32, Option<u32>, u64)>> = wanting
            .iter()
            .map(|light| {
                let kept = self.tiles.get(&(light.key, first_part(light))).map(|kept| kept.square.side);
                let count = light.has_casters.iter().filter(|has| **has).count() as u64;
                tiles += if light.is_directional { 0 } else { count };
                (tiles <= u64::from(most)).then_some((light.side, kept, count))
            })
            .collect();
        let side_of = |(demanded, kept, _): &(f32, Option<u32>, u64), shift: u32| {
            // A size is kept while it is not far off.
            let is_near = |side: &u32| (0.4..=1.1).contains(&(demanded / *side as f32));
            let steady = kept.map(|side| side << shift).filter(is_near);
            (steady.unwrap_or_else(|| (*demanded as u32).max(1).next_power_of_two()) >> shift).max(SIDE_MIN)
        };
        let needed = |demand: &(f32, Option<u32>, u64), shift| demand.2 * u64::from(side_of(demand, shift)).pow(2);
        let is_enough =
            |shift: &u32| demands.iter().flatten().map(|demand| needed(demand, *shift)).sum::<u64>() <= area;
        let shift = (0..16).find(is_enough).unwrap_or(16);
        let mut left = area;
        demands
            .iter()
            .map(|demand| {
                let Some(demand) = demand else { return 0 };
                let side = side_of(demand, shift);
                let needed = needed(demand, shift);
                let fits = needed <= left;
                left -= if fits { needed } else { 0 };
                if fits { side } else { 0 }
            })
            .collect()
    }

    /// The squares of every light's tiles, none of a tile without casters; none at all of a light that has no place.
    fn place(&mut self, wanting: &[Wanting], sides: &[u32]) -> Vec<Option<Vec<Option<Square>>>> {
        // First what stays where it is, then what is new; if that finds no gap, what nobody wants now is given up, and if that
        // does not help, everything is placed anew, which always fits.
        for attempt in 0..3 {
            match attempt {
                0 => (),
                1 => {
                    let is_wanted = |light: &Wanting, side: &u32| (*side > 0).then_some(light.key);
                    let wanted: BTreeSet<_> =
                        wanting.iter().zip(sides).filter_map(|(light, side)| is_wanted(light, side)).collect();
                    self.give_back(|key| !wanted.contains(&key.0));
                }
                _ => self.give_back(|_| true),
            }
            if let Some(placed) = self.try_place(wanting, sides) {
                return placed;
            }
        }
        vec![None; wanting.len()]
    }

    fn give_back(&mut self, is_given: impl Fn(&TileKey) -> bool) {
        let allocator = &mut self.allocator;
        self.tiles.retain(|key, kept| {
            let is_given = is_given(key);
            if is_given {
                allocator.give(kept.square);
            }
            !is_given
        });
    }

    fn try_place(&mut self, wanting: &[Wanting], sides: &[u32]) -> Option<Vec<Option<Vec<Option<Square>>>>> {
        let keys = |wanting: &Wanting, part: usize| (wanting.key, part as u8);
        // Tiles of another size make room first.
        for (light, side) in wanting.iter().zip(sides) {
            for (part, has_casters) in light.has_casters.iter().enumerate() {
                let key = keys(light, part);
                let Some(kept) = self.tiles.get(&key) else { continue };
                if !has_casters || kept.square.side != *side {
                    self.allocator.give(kept.square);
                    self.tiles.remove(&key);
                }
            }
        }
        let mut placed = Vec::with_capacity(wanting.len());
        let mut order: Vec<usize> = (0..wanting.len()).collect();
        order.sort_by_key(|at| std::cmp::Reverse(sides[*at]));
        placed.resize_with(wanting.len(), || None);
        for at in order {
            let (light, side) = (&wanting[at], sides[at]);
            if side == 0 {
                continue;
            }
            let mut squares = Vec::with_capacity(light.aims.len());
            for (part, has_casters) in light.has_casters.iter().enumerate() {
                if !has_casters {
                    squares.push(None);
                    continue;
                }
                let square = match self.tiles.entry(keys(light, part)) {
                    Entry::Occupied(kept) => kept.get().square,
                    Entry::Vacant(place) => {
                        let square = self.allocator.take(side)?;
                        place.insert(Kept { square, signature: 0 });
                        square
                    }
                };
                squares.push(Some(square));
            }
            placed[at] = Some(squares);
        }
        Some(placed)
    }

    /// The records of a light's tiles, and what of them is to be drawn.
    fn tiles_of(
        &mut self,
        casters: &Casters<'_>,
        wanting: &Wanting,
        squares: &[Option<Square>],
        frame: &mut FrameShadows,
    ) -> Vec<[[f32; 4]; 4]> {
        let atlas = self.allocator.side() as f32;
        let mut records = Vec::with_capacity(squares.len());
        for (part, (aim, square)) in wanting.aims.iter().zip(squares).enumerate() {
            let Some(square) = square else {
                let rows = aim.projection(SIDE_MIN).rows.map(|row| row.to_array());
                records.push([rows[0], rows[1], rows[2], [0.0; 4]]);
                continue;
            };
            let projection = aim.projection(square.side);
            let items: Vec<Caster> = casters.in_tile(&wanting.of_light.items, &projection).collect();
            let signature = casters.signature(&items, &projection);
            let key = (wanting.key, part as u8);
            let is_kept = self.tiles.get(&key).is_some_and(|kept| kept.signature == signature);
            if is_kept {
                frame.counts.tiles_kept += 1;
            } else {
                frame.counts.tiles_drawn += 1;
                if let Some(kept) = self.tiles.get_mut(&key) {
                    kept.signature = signature;
                }
                let draws = casters.draws(&items, &projection, &mut frame.instances);
                let Square { x, y, side } = *square;
                frame.tiles.push(Tile { rectangle: [x, y, side, side], draws });
            }
            let half = 0.5 * square.side as f32;
            let place =
                [(square.x as f32 + half) / atlas, (square.y as f32 + half) / atlas, half / atlas, projection.texel_m];
            let [x, y, z] = projection.rows.map(|row| row.to_array());
            records.push([x, y, z, place]);
        }
        records
    }
}

/// Whether one tile shows all that the light reaches.
fn is_single(light: &TableLight) -> bool {
    matches!(light.kind, LightKind::Spot { .. }) && Aim::of_local(light).len() == 1
}

/// The first of a light's tiles that has casters.
fn first_part(wanting: &Wanting) -> u8 {
    wanting.has_casters.iter().position(|has| *has).unwrap_or(0) as u8
}

fn view_shadows(viewer: &Viewer<'_>, table: &LightTable, of_lights: &OfLights<'_>, dealing: Dealing) -> ViewShadows {
    let mut shadows = ViewShadows::default();
    for light in &table.lights {
        let known = of_lights.get(&LightKey::of(viewer, light)).filter(|_| light.casts_shadows);
        let (records, weight) = known.map_or((&[][..], 1.0), |(records, weight)| (&records[..], *weight));
        let first = if records.is_empty() { 0 } else { table.len() as usize + shadows.tiles.len() / 4 };
        // What shines from its points in turn is as small as a point in each of them.
        let radius_m = if dealing.moves() { 0.0 } else { light.radius_m };
        shadows.of_light.push([first as f32, records.len() as f32, radius_m, 0.0]);
        shadows.weights.push(weight);
        shadows.tiles.extend(records.iter().flatten());
    }
    shadows
}
