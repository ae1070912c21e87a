//! Inputs of a batch that failed: each is said and reported as it happens, the rest goes on.

use crate::failure::{Failure, Kind};
use crate::report::Report;

/// How many inputs failed so far.
#[derive(Debug)]
pub struct Tally {
    input_count: usize,
    failed_count: usize,
    first_kind: Option<Kind>,
}

impl Tally {
    /// None of so many inputs.
    pub fn of(input_count: usize) -> Self {
        Self { input_count, failed_count: 0, first_kind: None }
    }

    /// Reports that an input failed, and at which frame of a sequence. Gives the failure back to be said, with the name
    /// of its input.
    ///
    /// # Errors
    /// The failure itself, if it is that of the only input or nothing can be done after it; or the report's.
    pub fn add(
        &mut self,
        name: &str,
        frame: Option<u32>,
        mut failure: Failure,
        report: Option<&mut Report>,
    ) -> Result<Failure, Failure> {
        report.map_or(Ok(()), |report| report.failed(name, frame, &failure))?;
        if self.input_count < 2 || matches!(failure.kind, Kind::DeviceLost | Kind::Interrupted) {
            return Err(failure);
        }
        if !failure.message.contains(name) {
            failure.message = format!("{name}: {}", failure.message);
        }
        self.first_kind.get_or_insert(failure.kind);
        self.failed_count += 1;
        Ok(failure)
    }

    /// What is said at the end.
    ///
    /// # Errors
    /// How many failed, if any did.
    pub fn result(self) -> Result<(), Failure> {
        let Self { input_count, failed_count, first_kind } = self;
        let Some(kind) = first_kind else { return Ok(()) };
        let others = if failed_count < input_count { "; the others are done" } else { "" };
        let message = format!("{failed_count} of {input_count} inputs failed");
        Err(Failure::new(kind, message, format!("the messages above say why{others}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_others_are_done_only_where_there_are_others() {
        let failure = || Failure::new(Kind::Failed, "broken", "mend it");
        let mut tally = Tally::of(2);
        assert_eq!(tally.add("a.glb", None, failure(), None).expect("said").message, "a.glb: broken");
        let result = Tally { ..tally }.result().expect_err("one failed");
        assert!(result.message == "1 of 2 inputs failed" && result.hint.ends_with("; the others are done"));
        tally.add("b.glb", Some(3), failure(), None).expect("said");
        assert_eq!(tally.result().expect_err("both failed").hint, "the messages above say why");
        assert_eq!(Tally::of(1).add("a.glb", None, failure(), None).expect_err("the only one").message, "broken");
        assert!(Tally::of(2).result().is_ok());
    }
}
