//! Lights that share the atlas by turns, so that in a still every light casts its shadow however many there are.
//!
//! Those that matter most have their tiles in every frame. The others are dealt out into rounds: a light shines in the
//! frames of its round alone, and there as much brighter as there are frames without it, so that the mean over all
//! frames is right. Frames of a round follow each other, so that its tiles are drawn once. And a light of some size
//! shines from another of its points in every frame, so that the mean has the penumbrae of all of it.

use crate::lights::TableLight;
use glam::{Vec2, Vec3};
use manypass_scene::LightKind;
use std::f32::consts::TAU;

/// Which of the frames of a picture this is, and how many rounds of lights they share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dealing {
    /// The index of the frame.
    pub frame: u32,
    /// The number of frames.
    pub frames: u32,
    /// Rounds; 0 to find out how many there have to be. None where every frame stands for itself: then lights for which
    /// there is no place are lit without shadows.
    pub rounds: Option<u32>,
    /// Whether the picture goes on from the one before, as that of a live view does.
    pub goes_on: bool,
}

impl Dealing {
    /// Which texels of blended surfaces stop light in this frame: another choice in as many parts of the frames as are
    /// worth drawing their maps anew. The choices of a texel divide its alpha evenly among them, so that sixteen
    /// suffice.
    pub fn pattern(&self) -> u32 {
        let patterns = self.frames.clamp(1, PATTERNS_MAX);
        (u64::from(self.frame) * u64::from(patterns) / u64::from(self.frames.max(1))) as u32
    }

    /// Whether lights take turns.
    pub fn deals(&self) -> bool {
        self.rounds.is_some_and(|rounds| rounds != 1)
    }

    /// The round whose turn it is.
    fn round(&self, rounds: u32) -> u32 {
        (u64::from(self.frame) * u64::from(rounds) / u64::from(self.frames.max(1))) as u32
    }

    /// The frames of a round.
    fn frames_of(&self, round: u32, rounds: u32) -> u32 {
        let first = |round: u32| (u64::from(round) * u64::from(self.frames)).div_ceil(u64::from(rounds.max(1)));
        (first(round + 1) - first(round)) as u32
    }

    /// Whether lights of some size shine from another of their points in every frame.
    pub fn moves(&self) -> bool {
        self.frames > 1
    }

    /// The light as this frame's shadows have it: at one of its points. Where every frame stands for itself the first
    /// has it in its middle: it may be all that is seen.
    pub fn moved(&self, light: &TableLight) -> TableLight {
        let is_first_of_all = self.rounds.is_none() && self.frame == 0;
        if !self.moves() || is_first_of_all || light.radius_m <= 0.0 || is_wide(light) {
            return *light;
        }
        let [a, b, c] = self.point(light.node.map_or(u32::MAX, |node| node.0));
        let angle = TAU * a;
        if light.kind == LightKind::Directional {
            // The disc that the source is in the sky.
            let right = light.direction.any_orthonormal_vector();
            let (across, up) = (b.sqrt() * light.radius_m, light.direction.cross(right));
            let direction = light.direction + (right * angle.cos() + up * angle.sin()) * across;
            return TableLight { direction: direction.normalize(), ..*light };
        }
        let height = 2.0 * b - 1.0;
        let across = (1.0 - height * height).max(0.0).sqrt();
        let direction = Vec3::new(across * angle.cos(), height, across * angle.sin());
        TableLight { position: light.position + direction * (radius_share(c) * light.radius_m), ..*light }
    }

    /// How far the texels of the map of a light at a place are moved in this frame, which is one of `lamps` that cast
    /// shadows: edges in the mean are then as straight as what casts them, where a map that stays has steps. A light of
    /// some size shines from other points anyway.
    pub fn shift_texels(&self, light: &TableLight, lamps: usize) -> Vec2 {
        let is_first_of_all = self.rounds.is_none() && self.frame == 0;
        if !self.moves() || is_first_of_all || light.radius_m > 0.0 || lamps > SHIFTED_LAMPS {
            return Vec2::ZERO;
        }
        let [x, y, _] = self.point(light.node.map_or(u32::MAX, |node| node.0));
        Vec2::new(x, y) - 0.5
    }

