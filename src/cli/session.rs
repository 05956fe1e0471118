//! What this process, or a command that is embedded in another one, has read, printed and begun to write: a signal can reach nothing but statics.

use super::{Cli, execute};
use crate::error::Malformed;
use crate::language::Language;
use clap::Parser;
#[cfg(unix)]
use signal_hook::consts::{SIGINT, SIGTERM};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender};
use std::sync::{Mutex, Once, PoisonError};

/// State of the process, or of one command within it.
pub(super) struct Session {
    /// Files that were read, without symbolic links.
    inputs: Vec<PathBuf>,
    /// Files that are not whole yet.
    temporaries: Vec<PathBuf>,
    /// What was noted on stderr: a file that is read again has no more to say.
    pub noted: BTreeSet<String>,
    /// May existing campaigns and benches be replaced?
    pub force: bool,
    /// The language of notes and of the frame of an error.
    pub language: Language,
    /// Of a command within another process: what it has printed.
    printed: Option<Printed>,
    /// Of one that is spoken with: lines that it is told, and what it says.
    spoken: Option<(Receiver<String>, Sender<String>)>,
}

/// What a command printed, and how it ended.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Printed {
    /// 0 done, 1 the question is malformed, 2 the answer is "rejected".
    pub exit_code: u8,
    /// What the program prints to stdout.
    pub stdout: Vec<u8>,
    /// What the program prints to stderr; progress bars excepted.
    pub stderr: String,
    /// What is malformed, where the question is (a wrong option excepted).
    pub error: Option<Malformed>,
}

static SESSION: Mutex<Session> = Mutex::new(Session::new());
static SIGNALS: Once = Once::new();

thread_local! {
    /// The session of a command within another process, where several may run at a time.
    static EMBEDDED: RefCell<Option<Session>> = const { RefCell::new(None) };
}

impl Session {
    const fn new() -> Self {
        Session {
            inputs: Vec::new(),
            temporaries: Vec::new(),
            noted: BTreeSet::new(),
            force: false,
            language: Language::English,
            printed: None,
            spoken: None,
        }
    }
}

/// Do something with the session of this thread's command.
pub(super) fn with<T>(work: impl FnOnce(&mut Session) -> T) -> T {
    EMBEDDED.with_borrow_mut(|session| match session {
        Some(session) => work(session),
        None => work(&mut SESSION.lock().unwrap_or_else(PoisonError::into_inner)),
    })
}

pub(super) fn language() -> Language {
    with(|session| session.language)
}

/// A file is read: no output may have its name.
pub(super) fn reads(path: &Path) {
    if let Ok(path) = path.canonicalize() {
        with(|session| session.inputs.push(path));
    }
}

pub(super) fn is_input(path: &Path) -> bool {
    path.canonicalize().is_ok_and(|path| with(|session| session.inputs.contains(&path)))
}

