//! MATLAB files of level 5 (`save -v6`, `-v7`): numeric arrays, also in structs; and of level 4. Level 7.3 is HDF5.
//!
//! The layout is that of *MAT-File Format* (The MathWorks). Left aside: cells, objects, sparse matrices, characters, arrays of structs.

use super::held::{Array, Held, tables};
use super::unpacked::unpacked;
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};

/// Length of the file's head.
const HEAD: usize = 128;
/// Structs inside each other.
const DEEPEST: usize = 16;

/// Longest element that is unpacked: 2^32 bytes are 5e8 numbers.
const LONGEST: u64 = 1 << 32;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Class of a struct.
const STRUCT: u8 = 2;

/// The head of a matrix of level 4, which has no mark of its own: byte order, type of its numbers, class (0: numbers in full), sides, whether it is complex, length of its name.
struct Level4 {
    big: bool,
    kind: u32,
    class: u32,
    sides: (usize, usize),
    complex: bool,
    name: usize,
}

/// Length of that head.
pub(super) const HEAD_4: usize = 20;

impl Level4 {
    /// `None` for what is no such head.
    fn of(bytes: &[u8]) -> Option<Self> {
        let words = bytes.get(..HEAD_4)?.as_chunks::<4>().0;
        [false, true].into_iter().find_map(|big| {
            let word = |word: &[u8; 4]| if big { u32::from_be_bytes(*word) } else { u32::from_le_bytes(*word) };
            let [kind, rows, columns, complex, name] =
                <[u32; 5]>::try_from(words.iter().map(word).collect::<Vec<_>>()).ok()?;
            // thousands are the byte order, tens the type of the numbers, ones the class
            let code = kind.checked_sub(if big { 1000 } else { 0 })?;
            let number = *[9, 7, 5, 3, 4, 2].get((code / 10) as usize)?;
            let is_head = code % 10 <= 2 && rows > 0 && columns > 0 && complex <= 1 && (2..=64).contains(&name);
            let sides = (rows as usize, columns as usize);
            is_head.then_some(Level4 {
                big,
                kind: number,
                class: code % 10,
                sides,
                complex: complex == 1,
                name: name as usize,
            })
        })
    }
}

/// Does a file begin as one of level 4 does?
pub(super) fn is_level_4(first: &[u8]) -> bool {
    Level4::of(first).is_some()
}

/// The matrices of a file of level 4; `None` where one ends too early.
fn level_4(bytes: &[u8]) -> Option<Vec<Array>> {
    let (mut arrays, mut rest) = (Vec::new(), bytes);
    while !rest.is_empty() {
        let head = Level4::of(rest)?;
        let mut reader = Reader { bytes: rest.get(HEAD_4..)?, big: head.big };
        let name = reader.take(head.name)?.split(|byte| *byte == 0).next().unwrap_or_default();
        let size = match head.kind {
            9 => 8,
            7 | 5 => 4,
            3 | 4 => 2,
            _ => 1,
        };
        let length = head.sides.0.checked_mul(head.sides.1)?.checked_mul(size)?;
        let values = reader.take(length)?;
        if head.complex {
            reader.take(length)?;
        } else if head.class == 0 {
            let values = numbers(head.kind, values, head.big)?;
            let name = String::from_utf8_lossy(name).into_owned();
            arrays.push(Array { name, shape: head.sides, values, ..Array::default() });
        }
        rest = reader.bytes;
    }
    Some(arrays)
}

/// Read the table that is meant.
///
/// Errors: a file that was cut off or is none, and those of choosing a table.
pub(super) fn open(name: &str, bytes: &[u8], table: Option<&str>) -> Result<Held> {
    let cut = || {
        Malformed::new(Fault::File, format!("'{name}' is a MATLAB file that was cut off, or is damaged"))
            .expected("whole elements up to the file's end")
            .in_file(name)
    };
    if is_level_4(bytes) {
        let arrays = level_4(bytes)
            .ok_or_else(|| cut().found(format!("{} bytes, and a matrix that does not end", bytes.len())))?;
        return Held::choose(name, "variable", tables(arrays), table);
    }
    let big = match bytes.get(126..HEAD) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err(cut().found("no mark of the byte order in its head")),
    };
    let mut reader = Reader { bytes: bytes.part(HEAD..), big };
    let mut arrays = Vec::new();
    let total = reader.bytes.len();
    while !reader.bytes.is_empty() {
        let at = HEAD + total - reader.bytes.len();
        let broken = || cut().found(format!("{} bytes, and an element at byte {at} that does not end", bytes.len()));
        let (mut kind, mut data) = reader.element(false).ok_or_else(broken)?;
        let plain;
        if kind == COMPRESSED {
            let unpacked = unpacked(data, LONGEST);
            plain = unpacked.map_err(|error| broken().found(format!("{error}, at byte {at}")))?;
            (kind, data) = Reader { bytes: &plain, big }.element(true).ok_or_else(broken)?;
        }
        if kind == MATRIX {
            matrix(&mut Reader { bytes: data, big }, None, "", 0, &mut arrays).ok_or_else(broken)?;
        }
    }
    Held::choose(name, "variable or struct", tables(arrays), table)
}

