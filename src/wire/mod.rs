//! Files at the edge: JSON and CSV in, domain types out, once, with errors that point at file, line, column and path.
//!
//! What a file has as it is used (an axis, a known value, an effect) is read into the type of the domain, which says its JSON itself; the types here are
//! those of files that become something else. Nothing here reads a file: whoever calls it brings the text and a function that fetches what the text
//! refers to (a bench file, a CSV of readings).

mod bench_file;
mod bounds_file;
mod build;
mod campaign_file;
mod columns;
mod correction_file;
mod effects_file;
mod folder;
mod front;
#[cfg(feature = "navigate")]
mod imu_errors_file;
mod lab;
mod locate;
#[cfg(feature = "navigate")]
mod measured_file;
#[cfg(feature = "navigate")]
mod mission_file;
#[cfg(feature = "navigate")]
mod motion_file;
mod named;
mod readings_file;
mod readings_table;
mod record_rows;
mod reduced;
mod reduction;
mod samples_file;
mod schema;
mod shapes;
mod site_file;
mod strict;
mod truth_file;
mod write;

use crate::elements::Parts;
pub use crate::record::ClockFrom;
pub use bench_file::BenchFile;
pub(crate) use bench_file::{DerivedFile, DirectionFile, LinkFile, SensorFile};
pub(crate) use bounds_file::{ConstraintFile, LimitFile};
pub use build::{BenchBuilder, CampaignBuilder, ReadingBuilder, SensorBuilder};
pub use campaign_file::{BenchRef, CampaignFile, ReadingsRef};
pub(crate) use campaign_file::{CovarianceFile, KnownEntry};
#[cfg(feature = "cli")]
pub(crate) use columns::{key_unit, of_title};
pub use correction_file::CorrectionFile;
pub(crate) use effects_file::EffectsFile;
pub use effects_file::{built_in_effects, read_effects};
pub use folder::Folder;
pub use front::{bench_ref, fit_rows_beside, read_campaign_beside};
#[cfg(feature = "navigate")]
pub(crate) use imu_errors_file::ErrorsFile;
pub use lab::read_lab;
pub(crate) use lab::{ContactFile, IssuerFile, ItemFile, LabFile};
use locate::in_source;
pub(crate) use locate::line_and_column;
pub use locate::locate;
#[cfg(feature = "navigate")]
pub use measured_file::{read_measured, write_measured};
#[cfg(feature = "navigate")]
pub use mission_file::MissionFile;
#[cfg(feature = "navigate")]
pub(crate) use mission_file::read_covariance;
#[cfg(feature = "navigate")]
pub(crate) use motion_file::MotionFile;
pub use named::Named;
pub use readings_file::{Cell, ReadingFile, read_rows};
pub use readings_table::{device_readings, inline_devices, read_readings, table_layout};
pub(crate) use readings_table::{table_cells, table_keys};
pub(crate) use record_rows::read_rows_of;
pub use reduced::read_schedule;
pub(crate) use reduced::{ReducedReading, Schedule};
pub use reduction::Reduced;
pub(crate) use samples_file::{Encoder, SamplesAs, SamplesFile, times};
pub use samples_file::{Recipe, SegmentsBy};
pub use schema::schema;
pub(crate) use schema::{SCHEMAS, identified};
pub(crate) use site_file::SiteFile;
pub(crate) use truth_file::TruthFile;
pub use truth_file::read_truth;
pub use write::{bench_file, campaign_file};

use crate::bench::Bench;
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use serde::de::DeserializeOwned;

