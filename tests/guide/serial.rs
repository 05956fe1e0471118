//! A serial port as the source of samples, over pairs of pseudo-terminals: its cable is unplugged, and plugged in again.

use crate::samples::{LONG_S, Spoken, Table, folder, is_sound, readings, tumble};
use serial2::SerialPort;
use std::os::fd::AsRawFd;
use std::path::Path;
use std::time::Duration;

/// Both ends of a cable.
struct Cable {
    board: SerialPort,
    _port: SerialPort,
}

impl Cable {
    /// Plug it in at this path.
    fn plugged_in(path: &Path) -> Self {
        let (mut board, port) = SerialPort::pair().unwrap();
        board.set_write_timeout(Duration::from_secs(120)).unwrap();
        let name = std::fs::read_link(format!("/proc/self/fd/{}", port.as_raw_fd())).unwrap();
        let _ = std::fs::remove_file(path);
        std::os::unix::fs::symlink(name, path).unwrap();
        Cable { board, _port: port }
    }

    fn says(&self, text: &str) {
        self.board.write_all(text.as_bytes()).unwrap();
    }
}

#[test]
fn a_port_is_read_and_waited_for() {
    let folder = folder();
    let path = folder.path().join("port");
    let cable = Cable::plugged_in(&path);
    let mut table = Table::new(11);
    let mut guide = Spoken::of(tumble(folder.path(), &["--serial", "port:115200", "--time", "t_s"]));
    let first = guide.next()["next"]["position"].as_str().unwrap().to_string();
    // the end of a row, of which the beginning came before the port was opened
    cable.says("125,0.0012,1.0021\nt_s,X,Y,Z\n");
    cable.says(&table.hold(&first, LONG_S));
    let second = guide.until(None);
    assert_eq!((&second["readings"], second["error"].as_str()), (&1.into(), None), "{second}");
    let second = second["next"]["position"].as_str().unwrap().to_string();
    drop(cable);
    let gone = guide.until(None);
    assert!(gone["error"].as_str().is_some_and(|own| own.contains("serial port 'port': it was unplugged")), "{gone}");
    assert_eq!(gone["readings"], 1);
    let cable = Cable::plugged_in(&path);
    let back = guide.until(None);
    assert_eq!((&back["readings"], back["error"].as_str()), (&1.into(), None), "{back}");
    cable.says("0.5,0.25\nt_s,X,Y,Z\n");
    cable.says(&table.hold(&second, LONG_S));
    let third = guide.until(None);
    assert_eq!((&third["readings"], third["error"].as_str()), (&2.into(), None), "{third}");
    guide.say("quit\n");
    assert_eq!(guide.child.wait().unwrap().code(), Some(2));
    for (keys, label) in readings(folder.path()).iter().zip([first, second]) {
        is_sound(&table, keys, &label);
    }
}

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
