//! Faces that are the backs of others: the same corners, wound the other way. Many programs write surfaces with two
//! sides so.

use super::vertex_corners::corners_by_vertex;

/// What is said of a back that looks as its front does.
pub(super) const LEFT_OUT: &str =
    "a face repeats another one with the opposite winding; it is left out, because surfaces have two sides";

/// The faces that are backs, in their order, each with its front: the first of the faces with these corners. `face`
/// gives the vertices of one of `count` faces; vertices at one place must be one vertex.
pub(super) fn backs<'f>(count: usize, face: impl Fn(usize) -> &'f [u32]) -> Vec<(usize, usize)> {
    let least: Vec<u32> = (0..count).map(|i| face(i).iter().copied().min().unwrap_or_default()).collect();
    let vertex_count = least.iter().max().map_or(0, |most| *most as usize + 1);
    // Only faces with the same least vertex can have the same corners.
    let (starts, order) = corners_by_vertex(vertex_count, &least);
    let round = |i: u32| Round::of(face(i as usize));
    let mut backs: Vec<(usize, usize)> = Vec::new();
    let mut near: Vec<u32> = Vec::new();
    for range in starts.windows(2) {
        let &[start, end] = range else { continue };
        near.clear();
        near.extend_from_slice(order.get(start as usize..end as usize).unwrap_or_default());
        // Stable: of faces with the same corners the first comes first.
        near.sort_by(|a, b| round(*a).vertices().cmp(round(*b).vertices()));
        for same in near.chunk_by(|a, b| round(*a).vertices().eq(round(*b).vertices())) {
            let Some((&front, others)) = same.split_first() else { continue };
            let is_forward = round(front).is_forward;
            let turned = others.iter().copied().filter(|other| round(*other).is_forward != is_forward);
            backs.extend(turned.map(|back| (back as usize, front as usize)));
        }
    }
    backs.sort_unstable();
    backs
}

/// The places of the corners of a back, and the places of the same vertices in its front.
pub(super) fn aligned(back: &[u32], front: &[u32]) -> impl Iterator<Item = (usize, usize)> {
    Round::of(back).places().zip(Round::of(front).places())
}

/// A way around a face that is the same for its back: from its least vertex on, towards the lesser neighbour of that.
#[derive(Clone, Copy, Debug)]
struct Round<'f> {
    face: &'f [u32],
    start: usize,
    /// Whether it goes as the face is wound.
    is_forward: bool,
}

impl<'f> Round<'f> {
    fn of(face: &'f [u32]) -> Self {
        let count = face.len();
        let start = (0..count).min_by_key(|place| face.get(*place)).unwrap_or_default();
        let later = |step: usize| face.get((start + step) % count.max(1));
        Self { face, start, is_forward: later(1) <= later(count.saturating_sub(1)) }
    }

    fn places(self) -> impl Iterator<Item = usize> {
        let Self { face, start, is_forward } = self;
        let count = face.len();
        (0..count).map(move |step| (start + if is_forward { step } else { count - step }) % count)
    }

    fn vertices(self) -> impl Iterator<Item = u32> {
        self.places().filter_map(move |place| self.face.get(place).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn backs_of(faces: &[&[u32]]) -> Vec<(usize, usize)> {
        backs(faces.len(), |i| faces[i])
    }

    #[test]
    fn the_same_corners_in_the_opposite_order_are_a_back_from_whichever_they_begin() {
        let quad: [u32; 4] = [4, 9, 2, 7];
        for turn in 0..4 {
            let mut back = quad;
            back.reverse();
            back.rotate_left(turn);
            assert_eq!(backs_of(&[&[2, 4, 5], &quad, &back]), [(2, 1)], "{back:?}");
            for (in_back, in_front) in aligned(&back, &quad) {
                assert_eq!(back[in_back], quad[in_front]);
            }
            assert_eq!(aligned(&back, &quad).count(), 4);
        }
        assert_eq!(backs_of(&[&[0, 1, 2], &[3, 2, 1], &[2, 1, 0], &[1, 2, 3]]), [(2, 0), (3, 1)]);
    }

    #[test]
    fn the_first_face_is_the_front_of_all_others() {
        let (front, back): (&[u32], &[u32]) = (&[0, 1, 2], &[1, 0, 2]);
        assert_eq!(backs_of(&[back, front, back, front, front]), [(1, 0), (3, 0), (4, 0)]);
    }

    #[test]
    fn other_faces_are_no_backs() {
        // Of the same winding, of the same corners across one another, with one corner more, and without an area.
        let faces: [&[u32]; 8] =
            [&[0, 1, 2], &[1, 2, 0], &[4, 5, 6, 7], &[4, 6, 5, 7], &[2, 1, 0, 3], &[8, 8, 9], &[9, 8, 8], &[]];
        assert!(backs_of(&faces).is_empty() && backs_of(&[]).is_empty());
    }

    #[test]
    fn many_faces_with_the_same_corner_end() {
        let fan: Vec<[u32; 3]> = (1..50_000).flat_map(|i| [[0, i, i + 1], [i + 1, i, 0]]).collect();
        assert_eq!(backs(fan.len(), |i| &fan[i][..]).len(), fan.len() / 2);
    }
}