    /// A point of the unit cube, another one for every frame and light: a sequence of the generalised golden ratio
    /// (Roberts 2018), from another beginning for every light.
    fn point(&self, light: u32) -> [f32; 3] {
        let mut hash = light.wrapping_mul(0x9e37_79b9);
        [0.819_172_5_f64, 0.671_043_6, 0.549_700_5].map(|step| {
            // The finaliser of MurmurHash3.
            hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
            hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
            (f64::from(hash >> 8) / f64::from(1u32 << 24) + step * f64::from(self.frame)).fract() as f32
        })
    }
}

/// Whether a light is so wide that its points in a few frames would each leave an edge of their own: its shadows on
/// surfaces are those of its middle, from one map for all frames.
pub(super) fn is_wide(light: &TableLight) -> bool {
    light.kind == LightKind::Directional && light.radius_m > 0.2
}

/// The distance from the middle, as a share of the radius, within which the share `share` of a ball's points lies, if
/// they are so dense that they look like a disc of one brightness from everywhere: in proportion to 1 / √(1 − r²), as
/// Abel's integral has it.
fn radius_share(share: f32) -> f32 {
    let within = |r: f32| (r.asin() - r * (1.0 - r * r).max(0.0).sqrt()) / std::f32::consts::FRAC_PI_2;
    let (mut low, mut high) = (0.0f32, 1.0f32);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        *(if within(middle) < share { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// So many lamps have their maps drawn anew in every frame of a still: of more the maps cost more than steps of their
/// edges are seen.
const SHIFTED_LAMPS: usize = 4;

/// The most choices of a picture.
const PATTERNS_MAX: u32 = 16;

/// More rounds than this make tiles smaller, rather than more rounds.
const ROUNDS_MAX: u32 = 16;

/// Who has tiles when.
#[derive(Debug)]
pub(super) struct Turns {
    /// Of every light the side of its tiles, and its round; none for one that has its tiles always.
    of_light: Vec<(u32, Option<u32>)>,
    rounds: u32,
}

impl Turns {
    /// The turns of lights that demand tiles of some side, so many each, the most important first, in an atlas of
    /// `area` texels. Half of it belongs to lights that always have their tiles, if not all of them can.
    pub fn new(demanded: &[(u32, u32)], area: u64, side_min: u32) -> Self {
        let texels =
            |(side, count): (u32, u32), shift: u32| u64::from((side >> shift).max(side_min)).pow(2) * u64::from(count);
        let sum = |shift: u32| demanded.iter().map(|light| texels(*light, shift)).sum::<u64>();
        let room = area / 2;
        // Tiles that are half as fine are better than turns, of which every light has a part of the samples alone.
        let is_enough = |shift: &u32| sum(*shift) <= room * u64::from(ROUNDS_MAX - 2);
        let of_turns = || (0..16).find(is_enough).unwrap_or(16);
        let shift = (0..2).find(|shift| sum(*shift) <= area).unwrap_or_else(of_turns);
        let side = |light: &(u32, u32)| (light.0 >> shift).max(side_min);
        if sum(shift) <= area {
            return Self { of_light: demanded.iter().map(|light| (side(light), None)).collect(), rounds: 1 };
        }
        let mut turns = Self { of_light: Vec::with_capacity(demanded.len()), rounds: 0 };
        let (mut lasting, mut in_round) = (0, u64::MAX);
        for light in demanded {
            let needed = texels(*light, shift);
            let round = if turns.rounds == 0 && lasting + needed <= room {
                lasting += needed;
                None
            } else {
                if in_round.saturating_add(needed) > area - lasting {
                    turns.rounds += 1;
                    in_round = 0;
                }
                in_round += needed;
                Some(turns.rounds - 1)
            };
            turns.of_light.push((side(light), round));
        }
        turns
    }

    /// The number of rounds.
    pub fn rounds(&self) -> u32 {
        self.rounds.max(1)
    }

    /// The number of lights that have no tiles at times.
    pub fn dealt(&self) -> u32 {
        self.of_light.iter().filter(|(_, round)| round.is_some()).count() as u32
    }

    /// The side of the tiles of every light in a frame, 0 where it has none.
    pub fn sides_in(&self, dealing: Dealing) -> Vec<u32> {
        let now = dealing.round(self.rounds());
        let side = |(side, round): &(u32, Option<u32>)| if round.is_none_or(|round| round == now) { *side } else { 0 };
        self.of_light.iter().map(side).collect()
    }

    /// By how much a light is brighter in a frame.
    pub fn weight(&self, at: usize, dealing: Dealing) -> f32 {
        match self.of_light.get(at).and_then(|(_, round)| *round) {
            None => 1.0,
            Some(round) if round == dealing.round(self.rounds()) => {
                dealing.frames as f32 / dealing.frames_of(round, self.rounds()).max(1) as f32
            }
            Some(_) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_light_has_its_turn_and_the_mean_is_one() {
        for (lights, frames) in [(40, 1), (40, 16), (400, 16), (1000, 7), (3000, 64)] {
            let demanded: Vec<_> = (0..lights).map(|i| (if i < 3 { 256 } else { 64 }, 1 + i % 6)).collect();
            let turns = Turns::new(&demanded, 512 * 512, 32);
            let frames = frames.max(turns.rounds());
            let mut means = vec![0.0; demanded.len()];
            for frame in 0..frames {
                let dealing = Dealing { frame, frames, rounds: Some(turns.rounds()), goes_on: false };
                let sides = turns.sides_in(dealing);
                let texels: u64 =
                    sides.iter().zip(&demanded).map(|(side, light)| u64::from(*side).pow(2) * u64::from(light.1)).sum();
                assert!(texels <= 512 * 512, "{lights} {frame}: {texels}");
                for (at, mean) in means.iter_mut().enumerate() {
                    let weight = turns.weight(at, dealing);
                    assert_eq!(weight > 0.0, sides[at] > 0, "a light shines with its shadow or not at all");
                    *mean += f64::from(weight) / f64::from(frames);
                }
            }
            assert!(means.iter().all(|mean| (mean - 1.0).abs() < 1e-5), "{lights} {frames}");
        }
    }

    #[test]
    fn a_ball_looks_like_a_disc_of_one_brightness() {
        let light = TableLight {
            node: Some(manypass_scene::NodeId(7)),
            kind: LightKind::Point,
            position: Vec3::ZERO,
            direction: Vec3::NEG_Z,
            range_m: None,
            radius_m: 2.0,
            casts_shadows: true,
        };
        let (frames, mut inner) = (4000, [0u32; 3]);
        for frame in 0..frames {
            let place = Dealing { frame, frames, rounds: Some(1), goes_on: false }.moved(&light).position;
            assert!(place.length() <= 2.0001);
            // Seen along each axis: a circle of half the area holds half the points.
            for (axis, count) in inner.iter_mut().enumerate() {
                let across = place.length_squared() - place[axis] * place[axis];
                *count += u32::from(across < 2.0);
            }
        }
        assert!(inner.iter().all(|count| count.abs_diff(frames / 2) < frames / 40), "{inner:?}");
        let live = |frame| Dealing { frame, frames, rounds: None, goes_on: true }.moved(&light).position;
        assert!(live(0) == Vec3::ZERO && live(1) != Vec3::ZERO, "what may be all that is seen has the middle");
        // The texels of a light of some size need not move.
        let still = |frame| Dealing { frame, frames, rounds: Some(1), goes_on: false };
        assert_eq!(still(3).shift_texels(&light, 1), Vec2::ZERO);
        let small = TableLight { radius_m: 0.0, ..light };
        let shifts = Vec::from_iter((0..16).map(|frame| still(frame).shift_texels(&small, SHIFTED_LAMPS)));
        assert!(shifts.iter().all(|shift| shift.abs().max_element() <= 0.5), "{shifts:?}");
        assert!(shifts.iter().sum::<Vec2>().length() < 1.5 && shifts[0] != shifts[1], "{shifts:?}");
        assert_eq!(still(3).shift_texels(&small, SHIFTED_LAMPS + 1), Vec2::ZERO);
    }
}
