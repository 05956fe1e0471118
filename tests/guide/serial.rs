//! A serial port as the source of samples. What comes through one, and an unplugged cable: `tests/scripts/guide_serial.py`, since a pair of
//! pseudo-terminals needs more than the standard library.

use crate::samples::{folder, tumble};

#[test]
fn a_port_that_is_not_there_is_said() {
    let folder = folder();
    for (port, said) in [
        ("nothing", "cannot open the serial port 'nothing' at 115200 bit/s"),
        ("port:fast", "the rate of the serial port is not understood"),
    ] {
        let output = tumble(folder.path(), &["--serial", port]).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(said), "{text}");
    }
}