/// A text and the name that errors should give it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Source {
    /// File name as the user knows it.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl Source {
    /// Take bytes as UTF-8 (a byte order mark is dropped).
    ///
    /// Errors: `Syntax` with the line of the first byte that is not UTF-8; UTF-16 is recognised and named.
    pub fn from_bytes(name: impl Into<String>, bytes: Vec<u8>) -> Result<Self> {
        let name = name.into();
        // what is no JSON is a table: spreadsheets write those in many encodings
        if !name.to_ascii_lowercase().ends_with(".json")
            && let Some(text) = crate::record::table_text(&name, &bytes)?
        {
            return Ok(Source { name, text });
        }
        if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
            return Err(Malformed::new(Fault::Syntax, "the file is UTF-16")
                .expected("UTF-8 text (in a spreadsheet: save as 'CSV UTF-8')")
                .found("a UTF-16 byte order mark")
                .at_line(1, 1)
                .in_file(name));
        }
        match String::from_utf8(bytes) {
            Ok(text) => {
                let text = text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text);
                Ok(Source { name, text })
            }
            Err(error) => {
                let at = error.utf8_error().valid_up_to();
                let bytes = error.into_bytes();
                let (line, column) = line_and_column(&String::from_utf8_lossy(bytes.part(..at)), at);
                let byte = bytes.get(at).copied().unwrap_or_default(); // there is one: what stood before it is not all
                Err(Malformed::new(Fault::Syntax, "the file is not UTF-8 text")
                    .expected("UTF-8 (in a spreadsheet: save as 'CSV UTF-8')")
                    .found(format!("byte 0x{byte:02X}, which is not UTF-8 here (Latin-1?)"))
                    .at_line(line, column)
                    .in_file(name))
            }
        }
    }
}

/// Fetches what a file refers to by a path of its own (relative to that file).
pub type Fetch<'a> = &'a mut dyn FnMut(&str) -> Result<Source>;

/// Read a bench file.
///
/// ```
/// let text = tumble::bench::built_in("gyro-turntable").unwrap().text;
/// let source = tumble::wire::Source { name: "gyro-turntable".into(), text: text.into() };
/// assert_eq!(tumble::wire::read_bench(&source).unwrap().tilts().count(), 6);
/// ```
pub fn read_bench(source: &Source) -> Result<Bench> {
    let file: BenchFile = parse(source)?;
    file.into_bench().map_err(|error| in_source(error, source))
}

/// Read a campaign file, with the bench and the table of readings (as text) that it refers to.
///
/// A bench that is named is a built-in id, or else a path for `fetch`. Errors carry the file in which the fault stands.
pub fn read_campaign(source: &Source, fetch: Fetch<'_>) -> Result<Campaign> {
    campaign_from(campaign_of(source)?, source, &mut folder::Texts(fetch))
}

/// Parse a campaign file without looking at the bench and the readings that it refers to.
pub fn campaign_of(source: &Source) -> Result<CampaignFile> {
    parse(source).map_err(|error| schema::no_campaign(source).unwrap_or(error))
}

/// The campaign of a file that was parsed, with everything that it refers to: benches, tables of readings in any format, records of samples.
pub(crate) fn campaign_from(file: CampaignFile, source: &Source, folder: &mut dyn Folder) -> Result<Campaign> {
    file.into_campaign(folder).map_err(|error| in_source(error, source))
}

/// Parse JSON into a wire type; syntax errors and unknown keys carry line, column and JSON path.
pub fn parse<T: DeserializeOwned>(source: &Source) -> Result<T> {
    let mut json = serde_json::Deserializer::from_str(&source.text);
    let parsed = serde_path_to_error::deserialize(strict::WholeFile(&mut json)).map_err(|error| {
        let path = error.path().to_string();
        let inner = error.into_inner();
        json_error(&inner, if path == "." { String::new() } else { path }, source)
    });
    let value: T = parsed?;
    json.end().map_err(|error| json_error(&error, String::new(), source))?;
    Ok(value)
}

