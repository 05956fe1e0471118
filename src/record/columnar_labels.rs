//! Labels from the pages of a Parquet column: each entry of a dictionary is looked up once, and a row costs an index.

use super::Labels;
use crate::elements::Parts;
use parquet::basic::{Encoding, Type};
use parquet::column::page::{Page, PageReader};
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;

type Read<T> = Result<T, ParquetError>;

/// A column of texts on its way.
pub(super) struct Pages {
    reader: Box<dyn PageReader>,
    /// May rows be without a text?
    is_optional: bool,
    /// Numbers of the dictionary's entries.
    entries: Vec<f64>,
    /// Numbers of rows that were decoded, from `next` on not yet handed on.
    rows: Vec<f64>,
    next: usize,
    present: Vec<u32>,
    indices: Vec<u32>,
}

/// Most texts of a page: what says that it has more was damaged.
const MOST: usize = 1 << 26;

fn cut_off() -> ParquetError {
    ParquetError::EOF("a page of texts is shorter than it says".into())
}

/// Can a column be read this way: flat texts, by a dictionary or plain?
pub(super) fn reads(column: &ColumnChunkMetaData) -> bool {
    let descriptor = column.column_descr();
    let known = |encoding: Encoding| {
        matches!(encoding, Encoding::PLAIN | Encoding::RLE | Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY)
    };
    column.column_type() == Type::BYTE_ARRAY
        && descriptor.max_rep_level() == 0
        && descriptor.max_def_level() <= 1
        && column.encodings().all(known)
}

impl Pages {
    pub(super) fn new(reader: Box<dyn PageReader>, is_optional: bool) -> Self {
        Pages {
            reader,
            is_optional,
            entries: Vec::new(),
            rows: Vec::new(),
            next: 0,
            present: Vec::new(),
            indices: Vec::new(),
        }
    }

    /// The numbers of the next rows, as many as asked for unless the column ends.
    pub(super) fn read(&mut self, count: usize, to: &mut Vec<f64>, labels: &mut Labels) -> Read<()> {
        while to.len() < count {
            if self.next >= self.rows.len() && !self.page(labels)? {
                break;
            }
            let end = self.rows.len().min(self.next + count - to.len());
            to.extend_from_slice(self.rows.part(self.next..end));
            self.next = end;
        }
        Ok(())
    }

    /// Decode a page; `false` after the last.
    fn page(&mut self, labels: &mut Labels) -> Read<bool> {
        self.rows.clear();
        self.next = 0;
        let Some(page) = self.reader.get_next_page()? else { return Ok(false) };
        let (bytes, count, encoding) = (page.buffer().clone(), page.num_values() as usize, page.encoding());
        if count > MOST {
            return Err(ParquetError::General(format!("a page of {count} texts")));
        }
        let bytes = bytes.as_ref();
        self.present.clear();
        let values = match &page {
            Page::DictionaryPage { .. } => {
                self.entries.clear();
                texts(bytes, count, |text| self.entries.push(labels.number(text)))?;
                return Ok(true);
            }
            Page::DataPage { .. } if !self.is_optional => bytes,
            Page::DataPage { .. } => {
                let (size, rest) = bytes.split_first_chunk::<4>().ok_or_else(cut_off)?;
                let (levels, rest) = rest.split_at_checked(u32::from_le_bytes(*size) as usize).ok_or_else(cut_off)?;
                hybrid(levels, 1, count, &mut self.present)?;
                rest
            }
            Page::DataPageV2 { def_levels_byte_len, rep_levels_byte_len, .. } => {
                let (_, rest) = bytes.split_at_checked(*rep_levels_byte_len as usize).ok_or_else(cut_off)?;
                let (levels, rest) = rest.split_at_checked(*def_levels_byte_len as usize).ok_or_else(cut_off)?;
                if self.is_optional {
                    hybrid(levels, 1, count, &mut self.present)?;
                }
                rest
            }
        };
        let here = if self.is_optional { self.present.iter().filter(|level| **level == 1).count() } else { count };
        let rows = &mut self.rows;
        match encoding {
            Encoding::PLAIN => texts(values, here, |text| rows.push(labels.number(text)))?,
            _ => {
                let (width, values) = values.split_first().map_or((0, values), |(width, rest)| (*width, rest));
                self.indices.clear();
                hybrid(values, width, here, &mut self.indices)?;
                for index in &self.indices {
                    let entry = self.entries.get(*index as usize);
                    rows.push(*entry.ok_or_else(|| ParquetError::General("a text beyond its dictionary".into()))?);
                }
            }
        }
        if here < count {
            // rows without a text stay empty
            let mut found = std::mem::take(rows).into_iter();
            rows.extend(self.present.iter().map(|level| match level {
                1 => found.next().unwrap_or(f64::NAN),
                _ => f64::NAN,
            }));
        }
        Ok(true)
    }
}

/// Plain texts: the length of each before its bytes.
fn texts(mut bytes: &[u8], count: usize, mut visit: impl FnMut(&[u8])) -> Read<()> {
    for _ in 0..count {
        let (size, rest) = bytes.split_first_chunk::<4>().ok_or_else(cut_off)?;
        let (text, rest) = rest.split_at_checked(u32::from_le_bytes(*size) as usize).ok_or_else(cut_off)?;
        visit(text);
        bytes = rest;
    }
    Ok(())
}

/// Numbers of `width` bits in runs of equal ones and in groups of eight packed together (Apache Parquet, Encodings.md: RLE/bit-packing hybrid).
fn hybrid(mut bytes: &[u8], width: u8, count: usize, to: &mut Vec<u32>) -> Read<()> {
    if width > 32 {
        return Err(ParquetError::General("indices of more than 32 bits".into()));
    }
    let end = to.len() + count;
    while to.len() < end {
        let (mut header, mut shift) = (0_u64, 0);
        loop {
            let (byte, rest) = bytes.split_first().ok_or_else(cut_off)?;
            bytes = rest;
            header |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                break;
            }
            if shift > 56 {
                return Err(cut_off());
            }
        }
        let left = end - to.len();
        if header & 1 == 0 {
            let (code, rest) = bytes.split_at_checked(usize::from(width.div_ceil(8))).ok_or_else(cut_off)?;
            let value = code.iter().rev().fold(0_u32, |sum, byte| (sum << 8) | u32::from(*byte));
            // longer than memory is longer than what is left
            to.resize(to.len() + left.min(usize::try_from(header >> 1).unwrap_or(usize::MAX)), value);
            bytes = rest;
            if header >> 1 == 0 {
                return Err(cut_off());
            }
            continue;
        }
        // a header that no memory could hold: the length that is left decides
        let groups = usize::try_from(header >> 1).unwrap_or(usize::MAX);
        // the last group may be cut off behind its last number
        let size = groups.saturating_mul(usize::from(width)).min(bytes.len());
        let (packed, rest) = bytes.split_at(size);
        bytes = rest;
        let numbers = groups.saturating_mul(8).min(left);
        if packed.len().saturating_mul(8) < numbers.saturating_mul(usize::from(width)) || numbers == 0 {
            return Err(cut_off());
        }
        let (mut bits, mut held, mut from) = (0_u64, 0_u32, packed.iter());
        for _ in 0..numbers {
            while held < u32::from(width) {
                bits |= u64::from(*from.next().ok_or_else(cut_off)?) << held;
                held += 8;
            }
            to.push(crate::number::low_half(bits & ((1_u64 << width) - 1)));
            bits >>= width;
            held -= u32::from(width);
        }
    }
    Ok(())
}
