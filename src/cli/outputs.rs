//! The one way out: what a command writes is checked before its work and written together after it, all or nothing.
//!
//! A regular file gets its name when it is whole (a temporary name beside it first), keeps its mode, and is found through symbolic links;
//! what is no regular file (a device, a pipe) is written to directly. Nothing replaces a file that was read, and what this
//! program did not write (`written.rs`) only with `--force`.

use super::{session, written};
use crate::error::{Fault, Malformed, Result};
use std::fs::{File, OpenOptions};
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

/// Symbolic links that are followed.
const MOST_LINKS: usize = 40;
/// Bytes for stdout that are held in memory.
const HELD: usize = 1 << 22;

/// What a command writes.
#[derive(Debug, Default)]
pub(super) struct Outputs {
    targets: Vec<PathBuf>,
    texts: Vec<(PathBuf, Vec<u8>)>,
    streams: Vec<Stream>,
}

impl Outputs {
    /// The files that a command is asked for, before it does its work.
    ///
    /// Errors: two that are one file, a folder, a folder that is not there, a file that was read, one of another's without `--force`.
    pub(super) fn plan<'a>(asked: impl IntoIterator<Item = Option<&'a Path>>) -> Result<Self> {
        let targets: Vec<PathBuf> = asked.into_iter().flatten().map(Path::to_path_buf).collect();
        let outputs = Outputs { targets, ..Outputs::default() };
        outputs.check()?;
        Ok(outputs)
    }

    fn check(&self) -> Result<()> {
        let places: Vec<Place> = self.targets.iter().map(|path| Place::of(path)).collect();
        for (k, (path, place)) in self.targets.iter().zip(&places).enumerate() {
            let name = path.display();
            if !matches!(place, Place::Null) && places.iter().take(k).any(|other| other == place) {
                let what = match place {
                    Place::Stdout => "two outputs go to standard output".to_string(),
                    _ => format!("two outputs go to '{name}'"),
                };
                return Err(Malformed::new(Fault::NameClash, what).expected("a different file for each output"));
            }
            let Place::Regular(target) = place else { continue };
            if target.is_dir() {
                return Err(fault(path, &"it is a folder"));
            }
            let folder = folder_of(target);
            if !folder.is_dir() {
                return Err(fault(path, &format!("there is no folder '{}'", folder.display())));
            }
            if session::is_input(target) {
                return Err(Malformed::new(Fault::File, format!("'{name}' is an input, and would be overwritten"))
                    .expected("another name for the output"));
            }
            if !session::with(|session| session.force) && !written::may_go(target) {
                return Err(Malformed::new(
                    Fault::File,
                    format!("'{name}' exists, and is not as this program wrote it"),
                )
                .expected("a name that is free, or --force to replace it"));
            }
        }
        Ok(())
    }

    /// Does one of them go to stdout, so that the table must not?
    pub(super) fn to_stdout(&self) -> bool {
        self.targets.iter().any(|path| Place::of(path) == Place::Stdout)
    }

    pub(super) fn add(&mut self, path: &Path, text: impl Into<Vec<u8>>) {
        if !self.targets.iter().any(|target| target == path) {
            self.targets.push(path.to_path_buf());
        }
        self.texts.push((path.to_path_buf(), text.into()));
    }

    pub(super) fn extend<T: Into<Vec<u8>>>(&mut self, texts: Vec<(PathBuf, T)>) {
        texts.into_iter().for_each(|(path, text)| self.add(&path, text));
    }

    /// Begin a file that is written while the work goes on; [`Outputs::finish`] takes it back.
    pub(super) fn open(&self, path: &Path) -> Result<Stream> {
        Stream::open(path, &Place::of(path)).map_err(|error| fault(path, &error))
    }

    /// The same, where what goes to stdout or into a pipe is held until all is written: it may have to be begun anew, and cannot be taken back.
    pub(super) fn open_held(&self, path: &Path) -> Result<Stream> {
        let mut stream = self.open(path)?;
        if matches!(Place::of(path), Place::Stdout | Place::Direct(_)) {
            stream.held = Some(Held::default());
        }
        Ok(stream)
    }

    /// One more value, written as JSON while it is read: the text of a report of a million readings is larger than all that they need.
    pub(super) fn json(&mut self, path: &Path, value: &impl serde::Serialize) -> Result<()> {
        let mut stream = self.open_held(path)?;
        stream.is_text = true;
        let mut text = std::io::BufWriter::new(stream);
        let written = serde_json::to_writer_pretty(&mut text, value).map_err(std::io::Error::from);
        let whole = written.and_then(|()| text.write_all(b"\n")).and_then(|()| text.into_inner().map_err(Into::into));
        self.finish(whole.map_err(|error| fault(path, &error))?);
        Ok(())
    }

    /// A file of [`Outputs::open`] that is whole.
    pub(super) fn finish(&mut self, stream: Stream) {
        self.streams.push(stream);
    }

    /// Write all of them, or none where one cannot be written.
    pub(super) fn write(mut self) -> Result<()> {
        self.check()?;
        for (path, text) in std::mem::take(&mut self.texts) {
            let mut stream = self.open_held(&path)?;
            stream.is_text = std::str::from_utf8(&text).is_ok();
            stream.write_all(&text).map_err(|error| fault(&path, &error))?;
            self.streams.push(stream);
        }
        for stream in &mut self.streams {
            stream.sync().map_err(|error| fault(&stream.path, &error))?;
        }
        for stream in &mut self.streams {
            stream.release().or_else(session::reader_left).map_err(|error| {
                match (&stream.temporary, &stream.file) {
                    (None, None) => super::not_printed(&error),
                    _ => fault(&stream.path, &error),
                }
            })?;
        }
        let whole: Vec<(PathBuf, PathBuf)> =
            self.streams.iter().filter_map(|stream| stream.temporary.clone()).collect();
        session::finishes(&whole).map_err(|(path, error)| fault(&path, &error))
    }
}