/// A file is begun; from now on SIGINT and SIGTERM remove it and end the program.
pub(super) fn begins(temporary: &Path) {
    if !is_embedded() {
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
    with(|session| session.temporaries.retain(|other| other != temporary));
    let _ = std::fs::remove_file(temporary);
}

/// Give whole files their names, without a signal between two of them. Errors: the file that cannot have its name.
pub(super) fn finishes(files: &[(PathBuf, PathBuf)]) -> std::result::Result<(), (PathBuf, std::io::Error)> {
    with(|session| {
        for (temporary, target) in files {
            std::fs::rename(temporary, target).map_err(|error| (target.clone(), error))?;
            session.temporaries.retain(|other| other != temporary);
        }
        Ok(())
    })
}

/// Is this a command within another process, which nobody answers, to which signals do not belong?
pub(super) fn is_embedded() -> bool {
    with(|session| session.printed.is_some())
}

/// The next line of input of an embedded command, `None` in it at the end; `None` where it has no input.
pub(super) fn spoken() -> Option<Option<String>> {
    with(|session| session.spoken.as_ref().map(|(input, _)| input.recv().ok()))
}

/// Keep a line of stderr, if this is an embedded command; false where it should be printed.
pub(super) fn notes(text: &str) -> bool {
    with(|session| session.printed.as_mut().map(|printed| printed.stderr += &format!("{text}\n")).is_some())
}

/// A reader that has gone away (`tumble ... | head`) is no error.
pub(super) fn reader_left(error: std::io::Error) -> std::io::Result<()> {
    if error.kind() == std::io::ErrorKind::BrokenPipe { Ok(()) } else { Err(error) }
}

/// Stdout, or where an embedded command keeps it.
#[derive(Debug)]
pub(super) struct Stdout;

impl std::io::Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let kept = with(|session| match (&session.spoken, &mut session.printed) {
            // who does not listen any more is told nothing
            (Some((_, output)), _) => {
                let _ = output.send(String::from_utf8_lossy(bytes).into_owned());
                Some(())
            }
            (None, printed) => printed.as_mut().map(|printed| printed.stdout.extend_from_slice(bytes)),
        });
        if kept.is_some() {
            return Ok(bytes.len());
        }
        std::io::stdout().write(bytes).or_else(|error| reader_left(error).map(|()| bytes.len()))
    }

    fn flush(&mut self) -> std::io::Result<()> {
        if is_embedded() { Ok(()) } else { std::io::stdout().flush().or_else(reader_left) }
    }
}

/// Run a command within this process: the arguments after the program's name, as in a shell.
///
/// Nothing is printed, signals keep the handlers that they have; several may run at a time, each in a thread. To stop one, run it in
/// [`Stop::run`](crate::stop::Stop::run).
///
/// ```
/// let printed = tumble::cli::run_embedded(["bench", "list"]);
/// assert_eq!(printed.exit_code, 0);
/// assert!(String::from_utf8_lossy(&printed.stdout).contains("gyro-turntable"));
/// ```
pub fn run_embedded<A: Into<OsString>>(arguments: impl IntoIterator<Item = A>) -> Printed {
    embedded(arguments, None)
}

/// Run a command within this process that is spoken with, as `guide` is: what it would read from standard input comes as lines from `input` (it ends
/// where nobody holds the other end), and what it would print goes to `output` at once. Otherwise as [`run_embedded`].
///
/// ```no_run
/// let ((say, heard), (said, hear)) = (std::sync::mpsc::channel(), std::sync::mpsc::channel());
/// let arguments = ["guide", "schedule.campaign.json", "--noise", "V=9e-4", "--json", "-"];
/// let guide = std::thread::spawn(move || tumble::cli::converse(arguments, heard, said));
/// let advice = hear.recv().unwrap();
/// say.send("{\"V\": 0.0123}".to_string()).unwrap();
/// # let _ = (advice, guide);
/// ```
pub fn converse<A: Into<OsString>>(
    arguments: impl IntoIterator<Item = A>,
    input: Receiver<String>,
    output: Sender<String>,
) -> Printed {
    embedded(arguments, Some((input, output)))
}

fn embedded<A: Into<OsString>>(
    arguments: impl IntoIterator<Item = A>,
    spoken: Option<(Receiver<String>, Sender<String>)>,
) -> Printed {
    /// The session ends with the command, also where that is stopped.
    struct Ends;
    impl Drop for Ends {
        fn drop(&mut self) {
            EMBEDDED.set(None);
        }
    }
    EMBEDDED.set(Some(Session { printed: Some(Printed::default()), spoken, ..Session::new() }));
    let _ends = Ends;
    let line = std::iter::once(OsString::from("tumble")).chain(arguments.into_iter().map(Into::into));
    let (exit_code, error) = match Cli::try_parse_from(line) {
        Ok(cli) => execute(cli),
        Err(error) => {
            let (text, wrong) = (error.render().to_string(), error.use_stderr());
            // writing to memory does not fail
            let _ = if wrong { notes(&text) } else { std::io::Write::write(&mut Stdout, text.as_bytes()).is_ok() };
            (u8::from(wrong), None)
        }
    };
    // nothing printed is an empty text
    Printed { exit_code, error, ..with(|session| session.printed.take()).unwrap_or_default() }
}
