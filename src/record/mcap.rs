//! MCAP logs: the messages `sensor_msgs/Imu` of ROS 1 and 2, as columns of rates and specific forces.
//!
//! The layout of the file is that of the MCAP specification (mcap.dev); messages are in ROS 1 serialization or in CDR (OMG DDS-XTypes). Other messages are
//! passed over. Times are those of the messages' heads, in seconds since the first; where these are all zero, those of the log.

use super::Column;
use super::held::{Held, Sheet};
use crate::error::{Fault, Malformed, Result};
use std::collections::HashMap;
use std::io::{self, BufRead, Read};

/// What every file begins with.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// Kinds of records.
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const DATA_END: u8 = 15;
/// Longest record that is read: a chunk is a few megabytes.
pub(super) const LONGEST: u64 = 1 << 32;

/// Columns of a message after its time: name and unit.
const COLUMNS: [(&str, &str); 6] =
    [("w_x", "rad/s"), ("w_y", "rad/s"), ("w_z", "rad/s"), ("a_x", "m/s^2"), ("a_y", "m/s^2"), ("a_z", "m/s^2")];

/// Read the topic that is meant.
///
/// Errors: a file that was cut off, no topic of that kind of message, several; with the topics found.
pub(super) fn open(name: &str, mut from: impl BufRead, table: Option<&str>) -> Result<Held> {
    let mut log = Log::default();
    let read = log.read(&mut from);
    read.map_err(|error| {
        let early = error.kind() == io::ErrorKind::UnexpectedEof;
        Malformed::new(Fault::File, format!("'{name}' cannot be read to its end as MCAP"))
            .expected(if early {
                "a whole log; this one was cut off, or is still being written"
            } else {
                "a sound log"
            })
            .found(error.to_string())
            .in_file(name)
    })?;
    choose(name, log.topics.into_values().collect(), table)
}

/// A fault of a log.
pub(super) fn invalid(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

/// The topic that is meant, of those of a log.
pub(super) fn choose(name: &str, mut topics: Vec<Topic>, table: Option<&str>) -> Result<Held> {
    topics.sort_by(|a, b| a.name.cmp(&b.name));
    if !topics.iter().any(|topic| topic.serial.is_some()) {
        let found: Vec<String> = topics.iter().map(|topic| format!("{} ({})", topic.name, topic.kind)).collect();
        return Err(Malformed::new(Fault::Missing, format!("'{name}' has no topic of sensor_msgs/Imu"))
            .expected("messages sensor_msgs/Imu (ROS 1) or sensor_msgs/msg/Imu (ROS 2)")
            .found(if found.is_empty() { "no topic".to_string() } else { found.join(", ") })
            .in_file(name));
    }
    let sheets = topics.into_iter().filter(|topic| topic.serial.is_some()).map(Topic::sheet).collect();
    Held::choose(name, "topic", sheets, table)
}

/// How a message's numbers are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Serial {
    Ros1,
    Cdr,
}

#[derive(Debug, Default)]
pub(super) struct Topic {
    pub name: String,
    pub kind: String,
    pub serial: Option<Serial>,
    /// Times of the heads and of the log, ns.
    pub stamps: Vec<(i128, u64)>,
    pub values: Vec<[f64; 6]>,
}

impl Topic {
    /// Takes a message: times of its head and of the log in nanoseconds, rates and specific forces.
    pub fn push(&mut self, stamp: i128, time: u64, values: [f64; 6]) {
        self.stamps.push((stamp, time));
        self.values.push(values);
    }

    fn sheet(self) -> Sheet {
        let by_log = self.stamps.iter().all(|(head, _)| *head == 0);
        let ns = |(head, log): &(i128, u64)| if by_log { i128::from(*log) } else { *head };
        // messages may come late into the log
        let mut rows: Vec<(i128, &[f64; 6])> = self.stamps.iter().map(ns).zip(&self.values).collect();
        rows.sort_by_key(|(at, _)| *at);
        let first = rows.first().map_or(0, |(at, _)| *at);
        let time = rows.iter().map(|(at, _)| (at - first) as f64 / 1e9).collect();
        let column = |name: &str, unit: &str| Column { name: name.into(), title: name.into(), unit: Some(unit.into()) };
        let mut columns = vec![(column("time_s", "s"), time)];
        columns.extend(COLUMNS.iter().enumerate().map(|(k, (name, unit))| {
            (column(name, unit), rows.iter().filter_map(|(_, row)| row.get(k).copied()).collect())
        }));
        Sheet { name: self.name, columns }
    }
}

#[derive(Debug, Default)]
struct Log {
    /// Name and encoding of each schema.
    schemas: HashMap<u16, String>,
    topics: HashMap<u16, Topic>,
}

