//! Passes that leave out fragments on one side of the nearest surfaces that light comes through, as `transparency.wgsl`
//! has it.
//!
//! Source: Everitt 2001, "Interactive Order-Independent Transparency" (depth peeling).

use manypass_graph::Handle;

/// Which fragments are drawn, by the nearest surface that light comes through in their pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Side {
    /// Those of surfaces that light comes through, without the nearest.
    Beyond = 1,
    /// Those of blended surfaces that are not before it.
    Behind = 2,
    /// Those of blended surfaces that are.
    Before = 3,
}

/// What of its surfaces a pass draws.
#[derive(Clone, Copy, Debug)]
pub struct Peel<'h> {
    /// Which fragments.
    pub side: Side,
    /// The distances of the nearest surfaces that light comes through.
    pub nearest_m: &'h Handle,
}
