//! Every reader of what a user may bring, on files of the examples and the tests with seeded damage: none panics, and what is written is read
//! again alike. Bounded by the count of inputs, not by time; `TUMBLE_LONG=1` has fifty times as many. `fuzz/` has the same readers for libFuzzer,
//! which looks for new paths where this only draws.

use crate::draws::draws;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde_json::Value;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use tumble::algebra::Expression;
use tumble::language::Language;
use tumble::record::{As, Block, Record};
use tumble::report::FitReport;
use tumble::wire::{self, MissionFile, Named, Source, parse, read_effects, read_lab, read_readings, read_truth};
use tumble::{Bench, Campaign};

/// Largest file that is damaged: a report of hundreds of kilobytes costs milliseconds an input.
const LARGEST: u64 = 60_000;

fn files(folder: &Path, ends: &[&str], found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        if path.is_dir() {
            files(&path, ends, found);
        } else if ends.iter().any(|end| name.ends_with(end)) && path.metadata().unwrap().len() <= LARGEST {
            found.push(path);
        }
    }
}

/// The contents of the project's files whose names end so.
fn corpus(folders: &[&str], ends: &[&str]) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    for folder in folders {
        files(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), ends, &mut found);
    }
    assert!(!found.is_empty(), "no file in {folders:?} ends with {ends:?}");
    found.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// What is put in: values that a format knows, and values at the ends of what numbers are.
const TOKENS: [&str; 36] = [
    "null",
    "true",
    "-1",
    "0",
    "1e999",
    "-1e-320",
    "NaN",
    "inf",
    "9007199254740993",
    "\"\"",
    "[]",
    "{}",
    "[",
    "}",
    ",",
    ":",
    "\"",
    "\\u0000",
    "\u{feff}",
    "\n",
    "\r",
    "\t",
    ";",
    "#",
    "=",
    "w_x",
    "a_z",
    "sin(",
    ")",
    "^",
    "^-2",
    "/0",
    "sqrt(-1)",
    "deg/h",
    "\u{00b5}",
    "\u{65e5}",
];

/// Some damage: bytes changed, cut, doubled, moved in from another file, numbers and tokens put in.
fn damaged(corpus: &[Vec<u8>], rng: &mut Pcg64Mcg) -> Vec<u8> {
    let below = |rng: &mut Pcg64Mcg, n: usize| (rng.next_u64() % n.max(1) as u64) as usize;
    let mut text = corpus[below(rng, corpus.len())].clone();
    for _ in 0..1 + below(rng, 4) {
        let at = below(rng, text.len() + 1);
        let end = (at + 1 + below(rng, 24)).min(text.len());
        match below(rng, 7) {
            0 if at < text.len() => text[at] ^= 1 << below(rng, 8),
            1 => drop(text.drain(at.min(end)..end)),
            2 => {
                let again = text[at.min(end)..end].to_vec();
                text.splice(at..at, again);
            }
            3 => {
                let other = &corpus[below(rng, corpus.len())];
                let from = below(rng, other.len() + 1);
                let to = (from + 1 + below(rng, 200)).min(other.len());
                text.splice(at..at, other[from.min(to)..to].iter().copied());
            }
            4 => text.truncate(at),
            5 => {
                // a number becomes another
                let digits: Vec<usize> = (0..text.len()).filter(|k| text[*k].is_ascii_digit()).collect();
                if !digits.is_empty() {
                    let start = digits[below(rng, digits.len())];
                    let length = text[start..].iter().take_while(|c| c.is_ascii_digit()).count();
                    let number = ["0", "-3", "1e308", "5e-324", "1e17", "0.1", "4294967296"][below(rng, 7)];
                    text.splice(start..start + length, number.bytes());
                }
            }
            _ => drop(text.splice(at..at, TOKENS[below(rng, TOKENS.len())].bytes())),
        }
    }
    text
}

/// The nodes of a JSON value.
fn nodes(value: &Value) -> usize {
    1 + match value {
        Value::Array(list) => list.iter().map(nodes).sum::<usize>(),
        Value::Object(map) => map.values().map(nodes).sum(),
        _ => 0,
    }
}

