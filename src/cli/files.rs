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
fn read_input(path: &Path) -> Result<(Source, Input)> {
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
    let fault = |error: std::io::Error| {
        Malformed::new(Fault::File, format!("cannot write '{}': {error}", path.display()))
            .expected("a folder that can be written to")
    };
    let temporary = temporary(path);
    let written = std::fs::File::create(&temporary)
        .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    written.map_err(fault)
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
