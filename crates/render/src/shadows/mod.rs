//! Shadow maps: which lights have them, where they lie in the atlas, and what is drawn into them.
//!
//! Source: Williams 1978, "Casting Curved Shadows on Curved Surfaces"; one atlas for all of them after Doghramachi 2015
//! ("Tile-Based Omnidirectional Shadows"). Every tile lasts from frame to frame, and is drawn again only if it changed
//! what it would show: the light, or a caster inside. The atlas and its tiles are the CPU's; `passes/shadows` draws
//! them, and `shaders/shadows.wgsl` reads them.

mod atlas;
mod cascades;
mod casters;
mod column;
mod dealing;
mod demand;
mod placing;
mod projection;
mod room;
mod settings;
mod still;

pub use atlas::Square;
pub use dealing::Dealing;
pub(crate) use demand::AROUND_DIRECTIONAL_PX;
pub use demand::Viewer;
pub(crate) use projection::{TileProjection, looking_along};
pub use settings::{ShadowFilter, ShadowSettings};

use crate::constants::TEXELS_PER_LIGHT;
use crate::draws::{Draw, Tile, WorldDraws};
use crate::levels::Chooser;
use crate::lights::{LightTable, TableLight};
use crate::resources::Instance;
use atlas::Allocator;
use casters::{Caster, Casters, OfLight};
use dealing::Turns;
use demand::TileDemand;
use manypass_scene::{LightKind, NodeId};
use placing::CachedTile;
use room::Room;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use still::{ShadowInputs, StillShadows};

/// The smallest tile: less would be all border.
const SIDE_MIN: u32 = 16;

/// Whose tiles: those of a light, of directional light in a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct LightKey {
    /// A number that the view's name gives; 0 of lights whose tiles all views share.
    view: u64,
    /// None of the light of the environment.
    node: Option<NodeId>,
}

impl LightKey {
    fn of(viewer: &Viewer<'_>, light: &TableLight) -> Self {
        let view = if light.kind == LightKind::Directional {
            let mut hasher = DefaultHasher::new();
            // Whatever is around places has the same.
            if viewer.is_around { "around" } else { viewer.name }.hash(&mut hasher);
            viewer.is_around.hash(&mut hasher);
            hasher.finish() | 1
        } else {
            0
        };
        Self { view, node: light.node }
    }
}

/// Which tile: one of a light's.
type TileKey = (LightKey, u8);

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
#[derive(Clone, Debug, Default)]
pub struct ViewShadows {
    /// One for every light: the first of its tiles among the records of lights and tiles (0: it casts no shadow), their
    /// number, the radius of the light in metres, 1 if light fades in where they end.
    pub of_light: Vec<[f32; 4]>,
    /// One for every light: by how much it is brighter in this frame, because it is dark in others.
    pub weights: Vec<f32>,
    /// Four texels a tile: the rows of its projection; the middle in texture coordinates, half the side, the side of a
    /// texel in metres. A tile without casters has no side.
    pub tiles: Vec<[f32; 4]>,
}

impl ViewShadows {
    /// Whether none of the first lights, which are directional, has more than one cascade.
    pub fn has_one_cascade(&self, directional_count: u32) -> bool {
        self.of_light.iter().take(directional_count as usize).all(|[_, tiles, _, fades]| *tiles <= 1.0 && *fades == 0.0)
    }

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
    /// Lights that the atlas has no place for; they shine through everything. That of the environment has no node.
    pub beyond: Vec<Option<NodeId>>,
    /// Lights whose tiles are less than half as fine as the picture asks for.
    pub starved: Vec<Option<NodeId>>,
    /// Its numbers.
    pub counts: ShadowCounts,
}

/// Of every light that wants tiles: their records, and its weight in this frame.
type OfLights<'w> = BTreeMap<&'w LightKey, (Vec<[[f32; 4]; 4]>, f32)>;

/// What lasts from frame to frame.
#[derive(Clone, Debug)]
pub struct Shadows {
    /// The atlas may grow to that.
    side_max: u32,
    allocator: Allocator,
    tiles: BTreeMap<TileKey, CachedTile>,
    /// Whether nothing was drawn into the atlas yet.
    is_empty: bool,
    /// Whether live frames had room for finer maps.
    room: Room,
    /// The shadows of the last frame, if the next one has the same.
    still: Option<Arc<StillShadows>>,
}

impl Default for Shadows {
    fn default() -> Self {
        Self {
            side_max: SIDE_MIN,
            allocator: Allocator::new(SIDE_MIN),
            tiles: BTreeMap::new(),
            is_empty: true,
            room: Room::default(),
            still: None,
        }
    }
}

