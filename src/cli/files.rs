//! Reading files (`outputs` writes them).

use super::session;
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::navigate::mission::Mission;
use crate::record::{Record, parted};
use crate::report::Input;
use crate::wire::{self, Folder, MissionFile, Source};
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
    let (source, input) = read_input(path)?;
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
        Record::at(path)
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

/// The same for a file that is read again, a campaign or a bench, whose first line says what wrote it (`own.rs`).
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
