//! What a reader passed over or took a default for, each kind once: what, how often, and where first.

use std::collections::HashMap;
use std::fmt::Display;

/// The most kinds that are told apart; more say nothing new.
const MOST_KINDS: usize = 100;

#[derive(Clone, Debug, Default)]
struct Kind {
    message: String,
    first_place: String,
    count: u64,
}

/// Warnings that are counted by their kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    kinds: Vec<Kind>,
    index_of: HashMap<String, usize>,
    /// How many were passed over because there were too many kinds.
    others: u64,
}

impl Tally {
    /// Counts a warning. Those with the same `key` are one kind, which is told by the message and place of the first.
    pub(crate) fn add_as(&mut self, key: &str, place: impl Display, message: impl Display) {
        if let Some(kind) = self.index_of.get(key).and_then(|index| self.kinds.get_mut(*index)) {
            kind.count += 1;
        } else if self.kinds.len() < MOST_KINDS {
            self.index_of.insert(key.to_owned(), self.kinds.len());
            self.kinds.push(Kind { message: message.to_string(), first_place: place.to_string(), count: 1 });
        } else {
            self.others += 1;
        }
    }

    /// One line for each kind, in the order in which they came first.
    pub(crate) fn into_lines(self) -> Vec<String> {
        let line = |Kind { message, first_place, count }: Kind| match (first_place.is_empty(), count) {
            (true, 1) => message,
            (true, _) => format!("{count} times: {message}"),
            (false, 1) => format!("{first_place}: {message}"),
            (false, _) => format!("{first_place} (first of {count}): {message}"),
        };
        let mut lines: Vec<String> = self.kinds.into_iter().map(line).collect();
        if self.others > 0 {
            lines.push(format!("{} warnings of other kinds are left out", self.others));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_told_once_with_its_count_and_first_place() {
        let mut tally = Tally::default();
        tally.add("line 3", "a");
        tally.add("line 5", "b");
        tally.add("line 7", "a");
        tally.add("", "c");
        tally.add_as("d", "line 8", "d of 1");
        tally.add_as("d", "line 9", "d of 2");
        (0..150).for_each(|i| tally.add(i, &format!("kind {i}")));
        let lines = tally.into_lines();
        assert_eq!(lines[..4], ["line 3 (first of 2): a", "line 5: b", "c", "line 8 (first of 2): d of 1"]);
        assert_eq!((lines.len(), lines[100].as_str()), (101, "54 warnings of other kinds are left out"));
    }
}
