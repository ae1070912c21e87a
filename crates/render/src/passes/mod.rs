//! The passes of the frame, one folder each. No pass imports another; outputs reach their consumers as arguments.

pub mod accumulate;
pub mod adaptive;
pub mod background;
pub mod behind;
pub mod coverage;
pub mod debug;
pub mod direct;
pub mod emission;
pub mod environment;
pub mod fog;
pub mod forward;
pub mod geometry;
pub mod gouraud;
pub mod ground;
pub mod ids;
pub mod indirect;
pub mod linear_depth;
pub mod meter;
pub mod motion;
pub mod present;
pub mod resolve;
pub mod shadows;
pub mod tile_depth;
pub mod tone_map;
pub mod transparency;
pub mod volumes;
