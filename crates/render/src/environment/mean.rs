//! How bright pictures of the environment are on the average: computed once a map, because all texels of one of 4096 by
//! 2048 take longer than the small frame that is metered.

use glam::Vec3;
use manypass_scene::EnvironmentMap;
use std::sync::{Arc, Weak};

/// The mean radiance of the maps that are still held elsewhere.
#[derive(Debug, Default)]
pub(super) struct MeanRadiances(Vec<(Weak<EnvironmentMap>, Vec3)>);

impl MeanRadiances {
    /// That of `map` over all directions ([`EnvironmentMap::mean_radiance`]).
    pub fn of(&mut self, map: &Arc<EnvironmentMap>) -> Vec3 {
        self.of_by(map, EnvironmentMap::mean_radiance)
    }

    fn of_by(&mut self, map: &Arc<EnvironmentMap>, mean: impl FnOnce(&EnvironmentMap) -> Vec3) -> Vec3 {
        self.0.retain(|(known, _)| known.strong_count() > 0);
        // No other map has its place, nor does it change, while there is a weak reference to it.
        if let Some((_, mean)) = self.0.iter().find(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(map))) {
            return *mean;
        }
        let mean = mean(map);
        self.0.push((Arc::downgrade(map), mean));
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_computed_once_a_map() {
        let of_radiance = |radiance: f32| Arc::new(EnvironmentMap::from_fn("a", 8, 4, |_| Vec3::splat(radiance)));
        let mut means = MeanRadiances::default();
        let mut count = 0;
        let mut mean_of = |map: &Arc<EnvironmentMap>| {
            let mean = means.of_by(map, |map| {
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
