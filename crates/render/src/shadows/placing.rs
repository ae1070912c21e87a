//! How large the tiles of lights are, and where they lie in the atlas.

use super::atlas::Square;
use super::demand::TileDemand;
use super::{SIDE_MIN, Shadows, TileKey};
use std::collections::BTreeSet;
use std::collections::btree_map::Entry;

/// A tile that lasts: where it lies, and what it was drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CachedTile {
    pub square: Square,
    pub signature: u64,
}

impl Shadows {
    /// The side of the tiles of every light, 0 where there is no place for them, or where there would be more than
    /// `most` of lights at a place. All are made smaller alike until they fit. Unless they are `given`, a side that is
    /// there stays while it is not far off.
    pub(super) fn sides(&self, demands: &[TileDemand], most: u32, given: bool) -> Vec<u32> {
        let area = u64::from(self.side_max).pow(2);
        let mut tiles = 0;
        // The demanded side, that which is there, and how many of them; none of a light beyond `most`.
        let demands: Vec<Option<(f32, Option<u32>, u64)>> = demands
            .iter()
            .map(|light| {
                let kept = self.tiles.get(&(light.key, first_part(light))).map(|kept| kept.square.side);
                let count = light.tile_count();
                tiles += if light.is_directional { 0 } else { count };
                (tiles <= u64::from(most)).then_some((light.side, kept, count))
            })
            .collect();
        let side_of = |(demanded, kept, _): &(f32, Option<u32>, u64), shift: u32| {
            let is_near = |side: &u32| !given && (0.4..=1.1).contains(&(demanded / *side as f32));
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
    pub(super) fn place(&mut self, demands: &[TileDemand], sides: &[u32]) -> Vec<Option<Vec<Option<Square>>>> {
        // First what stays where it is, then what is new; if that finds no gap, the atlas grows, if it may; else what
        // nobody wants now is given up, and if that does not help, everything is placed anew, which always fits.
        for attempt in 0..3 {
            match attempt {
                0 => (),
                1 if self.allocator.side() < self.side_max => self.reset(2 * self.allocator.side()),
                1 => {
                    let is_wanted = |light: &TileDemand, side: &u32| (*side > 0).then_some(light.key);
                    let wanted: BTreeSet<_> =
                        demands.iter().zip(sides).filter_map(|(light, side)| is_wanted(light, side)).collect();
                    self.give_back(|key| !wanted.contains(&key.0));
                }
                _ => self.give_back(|_| true),
            }
            if let Some(placed) = self.try_place(demands, sides) {
                return placed;
            }
        }
        vec![None; demands.len()]
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

    fn try_place(&mut self, demands: &[TileDemand], sides: &[u32]) -> Option<Vec<Option<Vec<Option<Square>>>>> {
        let keys = |demand: &TileDemand, part: usize| (demand.key, part as u8);
        // Tiles of another size make room first.
        for (light, side) in demands.iter().zip(sides) {
            for (part, has_casters) in light.has_casters.iter().enumerate() {
                let key = keys(light, part);
                let Some(kept) = self.tiles.get(&key) else { continue };
                if !has_casters || kept.square.side != *side {
                    self.allocator.give(kept.square);
                    self.tiles.remove(&key);
                }
            }
        }
        let mut placed = Vec::with_capacity(demands.len());
        let mut order: Vec<usize> = (0..demands.len()).collect();
        order.sort_by_key(|at| std::cmp::Reverse(sides[*at]));
        placed.resize_with(demands.len(), || None);
        for at in order {
            let (light, side) = (&demands[at], sides[at]);
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
                        place.insert(CachedTile { square, signature: 0 });
                        square
                    }
                };
                squares.push(Some(square));
            }
            placed[at] = Some(squares);
        }
        Some(placed)
    }
}

/// The first of a light's tiles that has casters.
fn first_part(demand: &TileDemand) -> u8 {
    demand.has_casters.iter().position(|has| *has).unwrap_or(0) as u8
}
