//! Lists in hints.

/// The most entries that a hint lists.
const MOST_ENTRIES: usize = 40;

/// What can be chosen by name or index, with the indices: a name may be missing or be there twice.
pub fn choices<'a>(kind: &str, entries: impl IntoIterator<Item = (usize, &'a str)>) -> String {
    let mut listed: Vec<String> = entries
        .into_iter()
        .map(|(index, name)| if name.is_empty() { format!("{index} (no name)") } else { format!("{index} `{name}`") })
        .collect();
    if listed.is_empty() {
        return format!("the file has no {kind}");
    }
    let more = listed.len().saturating_sub(MOST_ENTRIES);
    listed.truncate(MOST_ENTRIES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{kind} by index or name: {}{more}", listed.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_stand_before_names() {
        assert_eq!(choices("cameras", [(0, "A"), (2, "")]), "cameras by index or name: 0 `A`, 2 (no name)");
        assert_eq!(choices("cameras", []), "the file has no cameras");
        assert!(choices("cameras", (0..50).map(|index| (index, "A"))).ends_with("39 `A` and 10 more"));
    }
}
