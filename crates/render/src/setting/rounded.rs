//! Lengths of loops that are settings.

/// The first of `lengths` that is at least `length`, else the last; they ascend.
///
/// Software adapters make a shader anew for each value of a uniform that a loop's length depends on, so that such a
/// length is an `override` constant, and each makes a pipeline. A slider that is dragged makes no more than there are
/// `lengths`. Defaults and what tiers of quality ask for are among them.
pub(crate) fn rounded_up(length: u32, lengths: &[u32]) -> u32 {
    lengths.iter().copied().find(|known| *known >= length).or(lengths.last().copied()).unwrap_or(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_is_rounded_up_to_the_next_and_the_last_is_the_most() {
        let rounded = [0, 1, 4, 5, 8, 9].map(|length| rounded_up(length, &[0, 4, 8]));
        assert_eq!(rounded, [0, 4, 4, 8, 8, 8]);
    }
}
