//! Reading the first input while the graphics driver starts, which takes about as long.

use crate::failure::Failure;
use crate::input::{Input, InputScene};
use std::thread::JoinHandle;

type InputResult = Result<InputScene, Failure>;

/// An input that is being read on a thread of its own.
pub struct ReadAhead {
    input: Input,
    reader: JoinHandle<InputResult>,
}

impl ReadAhead {
    /// Starts to read `input`. Standard input waits for its turn: whoever writes to it may wait for a message of ours
    /// first. None, too, where the process may have no more threads.
    pub fn start(input: &Input) -> Option<Self> {
        if *input == Input::Stdin {
            return None;
        }
        let of_thread = input.clone();
        let reader = std::thread::Builder::new().spawn(move || of_thread.load()).ok()?;
        Some(Self { input: input.clone(), reader })
    }

    /// The scene of `input`, by whichever way it is there first.
    ///
    /// # Errors
    /// As [`Input::load`].
    pub fn take(ahead: &mut Option<Self>, input: &Input) -> InputResult {
        match ahead.take() {
            // A reader that panicked says so again where it is not alone.
            Some(ahead) if ahead.input == *input => ahead.reader.join().unwrap_or_else(|_| input.load()),
            _ => input.load(),
        }
    }
}
