//! What this process has read and what it has begun to write: a signal can reach nothing but statics.

use crate::language::Language;
#[cfg(unix)]
use signal_hook::consts::{SIGINT, SIGTERM};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

/// State of the process, as far as files go.
#[derive(Debug)]
struct Session {
    /// Files that were read, without symbolic links.
    inputs: Vec<PathBuf>,
    /// Files that are not whole yet.
    temporaries: Vec<PathBuf>,
    /// May existing campaigns and benches be replaced?
    force: bool,
    /// Is the program part of another process, to which signals belong?
    embedded: bool,
    /// The language of notes and of the frame of an error.
    language: Language,
}

static SESSION: Mutex<Session> = Mutex::new(Session {
    inputs: Vec::new(),
    temporaries: Vec::new(),
    force: false,
    embedded: false,
    language: Language::English,
});
/// Commands within another process take turns.
static TURN: Mutex<()> = Mutex::new(());
static SIGNALS: Once = Once::new();

fn session() -> MutexGuard<'static, Session> {
    SESSION.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Tell notes in a language from now on.
pub(super) fn speak(language: Language) {
    session().language = language;
}

/// The language of notes.
pub(super) fn language() -> Language {
    session().language
}

/// Begin a command within another process: nothing read before counts as its input. It lasts as long as what is returned.
pub(super) fn embed() -> MutexGuard<'static, ()> {
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut session = session();
    session.inputs.clear();
    (session.force, session.embedded) = (false, true);
    turn
}

/// Let outputs replace existing campaigns and benches.
pub(super) fn allow_replacing() {
    session().force = true;
}

/// May outputs replace existing campaigns and benches?
pub(super) fn may_replace() -> bool {
    session().force
}

/// A file is read: no output may have its name.
pub(super) fn reads(path: &Path) {
    if let Ok(path) = path.canonicalize() {
        session().inputs.push(path);
    }
}

/// Was this file read?
pub(super) fn is_input(path: &Path) -> bool {
    path.canonicalize().is_ok_and(|path| session().inputs.contains(&path))
}

/// A file is begun; from now on SIGINT and SIGTERM remove it and end the program.
pub(super) fn begins(temporary: &Path) {
    let mut session = session();
    if !session.embedded {
        SIGNALS.call_once(remove_on_signals);
    }
    session.temporaries.push(temporary.to_path_buf());
}

/// Without the handler (no thread, no Unix) an interrupted run leaves its temporary files behind, and works as well otherwise.
fn remove_on_signals() {
    #[cfg(unix)]
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) {
        let waiting = move || {
            if let Some(signal) = signals.forever().next() {
                // held to the end, so that nothing is renamed any more
                let session = session();
                session.temporaries.iter().for_each(|path| drop(std::fs::remove_file(path)));
                std::process::exit(128 + signal)
            }
        };
        let _ = std::thread::Builder::new().spawn(waiting);
    }
}

/// Remove a file that was begun; it is gone already if it has got its name.
pub(super) fn abandons(temporary: &Path) {
    let mut session = session();
    session.temporaries.retain(|own| own != temporary);
    let _ = std::fs::remove_file(temporary);
}

/// Give whole files their names, without a signal between two of them. Errors: the file that cannot have its name.
pub(super) fn finishes(files: &[(PathBuf, PathBuf)]) -> std::result::Result<(), (PathBuf, std::io::Error)> {
    let mut session = session();
    for (temporary, target) in files {
        std::fs::rename(temporary, target).map_err(|error| (target.clone(), error))?;
        session.temporaries.retain(|own| own != temporary);
    }
    Ok(())
}
