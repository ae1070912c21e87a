//! What is found in all texels of a picture of the environment, how bright it is on the average for example: computed
//! once a map, because those of one of 4096 by 2048 take longer than the small frame that is metered.

use manypass_scene::EnvironmentMap;
use std::sync::{Arc, Weak};

/// A value of each of the maps that are still held elsewhere.
#[derive(Debug, Default)]
pub(super) struct PerMap<T>(Vec<(Weak<EnvironmentMap>, T)>);

impl<T: Copy> PerMap<T> {
    /// That of `map`, which `compute` finds if it is not known.
    pub fn of(&mut self, map: &Arc<EnvironmentMap>, compute: impl FnOnce(&EnvironmentMap) -> T) -> T {
        self.0.retain(|(known, _)| known.strong_count() > 0);
        // No other map has its place, nor does it change, while there is a weak reference to it.
        if let Some((_, value)) = self.0.iter().find(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(map))) {
            return *value;
        }
        let value = compute(map);
        self.0.push((Arc::downgrade(map), value));
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_mean_is_computed_once_a_map() {
        let of_radiance = |radiance: f32| Arc::new(EnvironmentMap::from_fn("a", 8, 4, |_| Vec3::splat(radiance)));
        let mut means = PerMap::<Vec3>::default();
        let mut count = 0;
        let mut mean_of = |map: &Arc<EnvironmentMap>| {
            let mean = means.of(map, |map| {
                count += 1;
                map.mean_radiance()
            });
            (mean, count)
        };
        let (one, two) = (of_radiance(1.0), of_radiance(2.0));
        assert_eq!([&one, &two, &one, &two].map(|map| mean_of(map).1), [1, 2, 2, 2]);
        assert!((mean_of(&two).0 - Vec3::splat(2.0)).abs().max_element() < 1e-3);
        // What takes the place of a map that nobody holds is another one.
        drop(one);
        let three = of_radiance(3.0);
        assert!((mean_of(&three).0 - Vec3::splat(3.0)).abs().max_element() < 1e-3);
        assert_eq!(means.0.len(), 2, "none of a map that nobody holds");
    }
}
