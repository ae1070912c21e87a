//! What shaders know of a list of lights.

use bytemuck::{Pod, Zeroable};

/// A texel of the table of lists, which shares a texture of floats with the lights. All numbers are whole and below
/// 2²⁴, which floats hold exactly: where the list begins among all entries; its length, and 2¹⁶ times the low byte of
/// where its points end; where its points that cast no shadow end, and 2¹⁶ times the high byte of where its points end;
/// where its lights that cast shadows end. Ends are counted from its beginning.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ListRecord([f32; 4]);

const HIGH: u32 = 1 << 16;

impl ListRecord {
    /// A list without lights.
    pub const EMPTY: Self = Self([0.0; 4]);

    /// The record of a list that begins at `first` among all entries, whose lights are in the order of their classes.
    pub fn new(first: usize, list: &[u16], class_ends: &[u32; 6]) -> Self {
        let [.., quiet_points_end, points_end, casters_end, _] = *class_ends;
        let end = |class_end: u32| {
            // Mostly all lights are of one class.
            let is_before = |light: &u16| u32::from(*light) < class_end;
            match (list.first().is_some_and(is_before), list.last().is_some_and(is_before)) {
                (false, _) => 0,
                (true, true) => list.len() as u32,
                (true, false) => list.partition_point(is_before) as u32,
            }
        };
        let points_end = end(points_end);
        let numbers = [
            first as u32,
            list.len() as u32 + (points_end & 0xff) * HIGH,
            end(quiet_points_end) + (points_end >> 8) * HIGH,
            end(casters_end),
        ];
        Self(numbers.map(|number| number as f32))
    }

    /// The same list, behind so many entries of others.
    pub fn behind(self, entries: usize) -> Self {
        let [first, rest @ ..] = self.0;
        let [y, z, w] = rest;
        Self([first + entries as f32, y, z, w])
    }

    /// The number of lights.
    pub const fn count(self) -> u32 {
        self.0[1] as u32 % HIGH
    }

    /// The first of the lights that cast shadows, and the end of them.
    pub const fn casters(self) -> [u32; 2] {
        [self.0[2] as u32 % HIGH, self.0[3] as u32]
    }
}

#[cfg(test)]
impl ListRecord {
    /// The entries of the list, among all.
    pub fn entries(self) -> std::ops::Range<usize> {
        self.0[0] as usize..self.0[0] as usize + self.count() as usize
    }

    /// As shaders take it apart: the ends of quiet points, points, casters.
    fn ends(self) -> [u32; 3] {
        let [_, y, z, w] = self.0.map(|number| number as u32);
        [z & 0xffff, y >> 16 | (z >> 16) << 8, w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_tell_where_classes_end() {
        let ends = [0, 0, 10, 20, 30, 40];
        let of = |first, list: &[u16]| {
            let record = ListRecord::new(first, list, &ends);
            (record.entries(), record.ends(), record.casters())
        };
        assert_eq!(of(7, &[]), (7..7, [0, 0, 0], [0, 0]));
        assert_eq!(of(7, &[3, 9, 12, 19, 25, 31, 39]), (7..14, [2, 4, 5], [2, 5]));
        assert_eq!(of(0, &[21, 22]), (0..2, [0, 0, 2], [0, 2]));
        assert_eq!(of(0, &[0, 5]), (0..2, [2, 2, 2], [2, 2]));
        assert_eq!(of(0, &[35]), (0..1, [0, 0, 0], [0, 0]));
    }

    #[test]
    fn the_longest_list_is_exact() {
        let list: Vec<u16> = (0..u16::MAX).collect();
        let record = ListRecord::new((1 << 22) - 1, &list, &[0, 0, 65_533, 65_534, 65_535, 65_535]);
        assert_eq!(
            (record.entries().start, record.count(), record.ends()),
            ((1 << 22) - 1, 65_535, [65_533, 65_534, 65_535])
        );
    }
}
