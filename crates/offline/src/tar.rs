//! Headers of tar archives: `ustar`, as POSIX.1-1988 has it. The same files are the same bytes: they belong to nobody
//! and have no time.

use crate::stream::StreamError;

/// Bytes of a header; contents are filled up to a multiple of it.
pub(crate) const BLOCK_BYTES: usize = 512;

/// What ends an archive: two empty blocks.
pub(crate) const END: [u8; 2 * BLOCK_BYTES] = [0; 2 * BLOCK_BYTES];

/// The room for a name.
const NAME_BYTES: usize = 100;

/// The room for the folders before a name.
const PREFIX_BYTES: usize = 155;

/// The largest file: eleven octal digits.
const FILE_BYTES_MAX: u64 = (1 << 33) - 1;

/// Where the checksum stands, and how long it is.
const CHECKSUM: (usize, usize) = (148, 8);

/// The header of a file of so many bytes.
///
/// # Errors
/// If the name or the file is too long.
pub(crate) fn header(name: &str, bytes: u64) -> Result<[u8; BLOCK_BYTES], StreamError> {
    let (folders, rest) = split(name).ok_or_else(|| StreamError::LongName(name.to_owned()))?;
    if bytes > FILE_BYTES_MAX {
        return Err(StreamError::LargeFile(name.to_owned()));
    }
    let mut header = [0; BLOCK_BYTES];
    let mut put = |at: usize, field: &[u8]| {
        for (to, from) in header.iter_mut().skip(at).zip(field) {
            *to = *from;
        }
    };
    put(0, rest.as_bytes());
    // Mode, owner, group, size and time; octal digits and an end.
    put(100, b"0000644\0");
    put(108, b"0000000\0");
    put(116, b"0000000\0");
    put(124, format!("{bytes:011o}\0").as_bytes());
    put(136, b"00000000000\0");
    // The checksum is taken with spaces in its place.
    put(CHECKSUM.0, &[b' '; CHECKSUM.1]);
    // An ordinary file; then the magic number and the version.
    put(156, b"0");
    put(257, b"ustar\x0000");
    put(329, b"0000000\0");
    put(337, b"0000000\0");
    put(345, folders.as_bytes());
    let sum = checksum(&header);
    for (to, from) in header.iter_mut().skip(CHECKSUM.0).zip(format!("{sum:06o}\0 ").as_bytes()) {
        *to = *from;
    }
    Ok(header)
}

/// The sum of all bytes.
fn checksum(header: &[u8]) -> u32 {
    header.iter().map(|byte| u32::from(*byte)).sum()
}

/// The folders and the rest of a name that fit their fields.
fn split(name: &str) -> Option<(&str, &str)> {
    if name.len() <= NAME_BYTES {
        return Some(("", name));
    }
    let mut parts = name.match_indices('/').filter_map(|(at, _)| Some((name.get(..at)?, name.get(at + 1..)?)));
    parts.find(|(folders, rest)| folders.len() <= PREFIX_BYTES && (1..=NAME_BYTES).contains(&rest.len()))
}

/// How many zeros follow a file of so many bytes.
pub(crate) fn padding(bytes: usize) -> usize {
    bytes.next_multiple_of(BLOCK_BYTES) - bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text of a field before its end.
    fn field(header: &[u8], at: usize, bytes: usize) -> String {
        let field = &header[at..at + bytes];
        let end = field.iter().position(|byte| *byte == 0).unwrap_or(bytes);
        String::from_utf8(field[..end].to_vec()).expect("text")
    }

    #[test]
    fn a_header_has_its_fields_and_a_checksum() {
        let header = header("a_0001.png", 1234).expect("a header");
        assert_eq!(field(&header, 0, 100), "a_0001.png");
        assert_eq!((field(&header, 100, 8), field(&header, 124, 12)), ("0000644".into(), "00000002322".into()));
        assert_eq!((&header[136..148], &header[156..157]), (&b"00000000000\0"[..], &b"0"[..]));
        assert_eq!(&header[257..265], b"ustar\x0000");
        let mut without = header;
        without[148..156].fill(b' ');
        let expected: u32 = without.iter().map(|byte| u32::from(*byte)).sum();
        assert_eq!(u32::from_str_radix(&field(&header, 148, 8), 8).expect("octal"), expected);
        assert_eq!(header[154..156], [0, b' ']);
    }

    #[test]
    fn long_names_are_split_at_a_folder_or_refused() {
        let (folder, file) = ("f".repeat(90), "n".repeat(90));
        let header_of = |name: &str| header(name, 0);
        let split = header_of(&format!("{folder}/{file}")).expect("split");
        assert_eq!((field(&split, 345, 155), field(&split, 0, 100)), (folder, file));
        assert!(header_of(&"n".repeat(100)).is_ok());
        assert!(matches!(header_of(&"n".repeat(101)), Err(StreamError::LongName(name)) if name.len() == 101));
        assert!(matches!(header("a", 1 << 33), Err(StreamError::LargeFile(_))));
    }

    #[test]
    fn contents_end_at_a_block() {
        assert_eq!([0, 1, 511, 512, 513].map(padding), [0, 511, 1, 0, 511]);
    }
}
