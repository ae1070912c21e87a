//! NumPy's archives: a ZIP file, stored, of one array for each name.
//!
//! Sources: NEP 1 (the `.npy` format, version 1.0) and PKWARE's APPNOTE.TXT 6.3.10. An array's header holds the number
//! of pictures, and a ZIP entry its length and checksum, so arrays wait in temporary files until the last
//! picture is there. The archive itself is then written from its start to its end, and can go into a pipe.

use crate::atomic::WriteError;
use crate::encode::EncodeError;
use crate::exr_header::ExrPart;
use crate::spool::Spool;
use crate::still::Samples;
use manypass::Aov;

/// A number of 32 bits that says: see the extra field with 64 (APPNOTE 4.5.3).
const SEE_64: u32 = u32::MAX;

/// The 1st of January 1980, the first day that ZIP knows, so that the same arrays are the same bytes.
const DATE: u16 = 0x21;

/// The array of the pictures for the display.
const PICTURES: &str = "frames";

/// Arrays that grow by one picture after the other.
#[derive(Debug)]
pub(crate) struct Arrays {
    size: (u32, u32),
    picture_count: u64,
    /// The display first, then variables.
    arrays: Vec<Array>,
}

/// One array: picture, row, column, component.
#[derive(Debug)]
struct Array {
    name: &'static str,
    /// NumPy's name of the type of its numbers.
    type_name: &'static str,
    components: usize,
    /// Bytes of one picture.
    picture_bytes: u64,
    spool: Spool,
}

/// What the directory says of an entry.
struct Entry {
    name: String,
    crc: u32,
    bytes: u64,
    offset: u64,
}

impl Arrays {
    /// Arrays without pictures.
    ///
    /// # Errors
    /// If no temporary file can be made.
    pub(crate) fn new((width, height): (u32, u32), aovs: &[Aov]) -> Result<Self, WriteError> {
        let pixels = u64::from(width) * u64::from(height);
        let array = |name, type_name, components: usize, value_bytes: u64| {
            let picture_bytes = pixels * components as u64 * value_bytes;
            Ok::<_, WriteError>(Array { name, type_name, components, picture_bytes, spool: Spool::new()? })
        };
        let mut arrays = vec![array(PICTURES, "|u1", 4, 1)?];
        for aov in aovs {
            let info = aov.info();
            let type_name = if ExrPart::of(*aov).is_id { "<u4" } else { "<f4" };
            arrays.push(array(info.name, type_name, info.channels.len(), 4)?);
        }
        Ok(Self { size: (width, height), picture_count: 0, arrays })
    }

    /// Begins a picture; of one that was begun and not ended nothing stays.
    ///
    /// # Errors
    /// If the disk fails.
    pub(crate) fn begin(&mut self) -> Result<(), WriteError> {
        self.arrays.iter_mut().try_for_each(|array| array.spool.forget())
    }

    /// Appends rows of the variable with that index to the picture.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub(crate) fn append(&mut self, index: usize, samples: &Samples) -> Result<(), WriteError> {
        let bytes: Vec<u8> = match samples {
            Samples::Float { data, .. } => data.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Samples::Id(ids) => ids.iter().flat_map(|id| id.to_le_bytes()).collect(),
        };
        self.arrays.get_mut(index + 1).map_or(Ok(()), |array| array.spool.append(&bytes))
    }

    /// Appends the display to the picture, and ends it.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub(crate) fn end(&mut self, rgba8: &[u8]) -> Result<(), WriteError> {
        self.arrays.first_mut().map_or(Ok(()), |array| array.spool.append(rgba8))?;
        self.arrays.iter_mut().for_each(|array| array.spool.keep());
        self.picture_count += 1;
        Ok(())
    }

    /// Whether every variable of the picture has all of its rows.
    ///
    /// # Errors
    /// If one has fewer or more.
    pub(crate) fn check(&self) -> Result<(), EncodeError> {
        let is_wrong = |array: &&Array| array.spool.new_bytes() != array.picture_bytes;
        let Some(array) = self.arrays.iter().skip(1).find(is_wrong) else { return Ok(()) };
        let (found, expected) = (array.spool.new_bytes(), array.picture_bytes);
        let reason = format!("{} has {found} bytes of {expected}", array.name);
        Err(EncodeError::Encoder { format: "NPZ", reason })
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// If the disk fails, or `put` does.
    pub(crate) fn write(mut self, mut put: impl FnMut(&[u8]) -> Result<(), WriteError>) -> Result<(), WriteError> {
        let (width, height) = self.size;
        let (mut entries, mut offset) = (Vec::new(), 0);
        for array in &mut self.arrays {
            let shape = [self.picture_count, height.into(), width.into(), array.components as u64];
            let header = npy_header(array.type_name, shape);
            let bytes = header.len() as u64 + array.spool.kept_bytes();
            let entry =
                Entry { name: format!("{}.npy", array.name), crc: array.spool.crc_after(&header), bytes, offset };
            let local = local_header(&entry);
            put(&local)?;
            put(&header)?;
            array.spool.copy(&mut put)?;
            offset += local.len() as u64 + bytes;
            entries.push(entry);
        }
        let mut directory: Vec<u8> = entries.iter().flat_map(directory_entry).collect();
        let end = directory_end(entries.len(), offset, directory.len() as u64);
        directory.extend_from_slice(&end);
        put(&directory)
    }
}

