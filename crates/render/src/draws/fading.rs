//! Levels that fade into each other: each draws its own pixels of a pattern, as `level_fade.wgsl` has it.

use crate::constants::{FADE_COARSER, FADE_SHIFT, FADE_STEPS};
use crate::resources::Instance;

/// The constant of `level_fade.wgsl` that is 1 where what is drawn fades.
pub(crate) const FADES: &str = "fades";

/// Which of the two levels is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The one that fades out.
    Finer,
    /// The one that fades in.
    Coarser,
}

/// An instance that draws its side's pixels, where the coarser level has a share of them; none if its object's id
/// leaves no room to say so, or it has all pixels or none.
pub(crate) fn faded(instance: &Instance, coarser_share: f32, side: Side) -> Option<Instance> {
    let steps = (coarser_share * FADE_STEPS as f32).round() as u32;
    let id = instance.ids[0];
    if id >> FADE_SHIFT != 0 || steps == 0 || steps >= FADE_STEPS {
        return None;
    }
    let code = steps | if side == Side::Coarser { FADE_COARSER } else { 0 };
    let mut faded = *instance;
    faded.ids[0] = id | code << FADE_SHIFT;
    Some(faded)
}

/// The object id of such an instance.
pub(crate) fn faded_id(instance: &Instance) -> u32 {
    instance.ids[0] & ((1 << FADE_SHIFT) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::WITHOUT_NORMALS;
    use bytemuck::Zeroable;

    #[test]
    fn the_code_leaves_the_object_alone() {
        let instance = |id: u32| Instance { ids: [id, 1, 2, 3], ..Instance::zeroed() };
        let coded = |id, share, side| faded(&instance(id), share, side).map(|faded| faded.ids[0]);
        assert_eq!(coded(77, 0.5, Side::Finer), Some(77 | 32 << 23));
        assert_eq!(coded(77, 0.5, Side::Coarser), Some(77 | 96 << 23));
        assert_eq!(faded(&instance(77), 0.5, Side::Coarser).map(|faded| faded_id(&faded)), Some(77));
        for share in [0.0, 0.005, 0.995, 1.0] {
            assert_eq!(coded(77, share, Side::Finer), None);
        }
        assert_eq!(coded(1 << 23, 0.5, Side::Finer), None);
        assert_eq!(coded(77 | WITHOUT_NORMALS, 0.5, Side::Finer), None);
        assert!(coded((1 << 23) - 1, 0.9, Side::Coarser).is_some_and(|id| id & WITHOUT_NORMALS == 0));
    }
}
