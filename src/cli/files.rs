//! Reading files (`outputs` writes them): campaigns with their folders, missions, catalogues, records with their clocks; names with `*` and `?`, where the shell has left them.

use super::session;
use crate::campaign::Campaign;
use crate::diagnosis::Effect;
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::navigate::mission::Mission;
use crate::record::{ClockFrom, Record, listed, parted};
use crate::report::Input;
use crate::wire::{self, Folder, MissionFile, Source};
use clap::Args;
use serde::Serialize;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file that is read: a campaign takes several times its size in memory.
const MOST_BYTES: u64 = 1 << 30;
/// Bytes that are read before they are looked at.
const BLOCK: u64 = 1 << 20;

pub(super) fn read(path: &Path) -> Result<Source> {
    read_input(path).map(|(source, _)| source)
}

/// Read a file as text, with the digest of its bytes; `-` is standard input.
pub(super) fn read_input(path: &Path) -> Result<(Source, Input)> {
    let path = if path == Path::new("-") { Path::new("/dev/stdin") } else { path };
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(Malformed::new(Fault::File, format!("'{name}' is a folder")).expected("a file").in_file(name));
    }
    let bytes = bytes(path, &name)?;
    session::reads(path);
    let input = Input::new(&name, &bytes);
    Ok((Source::from_bytes(name, bytes)?, input))
}

/// The name and the digest of a file that is too large to be read at once.
pub(super) fn input(path: &Path) -> Result<Input> {
    let name = path.display().to_string();
    let fault = |error: std::io::Error| Malformed::new(Fault::File, format!("cannot read '{name}': {error}"));
    let mut file = std::fs::File::open(path).map_err(fault)?;
    Input::read(&name, &mut file).map_err(fault)
}

/// The bytes of a text file, no more than [`MOST_BYTES`]; a device of zeros is found out in its first block.
fn bytes(path: &Path, name: &str) -> Result<Vec<u8>> {
    let cannot = |error: std::io::Error| {
        Malformed::new(Fault::File, format!("cannot read '{name}': {error}")).expected("a readable file")
    };
    let mut file = std::fs::File::open(path).map_err(cannot)?;
    let expected = file.metadata().map_or(0, |there| there.len());
    let mut bytes = Vec::with_capacity(expected.min(MOST_BYTES) as usize);
    loop {
        let begin = bytes.len();
        let read = Read::by_ref(&mut file).take(BLOCK).read_to_end(&mut bytes).map_err(cannot)?;
        let utf_16 = bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]);
        let zero = bytes.get(begin..).and_then(|block| block.iter().position(|byte| *byte == 0));
        if let Some(at) = zero.filter(|_| !utf_16) {
            return Err(Malformed::new(Fault::Syntax, format!("'{name}' is not a text file"))
                .expected("UTF-8 text")
                .found(format!("a zero byte at offset {}", begin + at)));
        }
        if bytes.len() as u64 > MOST_BYTES || (utf_16 && begin > 0 && read > 0) {
            return Err(Malformed::new(Fault::File, format!("'{name}' is too large to be read at once"))
                .expected(format!("a file of at most {} MiB", MOST_BYTES >> 20))
                .found(match expected {
                    0 => "more".to_string(),
                    _ => format!("{} MiB", expected >> 20),
                }));
        }
        if read == 0 {
            return Ok(bytes);
        }
    }
}

/// Read a campaign, with its source, for errors that come later, and every file that was read for it; those that it refers to are looked for in its
/// folder.
pub(super) fn campaign(path: &Path) -> Result<(Campaign, Source, Vec<Input>)> {
    campaign_in(path, read_input(path)?)
}

/// The same from a file that was read: standard input can be read once.
pub(super) fn campaign_in(path: &Path, (source, input): (Source, Input)) -> Result<(Campaign, Source, Vec<Input>)> {
    let mut folder = Beside::new(path);
    let campaign = wire::campaign_from(wire::campaign_of(&source)?, &source, &mut folder)?;
    Ok((campaign, source, [vec![input], folder.inputs].concat()))
}