/// Damage that leaves JSON what it is, so that it comes past the parser: one node becomes another.
fn changed(value: &mut Value, at: &mut usize, rng: &mut Pcg64Mcg) {
    if *at > 0 {
        *at -= 1;
        let parts: Vec<&mut Value> = match value {
            Value::Array(list) => list.iter_mut().collect(),
            Value::Object(map) => map.values_mut().collect(),
            _ => Vec::new(),
        };
        for part in parts {
            let count = nodes(part);
            if *at < count {
                return changed(part, at, rng);
            }
            *at -= count;
        }
        return;
    }
    let draw = |rng: &mut Pcg64Mcg, n: usize| (rng.next_u64() % n.max(1) as u64) as usize;
    match value {
        Value::Number(number) => {
            let own = number.as_f64().unwrap_or(1.0);
            let others = [0.0, -own, 1e308, 5e-324, 1e17, 0.1, 4_294_967_296.0, own * 1e9, own * 1e-9, own + 1.0];
            *value = others[draw(rng, others.len())].into();
        }
        Value::String(text) => match draw(rng, 4) {
            0 => text.clear(),
            1 => text.push_str(TOKENS[draw(rng, TOKENS.len())]),
            2 => *value = Value::Null,
            _ => *value = 1.5.into(),
        },
        Value::Array(list) => match (draw(rng, 4), list.last().cloned()) {
            (0, _) => list.clear(),
            (1, _) => drop(list.pop()),
            (2, Some(last)) => list.push(last),
            _ => list.reverse(),
        },
        Value::Object(map) => {
            let keys: Vec<String> = map.keys().cloned().collect();
            let pair = [draw(rng, keys.len()), draw(rng, keys.len())].map(|k| keys.get(k).cloned().unwrap_or_default());
            match (draw(rng, 3), map.remove(&pair[0])) {
                // it goes, it has another name, or it has what another has
                (0, _) | (_, None) => {}
                (1, Some(own)) => drop(map.insert(format!("{}_x", pair[0]), own)),
                (_, Some(own)) => {
                    let other = map.insert(pair[1].clone(), own.clone());
                    map.insert(pair[0].clone(), other.unwrap_or(own));
                }
            }
        }
        Value::Bool(own) => *own = !*own,
        Value::Null => *value = 1e3.into(),
    }
}

/// Some damage: of files of JSON, every second input stays JSON.
fn input(corpus: &[Vec<u8>], number: usize) -> Vec<u8> {
    let mut rng = Pcg64Mcg::seed_from_u64(number as u64);
    if number.is_multiple_of(2) {
        return damaged(corpus, &mut rng);
    }
    let own = &corpus[(rng.next_u64() % corpus.len() as u64) as usize];
    let Ok(mut value) = serde_json::from_slice::<Value>(own) else { return damaged(corpus, &mut rng) };
    for _ in 0..1 + rng.next_u64() % 2 {
        let mut at = (rng.next_u64() % nodes(&value) as u64) as usize;
        changed(&mut value, &mut at, &mut rng);
    }
    value.to_string().into_bytes()
}

