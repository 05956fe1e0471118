//! A serial port as a source of lines. Its cable may be unplugged: it is waited for.

use crate::error::{Fault, Malformed, Result};
use serial2::SerialPort;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::Duration;

/// Bits a second where none are given: what most sensors' boards are set to.
const BAUD: u32 = 115_200;
/// How long bytes are waited for before commands are asked for again, and how long a port that is away before it is looked for again.
const PAUSE: Duration = Duration::from_millis(50);
const AWAY: Duration = Duration::from_millis(200);

pub(super) struct Port {
    path: PathBuf,
    baud: u32,
    open: Option<SerialPort>,
}

pub(super) enum Came {
    Bytes(usize),
    Nothing,
    /// It is no longer there, and why.
    Gone(String),
    /// It is there again.
    Back,
}

impl Port {
    /// Open a port: `/dev/ttyUSB0`, `/dev/ttyUSB0:57600`, `COM3`.
    ///
    /// Errors: no port there, or one that may not be opened or does not know the rate.
    pub fn open(asked: &str) -> Result<Self> {
        let (path, baud) = match asked.rsplit_once(':') {
            Some((path, baud)) => match baud.parse::<u32>() {
                Ok(baud) if baud > 0 && !path.is_empty() => (path, baud),
                _ => {
                    return Err(Malformed::new(Fault::Value, "the rate of the serial port is not understood")
                        .expected("a port and its bits a second, for example /dev/ttyUSB0:115200")
                        .found(format!("'{asked}'")));
                }
            },
            None => (asked, BAUD),
        };
        let mut port = Port { path: path.into(), baud, open: None };
        port.open = Some(port.connect().map_err(|error| {
            Malformed::new(Fault::File, format!("cannot open the serial port '{path}' at {baud} bit/s: {error}"))
                .expected("a port that is plugged in and that this user may open (on Linux: the group dialout)")
        })?);
        Ok(port)
    }

    pub fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn connect(&self) -> std::io::Result<SerialPort> {
        let mut port = SerialPort::open(&self.path, self.baud)?;
        port.set_read_timeout(PAUSE)?;
        Ok(port)
    }

    /// What has come, after a pause at most.
    pub fn read(&mut self, block: &mut [u8]) -> Came {
        let Some(port) = &self.open else {
            std::thread::sleep(AWAY);
            self.open = self.connect().ok();
            return if self.open.is_some() { Came::Back } else { Came::Nothing };
        };
        let why = match port.read(block) {
            Ok(0) => "it was unplugged".to_string(),
            Ok(count) => return Came::Bytes(count),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => return Came::Nothing,
            Err(error) => format!("it was unplugged ({error})"),
        };
        self.open = None;
        Came::Gone(why)
    }
}
