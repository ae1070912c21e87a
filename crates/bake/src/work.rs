//! Work that threads share, and that goes on where it was interrupted.

use crate::BakeError;
use crate::progress::{Progress, Stage};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Texels that a thread takes at a time.
pub(crate) const BLOCK: usize = 1024;

/// Keeps blocks of a bake that is interrupted, for one of the same scene with the same settings.
pub trait Keeper: Sync {
    /// What was kept of a block of a round.
    fn get(&self, round: u32, block: u32) -> Option<Vec<u8>>;
    /// Keeps a block of a round. What cannot be kept is not.
    fn put(&self, round: u32, block: u32, bytes: &[u8]);
}

/// Keeps nothing.
impl Keeper for () {
    fn get(&self, _: u32, _: u32) -> Option<Vec<u8>> {
        None
    }

    fn put(&self, _: u32, _: u32, _: &[u8]) {}
}

/// Does something with each of many blocks, which threads take in turn: what comes out does not depend on how many there
/// are. Blocks have `size` texels or probes each, `total` together.
///
/// # Errors
/// `progress` says to stop.
pub(crate) fn each_block<B: Send>(
    blocks: impl Iterator<Item = B> + Send,
    (size, total): (usize, usize),
    (progress, stage): (&dyn Progress, Stage),
    work: impl Fn(usize, B) + Sync,
) -> Result<(), BakeError> {
    let (is_stopped, done) = (AtomicBool::new(false), Mutex::new(0));
    let blocks = Mutex::new(blocks.enumerate());
    let run = || {
        while !is_stopped.load(Ordering::Relaxed) {
            let Some((number, block)) = blocks.lock().unwrap_or_else(PoisonError::into_inner).next() else { break };
            work(number, block);
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            *done += size;
            if !progress.step(stage, (*done).min(total) as u64, total as u64) {
                is_stopped.store(true, Ordering::Relaxed);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        // Where no further thread can be had, the others do its work.
        (1..threads).for_each(|_| drop(std::thread::Builder::new().spawn_scoped(scope, run)));
        run();
    });
    if is_stopped.into_inner() { Err(BakeError::Interrupted) } else { Ok(()) }
}

/// Computes every value by its index.
///
/// # Errors
/// `progress` says to stop.
pub(crate) fn share_out<T: Send>(
    values: &mut [T],
    progress: (&dyn Progress, Stage),
    compute: impl Fn(usize) -> T + Sync,
) -> Result<(), BakeError> {
    let total = values.len();
    each_block(values.chunks_mut(BLOCK), (BLOCK, total), progress, |number, block| {
        for (index, value) in block.iter_mut().enumerate() {
            *value = compute(number * BLOCK + index);
        }
    })
}

/// Computes numbers for every texel or probe, `N` each, as blocks that `keeper` may know, and gives them to `place`, which is called
/// once a block with the numbers of its texels.
///
/// # Errors
/// `progress` says to stop.
pub(crate) fn keep_blocks<B: Send, const N: usize>(
    blocks: impl Iterator<Item = B> + Send,
    (size, total): (usize, usize),
    progress: (&dyn Progress, Stage),
    (keeper, round): (&dyn Keeper, u32),
    compute: impl Fn(usize) -> [f32; N] + Sync,
    place: impl Fn(B, &[[f32; N]]) + Sync,
) -> Result<(), BakeError> {
    each_block(blocks, (size, total), progress, |number, block| {
        let texels = number * size..total.min((number + 1) * size);
        let known = keeper.get(round, number as u32).and_then(|bytes| numbers(&bytes, texels.len()));
        let values = known.unwrap_or_else(|| {
            let values: Vec<[f32; N]> = texels.map(&compute).collect();
            keeper.put(
                round,
                number as u32,
                &values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>(),
            );
            values
        });
        place(block, &values);
    })
}

/// The numbers of a block of `count` texels.
fn numbers<const N: usize>(bytes: &[u8], count: usize) -> Option<Vec<[f32; N]>> {
    let (words, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() || words.len() != count * N {
        return None;
    }
    let values: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    Some(values.chunks_exact(N).filter_map(|values| values.try_into().ok()).collect())
}
