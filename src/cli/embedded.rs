//! The program inside another process: its arguments as text, what it prints as text.

use super::{Cli, Outcome, run, session, show_error};
use crate::error::Malformed;
use clap::Parser;
use std::cell::RefCell;
use std::ffi::OsString;
use std::sync::mpsc::{Receiver, Sender};

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

thread_local! {
    static PRINTED: RefCell<Option<Printed>> = const { RefCell::new(None) };
}

thread_local! {
    /// Of a command that is spoken with: lines that it is told, and what it says.
    static SPOKEN: RefCell<Option<(Receiver<String>, Sender<String>)>> = const { RefCell::new(None) };
}

/// The next line that a command is told where it is spoken with, `None` in it at the end; else `None`.
pub(super) fn told() -> Option<Option<String>> {
    SPOKEN.with_borrow(|spoken| spoken.as_ref().map(|(input, _)| input.recv().ok()))
}

/// Is this a command within another process, which nobody answers?
pub(super) fn is_embedded() -> bool {
    PRINTED.with_borrow(Option::is_some)
}

/// Keep what goes to stdout, if this thread is asked to; false where it should be printed.
pub(super) fn keeps(bytes: &[u8]) -> bool {
    let said = SPOKEN.with_borrow(|spoken| {
        // who does not listen any more is told nothing
        spoken.as_ref().map(|(_, output)| output.send(String::from_utf8_lossy(bytes).into_owned()).is_ok())
    });
    if said.is_some() {
        return true;
    }
    PRINTED.with_borrow_mut(|printed| printed.as_mut().map(|printed| printed.stdout.extend_from_slice(bytes)).is_some())
}

/// Keep a line of stderr, if this thread is asked to; false where it should be printed.
pub(super) fn notes(text: &str) -> bool {
    PRINTED.with_borrow_mut(|printed| {
        printed
            .as_mut()
            .map(|printed| {
                printed.stderr.push_str(text);
                printed.stderr.push('\n');
            })
            .is_some()
    })
}

/// Stdout, or where this thread keeps it.
#[derive(Debug)]
pub(super) struct Stdout;

impl std::io::Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if keeps(bytes) { Ok(bytes.len()) } else { std::io::stdout().write(bytes) }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        if PRINTED.with_borrow(Option::is_some) { Ok(()) } else { std::io::stdout().flush() }
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
    let _session = session::Embedded::begin();
    PRINTED.set(Some(Printed::default()));
    let line = std::iter::once(OsString::from("tumble")).chain(arguments.into_iter().map(Into::into));
    let mut malformed = None;
    let exit_code = match Cli::try_parse_from(line) {
        Err(error) => {
            let text = error.render().to_string();
            let wrong = error.use_stderr();
            let _ = if wrong { notes(&text) } else { keeps(text.as_bytes()) };
            u8::from(wrong)
        }
        Ok(cli) => {
            if cli.force {
                session::allow_replacing();
            }
            match super::speaks(&cli.command, cli.lang).and_then(|()| run(cli.command, cli.lang)) {
                Ok(Outcome::Done) => 0,
                Ok(Outcome::Rejected) => 2,
                Err(error) => {
                    show_error::show(&error);
                    malformed = Some(error);
                    1
                }
            }
        }
    };
    // nothing printed is an empty text
    Printed { exit_code, error: malformed, ..PRINTED.take().unwrap_or_default() }
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
    SPOKEN.set(Some((input, output)));
    let printed = run_embedded(arguments);
    SPOKEN.set(None);
    printed
}