impl Shadows {
    /// Lets the atlas grow to the side `side_max`, a power of two. Where it was allowed another one, what the tiles
    /// hold is forgotten.
    pub fn allow(&mut self, side_max: u32) {
        if self.side_max != side_max {
            self.side_max = side_max;
            self.room = Room::default();
            self.reset(SIDE_MIN);
        }
    }

    /// The side of the atlas, which has as much room as lights have wanted so far.
    pub fn atlas_side(&self) -> u32 {
        self.allocator.side()
    }

    fn reset(&mut self, side: u32) {
        self.allocator = Allocator::new(side);
        self.tiles.clear();
        self.is_empty = true;
        self.still = None;
    }

    /// Makes room for tiles of these `sides`. What the tiles hold is forgotten if the atlas has to grow for them.
    fn grow(&mut self, demands: &[TileDemand], sides: &[u32]) {
        let tiles = demands.iter().zip(sides).map(|(light, side)| (light.tile_count(), u64::from(*side)));
        let area: u64 = tiles.map(|(count, side)| count * side * side).sum();
        let side = SIDE_MIN << (0..16).find(|shift| u64::from(SIDE_MIN << shift).pow(2) >= area).unwrap_or(16);
        if side > self.allocator.side() {
            self.reset(side.min(self.side_max));
        }
    }

    /// Forgets what the tiles hold, so that all are drawn.
    pub fn redraw(&mut self) {
        self.still = None;
        self.tiles.values_mut().for_each(|kept| kept.signature = 0);
    }

    /// The largest side of the atlas that `settings` allow, where textures have at most `limit` texels a side. A
    /// picture whose longer side is `longest_px` makes no use of more than four times as many, unless so many `lights`
    /// have small tiles, or the settings say how large tiles are.
    pub fn side_allowed(settings: &ShadowSettings, limit: u32, longest_px: u32, lights: usize) -> u32 {
        // Six of the second smallest size for each.
        let of_lights = (24.0 * lights as f32).sqrt() as u32 * SIDE_MIN;
        let used = longest_px
            .max(settings.map_px)
            .saturating_mul(4)
            .max(of_lights)
            .clamp(SIDE_MIN * 16, 1 << 20)
            .next_power_of_two();
        let side = settings.atlas_px.next_power_of_two().min(used);
        if side <= limit { side } else { 1 << limit.max(1).ilog2() }
    }