/// The folder of a campaign file: what the campaign refers to, and what was read of it.
pub(super) struct Beside {
    folder: PathBuf,
    /// Files that were read, with digests.
    pub(super) inputs: Vec<Input>,
    /// Pipes that were read.
    pipes: Vec<PathBuf>,
}

impl Beside {
    pub(super) fn new(campaign: &Path) -> Self {
        Beside {
            folder: campaign.parent().map(Path::to_path_buf).unwrap_or_default(),
            inputs: Vec::new(),
            pipes: Vec::new(),
        }
    }

    /// A table of readings at a path of the user's.
    pub(super) fn table_at(&mut self, path: &Path) -> Result<Record> {
        let (file, _) = parted(path);
        let name = file.display().to_string();
        if file.is_file() && self.inputs.iter().all(|input| input.name != name) {
            self.inputs.push(input(&file)?);
            session::reads(&file);
        }
        told(Record::at(path)?)
    }
}

impl Folder for Beside {
    fn text(&mut self, name: &str) -> Result<Source> {
        let (source, input) = read_input(&self.folder.join(name))?;
        self.inputs.push(input);
        Ok(source)
    }

    fn table(&mut self, name: &str) -> Result<Record> {
        self.table_at(&self.folder.join(name))
    }

    fn record(&mut self, name: &str) -> Result<Record> {
        let path = self.folder.join(name);
        if self.pipes.contains(&path) {
            return Err(Malformed::new(Fault::File, format!("'{}' can be read once only", path.display()))
                .expected("a file, which is read in several passes"));
        }
        if path.exists() && !path.is_file() && !path.is_dir() {
            self.pipes.push(path.clone());
        }
        self.table_at(&path)
    }

    fn note(&mut self, text: String) {
        super::note(&format!("note: {text}"));
    }
}

/// Say that a schedule is judged or simulated as that of one device, where its campaign is of many.
pub(super) fn one_device(campaign: &Campaign) {
    if let Some(by) = &campaign.by {
        super::note(&format!(
            "note: all positions are taken as those of one device; \"by\": \"{by}\" is used by fit and diagnose only"
        ));
    }
}

pub(super) fn mission(path: &Path) -> Result<(MissionFile, Mission, Source)> {
    let source = read(path)?;
    let file: MissionFile = wire::parse(&source)?;
    let mission = file.mission().map_err(|error| wire::locate(error, &source))?;
    Ok((file, mission, source))
}

/// The same for a file that is read again, a campaign or a bench, whose first line says what wrote it (`written.rs`).
pub(super) fn marked(value: &impl Serialize) -> Result<String> {
    json(value).map(|text| super::written::mark(&text))
}

/// A value as JSON text that ends with a line break.
pub(super) fn json(value: &impl Serialize) -> Result<String> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(Malformed::new(Fault::Value, format!("the report cannot be written as JSON: {error}"))),
    }
}

/// The effects that a diagnosis or a plan tries: the built-in catalogue, after a user's own.
pub(super) struct Catalogue {
    pub effects: Vec<Effect>,
    /// The user's own file.
    file: Option<Source>,
}

impl Catalogue {
    /// The user's effects first, so that their names are used where both have the same term.
    pub fn new(file: Option<Source>) -> Result<Self> {
        let mut effects = match &file {
            Some(source) => wire::read_effects(source)?,
            None => Vec::new(),
        };
        effects.extend(wire::built_in_effects()?);
        Ok(Catalogue { effects, file })
    }

    /// The place of an error: the user's catalogue where it is about an effect, else the campaign.
    pub fn locate(&self, error: Malformed, campaign: &Source) -> Malformed {
        match &self.file {
            Some(effects) if error.place().path.starts_with("effects[") => wire::locate(error, effects),
            _ => wire::locate(error, campaign),
        }
    }
}

/// The built-in catalogue, after a user's own.
pub(super) fn catalogue(path: Option<&Path>) -> Result<Catalogue> {
    Catalogue::new(path.map(read).transpose()?)
}

