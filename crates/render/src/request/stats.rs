//! What is told of a frame afterwards.

use crate::levels::LevelCount;

/// Statistics of the last frame.
#[derive(Clone, Debug, Default, serde::Serialize)]
#[non_exhaustive]
pub struct FrameStats {
    /// Draw calls of surfaces.
    pub draws: u32,
    /// Draw calls that only light what others drew: one for each rectangle of the picture that lights reach, volumes
    /// and what marks them, later batches of surfaces.
    pub light_draws: u32,
    /// Bytes that the frame's passes write if each covers its targets once.
    pub written_bytes: u64,
    /// Triangles of all draws.
    pub triangles: u64,
    /// Points of all draws. Of clouds of 4,096 points or more, what lies beside the picture is left out, and in later
    /// samples of a still what lies on converged tiles, which are skipped (`adaptive.threshold`).
    pub points: u64,
    /// Pictures within the picture that were drawn: what monitors show. Each is a view of its own.
    pub captures: u32,
    /// Pictures within the picture that were left out, because nobody sees them, or it was not their turn.
    pub captures_left_out: u32,
    /// Probes that were looked around, to find their light. A still has looked around all before its first frame.
    pub probes_captured: u32,
    /// What of them is of each level of detail, of all that has levels; those of the finest first.
    pub levels: Vec<LevelCount>,
    /// Lights of the scene; that of an environment is none of them.
    pub lights: u32,
    /// Those of them that are left out because what they reach is seen too small (`lights.min_px`), of several views in
    /// the one that leaves out the most.
    pub lights_too_small: u32,
    /// Entries of all lists of lights.
    pub list_entries: u64,
    /// Views whose lists of lights were made for the frame, because something changed that they are made of.
    pub light_lists_made: u32,
    /// Primitives of nodes that were posed: all if anything of the scene changed, and none if nothing did.
    pub items_posed: u32,
    /// Lists of what views draw that were made, and not kept from the last frame.
    pub draw_lists_made: u32,
    /// Milliseconds to make the lists of lights, or to find that they are still right.
    pub culling_ms: f64,
    /// Lights that cast shadows and have shadow maps.
    pub shadowed_lights: u32,
    /// Tiles of shadow maps that were drawn for the frame.
    pub shadow_tiles_drawn: u32,
    /// Tiles of shadow maps that were kept from the frames before, because nothing in them changed.
    pub shadow_tiles_kept: u32,
    /// Lights whose shadow maps are less than half as fine as the picture asks for, because the atlas is full.
    pub lights_starved: u32,
    /// Lights that should cast shadows and for whose shadow maps the atlas has no place: they shine through everything.
    pub lights_beyond_atlas: u32,
    /// Lights that cast shadows and share the atlas by turns.
    pub lights_dealt: u32,
    /// Rounds in which they have their turns.
    pub light_rounds: u32,
    /// Lights inside of surfaces that glow, such as a bulb, which cast no shadow of theirs.
    pub lights_in_emitters: u32,
    /// Bytes of the texture of all shadow maps.
    pub texture_bytes_of_shadows: u64,
    /// Textures that were made for the passes of the frame, because the frames before left none of their shape. Those that
    /// outlive frames, such as the picture and shadow maps, are not counted.
    pub textures_made: u64,
    /// Bind groups that were made for the frame, because nothing alike was bound in the frames before.
    pub bind_groups_made: u64,
    /// Render bundles that were executed, in place of the draws that they hold.
    pub bundles_executed: u64,
    /// How often passes bound another pipeline, or another material, for the surfaces that they draw.
    pub binding_changes: u64,
    /// Programs and pipelines that were made for the frame.
    pub pipelines_made: u64,
    /// Bytes that were uploaded for the frame because they changed: uniforms, instances, lights, lists, poses, and what
    /// of the scene is new since the last frame or [`crate::Renderer::load`].
    pub uploaded_bytes: u64,
    /// Bytes of the frame's textures after aliasing.
    pub texture_bytes: u64,
    /// Bytes of the frame's textures without aliasing.
    pub texture_bytes_unaliased: u64,
}

/// Pairs of a light and what it may reach: a pixel of the picture, or on forward paths a fragment that is drawn, or
/// with Gouraud shading a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct PairCounts {
    /// Iterations of the loop over lights.
    pub pairs_visited: u64,
    /// Reflectance evaluated.
    pub pairs_shaded: u64,
    /// The place lies within the light's range, and within its cone.
    pub pairs_in_range: u64,
    /// Visited, but not even tested for their distance, because the light lies before or behind all of the tile's
    /// surfaces (tiled lighting alone).
    pub pairs_passed_over: u64,
}

impl std::ops::AddAssign for PairCounts {
    fn add_assign(&mut self, other: Self) {
        self.pairs_visited += other.pairs_visited;
        self.pairs_shaded += other.pairs_shaded;
        self.pairs_in_range += other.pairs_in_range;
        self.pairs_passed_over += other.pairs_passed_over;
    }
}