/// `reader` says whether it took an input. Prints how many it took; a panic is reported with the input, kept in the folder for temporary files.
fn hold(name: &str, corpus: &[Vec<u8>], count: usize, reader: impl Fn(&[u8]) -> bool) {
    let mut taken = 0;
    for k in 0..count {
        let input = input(corpus, k);
        match catch_unwind(AssertUnwindSafe(|| reader(&input))) {
            Ok(took) => taken += usize::from(took),
            Err(_) => {
                let kept = std::env::temp_dir().join(format!("tumble-mutated-{name}-{k}"));
                std::fs::write(&kept, &input).unwrap();
                panic!("{name}: input {k} panics; it is kept as {}", kept.display());
            }
        }
    }
    println!("{name:<9} {count:>7} inputs from {:>3} files, {taken:>6} taken, the others refused", corpus.len());
    assert!(taken > 0, "{name}: every input is refused at the door, so that nothing behind it is tried");
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn source(bytes: &[u8]) -> Source {
    Source { name: "mutated".into(), text: text(bytes) }
}

const ALL: [&str; 3] = ["examples", "data", "tests/data"];

#[test]
fn campaigns() {
    let reader = |bytes: &[u8]| {
        let Ok(campaign) = Campaign::from_json(&text(bytes)) else { return false };
        if campaign.readings.rows.len() < 50 && campaign.unknowns() < 20 {
            let _ = tumble::fit(&campaign, &Default::default());
        }
        true
    };
    hold("campaign", &corpus(&ALL, &[".campaign.json"]), draws(2_000, 100_000), reader);
}

#[test]
fn benches() {
    let reader = |bytes: &[u8]| {
        let Ok(bench) = Bench::from_json(&text(bytes)) else { return false };
        let file = wire::bench_file(&bench);
        assert_eq!(wire::bench_file(&file.clone().into_bench().expect("what was written is read")), file);
        true
    };
    hold("bench", &corpus(&ALL, &[".bench.json"]), draws(2_000, 100_000), reader);
}

#[test]
fn missions() {
    let reader = |bytes: &[u8]| parse::<MissionFile>(&source(bytes)).is_ok_and(|file| file.mission().is_ok());
    hold("mission", &corpus(&ALL, &[".mission.json"]), draws(2_000, 100_000), reader);
}

#[test]
fn truths_effects_laboratories_and_reports() {
    let campaign =
        Campaign::from_json(include_str!("../../data/campaigns/li2012-table1.campaign.json")).expect("a campaign");
    let count = draws(1_000, 50_000);
    hold("truth", &corpus(&ALL, &["truth.json"]), count, |bytes| read_truth(&source(bytes), &campaign).is_ok());
    hold("effects", &corpus(&["data"], &["effects.json"]), count, |bytes| read_effects(&source(bytes)).is_ok());
    hold("lab", &corpus(&["tests/data/lab"], &[".json"]), count, |bytes| read_lab(&source(bytes)).is_ok());
    let kept = ["constrained.json", "defect.json", "linear.json", "monte-carlo.json", "robust.json"];
    hold("report", &corpus(&["tests/data/kept-0.1"], &kept), count, |bytes| {
        let Ok(report) = parse::<FitReport>(&source(bytes)) else { return false };
        // what was written is read, and written alike
        let written = serde_json::to_string(&report).expect("JSON");
        let again = parse::<FitReport>(&self::source(written.as_bytes())).map(|own| serde_json::to_string(&own));
        assert_eq!(again.expect("what was written is read").expect("JSON"), written);
        let _ = tumble::document::terminal::brief(&tumble::report::fit_document(
            &report,
            &tumble::report::Asked { readings: true, budget: true, correction: true, ..Default::default() },
            Language::English,
        ));
        true
    });
}

#[test]
fn tables() {
    let bench = Bench::named("gyro-turntable").expect("a bench");
    let count = draws(2_000, 100_000);
    let tables = corpus(&ALL, &[".csv"]);
    hold("readings", &tables, count, |bytes| {
        let Ok(record) = Record::of_text("readings.csv", bytes) else { return false };
        read_readings(&bench, record, &Named::default(), &[]).is_ok()
    });
    let records = corpus(&ALL, &[".csv", ".csv.gz"]);
    hold("record", &records, count, |bytes| {
        let Ok(mut table) = Record::of_stream("record", Cursor::new(bytes.to_vec())) else { return false };
        let columns: Vec<(usize, As)> = (0..table.columns().len()).map(|k| (k, As::Number)).collect();
        table.select(&columns);
        let mut block = Block::default();
        while let Ok(true) = table.next(&mut block) {}
        true
    });
}

/// Reads a file in whatever format as numbers, as numbers and labels, and as labels; `true` where all of it is taken.
fn read_file(path: &Path) -> bool {
    [As::Number, As::Mixed, As::Label].into_iter().all(|kind| {
        let Ok(mut record) = Record::at(path) else { return false };
        record.select(&(0..record.columns().len()).map(|k| (k, kind)).collect::<Vec<_>>());
        let mut block = Block::default();
        loop {
            match record.next(&mut block) {
                Ok(true) => {}
                Ok(false) => return true,
                Err(_) => return false,
            }
        }
    })
}

/// Formats that are not text, each from files that the libraries of its own community wrote.
#[test]
fn binary_files() {
    let folder = tempfile::tempdir().expect("a folder");
    for format in ["parquet", "xlsx", "xls", "ods", "mat", "h5", "mcap", "bag", "ulg"] {
        let seeds = corpus(&["tests/data/records", "tests/data/doors", "tests/data/fuzzed"], &[&format!(".{format}")]);
        let path = folder.path().join(format);
        hold(format, &seeds, draws(300, 20_000), |bytes| {
            std::fs::write(&path, bytes).expect("a file");
            read_file(&path)
        });
    }
}

/// Inputs that runs of fuzzing kept, each of which gets another answer: the program reads or refuses it, and neither panics nor asks for 2 GB.
#[cfg(unix)]
#[test]
fn inputs_that_fuzzing_kept() {
    let mut kept = Vec::new();
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzzed"), &[""], &mut kept);
    assert!(kept.len() > 50, "{}", kept.len());
    for path in kept {
        let program = assert_cmd::cargo::cargo_bin("tumble");
        let output = std::process::Command::new("sh")
            .args(["-c", "ulimit -v 2000000; exec \"$0\" noise --rate 100 --json - \"$1\""])
            .args([&program, &path])
            .output()
            .expect("a run");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(
            matches!(output.status.code(), Some(0..=2)) && !error.contains("panicked"),
            "{}: {error}",
            path.display()
        );
    }
}

#[test]
fn lines_and_units() {
    let mut lines = Vec::new();
    for text in corpus(&["data"], &[".bench.json"]) {
        let text = String::from_utf8(text).expect("a file of the project");
        lines.extend(
            text.split("\"model\": \"")
                .skip(1)
                .filter_map(|rest| rest.split('"').next())
                .map(|l| l.as_bytes().to_vec()),
        );
    }
    hold("line", &lines, draws(20_000, 1_000_000), |bytes| {
        let Ok(line) = Expression::parse(&text(bytes)) else { return false };
        let printed = line.canonical();
        assert_eq!(Expression::parse(&printed).expect("what was printed is parsed").canonical(), printed);
        true
    });
    let units = ["deg/h", "V/(deg/s)", "m/s^2", "ug/sqrt(Hz)", "arcsec", "1/g", "deg/(g*h)", "pulse/s/(deg/h)"];
    let units: Vec<Vec<u8>> = units.iter().map(|unit| unit.as_bytes().to_vec()).collect();
    hold("unit", &units, draws(20_000, 1_000_000), |bytes| tumble::units::Unit::parse_any(&text(bytes)).is_ok());
}
