//! Which files this program wrote itself, so that it may write them anew: each kind says so in its content.
//!
//! | what | says it by |
//! |---|---|
//! | reports | their keys `report` and `tumble` |
//! | campaigns, benches, missions | their first line, with a digest of what follows: one that somebody has changed since is that person's |
//! | workbooks | a digest of their cells: one in which somebody has written since is that person's |
//! | Parquet | the program that it names as its writer |
//! | tables of text | titles that only this program gives, or the notation of the numbers in the last column below titles that others give, too |
//! | pages, sources, other text | the program's name at the beginning or at the end |

use crate::report::{Input, VERSION};
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde::de::Deserializer as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// With its version, what a Parquet file names as the program that wrote it.
pub(super) const WRITER: &str = "tumble ";
/// Bytes in which a text says what wrote it.
const BEGINNING: u64 = 1 << 16;
/// Names that tables of text end in.
const TABLES: [&str; 5] = [".csv", ".tsv", ".jsonl", ".ndjson", ".gz"];
/// Titles that end a row of a device, in rows of fits and of diagnoses.
const OF_DEVICES: [&[&str]; 2] = [&["normality_p", "suspects", "schedule", "why"], &["units", "p", "aliases", "why"]];

/// The text before the digest in the first line of a file that is read again.
const MARK: &str = "{\n  \"$comment\": \"Written by tumble ";
const DIGEST: &str = ", which replaces it unless it was changed; SHA-256 of the lines below: ";

/// JSON text of an object with a first line that says what wrote it, and the digest of what follows.
pub(super) fn mark(text: &str) -> String {
    let body = text.strip_prefix("{\n").unwrap_or(text);
    format!("{MARK}{VERSION}{DIGEST}{}\",\n{body}", Input::new("", body.as_bytes()).sha256)
}

/// May a file be replaced: is it empty, not there, or of this program's making?
pub(super) fn may_go(path: &Path) -> bool {
    let Ok(there) = path.metadata() else { return true };
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut first = [0; 4];
    let parquet = File::open(path).is_ok_and(|mut file| file.read_exact(&mut first).is_ok()) && &first == b"PAR1";
    match there.len() {
        0 => true,
        _ if parquet => is_our_parquet(path),
        #[cfg(feature = "excel")]
        _ if name.ends_with(".xlsx") => crate::document::workbook::is_untouched(path),
        _ if TABLES.iter().any(|ending| name.ends_with(ending)) => is_our_table(path).unwrap_or(false),
        _ if name.ends_with(".json") => is_our_json(path),
        _ => mentions_this_program(path),
    }
}

fn is_our_parquet(path: &Path) -> bool {
    let file = File::open(path).ok().and_then(|file| SerializedFileReader::new(file).ok());
    file.is_some_and(|file| file.metadata().file_metadata().created_by().is_some_and(|by| by.starts_with(WRITER)))
}

/// A report, a marked file that nobody has changed, or an object that says nothing at all.
fn is_our_json(path: &Path) -> bool {
    let Ok(file) = File::open(path) else { return false };
    let mut file = BufReader::new(file);
    if file.fill_buf().is_ok_and(|beginning| beginning.starts_with(MARK.as_bytes())) {
        let mut text = String::new();
        let whole = file.read_to_string(&mut text).is_ok();
        let lines = text.strip_prefix(MARK).and_then(|text| text.split_once("\",\n")).filter(|_| whole);
        return lines
            .and_then(|(said, body)| Some((said.split_once(DIGEST)?.1, body)))
            .is_some_and(|(digest, body)| digest == Input::new("", body.as_bytes()).sha256);
    }
    let mut keys = Keys::default();
    let whole = serde_json::Deserializer::from_reader(file).deserialize_map(&mut keys).is_ok();
    (keys.report && keys.tumble) || (whole && keys.any == 0)
}

/// The keys of an object, up to those of a report: behind them may be a million readings.
#[derive(Default)]
struct Keys {
    any: usize,
    report: bool,
    tumble: bool,
}

impl<'de> serde::de::Visitor<'de> for &mut Keys {
    type Value = ();

    fn expecting(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str("an object")
    }

    fn visit_map<A: serde::de::MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            self.any += 1;
            self.report |= key == "report";
            self.tumble |= key == "tumble";
            if self.report && self.tumble {
                return Err(serde::de::Error::custom("a report"));
            }
            map.next_value::<serde::de::IgnoredAny>()?;
        }
        Ok(())
    }
}

/// A table of text that this program wrote. `None` where it cannot be read as one.
fn is_our_table(path: &Path) -> Option<bool> {
    let mut file = BufReader::new(File::open(path).ok()?);
    if file.fill_buf().ok()?.starts_with(b"{") {
        // rows of devices: a JSON object each
        let mut line = String::new();
        file.take(BEGINNING).read_line(&mut line).ok()?;
        let last = |titles: &&[&str]| titles.iter().all(|title| line.contains(&format!("\"{title}\":")));
        return Some(OF_DEVICES.iter().any(last));
    }
    let mut table = csv::Reader::from_reader(file);
    let titles: Vec<String> = table.headers().ok()?.iter().map(str::to_string).collect();
    let plain: Vec<&str> = titles.iter().map(String::as_str).collect();
    if OF_DEVICES.iter().any(|last| plain.ends_with(last)) {
        return Some(true);
    }
    // series, readings, measured errors and corrected records are files of people, too; their last numbers are written as no other program does
    let (mut ours, mut numbers) = (true, 0);
    for row in table.records() {
        let row = row.ok()?;
        let cell = row.iter().next_back().unwrap_or_default();
        numbers += usize::from(!cell.is_empty());
        ours = ours && is_our_notation(cell);
    }
    Some(ours && numbers > 0)
}

/// Is a number written with its exponent as Rust does (`1.5e-4`, where others have `1.5e-04`), or a cell empty?
fn is_our_notation(cell: &str) -> bool {
    let Some((digits, exponent)) = cell.split_once('e') else { return cell.is_empty() };
    let whole = exponent.strip_prefix('-').unwrap_or(exponent);
    let plain = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    plain(whole) && (whole == "0" || !whole.starts_with('0')) && digits.parse::<f64>().is_ok()
}

/// Pages, drawings and exported sources say at their beginning what wrote them, or, as Markdown does, at their end.
fn mentions_this_program(path: &Path) -> bool {
    let mut said = Vec::new();
    let read = File::open(path).and_then(|mut file| {
        file.by_ref().take(BEGINNING).read_to_end(&mut said)?;
        let length = file.metadata()?.len();
        if length > BEGINNING {
            file.seek(SeekFrom::Start(length - BEGINNING))?;
            // no word across the gap
            said.push(b'\n');
            file.take(BEGINNING).read_to_end(&mut said)?;
        }
        Ok(())
    });
    // drawings have a title instead
    read.is_err() || said.starts_with(b"<svg") || said.windows(6).any(|word| word.eq_ignore_ascii_case(b"tumble"))
}