/// What stands before the numbers of an array, filled up to a multiple of 64 bytes.
fn npy_header(type_name: &str, [pictures, height, width, components]: [u64; 4]) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    const LENGTH_BYTES: usize = 2;
    let mut text = format!(
        "{{'descr': '{type_name}', 'fortran_order': False, 'shape': ({pictures}, {height}, {width}, {components}), }}"
    );
    let before = MAGIC.len() + LENGTH_BYTES;
    // One byte is the end of the line.
    let padded = (before + text.len() + 1).next_multiple_of(64) - before;
    text.extend(std::iter::repeat_n(' ', padded - 1 - text.len()));
    text.push('\n');
    // Four numbers of at most 20 digits: it never has more than some hundreds of bytes.
    [MAGIC, &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat()
}

/// A length or a place as far as 32 bits hold it.
fn low(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(SEE_64)
}

/// Whether 32 bits do not hold it.
fn is_large(value: u64) -> bool {
    low(value) == SEE_64
}

/// The extra field of what 32 bits do not hold; nothing if they hold all.
fn extra_field(values: &[u64]) -> Vec<u8> {
    let large: Vec<u8> =
        values.iter().filter(|value| is_large(**value)).flat_map(|value| value.to_le_bytes()).collect();
    if large.is_empty() {
        return large;
    }
    [&1u16.to_le_bytes()[..], &(large.len() as u16).to_le_bytes(), &large].concat()
}

/// The version of the format that a reader must know: 4.5 for 64 bits, else 2.0.
fn version(values: &[u64]) -> [u8; 2] {
    let needed: u16 = if values.iter().any(|value| is_large(*value)) { 45 } else { 20 };
    needed.to_le_bytes()
}

/// What both headers of an entry have from its flags to the lengths of its name and its extra field.
fn common(entry: &Entry, extra: &[u8]) -> Vec<u8> {
    let bytes = low(entry.bytes).to_le_bytes();
    let mut fields = Vec::new();
    // No flags, stored, and the time of day.
    fields.extend_from_slice(&[0; 6]);
    fields.extend_from_slice(&DATE.to_le_bytes());
    fields.extend_from_slice(&entry.crc.to_le_bytes());
    // The compressed length, and the true one.
    fields.extend_from_slice(&bytes);
    fields.extend_from_slice(&bytes);
    fields.extend_from_slice(&(entry.name.len() as u16).to_le_bytes());
    fields.extend_from_slice(&(extra.len() as u16).to_le_bytes());
    fields
}

/// What stands before an entry's bytes (APPNOTE 4.3.7).
fn local_header(entry: &Entry) -> Vec<u8> {
    let lengths = [entry.bytes, entry.bytes];
    let extra = extra_field(&lengths);
    [&b"PK\x03\x04"[..], &version(&lengths)[..], &common(entry, &extra)[..], entry.name.as_bytes(), &extra[..]].concat()
}

/// What the directory says of an entry (APPNOTE 4.3.12).
fn directory_entry(entry: &Entry) -> Vec<u8> {
    let numbers = [entry.bytes, entry.bytes, entry.offset];
    let extra = extra_field(&numbers);
    let mut fields = b"PK\x01\x02".to_vec();
    // Made by the version that is needed, on a system with the attributes of MS-DOS.
    fields.extend_from_slice(&version(&numbers));
    fields.extend_from_slice(&version(&numbers));
    fields.extend_from_slice(&common(entry, &extra));
    // No comment, the first disk, no attributes.
    fields.extend_from_slice(&[0; 10]);
    fields.extend_from_slice(&low(entry.offset).to_le_bytes());
    [&fields[..], entry.name.as_bytes(), &extra[..]].concat()
}

