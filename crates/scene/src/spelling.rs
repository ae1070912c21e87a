//! The name that somebody may have meant.

/// Longer names are compared with none: the work grows with the product of two lengths.
const LONGEST: usize = 200;

/// The known name that is most like `name`, if two of three letters stay.
pub fn nearest<'k>(name: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    let near = known.filter(|known| name.len().max(known.len()) <= LONGEST);
    let (distance, nearest) = near.map(|known| (edit_distance(name, known), known)).min()?;
    (3 * distance <= name.len()).then_some(nearest)
}

/// The least number of bytes that must be changed, put in or taken out to make `b` of `a` (Levenshtein 1966).
pub fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let (mut diagonal, mut left) = (i, i + 1);
        for (above, y) in row.iter_mut().skip(1).zip(b.bytes()) {
            let least = (*above + 1).min(left + 1).min(diagonal + usize::from(x != y));
            diagonal = *above;
            (*above, left) = (least, least);
        }
        if let Some(first) = row.first_mut() {
            *first = i + 1;
        }
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn likeness_is_the_number_of_changes() {
        for (a, b, expected) in [("", "", 0), ("", "abc", 3), ("abc", "", 3), ("kitten", "sitting", 3), ("a", "b", 1)] {
            assert_eq!(edit_distance(a, b), expected, "{a} {b}");
        }
        let known = ["range_m", "radius_m", "name"];
        assert_eq!(nearest("rang_m", known.into_iter()), Some("range_m"));
        assert_eq!(nearest("colour", known.into_iter()), None);
    }
}