    /// Gives every light its tiles, and says which are to be drawn. `version` rises whenever a mesh or a material
    /// changed.
    pub(crate) fn prepare(
        &mut self,
        (world, chooser): (&WorldDraws, Option<&Chooser>),
        version: u64,
        views: &[(Viewer<'_>, &LightTable)],
        settings: &ShadowSettings,
        dealing: Dealing,
    ) -> FrameShadows {
        let inputs = ShadowInputs { world, chooser, version, views, settings, dealing };
        if let Some(frame) = self.still.as_ref().and_then(|still| still.frame(&inputs)) {
            return frame;
        }
        let before = (self.tiles.clone(), self.room, self.is_empty);
        let frame = self.prepare_anew(&inputs);
        let is_still =
            frame.tiles.is_empty() && before.0 == self.tiles && (before.1, before.2) == (self.room, self.is_empty);
        self.still = is_still.then(|| Arc::new(StillShadows::new(&inputs, &frame)));
        frame
    }

    fn prepare_anew(&mut self, inputs: &ShadowInputs<'_>) -> FrameShadows {
        let ShadowInputs { world, chooser, version, views, settings, dealing } = *inputs;
        let casters = Casters::new(world, chooser, version, dealing.pattern());
        let mut demands = self.demands(&casters, world, views, settings, dealing);
        demands.sort_by(|a, b| b.side.total_cmp(&a.side).then_with(|| a.key.cmp(&b.key)));
        let mut frame = FrameShadows::default();
        let turns = if dealing.deals() { Some(self.turns(&demands)) } else { None };
        let sides = match &turns {
            Some(turns) => turns.sides_in(dealing),
            None => {
                let most = if dealing.rounds.is_none() { settings.maps } else { u32::MAX };
                self.sides(&demands, most, settings.map_px > 0)
            }
        };
        frame.counts.rounds = turns.as_ref().map_or(1, Turns::rounds);
        frame.counts.dealt = turns.as_ref().map_or(0, Turns::dealt);
        if turns.is_none() {
            let beyond = demands.iter().zip(&sides).filter(|(_, side)| **side == 0);
            frame.beyond.extend(beyond.map(|(light, _)| light.key.node));
        }
        self.grow(&demands, &sides);
        let placed = self.place(&demands, &sides);
        let mut of_lights: OfLights<'_> = BTreeMap::new();
        for (at, (demand, squares)) in demands.iter().zip(&placed).enumerate() {
            let weight = turns.as_ref().map_or(1.0, |turns| turns.weight(at, dealing));
            let Some(squares) = squares else {
                of_lights.insert(&demand.key, (Vec::new(), weight));
                continue;
            };
            frame.counts.lights += 1;
            frame.counts.in_emitters += u32::from(demand.of_light.is_in_emitter);
            let side = squares.iter().flatten().map(|square| square.side).max();
            if side.is_some_and(|side| (side as f32) < 0.5 * demand.side) {
                frame.starved.push(demand.key.node);
            }
            let records = self.tiles_of(&casters, demand, squares, &mut frame);
            of_lights.insert(&demand.key, (records, weight));
        }
        frame.is_first = self.is_empty;
        self.is_empty &= frame.tiles.is_empty();
        frame.views =
            views.iter().map(|(viewer, table)| view_shadows(viewer, table, &of_lights, settings, dealing)).collect();
        frame
    }

    /// Which lights always have their tiles, and whose turn comes when.
    fn turns(&self, demands: &[TileDemand]) -> Turns {
        let demanded: Vec<(u32, u32)> = demands
            .iter()
            .map(|light| ((light.side as u32).max(SIDE_MIN).next_power_of_two(), light.tile_count() as u32))
            .collect();
        Turns::new(&demanded, u64::from(self.side_max).pow(2), SIDE_MIN)
    }

    /// The records of a light's tiles, and what of them is to be drawn.
    fn tiles_of(
        &mut self,
        casters: &Casters<'_>,
        demand: &TileDemand,
        squares: &[Option<Square>],
        frame: &mut FrameShadows,
    ) -> Vec<[[f32; 4]; 4]> {
        let atlas = self.allocator.side() as f32;
        let mut records = Vec::with_capacity(squares.len());
        for (part, (aim, square)) in demand.aims.iter().zip(squares).enumerate() {
            let Some(square) = square else {
                let rows = aim.projection(SIDE_MIN).rows.map(|row| row.to_array());
                records.push([rows[0], rows[1], rows[2], [0.0; 4]]);
                continue;
            };
            let projection = aim.projection(square.side);
            let items: Vec<Caster> = casters.in_tile(&demand.of_light.items, &projection).collect();
            let signature = casters.signature(&items, &projection);
            let key = (demand.key, part as u8);
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

/// What casts shadows, for maps beside the atlas.
pub(crate) struct ShadowCasters<'w> {
    casters: Casters<'w>,
    everywhere: OfLight,
}

impl<'w> ShadowCasters<'w> {
    /// Of a world; `version` rises whenever a mesh or a material changed.
    pub fn new(world: &'w WorldDraws, version: u64) -> Self {
        let casters = Casters::new(world, None, version, 0);
        Self { everywhere: casters.everywhere(), casters }
    }

    /// What a map shows, whose instances are appended to `instances`, and a number that it shares with all that are
    /// alike.
    pub fn tile(&self, projection: &TileProjection, instances: &mut Vec<Instance>) -> (Vec<Draw>, u64) {
        let items: Vec<Caster> = self.casters.in_tile(&self.everywhere.items, projection).collect();
        let signature = self.casters.signature(&items, projection);
        (self.casters.draws(&items, projection, instances), signature)
    }
}

fn view_shadows(
    viewer: &Viewer<'_>,
    table: &LightTable,
    of_lights: &OfLights<'_>,
    settings: &ShadowSettings,
    dealing: Dealing,
) -> ViewShadows {
    let mut shadows = ViewShadows::default();
    for light in &table.lights {
        let known = of_lights.get(&LightKey::of(viewer, light)).filter(|_| light.casts_shadows);
        let (records, weight) = known.map_or((&[][..], 1.0), |(records, weight)| (&records[..], *weight));
        let first = if records.is_empty() { 0 } else { table.len() as usize + shadows.tiles.len() / 4 };
        // What shines from its points in turn is as small as a point in each of them.
        let radius_m = if dealing.moves() { 0.0 } else { light.radius_m };
        let ends = light.kind == LightKind::Directional && settings.distance_m > 0.0;
        shadows.of_light.push([first as f32, records.len() as f32, radius_m, f32::from(u8::from(ends))]);
        shadows.weights.push(weight);
        shadows.tiles.extend(records.iter().flatten());
    }
    shadows
}