/// What ends the archive (APPNOTE 4.3.14 to 4.3.16).
fn directory_end(entry_count: usize, offset: u64, bytes: u64) -> Vec<u8> {
    let count = entry_count as u64;
    let mut end = Vec::new();
    if is_large(offset) || is_large(bytes) {
        let (end_offset, needed) = (offset + bytes, version(&[offset, bytes]));
        end.extend_from_slice(b"PK\x06\x06");
        // The length of what follows in this record.
        end.extend_from_slice(&44u64.to_le_bytes());
        end.extend_from_slice(&[needed, needed].concat());
        // This disk, and that of the directory.
        end.extend_from_slice(&[0; 8]);
        [count, count, bytes, offset].iter().for_each(|value| end.extend_from_slice(&value.to_le_bytes()));
        end.extend_from_slice(b"PK\x06\x07\0\0\0\0");
        end.extend_from_slice(&end_offset.to_le_bytes());
        end.extend_from_slice(&1u32.to_le_bytes());
    }
    // There are fewer variables than 16 bits count.
    let short_count = (entry_count as u16).to_le_bytes();
    end.extend_from_slice(b"PK\x05\x06\0\0\0\0");
    end.extend_from_slice(&[short_count, short_count].concat());
    end.extend_from_slice(&low(bytes).to_le_bytes());
    end.extend_from_slice(&low(offset).to_le_bytes());
    // No comment.
    end.extend_from_slice(&[0; 2]);
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_arrays_end_at_a_multiple_of_64() {
        for shape in [[1, 1, 1, 1], [48, 720, 1280, 4], [u64::MAX; 4], [123_456, 16_384, 16_384, 3]] {
            let header = npy_header("<f4", shape);
            assert!(header.len().is_multiple_of(64) && header.ends_with(b"\n"), "{shape:?}: {}", header.len());
            assert_eq!(usize::from(u16::from_le_bytes([header[8], header[9]])), header.len() - 10);
        }
        let header = npy_header("|u1", [2, 3, 5, 4]);
        let text = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 5, 4), }";
        assert_eq!(&header[..8], b"\x93NUMPY\x01\x00");
        assert!(String::from_utf8_lossy(&header[10..]).starts_with(text));
    }

    /// The number of 32 bits at a place.
    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
    }

    #[test]
    fn an_archive_has_whole_pictures_alone() {
        let mut arrays = Arrays::new((2, 1), &[Aov::Depth, Aov::ObjectId]).expect("temporary files");
        let mut picture = |depth: f32, is_whole: bool| {
            arrays.begin().expect("begun");
            arrays.append(0, &Samples::Float { components: 1, data: vec![depth, f32::INFINITY] }).expect("appended");
            assert!(arrays.check().is_err(), "ids are missing");
            arrays.append(1, &Samples::Id(vec![7, u32::MAX])).expect("appended");
            arrays.check().expect("whole");
            if is_whole {
                arrays.end(&[depth as u8; 8]).expect("ended");
            }
        };
        picture(1.0, true);
        picture(2.0, false);
        picture(3.0, true);
        let mut bytes = Vec::new();
        let put = |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok(())
        };
        arrays.write(put).expect("written");
        let depth: Vec<u8> = [1.0, f32::INFINITY, 3.0, f32::INFINITY].iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut at = 0;
        for (name, shape, data) in [
            ("frames.npy", "'|u1', 'fortran_order': False, 'shape': (2, 1, 2, 4)", [[1u8; 8], [3; 8]].concat()),
            ("depth.npy", "'<f4', 'fortran_order': False, 'shape': (2, 1, 2, 1)", depth),
            ("object_id.npy", "'<u4', 'fortran_order': False, 'shape': (2, 1, 2, 1)", {
                [7, u32::MAX, 7, u32::MAX].iter().flat_map(|id| id.to_le_bytes()).collect()
            }),
        ] {
            assert_eq!((&bytes[at..at + 4], &bytes[at + 28..at + 30]), (&b"PK\x03\x04"[..], &[0, 0][..]));
            let (crc, entry_bytes) = (word(&bytes, at + 14), word(&bytes, at + 22) as usize);
            assert_eq!(&bytes[at + 30..at + 30 + name.len()], name.as_bytes());
            let entry = &bytes[at + 30 + name.len()..][..entry_bytes];
            let mut expected = flate2::Crc::new();
            expected.update(entry);
            assert_eq!(crc, expected.sum(), "{name}");
            assert!(String::from_utf8_lossy(entry).contains(shape) && entry.ends_with(&data), "{name}");
            assert_eq!((entry.len() - data.len()) % 64, 0);
            at += 30 + name.len() + entry_bytes;
        }
        let end = bytes.len() - 22;
        assert_eq!((&bytes[at..at + 4], &bytes[end..end + 4]), (&b"PK\x01\x02"[..], &b"PK\x05\x06"[..]));
        assert_eq!((word(&bytes, end + 16) as usize, word(&bytes, end + 12) as usize), (at, end - at));
    }

    #[test]
    fn what_is_larger_than_4_gib_has_numbers_of_64_bits() {
        let entry = Entry { name: "a.npy".into(), crc: 1, bytes: 5 << 30, offset: 6 << 30 };
        let local = local_header(&entry);
        assert_eq!((local[4], word(&local, 18), word(&local, 22)), (45, SEE_64, SEE_64));
        assert_eq!(local[35..], [&[1u8, 0, 16, 0][..], &[5u64 << 30; 2].map(u64::to_le_bytes).concat()].concat());
        let listed = directory_entry(&entry);
        assert_eq!((listed.len(), word(&listed, 42)), (46 + 5 + 28, SEE_64));
        assert_eq!(listed[46 + 5 + 20..], (6u64 << 30).to_le_bytes());
        let end = directory_end(1, 11 << 30, 79);
        assert_eq!((end.len(), word(&end, 56 + 20 + 16)), (56 + 20 + 22, SEE_64));
        assert_eq!(end[56 + 8..56 + 16], ((11u64 << 30) + 79).to_le_bytes());
        let small = Entry { bytes: 5, offset: 6, ..entry };
        assert_eq!((local_header(&small).len(), directory_entry(&small).len()), (30 + 5, 46 + 5));
    }
}
