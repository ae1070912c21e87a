//! Settings of variables.

use crate::setting::settings;

settings! {
    /// Settings of variables.
    pub struct AovSettings {
        /// Whether variables show whatever the eye meets first: surfaces that are blended (where alpha is at least
        /// 1/255) and those that light comes through, too, and not what lies behind them. `radiance` is the same either
        /// way.
        first_surface: bool = false;
    }
}
