//! What Arrow says of the columns of a Parquet file beside the types of Parquet: durations, which are plain whole numbers in these, and units.
//!
//! A writer of Arrow keeps its schema under the key `ARROW:schema`: a message of Arrow's IPC format in base64, a table of FlatBuffers (`format/Message.fbs`,
//! `format/Schema.fbs` of the Arrow project). Each place is looked up, so that a damaged one says nothing.

use std::collections::HashMap;

/// Fields of the tables, by their numbers.
const HEADER: usize = 2;
const FIELDS: usize = 1;
const NAME: usize = 0;
const KIND: usize = 2;
const TYPE: usize = 3;
const CHILDREN: usize = 5;
const METADATA: usize = 6;
const KEY: usize = 0;
const VALUE: usize = 1;
const UNIT: usize = 0;
/// The kind of a duration.
const DURATION: u8 = 18;
/// Fields within fields that are followed.
const DEEPEST: usize = 16;

/// What is said of columns, by their paths.
#[derive(Default)]
pub(super) struct Said {
    /// Seconds in the unit of each column of durations.
    pub durations: HashMap<String, f64>,
    /// Metadata `unit` or `units`.
    pub units: HashMap<String, String>,
}

/// What a schema says.
pub(super) fn said(schema: &str) -> Said {
    let mut found = Said::default();
    let bytes = base64(schema);
    // a mark and a length stand before the message
    let message = match bytes.get(..4) {
        Some([0xFF, 0xFF, 0xFF, 0xFF]) => bytes.get(8..),
        _ => bytes.get(4..),
    };
    let buffer = Buffer(message.unwrap_or_default());
    if let Some(fields) = buffer.follow(0).and_then(|message| buffer.child(buffer.child(message, HEADER)?, FIELDS)) {
        buffer.fields(fields, "", 0, &mut found);
    }
    found
}

/// Bytes in which tables refer to places.
struct Buffer<'a>(&'a [u8]);

impl Buffer<'_> {
    fn bytes<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        self.0.get(at..)?.first_chunk().copied()
    }

    fn count(&self, at: usize) -> Option<usize> {
        usize::try_from(u32::from_le_bytes(self.bytes(at)?)).ok()
    }

    /// The place to which the one at `at` refers.
    fn follow(&self, at: usize) -> Option<usize> {
        at.checked_add(self.count(at)?)
    }

    /// Where a field of a table stands; `None` where it has its default.
    fn field(&self, table: usize, number: usize) -> Option<usize> {
        let back = i32::from_le_bytes(self.bytes(table)?);
        let entries = table.checked_add_signed(isize::try_from(back).ok()?.checked_neg()?)?;
        let entry = 4 + 2 * number;
        let size = usize::from(u16::from_le_bytes(self.bytes(entries)?));
        let offset = usize::from(u16::from_le_bytes(self.bytes(entries.checked_add(entry)?)?));
        (entry < size && offset > 0).then(|| table + offset)
    }

    /// The table, list or text that is a field of a table.
    fn child(&self, table: usize, number: usize) -> Option<usize> {
        self.follow(self.field(table, number)?)
    }

    /// The text that is a field of a table.
    fn text(&self, table: usize, number: usize) -> Option<&str> {
        let bytes = self.child(table, number).and_then(|at| self.0.get(at + 4..)?.get(..self.count(at)?))?;
        std::str::from_utf8(bytes).ok()
    }

    /// The tables of a list.
    fn each(&self, list: usize) -> impl Iterator<Item = usize> {
        // no more places than bytes
        let count = self.count(list).unwrap_or(0).min(self.0.len() / 4);
        (0..count).filter_map(move |k| self.follow(list + 4 * (k + 1)))
    }

    /// What is said of a list of fields and of what is in these.
    fn fields(&self, list: usize, path: &str, depth: usize, found: &mut Said) {
        for field in self.each(list) {
            let Some(name) = self.text(field, NAME) else { continue };
            let path = if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
            let mut metadata = self.child(field, METADATA).into_iter().flat_map(|list| self.each(list));
            let is_unit = |key: &str| ["unit", "units"].iter().any(|name| key.eq_ignore_ascii_case(name));
            if let Some(pair) = metadata.find(|pair| self.text(*pair, KEY).is_some_and(is_unit)) {
                found.units.extend(self.text(pair, VALUE).map(|unit| (path.clone(), unit.trim().to_string())));
            }
            let kind = self.field(field, KIND).and_then(|at| self.bytes(at));
            if kind == Some([DURATION]) {
                let unit = self.child(field, TYPE).and_then(|kind_table| self.bytes(self.field(kind_table, UNIT)?));
                // milliseconds are the default
                let seconds = match unit.map_or(1, u16::from_le_bytes) {
                    0 => 1.0,
                    1 => 1e-3,
                    2 => 1e-6,
                    _ => 1e-9,
                };
                found.durations.insert(path, seconds);
            } else if let Some(children) = self.child(field, CHILDREN).filter(|_| depth < DEEPEST) {
                self.fields(children, &path, depth + 1, found);
            }
        }
    }
}

/// The bytes of base64, up to what is none.
fn base64(text: &str) -> Vec<u8> {
    let digit = |letter: u8| match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' | b'-' => Some(62),
        b'/' | b'_' => Some(63),
        _ => None,
    };
    let (mut bytes, mut bits, mut held) = (Vec::with_capacity(text.len() / 4 * 3), 0, 0_u32);
    for value in text.bytes().map_while(digit) {
        (held, bits) = (held << 6 | u32::from(value), bits + 6);
        if bits >= 8 {
            bits -= 8;
            let [byte, ..] = (held >> bits).to_le_bytes();
            bytes.push(byte);
        }
    }
    bytes
}