/// The files that these names denote, those of one pattern in the order of their names.
///
/// Errors: a pattern that no file has.
pub(super) fn expand(names: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for name in names {
        let text = name.to_string_lossy();
        if name.exists() || !text.contains(['*', '?']) {
            found.push(name.clone());
            continue;
        }
        let mut matching = matching(name);
        if matching.is_empty() {
            return Err(Malformed::new(Fault::File, format!("no file is called '{text}'"))
                .expected("a file, or a pattern with * and ? that some file matches"));
        }
        matching.sort();
        found.append(&mut matching);
    }
    Ok(found)
}

fn matching(pattern: &Path) -> Vec<PathBuf> {
    let mut folders = vec![PathBuf::new()];
    for part in pattern.components() {
        let text = part.as_os_str().to_string_lossy().to_string();
        if !text.contains(['*', '?']) {
            folders.iter_mut().for_each(|folder| folder.push(part));
            continue;
        }
        let mut next = Vec::new();
        for folder in folders {
            let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
            for entry in std::fs::read_dir(listed).into_iter().flatten().flatten() {
                let name = entry.file_name();
                let hidden = name.to_string_lossy().starts_with('.') && !text.starts_with('.');
                if !hidden && fits(text.as_bytes(), name.to_string_lossy().as_bytes()) {
                    next.push(folder.join(name));
                }
            }
        }
        folders = next;
    }
    folders.retain(|path| path.is_file());
    folders
}

/// Does a name fit a pattern of `*` (any text) and `?` (one byte)?
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    match (pattern, name) {
        ([b'*', tail @ ..], _) => (0..=name.len()).any(|from| fits(tail, name.part(from..))),
        ([sign, tail @ ..], [byte, name @ ..]) => (*sign == b'?' || sign == byte) && fits(tail, name),
        (pattern, name) => pattern.is_empty() && name.is_empty(),
    }
}

/// Where the times of the samples come from.
#[derive(Debug, Clone, Args)]
pub(super) struct Clock {
    /// The column of times (by default one that is named time_s, time, t or timestamp, or whose values rise as times do).
    #[arg(long, value_name = "COLUMN", conflicts_with = "rate")]
    time: Option<String>,
    /// Sampling rate in Hz, if there is no column of times.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

/// Open a record; `FILE#NAME` is one table of a file that has several.
pub(super) fn open(path: &Path) -> Result<Record> {
    let record = Record::at(path)?;
    session::reads(&parted(path).0);
    told(record)
}

/// A record, of which is said how its numbers are taken.
fn told(record: Record) -> Result<Record> {
    record.doubt().into_iter().for_each(|doubt| super::note(&format!("note: {}: {doubt}", record.name())));
    Ok(record)
}

impl Clock {
    pub(super) fn source(&self) -> ClockFrom {
        ClockFrom { time: self.time.clone(), rate: self.rate }
    }
}

/// The columns that are named, or all of numbers but the times.
pub(super) fn numeric_columns(record: &Record, names: &[String], clock: &ClockFrom) -> Result<Vec<usize>> {
    if !names.is_empty() {
        return names.iter().map(|name| record.find(name.trim())).collect();
    }
    let time = clock.column(record)?;
    let unused = clock.unused(record);
    let others: Vec<usize> = (0..record.columns().len()).filter(|k| ![time, unused].contains(&Some(*k))).collect();
    let (texts, numbers): (Vec<usize>, Vec<usize>) = others.iter().partition(|k| record.is_text(**k));
    let unread = texts.iter().filter_map(|k| Some((record.columns().get(*k)?.title.as_str(), record.unread(*k)?)));
    let unread: Vec<String> = unread.map(|(title, cell)| format!("'{cell}' in '{title}'")).collect();
    if numbers.is_empty() {
        return Err(Malformed::new(Fault::Missing, "no column of the record holds numbers")
            .expected("columns of numbers, without units or signs in their cells")
            .found(if unread.is_empty() { listed(record.columns()) } else { unread.join(", ") })
            .in_file(record.name()));
    }
    if !unread.is_empty() {
        super::note(&format!("note: columns of texts are left out; no numbers are {}", unread.join(", ")));
    }
    Ok(numbers)
}
