//! The limit of lighting: a bare loop over lights, measured by a bench of the renderer's.

use crate::step::cargo;
use crate::step::last_json;
use anyhow::{Context, Result};
use serde_json::Value;

/// Pixels of the frame in which the limit is measured.
const PIXELS: f64 = 960.0 * 540.0;

/// What a bare loop over lights costs on an adapter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Limit {
    pub adapter: String,
    pub ns_per_pair: f64,
    /// What a frame of 960×540 costs besides.
    pub fixed_ms: f64,
}

impl Limit {
    /// Measures it. What was built for trials does so as well, because the time is the adapter's.
    pub fn measure(is_trial: bool) -> Result<Self> {
        let mut command = if is_trial {
            cargo(["test", "--quiet", "--workspace", "--bench", "limit", "--", "--json"])
        } else {
            cargo(["bench", "--quiet", "-p", "manypass", "--bench", "limit", "--", "--json"])
        };
        Self::parse(&last_json(&mut command)?)
    }

    fn parse(value: &Value) -> Result<Self> {
        let number = |key: &str| value[key].as_f64().with_context(|| format!("the limit has no {key}: {value}"));
        Ok(Self {
            adapter: value["adapter"].as_str().unwrap_or("an unknown adapter").to_owned(),
            ns_per_pair: number("ns_per_pair")?,
            fixed_ms: number("fixed_ms")?,
        })
    }

    /// The lesser of two measurements, by what they say of a million pairs: other work only makes frames slower.
    pub fn or_less(self, other: Option<Self>) -> Self {
        match other {
            Some(other) if other.ms(1e6, PIXELS) < self.ms(1e6, PIXELS) => other,
            _ => self,
        }
    }

    /// What so many pairs of pixel and light would cost, in a frame of so many pixels.
    pub fn ms(&self, pairs: f64, pixels: f64) -> f64 {
        1e-6 * self.ns_per_pair * pairs + self.fixed_ms * pixels / PIXELS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_limit_grows_with_pairs_and_pixels() {
        let value = json!({ "adapter": "a", "ns_per_pair": 4.0, "fixed_ms": 2.0 });
        let limit = Limit::parse(&value).expect("a limit");
        assert!((limit.ms(3e6, PIXELS) - 14.0).abs() < 1e-9);
        assert!((limit.ms(0.0, 0.25 * PIXELS) - 0.5).abs() < 1e-9);
        assert!(Limit::parse(&json!({ "ns_per_pair": 4.0 })).is_err());
    }

    #[test]
    fn the_lesser_of_two_limits_counts() {
        let limit = |ns_per_pair, fixed_ms| Limit { adapter: "a".into(), ns_per_pair, fixed_ms };
        assert_eq!(limit(4.0, 2.0).or_less(None), limit(4.0, 2.0));
        assert_eq!(limit(4.0, 2.0).or_less(Some(limit(6.0, 0.5))), limit(4.0, 2.0));
        assert_eq!(limit(4.0, 2.0).or_less(Some(limit(4.1, 1.6))), limit(4.1, 1.6));
    }
}