impl Log {
    fn read(&mut self, from: &mut impl BufRead) -> io::Result<()> {
        let mut magic = [0_u8; 8];
        from.read_exact(&mut magic)?;
        if magic != MAGIC {
            return Err(invalid("another version of the format"));
        }
        let mut data = Vec::new();
        let mut sum = crc32fast::Hasher::new();
        sum.update(&magic);
        loop {
            let mut head = [0_u8; 9];
            from.read_exact(&mut head)?;
            let [kind, length @ ..] = head;
            let length = u64::from_le_bytes(length);
            if length > LONGEST {
                return Err(invalid(format!("a record of {length} bytes")));
            }
            data.clear();
            if from.by_ref().take(length).read_to_end(&mut data)? as u64 != length {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            if kind != DATA_END {
                sum.update(&head);
                sum.update(&data);
            }
            match kind {
                DATA_END => {
                    let said = data.first_chunk::<4>().map_or(0, |bytes| u32::from_le_bytes(*bytes));
                    if said != 0 && sum.finalize() != said {
                        return Err(invalid("data whose checksum (CRC) is another one: the file is damaged"));
                    }
                    return Ok(());
                }
                CHUNK => self.chunk(&data)?,
                _ => self.record(kind, &data)?,
            }
        }
    }

    fn chunk(&mut self, data: &[u8]) -> io::Result<()> {
        let mut at = Bytes(data);
        let head = (|| {
            at.take(16)?;
            let size = at.u64()?;
            let sum = u32::from_le_bytes(at.take(4)?.try_into().ok()?);
            let compression = at.text()?;
            let length = usize::try_from(at.u64()?).ok()?;
            Some((size, sum, compression, at.take(length)?))
        })();
        let (size, sum, compression, packed) = head.ok_or(io::ErrorKind::UnexpectedEof)?;
        let mut plain = Vec::new();
        match compression.as_str() {
            "" => plain.extend_from_slice(packed),
            "zstd" => {
                zstd::stream::read::Decoder::new(packed)?.take(LONGEST).read_to_end(&mut plain)?;
            }
            "lz4" => {
                lz4_flex::frame::FrameDecoder::new(packed).take(LONGEST).read_to_end(&mut plain)?;
            }
            other => return Err(invalid(format!("a chunk compressed by '{other}'"))),
        }
        if plain.len() as u64 != size {
            return Err(invalid("a chunk of another size than it says"));
        }
        // 0: the writer left it out
        if sum != 0 && crc32fast::hash(&plain) != sum {
            return Err(invalid("a chunk whose checksum (CRC) is another one: the file is damaged"));
        }
        let mut at = Bytes(&plain);
        while !at.0.is_empty() {
            let record = (|| {
                let kind = *at.take(1)?.first()?;
                let length = usize::try_from(at.u64()?).ok()?;
                Some((kind, at.take(length)?))
            })();
            let (kind, data) = record.ok_or(io::ErrorKind::UnexpectedEof)?;
            self.record(kind, data)?;
        }
        Ok(())
    }

    fn record(&mut self, kind: u8, data: &[u8]) -> io::Result<()> {
        let mut at = Bytes(data);
        let read = match kind {
            SCHEMA => (|| {
                let id = at.u16()?;
                self.schemas.insert(id, at.text()?);
                Some(())
            })(),
            CHANNEL => (|| {
                let (id, schema) = (at.u16()?, at.u16()?);
                let (name, encoding) = (at.text()?, at.text()?);
                let kind = self.schemas.get(&schema).cloned().unwrap_or_default();
                let imu = matches!(kind.as_str(), "sensor_msgs/Imu" | "sensor_msgs/msg/Imu");
                let serial = match encoding.as_str() {
                    "ros1" if imu => Some(Serial::Ros1),
                    "cdr" if imu => Some(Serial::Cdr),
                    _ => None,
                };
                self.topics.entry(id).or_insert_with(|| Topic { name, kind, serial, ..Topic::default() });
                Some(())
            })(),
            MESSAGE => (|| {
                let id = at.u16()?;
                at.take(4)?;
                let time = at.u64()?;
                at.take(8)?;
                let Some(topic) = self.topics.get_mut(&id) else { return Some(()) };
                let Some(serial) = topic.serial else { return Some(()) };
                let (stamp, values) = imu(at.0, serial)?;
                topic.push(stamp, time, values);
                Some(())
            })(),
            _ => Some(()),
        };
        read.ok_or_else(|| invalid("a record that ends too early"))
    }
}

/// Time of the head in nanoseconds, rates and specific forces of a message.
pub(super) fn imu(data: &[u8], serial: Serial) -> Option<(i128, [f64; 6])> {
    let mut at = Bytes(data);
    let mut big = false;
    if serial == Serial::Cdr {
        // representation: plain CDR, version 1 or 2, either byte order
        let [_, kind, _, _] = at.take(4)? else { return None };
        big = kind % 2 == 0;
    }
    let body = at.0;
    let number = |bytes: &[u8]| {
        let word = <[u8; 4]>::try_from(bytes).ok()?;
        Some(if big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
    };
    if serial == Serial::Ros1 {
        at.take(4)?;
    }
    let seconds = number(at.take(4)?)?;
    // ROS 2 counts with a sign
    let seconds = if serial == Serial::Cdr { i128::from(seconds as i32) } else { i128::from(seconds) };
    let stamp = seconds * 1_000_000_000 + i128::from(number(at.take(4)?)?);
    let length = number(at.take(4)?)? as usize;
    at.take(length)?;
    if serial == Serial::Cdr {
        let to = if data.get(1).is_some_and(|kind| *kind >= 6) { 4 } else { 8 };
        let done = body.len() - at.0.len();
        at.take((to - done % to) % to)?;
    }
    // orientation 4, its covariance 9, rate 3, covariance 9, specific force 3
    let mut values = [0.0; 6];
    for (value, place) in values.iter_mut().zip([13, 14, 15, 25, 26, 27]) {
        let word = <[u8; 8]>::try_from(at.0.get(8 * place..8 * place + 8)?).ok()?;
        *value = if big { f64::from_be_bytes(word) } else { f64::from_le_bytes(word) };
    }
    Some((stamp, values))
}

/// Bytes that are taken from the front, in little-endian order.
pub(super) struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    /// As many as the four bytes before them say.
    pub fn part(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.take(4)?.try_into().ok()?) as usize;
        self.take(length)
    }

    fn text(&mut self) -> Option<String> {
        Some(String::from_utf8_lossy(self.part()?).into_owned())
    }
}
