//! Bags of ROS 1 (version 2.0): the messages `sensor_msgs/Imu`, as in an MCAP log.
//!
//! A record is a head of fields `name=value` and data; chunks hold records of connections and messages. What follows the chunks (indices) is not needed.

use super::Format;
use super::held::Held;
use super::mcap::{Bytes, LONGEST, Serial, Topic, choose, imu, invalid};
use crate::error::{Fault, Malformed, Result};
use std::collections::HashMap;
use std::io::{self, BufRead, Read};

/// What every file begins with.
const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Kinds of records.
const MESSAGE: u8 = 2;
const CHUNK: u8 = 5;
const CONNECTION: u8 = 7;

/// Read the topic that is meant.
///
/// Errors: a file that was cut off, no topic of that kind of message, several; with the topics found.
pub(super) fn open(name: &str, mut from: impl BufRead, table: Option<&str>) -> Result<Held> {
    let mut topics = HashMap::new();
    read(&mut from, &mut topics).map_err(|error| {
        Malformed::new(Fault::File, format!("'{name}' cannot be read to its end as {}", Format::Bag.name()))
            .expected("a whole bag of version 2.0, not compressed or compressed by lz4")
            .found(error.to_string())
            .in_file(name)
    })?;
    choose(name, topics.into_values().collect(), table)
}

fn read(from: &mut impl BufRead, topics: &mut HashMap<u32, Topic>) -> io::Result<()> {
    let mut magic = [0_u8; MAGIC.len()];
    from.read_exact(&mut magic)?;
    if magic != *MAGIC {
        return Err(invalid("another version of the format"));
    }
    let (mut head, mut data) = (Vec::new(), Vec::new());
    while !from.fill_buf()?.is_empty() {
        for part in [&mut head, &mut data] {
            let mut length = [0_u8; 4];
            from.read_exact(&mut length)?;
            let length = u64::from(u32::from_le_bytes(length));
            part.clear();
            if from.by_ref().take(length).read_to_end(part)? as u64 != length {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
        }
        record(&head, &data, topics, true)?;
    }
    Ok(())
}

/// A field of a head.
fn field<'a>(head: &'a [u8], name: &str) -> Option<&'a [u8]> {
    let mut at = Bytes(head);
    loop {
        let entry = at.part()?;
        let equals = entry.iter().position(|byte| *byte == b'=')?;
        let (key, value) = entry.split_at_checked(equals)?;
        if key == name.as_bytes() {
            return value.get(1..);
        }
    }
}

fn number(head: &[u8], name: &str) -> io::Result<u32> {
    let bytes = field(head, name).and_then(|bytes| bytes.try_into().ok());
    bytes.map(u32::from_le_bytes).ok_or_else(|| invalid(format!("a record without the field '{name}'")))
}

fn record(head: &[u8], data: &[u8], topics: &mut HashMap<u32, Topic>, outside: bool) -> io::Result<()> {
    let text = |bytes: Option<&[u8]>| String::from_utf8_lossy(bytes.unwrap_or_default()).into_owned();
    match field(head, "op") {
        Some([CONNECTION]) => {
            let kind = text(field(data, "type"));
            let serial = (kind == "sensor_msgs/Imu").then_some(Serial::Ros1);
            let name = text(field(head, "topic"));
            topics.entry(number(head, "conn")?).or_insert_with(|| Topic { name, kind, serial, ..Topic::default() });
        }
        Some([MESSAGE]) => {
            let Some(topic) = topics.get_mut(&number(head, "conn")?) else { return Ok(()) };
            let Some(serial) = topic.serial else { return Ok(()) };
            let time = field(head, "time").and_then(|bytes| bytes.try_into().ok()).map_or(0, u64::from_le_bytes);
            let time = (time & 0xFFFF_FFFF) * 1_000_000_000 + (time >> 32);
            let (stamp, values) = imu(data, serial).ok_or_else(|| invalid("a message that ends too early"))?;
            topic.push(stamp, time, values);
        }
        Some([CHUNK]) if outside => {
            let size = u64::from(number(head, "size")?);
            let mut unpacked = Vec::new();
            let plain = match field(head, "compression") {
                Some(b"none") => data,
                Some(b"lz4") => {
                    lz4_flex::frame::FrameDecoder::new(data).take(size.min(LONGEST)).read_to_end(&mut unpacked)?;
                    unpacked.as_slice()
                }
                other => return Err(invalid(format!("a chunk compressed by '{}'", text(other)))),
            };
            if plain.len() as u64 != size {
                return Err(invalid("a chunk of another size than it says"));
            }
            let mut at = Bytes(plain);
            while !at.0.is_empty() {
                let (head, data) = at.part().zip(at.part()).ok_or(io::ErrorKind::UnexpectedEof)?;
                record(head, data, topics, false)?;
            }
        }
        _ => {}
    }
    Ok(())
}