struct Reader<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(head)
    }

    fn u32(&mut self) -> Option<u32> {
        let word = <[u8; 4]>::try_from(self.take(4)?).ok()?;
        Some(if self.big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
    }

    /// Type and data of the next element; those within a matrix are padded to eight bytes, a compressed one is not.
    fn element(&mut self, last: bool) -> Option<(u32, &'a [u8])> {
        let tag = self.u32()?;
        if tag >> 16 != 0 {
            // a small element: type, length and up to four bytes in eight
            let data = self.take(4)?;
            return Some((tag & 0xFFFF, data.get(..(tag >> 16) as usize)?));
        }
        let length = self.u32()? as usize;
        let data = self.take(length)?;
        if tag != COMPRESSED && !last {
            let padding = (8 - length % 8) % 8;
            self.take(padding.min(self.bytes.len()))?;
        }
        Some((tag, data))
    }

    fn integers(&mut self) -> Option<Vec<i32>> {
        let big = self.big;
        let (_, data) = self.element(false)?;
        let words = data.chunks_exact(4).filter_map(|b| <[u8; 4]>::try_from(b).ok());
        Some(words.map(|b| if big { i32::from_be_bytes(b) } else { i32::from_le_bytes(b) }).collect())
    }
}

/// An array and what is in it; `None` where it ends too early. A field of a struct brings its own name.
fn matrix(
    reader: &mut Reader<'_>,
    field: Option<&str>,
    group: &str,
    depth: usize,
    arrays: &mut Vec<Array>,
) -> Option<()> {
    if reader.bytes.is_empty() {
        return Some(());
    }
    let flags = reader.integers()?;
    let class = flags.first()?.to_le_bytes()[0];
    let complex = flags.first()? & 0x800 != 0;
    if class > 15 {
        return Some(());
    }
    let sides = reader.integers()?;
    let (_, name_bytes) = reader.element(false)?;
    let name = field.map_or_else(|| String::from_utf8_lossy(name_bytes).into_owned(), str::to_string);
    let count: usize = sides.iter().try_fold(1_usize, |n, side| n.checked_mul(usize::try_from(*side).ok()?))?;
    match class {
        STRUCT if count == 1 && depth < DEEPEST => {
            let width = usize::try_from(*reader.integers()?.first()?).ok()?;
            let (_, names) = reader.element(false)?;
            let inside = if group.is_empty() { name } else { format!("{group}/{name}") };
            for field_name in names.chunks(width.max(1)) {
                let text: Vec<u8> = field_name.iter().copied().take_while(|b| *b != 0).collect();
                let (kind, data) = reader.element(false)?;
                if kind == MATRIX {
                    let mut inner = Reader { bytes: data, big: reader.big };
                    matrix(&mut inner, Some(&String::from_utf8_lossy(&text)), &inside, depth + 1, arrays)?;
                }
            }
        }
        6..=15 if !complex && sides.len() == 2 && count > 0 => {
            let (kind, data) = reader.element(false)?;
            let values = numbers(kind, data, reader.big)?;
            if values.len() != count {
                return None;
            }
            let side = |k: usize| sides.get(k).and_then(|n| usize::try_from(*n).ok());
            arrays.push(Array { group: group.into(), name, unit: None, shape: (side(0)?, side(1)?), values });
        }
        _ => {}
    }
    Some(())
}

/// Numbers as they are stored: MATLAB packs whole numbers into the smallest type that holds them.
pub(super) fn numbers(kind: u32, data: &[u8], big: bool) -> Option<Vec<f64>> {
    macro_rules! all {
        ($type:ty) => {
            data.chunks_exact(size_of::<$type>())
                .filter_map(|b| b.try_into().ok())
                .map(|b| (if big { <$type>::from_be_bytes(b) } else { <$type>::from_le_bytes(b) }) as f64)
                .collect()
        };
    }
    Some(match kind {
        1 => all!(i8),
        2 => all!(u8),
        3 => all!(i16),
        4 => all!(u16),
        5 => all!(i32),
        6 => all!(u32),
        7 => all!(f32),
        9 => all!(f64),
        12 => all!(i64),
        13 => all!(u64),
        _ => return None,
    })
}
