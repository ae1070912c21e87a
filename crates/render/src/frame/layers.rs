//! What a view shows beside its surfaces.

use crate::passes::mirrors::MirrorDraw;
use crate::passes::particles::ParticlesDraw;
use crate::passes::portals::PortalDraw;
use crate::passes::water::WaterDraw;

/// What a view shows beside its surfaces: mirrors, water and portals, whose own views were drawn before, and particles.
#[derive(Debug, Default)]
pub struct SceneLayers {
    /// Mirrors.
    pub mirrors: Vec<MirrorDraw>,
    /// Water, the farthest first.
    pub water: Vec<WaterDraw>,
    /// Ends of portals.
    pub portals: Vec<PortalDraw>,
    /// Particles.
    pub particles: Vec<ParticlesDraw>,
}
