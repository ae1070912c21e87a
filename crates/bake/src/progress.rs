//! How far a bake is.

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Surfaces are laid out.
    Layout,
    /// What lies inside something is found.
    Inside,
    /// Light that comes straight from where it is made.
    Direct,
    /// Light that was sent back so many times.
    Bounce(u32),
    /// Occlusion.
    Occlusion,
    /// The light of probes.
    Probes,
    /// Pictures of what is to be seen around places.
    Surroundings,
    /// Noise is taken out.
    Finish,
}

/// Is told how far a bake is.
pub trait Progress: Sync {
    /// So many of `total` steps of a stage are done; a total of 0 is not known. Gives whether to go on. Threads call it,
    /// one at a time.
    fn step(&self, stage: Stage, done: u64, total: u64) -> bool;
}

/// Goes on without a word.
impl Progress for () {
    fn step(&self, _: Stage, _: u64, _: u64) -> bool {
        true
    }
}