/// A serde_json error in our words; its "at line L column C" becomes a place, and the caret underlines what was read last there.
fn json_error(error: &serde_json::Error, path: String, source: &Source) -> Malformed {
    let full = error.to_string();
    let message = full.rsplit_once(" at line ").map_or(full.as_str(), |(message, _)| message);
    let malformed = json_fault(message, error.is_data(), error.is_eof());
    // serde_path_to_error writes `?` for a key that was not read to its end
    let malformed = malformed.at_path(path.trim_end_matches('?').trim_end_matches('.')).in_file(&source.name);
    let Some(offset) = locate::offset_of(&source.text, error.line(), error.column().max(1)) else { return malformed };
    let (start, len) = locate::token_ending_at(&source.text, offset);
    let (line, column) = line_and_column(&source.text, start);
    malformed.at_span(start, len).at_line(line, column)
}

/// The error for a value of another type: a number where an object is expected, say.
pub(super) const WRONG_FORM: &str = "this value has another form than expected";

/// The type that serde found, in our words.
fn in_words(found: &str) -> String {
    const WORDS: [(&str, &str); 6] = [
        ("integer", "the number"),
        ("floating point", "the number"),
        ("string", "the text"),
        ("boolean", "the word"),
        ("sequence", "a list"),
        ("map", "an object"),
    ];
    let word = WORDS.iter().find_map(|(theirs, ours)| Some(format!("{ours}{}", found.strip_prefix(theirs)?)));
    word.unwrap_or_else(|| found.to_string()).replace('`', "")
}

/// What serde expected, in our words.
fn expected_in_words(expected: &str) -> String {
    if let Some(size) = expected.strip_prefix("a tuple of size ") {
        return format!("a list of {size}");
    }
    match expected {
        "f64" => "a number",
        "u64" | "u32" | "usize" => "a whole number",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        "a map" => "an object",
        _ if expected.starts_with("struct ") => "an object { ... }",
        other => other,
    }
    .to_string()
}

/// What serde_json found, and what it (or the type that was read) expected.
fn json_fault(message: &str, is_data: bool, is_eof: bool) -> Malformed {
    if let Some(text) = message.strip_prefix("unknown field ") {
        let (key, expected) = text.split_once(", expected ").unwrap_or((text, "another key"));
        let found = key.replace('`', "'");
        return Malformed::new(Fault::UnknownKey, format!("unknown key {found}"))
            .expected(expected.replace('`', ""))
            .found(found);
    }
    if let Some(key) = message.strip_prefix("missing field ") {
        let key = key.replace('`', "\"");
        return Malformed::new(Fault::Missing, format!("the key {key} is missing"))
            .expected(format!("{key} before this brace closes"));
    }
    let fault = if is_data { Fault::Value } else { Fault::Syntax };
    if let Some((what, expected)) = message.split_once(", expected ") {
        let expected = expected_in_words(expected);
        return match (what.strip_prefix("invalid type: "), what.strip_prefix("invalid length ")) {
            (Some(found), _) => Malformed::new(fault, WRONG_FORM).expected(expected).found(in_words(found)),
            (None, Some(length)) => {
                Malformed::new(fault, WRONG_FORM).expected(expected).found(format!("a list of {length}"))
            }
            (None, None) => Malformed::new(fault, what).expected(expected),
        };
    }
    // what a value of several forms may be
    if is_data && ["a ", "an ", "\""].iter().any(|start| message.starts_with(start)) {
        return Malformed::new(fault, WRONG_FORM).expected(message);
    }
    if let Some(expected) = message.strip_prefix("expected ") {
        return Malformed::new(fault, "this is not JSON").expected(expected);
    }
    let expected = match message {
        _ if is_eof => "more text: the file ends too early",
        "number out of range" => "a finite number, of size below 1.8e308",
        "trailing comma" => "another entry after the comma, or no comma",
        "trailing characters" => "the end of the file",
        "key must be a string" => "a key in double quotes",
        "recursion limit exceeded" => "at most 128 brackets inside each other",
        _ => "JSON text",
    };
    Malformed::new(fault, message).expected(expected)
}
