//! What this process has read and what it has begun to write: a signal can reach nothing but statics.

use crate::language::Language;
#[cfg(unix)]
use signal_hook::consts::{SIGINT, SIGTERM};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once, PoisonError};

/// State of the process, as far as files go.
#[derive(Debug)]
struct Session {
    /// Files that were read, without symbolic links.
    inputs: Vec<PathBuf>,
    /// Files that are not whole yet.
    temporaries: Vec<PathBuf>,
    /// May existing campaigns and benches be replaced?
    force: bool,
    /// The language of notes and of the frame of an error.
    language: Language,
}

static SESSION: Mutex<Session> = Mutex::new(Session::new());
static SIGNALS: Once = Once::new();

thread_local! {
    /// The session of a command within another process, where several may run at a time.
    static EMBEDDED: RefCell<Option<Session>> = const { RefCell::new(None) };
}

impl Session {
    const fn new() -> Self {
        Session { inputs: Vec::new(), temporaries: Vec::new(), force: false, language: Language::English }
    }
}

/// Do something with the session of this thread's command.
fn with<T>(work: impl FnOnce(&mut Session) -> T) -> T {
    EMBEDDED.with_borrow_mut(|own| match own {
        Some(own) => work(own),
        None => work(&mut SESSION.lock().unwrap_or_else(PoisonError::into_inner)),
    })
}

/// A command within another process, to which signals belong; it has a session of its own until this is dropped.
#[derive(Debug)]
pub(super) struct Embedded;

impl Embedded {
    pub(super) fn begin() -> Self {
        EMBEDDED.set(Some(Session::new()));
        Embedded
    }
}

impl Drop for Embedded {
    fn drop(&mut self) {
        EMBEDDED.set(None);
    }
}

/// Tell notes in a language from now on.
pub(super) fn speak(language: Language) {
    with(|session| session.language = language);
}

/// The language of notes.
pub(super) fn language() -> Language {
    with(|session| session.language)
}

/// Let outputs replace existing campaigns and benches.
pub(super) fn allow_replacing() {
    with(|session| session.force = true);
}

/// May outputs replace existing campaigns and benches?
pub(super) fn may_replace() -> bool {
    with(|session| session.force)
}

/// A file is read: no output may have its name.
pub(super) fn reads(path: &Path) {
    if let Ok(path) = path.canonicalize() {
        with(|session| session.inputs.push(path));
    }
}

/// Was this file read?
pub(super) fn is_input(path: &Path) -> bool {
    path.canonicalize().is_ok_and(|path| with(|session| session.inputs.contains(&path)))
}

/// A file is begun; from now on SIGINT and SIGTERM remove it and end the program.
pub(super) fn begins(temporary: &Path) {
    if EMBEDDED.with_borrow(Option::is_none) {
        SIGNALS.call_once(remove_on_signals);
    }
    with(|session| session.temporaries.push(temporary.to_path_buf()));
}

/// Without the handler (no thread, no Unix) an interrupted run leaves its temporary files behind, and works as well otherwise.
fn remove_on_signals() {
    #[cfg(unix)]
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
        let waiting = move || {
            if let Some(signal) = signals.forever().next() {
                // held to the end, so that nothing is renamed any more
                let session = SESSION.lock().unwrap_or_else(PoisonError::into_inner);
                session.temporaries.iter().for_each(|path| drop(std::fs::remove_file(path)));
                std::process::exit(128 + signal)
            }
        };
        let _ = std::thread::Builder::new().spawn(waiting);
    }
}

/// Remove a file that was begun; it is gone already if it has got its name.
pub(super) fn abandons(temporary: &Path) {
    with(|session| session.temporaries.retain(|own| own != temporary));
    let _ = std::fs::remove_file(temporary);
}

/// Give whole files their names, without a signal between two of them. Errors: the file that cannot have its name.
pub(super) fn finishes(files: &[(PathBuf, PathBuf)]) -> std::result::Result<(), (PathBuf, std::io::Error)> {
    with(|session| {
        for (temporary, target) in files {
            std::fs::rename(temporary, target).map_err(|error| (target.clone(), error))?;
            session.temporaries.retain(|own| own != temporary);
        }
        Ok(())
    })
}
