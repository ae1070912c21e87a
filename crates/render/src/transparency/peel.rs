//! Passes of blended surfaces that leave out fragments on one side of the nearest surfaces that light comes through, as
//! `transparency.wgsl` has it.
//!
//! Source: Everitt 2001, "Interactive Order-Independent Transparency" (depth peeling).

use manypass_graph::Handle;

/// Which fragments of blended surfaces are drawn, by the nearest surface that light comes through in their pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Side {
    /// Those that are not before it.
    Behind = 1,
    /// Those that are.
    Before = 2,
}

/// What of its surfaces a pass draws.
#[derive(Clone, Copy, Debug)]
pub struct Peel<'h> {
    /// Which fragments.
    pub side: Side,
    /// The distances of the nearest surfaces that light comes through.
    pub nearest_m: &'h Handle,
}