/// Where an output goes.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Place {
    Stdout,
    /// What takes everything.
    Null,
    /// A device or a pipe.
    Direct(PathBuf),
    /// A file, there or not yet, without symbolic links.
    Regular(PathBuf),
}

impl Place {
    fn of(path: &Path) -> Self {
        match path.to_str() {
            Some("-" | "/dev/stdout") => return Place::Stdout,
            Some("/dev/null") => return Place::Null,
            _ => {}
        }
        let special = path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir());
        if special || path.starts_with("/dev") || path.starts_with("/proc") {
            return Place::Direct(path.to_path_buf());
        }
        if let Ok(there) = path.canonicalize() {
            return Place::Regular(there);
        }
        // not there yet: a new file, or a symbolic link that leads to one
        let mut target = path.to_path_buf();
        for _ in 0..MOST_LINKS {
            match std::fs::read_link(&target) {
                Ok(next) => target = folder_of(&target).join(next),
                Err(_) => break,
            }
        }
        match (folder_of(&target).canonicalize(), target.file_name()) {
            (Ok(folder), Some(name)) => Place::Regular(folder.join(name)),
            _ => Place::Regular(target),
        }
    }
}

/// The folder of a file; `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file in the making; it is removed when it is dropped before it has got its name.
#[derive(Debug)]
pub(super) struct Stream {
    /// The name that the user gave.
    path: PathBuf,
    /// The name until it is whole, and the name after.
    temporary: Option<(PathBuf, PathBuf)>,
    /// `None` for stdout.
    file: Option<File>,
    /// What waits for stdout or a pipe.
    held: Option<Held>,
    /// Is it text, of which a terminal is shown no more than characters?
    is_text: bool,
}

/// Bytes in memory, and those before them in a temporary file, once they are many.
#[derive(Debug, Default)]
struct Held {
    bytes: Vec<u8>,
    file: Option<(File, PathBuf)>,
    /// Was there no place for a file?
    stays: bool,
}

impl Held {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        if self.bytes.len() < HELD || self.stays {
            return Ok(bytes.len());
        }
        if self.file.is_none() {
            let path = std::env::temp_dir().join(format!("tumble.{}.rows.tmp", std::process::id()));
            match File::options().read(true).write(true).create_new(true).open(&path) {
                Ok(file) => {
                    session::begins(&path);
                    self.file = Some((file, path));
                }
                // no such folder, or a full one: memory has to do
                Err(_) => {
                    self.stays = true;
                    return Ok(bytes.len());
                }
            }
        }
        if let Some((file, _)) = &mut self.file {
            file.write_all(&self.bytes)?;
            self.bytes.clear();
        }
        Ok(bytes.len())
    }

    fn copy_to(&mut self, to: &mut impl Write) -> std::io::Result<()> {
        if let Some((file, _)) = &mut self.file {
            file.rewind()?;
            std::io::copy(file, to)?;
        }
        to.write_all(&self.bytes)?;
        to.flush()
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some((_, path)) = self.file.take() {
            session::abandons(&path);
        }
    }
}

impl Stream {
    fn open(path: &Path, place: &Place) -> std::io::Result<Self> {
        let mut stream = Stream { path: path.to_path_buf(), temporary: None, file: None, held: None, is_text: false };
        match place {
            Place::Stdout => {}
            Place::Null | Place::Direct(_) => stream.file = Some(OpenOptions::new().write(true).open(path)?),
            Place::Regular(target) => {
                let mut name = target.file_name().unwrap_or_default().to_os_string();
                name.push(format!(".{}.tmp", std::process::id()));
                let temporary = target.with_file_name(name);
                session::begins(&temporary);
                stream.temporary = Some((temporary.clone(), target.clone()));
                let file = File::create(&temporary)?;
                if let Ok(there) = target.metadata() {
                    file.set_permissions(there.permissions())?;
                }
                stream.file = Some(file);
            }
        }
        Ok(stream)
    }

    fn sync(&mut self) -> std::io::Result<()> {
        match (&self.file, &self.temporary) {
            (Some(file), Some(_)) => file.sync_all(),
            _ => Ok(()),
        }
    }

    /// Let go what was held for stdout or a pipe.
    fn release(&mut self) -> std::io::Result<()> {
        match (self.held.take(), &mut self.file) {
            (Some(mut held), Some(file)) => held.copy_to(file),
            (Some(mut held), None) if self.is_text => held.copy_to(&mut super::Visible::default()),
            (Some(mut held), None) => held.copy_to(&mut session::Stdout),
            (None, _) => Ok(()),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match (&mut self.held, &mut self.file) {
            (Some(held), _) => held.write(bytes),
            (None, Some(file)) => file.write(bytes),
            (None, None) => session::Stdout.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match (&self.held, &mut self.file) {
            (Some(_), _) => Ok(()),
            (None, Some(file)) => file.flush(),
            (None, None) => session::Stdout.flush(),
        }
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        if let Some((temporary, _)) = &self.temporary {
            session::abandons(temporary);
        }
    }
}

pub(super) fn fault(path: &Path, error: &dyn std::fmt::Display) -> Malformed {
    Malformed::new(Fault::File, format!("cannot write '{}': {error}", path.display()))
        .expected("a file that can be written to")
}
