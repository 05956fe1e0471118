//! Reading and writing files. Nothing is ever half-written: a temporary name first, then a rename.

use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::report::Input;
use crate::wire::{self, MissionFile, Source};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Read a file as text.
pub(super) fn read(path: &Path) -> Result<Source> {
    read_input(path).map(|(source, _)| source)
}

/// Read a file as text, with the digest of its bytes.
pub(super) fn read_input(path: &Path) -> Result<(Source, Input)> {
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(Malformed::new(Fault::File, format!("'{name}' is a folder")).expected("a file").in_file(name));
    }
    let bytes = std::fs::read(path).map_err(|error| {
        Malformed::new(Fault::File, format!("cannot read '{name}': {error}")).expected("a readable file")
    })?;
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

/// Read a campaign; what it refers to is looked for beside it. Also gives its source, for errors that come later.
pub(super) fn campaign(path: &Path) -> Result<(Campaign, Source)> {
    campaign_and_inputs(path).map(|(campaign, source, _)| (campaign, source))
}

/// Read a campaign, and list every file that was read for it.
pub(super) fn campaign_and_inputs(path: &Path) -> Result<(Campaign, Source, Vec<Input>)> {
    let (source, input) = read_input(path)?;
    let mut inputs = vec![input];
    let folder: PathBuf = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let campaign = wire::read_campaign(&source, &mut |name| {
        let (source, input) = read_input(&folder.join(name))?;
        inputs.push(input);
        Ok(source)
    })?;
    Ok((campaign, source, inputs))
}

/// Read a mission file.
pub(super) fn mission(path: &Path) -> Result<(MissionFile, Source)> {
    let source = read(path)?;
    let file = wire::parse(&source)?;
    Ok((file, source))
}

/// The name that a file has until it is whole.
pub(super) fn temporary(path: &Path) -> PathBuf {
    let mut name = path.file_name().map(|n| n.to_os_string()).unwrap_or_default();
    name.push(format!(".{}.tmp", std::process::id()));
    path.with_file_name(name)
}

/// Write a file whole or not at all.
pub(super) fn write(path: &Path, text: &str) -> Result<()> {
    write_all(&[&(path.to_path_buf(), text.to_string())])
}

/// Write several files, each whole; where one of them cannot be written, none is.
pub(super) fn write_all(files: &[&(PathBuf, String)]) -> Result<()> {
    let fault = |path: &Path, error: &dyn std::fmt::Display| {
        Malformed::new(Fault::File, format!("cannot write '{}': {error}", path.display()))
            .expected("a folder that can be written to")
    };
    let whole = |path: &Path, text: &str| {
        std::fs::File::create(temporary(path)).and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        })
    };
    let written = files.iter().try_for_each(|(path, text)| {
        if path.is_dir() {
            return Err(fault(path, &"it is a folder"));
        }
        whole(path, text).map_err(|error| fault(path, &error))
    });
    let renamed = written.and_then(|()| {
        files
            .iter()
            .try_for_each(|(path, _)| std::fs::rename(temporary(path), path).map_err(|error| fault(path, &error)))
    });
    if renamed.is_err() {
        // those that were renamed are gone from here already
        files.iter().for_each(|(path, _)| drop(std::fs::remove_file(temporary(path))));
    }
    renamed
}

/// A value as JSON text that ends with a line break.
pub(super) fn json(value: &impl Serialize) -> Result<String> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => Ok(text + "\n"),
        Err(error) => Err(Malformed::new(Fault::Value, format!("the report cannot be written as JSON: {error}"))),
    }
}

/// Write text to a file, or to stdout for `-`.
pub(super) fn write_or_print(path: &Path, text: &str) -> Result<()> {
    if path == Path::new("-") {
        super::print(text);
        return Ok(());
    }
    write(path, text)
}
