//! ULog, the logs of PX4: each subscription is a table, its fields are columns; `timestamp` is in microseconds.
//!
//! The layout is that of the PX4 guide (File Format, ULog). A log ends where the power did: a last message that is cut off is left out.

use super::Column;
use super::held::{Held, Sheet};
use crate::error::{Fault, Malformed, Result};
use std::collections::{BTreeMap, HashMap};

/// What every file begins with, and how long its head is.
const MAGIC: &[u8] = b"ULog\x01\x12\x35";
const HEAD: usize = 16;
/// Most columns of a subscription, and types inside each other.
const WIDEST: usize = 4096;
const DEEPEST: usize = 8;

/// A column in a message: its name, the place of its first byte, how its bytes are a number.
type Field = (String, usize, fn(&[u8]) -> Option<f64>);

/// Fields of a subscription with their values.
struct Topic {
    name: String,
    fields: Vec<Field>,
    values: Vec<Vec<f64>>,
}

/// Read the subscription that is meant; `NAME_0` is the first of its name.
///
/// Errors: a file that is no ULog inside, no subscription with numbers, several; with those found.
pub(super) fn open(name: &str, bytes: &[u8], table: Option<&str>) -> Result<Held> {
    let topics = read(bytes).map_err(|found| {
        Malformed::new(Fault::File, format!("'{name}' cannot be read as a ULog"))
            .expected("a sound ULog of PX4")
            .found(found)
            .in_file(name)
    })?;
    let sheet = |topic: Topic| {
        let column = |((title, ..), values): (Field, Vec<f64>)| {
            let unit = (title == "timestamp").then(|| "us".to_string());
            (Column { name: title.clone(), title, unit }, values)
        };
        Sheet { name: topic.name, columns: topic.fields.into_iter().zip(topic.values).map(column).collect() }
    };
    Held::choose(name, "subscription", topics.into_values().map(sheet).collect(), table)
}

fn read(bytes: &[u8]) -> std::result::Result<BTreeMap<u16, Topic>, String> {
    let mut rest = bytes.strip_prefix(MAGIC).and_then(|_| bytes.get(HEAD..)).ok_or("no head of a ULog")?;
    let mut formats: HashMap<&str, &str> = HashMap::new();
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    while let Some((message, left)) = message(rest) {
        rest = left;
        match message {
            (b'F', data) => {
                let text = std::str::from_utf8(data).map_err(|_| "a format that is not text")?;
                let (name, fields) = text.split_once(':').ok_or("a format without a name")?;
                formats.insert(name, fields);
            }
            (b'A', [several, low, high, name @ ..]) => {
                let name = std::str::from_utf8(name).map_err(|_| "a subscription whose name is not text")?;
                let (mut fields, mut at) = (Vec::new(), 0);
                layout(&formats, name, "", &mut at, &mut fields, 0)?;
                let values = vec![Vec::new(); fields.len()];
                let name = format!("{name}_{several}");
                topics.insert(u16::from_le_bytes([*low, *high]), Topic { name, fields, values });
            }
            (b'D', [low, high, data @ ..]) => {
                let Some(topic) = topics.get_mut(&u16::from_le_bytes([*low, *high])) else { continue };
                for ((_, place, number), values) in topic.fields.iter().zip(&mut topic.values) {
                    let value = data.get(*place..).and_then(number);
                    values.push(value.ok_or_else(|| format!("a message of {} that is too short", topic.name))?);
                }
            }
            _ => {}
        }
    }
    Ok(topics)
}

/// Kind and data of the next message, and what follows it; `None` at the end.
fn message(bytes: &[u8]) -> Option<((u8, &[u8]), &[u8])> {
    let (head, rest) = bytes.split_first_chunk::<3>()?;
    let [low, high, kind] = *head;
    let (data, left) = rest.split_at_checked(usize::from(u16::from_le_bytes([low, high])))?;
    Some(((kind, data), left))
}

/// The columns of a format: `float[3] gyro;uint64_t timestamp;`, formats inside it with their names before a point.
fn layout(
    formats: &HashMap<&str, &str>,
    format: &str,
    before: &str,
    at: &mut usize,
    fields: &mut Vec<Field>,
    depth: usize,
) -> std::result::Result<(), String> {
    let list = formats.get(format).ok_or_else(|| format!("the format '{format}', which is not declared"))?;
    if depth > DEEPEST {
        return Err(format!("the format '{format}', which has itself inside"));
    }
    for field in list.split(';').filter(|field| !field.is_empty()) {
        let (kind, name) = field.split_once(' ').ok_or_else(|| format!("the field '{field}' without a name"))?;
        let (kind, count) = match kind.strip_suffix(']').and_then(|rest| rest.split_once('[')) {
            Some((kind, count)) => (kind, count.parse().map_err(|_| format!("the field '{field}'"))?),
            None => (kind, 1_usize),
        };
        let is_padding = name.starts_with("_padding");
        for k in 0..count {
            if fields.len() > WIDEST || *at > usize::from(u16::MAX) {
                return Err(format!("the format '{format}', which is too wide"));
            }
            let name = if count > 1 { format!("{before}{name}[{k}]") } else { format!("{before}{name}") };
            let Some((size, number)) = number(kind) else {
                let start = *at;
                layout(formats, kind, &format!("{name}."), at, fields, depth + 1)?;
                // any number of nothing has no end
                if *at == start {
                    return Err(format!("the format '{kind}', which has no field"));
                }
                continue;
            };
            if kind != "char" && !is_padding {
                fields.push((name, *at, number));
            }
            *at += size;
        }
    }
    Ok(())
}

/// Size of a type, and how its bytes are a number.
fn number(kind: &str) -> Option<(usize, fn(&[u8]) -> Option<f64>)> {
    macro_rules! of {
        ($kind:ty) => {
            (size_of::<$kind>(), |bytes| bytes.first_chunk().map(|word| <$kind>::from_le_bytes(*word) as f64))
        };
    }
    Some(match kind {
        "int8_t" => of!(i8),
        "uint8_t" | "bool" | "char" => of!(u8),
        "int16_t" => of!(i16),
        "uint16_t" => of!(u16),
        "int32_t" => of!(i32),
        "uint32_t" => of!(u32),
        "int64_t" => of!(i64),
        "uint64_t" => of!(u64),
        "float" => of!(f32),
        "double" => of!(f64),
        _ => return None,
    })
}
