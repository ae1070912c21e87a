//! Shaders of the user's, each a text in one file: where faults in it are, its comments, its uniforms as settings, and what is
//! asked of it. Effects and simulations are made of them.

pub(crate) mod checks;
mod loops;
pub(crate) mod padding;
pub(crate) mod rounds;
pub(crate) mod scan;
mod size;
pub(crate) mod source;
pub(crate) mod uniforms;

pub(crate) use source::Source;
