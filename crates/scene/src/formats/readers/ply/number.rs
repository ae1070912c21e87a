//! Numbers as they are written.

/// A number, which may be without end, or none: scanners write what they did not see so.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    // As Microsoft's libraries print it: 1.#QNAN, -1.#IND, 1.#INF.
    if word.contains(&b'#') {
        let start = word.split(|byte| *byte == b'#').next()?;
        return std::str::from_utf8(start).ok()?.parse::<f64>().ok().map(|_| f64::NAN);
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}
