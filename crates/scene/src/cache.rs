//! What is dear to make and the same in the next process.

use std::fmt::Debug;

/// A cache of bytes by name, which may drop entries at any time: they are computed again. Names are made of letters,
/// digits and `-`.
pub trait Cache: Debug + Send + Sync {
    /// What was put there under this name.
    fn get(&self, name: &str) -> Option<Vec<u8>>;
    /// Keeps `bytes` under this name. What cannot be kept is not.
    fn put(&self, name: &str, bytes: &[u8]);
}
