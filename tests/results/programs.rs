//! Programs of other languages, where they are installed.

use std::io::Write;
use std::path::Path;
use std::process::Command;

/// What a command prints, or nothing where it is not installed; that is said past the harness, which keeps what a test prints to itself.
pub fn run(program: &str, arguments: &[&str], folder: &Path) -> Option<String> {
    let output = match Command::new(program).args(arguments).current_dir(folder).output() {
        Ok(output) => output,
        Err(_) => {
            #[allow(clippy::explicit_write, reason = "the test harness keeps back what the macros print")]
            writeln!(std::io::stderr(), "left out: {program} is not installed; what it would run was written, not run")
                .unwrap();
            return None;
        }
    };
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}
