//! Scenes that Manypass draws, and the readers of their files.
//!
//! A [`Scene`] is one arena of nodes together with the meshes, materials, images, lights, cameras, skins and animations
//! that the nodes refer to by index. This crate knows no GPU: it reads glTF ([`gltf_file`]), other formats
//! ([`formats`]) and stages ([`stage`]), builds procedural geometry ([`primitives`]), evaluates animations
//! ([`animation`]) and computes bounds ([`bounds`]).
//!
//! Readers that not every program needs are cargo features, all on by default: `draco`, `exr`, `formats`, `ktx2`,
//! `meshopt`, `simplify`, `text`. Without one, what it would read is an error or a warning that names it.
//!
//! Space is right-handed with +Y up, lengths are metres, angles radians, light is candela and lux, as in glTF 2.0.

pub mod animation;
pub mod bounds;
mod cache;
pub mod camera;
pub mod capture;
mod chance;
pub mod colour;
pub mod decal;
pub mod demo;
mod diagnostic;
mod editing;
pub mod environment;
pub mod formats;
pub mod framing;
pub mod gltf_file;
pub mod image;
pub mod input_file;
mod ktx2;
mod late_images;
pub mod levels;
pub mod light;
pub mod material;
pub mod mesh;
mod near;
pub mod node;
mod node_id;
mod nodes;
pub mod overlay;
pub mod particles;
pub mod portal;
pub mod primitives;
pub mod probes;
pub mod renamed;
pub mod scenes;
#[cfg(feature = "simplify")]
mod simplify;
#[cfg(not(feature = "simplify"))]
#[path = "simplify/absent.rs"]
mod simplify;
pub mod simulation;
mod skins;
pub mod sky;
pub mod spelling;
pub mod stage;
pub mod surroundings;
mod tally;
pub mod turns;
pub mod variants;
pub mod water;

pub use animation::{Animation, Channel, Interpolation, Keyframes, Skin};
pub use bounds::Aabb;
pub use cache::Cache;
pub use camera::{Camera, Projection};
pub use diagnostic::Diagnostic;
pub use environment::{EnvironmentError, EnvironmentLayout, EnvironmentLight, EnvironmentMap};
pub use formats::{load_bytes, load_path};
pub use framing::{Framing, Interior};
pub use gltf_file::{LoadError, LoadedScene};
pub use image::{
    BlockFormat, Blocks, HalfFloats, Heights, Image, ImageError, ImageSource, PixelFormat, Pixels, Sampler, Texture,
    Wrap,
};
pub use late_images::{LateImages, ON_ITS_WAY};
pub use levels::{LevelOf, Levels};
pub use light::{Light, LightKind, LightMode};
pub use material::{AlphaMode, LayerMap, Material, ShadingModel, TextureRef, TextureTransform, TexturedFactor};
pub use mesh::{Mesh, MorphTarget, Primitive, PrimitiveLevel, Topology};
pub use node::{LastPlace, Node, Scene};
pub use node_id::NodeId;
pub use nodes::Nodes;
pub use overlay::{Overlay, OverlayItem};
pub use scenes::{SceneRoots, ShowError};
pub use sky::Sky;
pub use stage::Stage;
