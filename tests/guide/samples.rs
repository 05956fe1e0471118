//! Samples as they come: positions that are held become readings, are recognised, and are not read twice.

use crate::bench::{measure, parse};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use tumble::campaign::{Campaign, Reading};
use tumble::simulate::Truth;

/// Three accelerometers on two joints, level with the ground; 14 settings, of which gravity tells most apart.
const SCHEDULE: &str = r#"{ "bench": { "id": "triad", "site": { "latitude_deg": 48 }, "units": { "rate": "deg/s", "force": "g" },
    "chain": [ { "joint": "roll", "about": "x" }, { "joint": "pitch", "about": "y" } ],
    "sensors": { "X": { "unit": "V", "axes": { "I": "x" }, "model": "bx + kx*a_I" },
                 "Y": { "unit": "V", "axes": { "I": "y" }, "model": "by + ky*a_I" },
                 "Z": { "unit": "V", "axes": { "I": "z" }, "model": "bz + kz*a_I" } } },
  "estimate": { "bx": {}, "by": {}, "bz": {}, "kx": { "start": 1 }, "ky": { "start": 1 }, "kz": { "start": 1 } },
  "readings": [
    { "position": "up", "roll_deg": 0, "pitch_deg": 0 }, { "position": "down", "roll_deg": 180, "pitch_deg": 0 },
    { "position": "left", "roll_deg": 90, "pitch_deg": 0 }, { "position": "right", "roll_deg": 270, "pitch_deg": 0 },
    { "position": "nose", "roll_deg": 0, "pitch_deg": 90 }, { "position": "tail", "roll_deg": 0, "pitch_deg": 270 },
    { "position": "edge", "roll_deg": 45, "pitch_deg": 0 }, { "position": "over", "roll_deg": 180, "pitch_deg": 180 } ] }"#;

const HZ: f64 = 100.0;
/// Standard deviation of a sample, and what is wanted of a reading: 178 samples of white noise.
const SD: f64 = 2e-4;
const WANTED: f64 = 1.5e-5;
/// Positions are held for so long that hardly any of them, whatever its noise looks like by chance, is not known so well.
pub const LONG_S: f64 = 30.0;

pub struct Table {
    schedule: Campaign,
    truth: Truth,
    random: Pcg64Mcg,
    rows: u64,
    values: Vec<f64>,
}

impl Table {
    pub fn new(seed: u64) -> Self {
        let schedule = parse(SCHEDULE);
        let mut point = schedule.reference_point();
        let shifts = [3e-3, -2e-3, 1e-3, 4e-3, -1e-3, 2e-3];
        point.iter_mut().zip(shifts).for_each(|(value, by)| *value += by);
        let truth = Truth { point, noise: Vec::new(), effects: Vec::new(), scatter: Vec::new() };
        Table { schedule, truth, random: Pcg64Mcg::seed_from_u64(seed), rows: 0, values: vec![0.0; 3] }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn setting(&self, label: &str) -> Reading {
        self.schedule.readings.rows.iter().find(|own| own.position == label).unwrap().clone()
    }

    /// What the sensors say at a position without noise.
    fn quiet(&self, label: &str) -> Vec<f64> {
        let read = measure(&self.schedule, &self.truth, &[], &self.setting(label), 1);
        read.observations.iter().map(|own| own.value).collect()
    }

    fn row(&mut self, text: &mut String, label: Option<&str>) {
        write!(text, "{:.2}", self.rows as f64 / HZ).unwrap();
        for k in 0..3 {
            let value = self.values[k] + SD * self.normal();
            write!(text, ",{value:.7}").unwrap();
        }
        writeln!(text, "{}", label.map_or(String::new(), |label| format!(",{label}"))).unwrap();
        self.rows += 1;
    }

    /// Move there in two seconds, the hand shaking, and hold it; at first it stands there.
    pub fn hold(&mut self, label: &str, seconds: f64) -> String {
        self.run(label, seconds, None)
    }

    fn run(&mut self, label: &str, seconds: f64, said: Option<&str>) -> String {
        let (from, to) = (self.values.clone(), self.quiet(label));
        let mut text = String::new();
        let moving = if self.rows == 0 { 0 } else { (2.0 * HZ) as usize };
        for k in 0..moving {
            let share = k as f64 / moving as f64;
            for i in 0..3 {
                self.values[i] = from[i] + share * (to[i] - from[i]) + 0.02 * self.normal();
            }
            self.row(&mut text, said.map(|_| ""));
        }
        self.values = to;
        for _ in 0..(seconds * HZ) as usize {
            self.row(&mut text, said);
        }
        text
    }
}

pub fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("schedule.campaign.json"), SCHEDULE).unwrap();
    folder
}

pub fn tumble(folder: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tumble"));
    let noise = ["X", "Y", "Z"].map(|id| format!("{id}={WANTED}"));
    command.current_dir(folder).args(["guide", "schedule.campaign.json", "--json", "-"]);
    noise.iter().for_each(|own| {
        command.args(["--noise", own]);
    });
    command.args(more);
    command
}

/// A guide that is spoken with.
pub struct Spoken {
    pub child: Child,
    input: ChildStdin,
    answers: std::io::Lines<BufReader<ChildStdout>>,
}

impl Spoken {
    fn begin(folder: &Path, more: &[&str]) -> Self {
        let mut command = tumble(folder, &["--samples", "-", "--time", "t_s"]);
        command.args(more);
        Spoken::of(command)
    }

    pub fn of(mut command: Command) -> Self {
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let input = child.stdin.take().unwrap();
        let answers = BufReader::new(child.stdout.take().unwrap()).lines();
        Spoken { child, input, answers }
    }

    pub fn say(&mut self, text: &str) {
        self.input.write_all(text.as_bytes()).unwrap();
    }

    pub fn next(&mut self) -> serde_json::Value {
        serde_json::from_str(&self.answers.next().unwrap().unwrap()).unwrap()
    }

    /// The next line that says an advice, or a state of what is held.
    pub fn until(&mut self, state: Option<&str>) -> serde_json::Value {
        loop {
            let line = self.next();
            if line["held"]["state"].as_str() == state {
                return line;
            }
        }
    }
}

pub fn readings(folder: &Path) -> Vec<serde_json::Value> {
    let journal = std::fs::read_to_string(folder.join("guided.journal.jsonl")).unwrap();
    let entries = journal.lines().skip(1).map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    entries.filter_map(|own| Some(own.get("reading")?["keys"].clone())).collect()
}

/// A reading stands at its position, and its mean within 4 u of the truth; its u is that of white noise, or a little more.
pub fn is_sound(table: &Table, keys: &serde_json::Value, label: &str) {
    let told = keys["position"].as_str().unwrap();
    assert!(told == label || told.starts_with(&format!("{label} again")), "{keys}: not {label}");
    for (id, value) in ["X", "Y", "Z"].iter().zip(table.quiet(label)) {
        let (mean, u) = (keys[id].as_f64().unwrap(), keys[format!("{id}_u")].as_f64().unwrap());
        assert!((mean - value).abs() < 4.0 * u, "{keys}: {id} is {value}");
        // not more samples than there were
        assert!(u <= WANTED && u > SD / (LONG_S * HZ).sqrt(), "{keys}");
    }
}

#[test]
fn what_is_held_becomes_the_reading_that_was_asked_for() {
    let folder = folder();
    let mut table = Table::new(1);
    let mut guide = Spoken::begin(folder.path(), &[]);
    let mut asked = guide.next()["next"]["position"].as_str().unwrap().to_string();
    guide.say("t_s,X,Y,Z\n");
    let mut labels = Vec::new();
    for k in 0..4 {
        let text = table.hold(&asked, LONG_S);
        guide.say(&text);
        let held = guide.until(Some("held"));
        assert_eq!(held["held"]["position"].as_str(), Some(asked.as_str()), "{held}");
        let advice = guide.until(None);
        assert_eq!(advice["readings"], k + 1, "{advice}");
        labels.push(asked);
        asked = advice["next"]["position"].as_str().unwrap().to_string();
        assert_ne!(labels.last(), Some(&asked), "the same position at once");
        // what is left of the standstill is not read again
        assert_eq!(guide.until(Some("read"))["held"]["position"].as_str(), labels.last().map(String::as_str));
    }
    guide.say("undo\nquit\n");
    assert_eq!(guide.until(None)["readings"], 3);
    assert_eq!(guide.child.wait().unwrap().code(), Some(2));
    let found = readings(folder.path());
    assert_eq!(found.len(), 4);
    found.iter().zip(&labels).for_each(|(keys, label)| is_sound(&table, keys, label));
}

#[test]
fn a_position_that_is_left_early_is_not_read_and_take_reads_it_as_it_is() {
    let folder = folder();
    let mut table = Table::new(2);
    let mut guide = Spoken::begin(folder.path(), &[]);
    let asked = guide.next()["next"]["position"].as_str().unwrap().to_string();
    let text = table.hold(&asked, 2.5) + &table.hold("edge", 2.5);
    guide.say(&format!("t_s,X,Y,Z\n{text}"));
    let left = guide.until(Some("left"));
    let seconds = left["held"]["held_s"].as_f64().unwrap();
    // half a second at both ends is left out, and a window may begin an eighth of it later
    assert!((1.0..=1.6).contains(&seconds), "{left}");
    guide.until(Some("held"));
    guide.say("position edge\ntake\nquit\n");
    let advice = guide.until(None);
    assert_eq!((&advice["readings"], &advice["newest"]["position"]), (&1.into(), &"edge".into()), "{advice}");
    assert!(readings(folder.path())[0]["X_u"].as_f64().unwrap() > WANTED);
    guide.child.wait().unwrap();
}

/// The clock of the samples is set back, and forward: both are said where they happen, and the calibration goes on.
#[test]
fn a_clock_that_jumps_is_said() {
    let folder = folder();
    let mut table = Table::new(5);
    let mut guide = Spoken::begin(folder.path(), &[]);
    let asked = guide.next()["next"]["position"].as_str().unwrap().to_string();
    guide.say("t_s,X,Y,Z\n");
    let said = |guide: &mut Spoken, what: &str, step: &str| loop {
        let line = guide.next();
        if let Some(error) = line["error"].as_str() {
            assert!(error.contains(what) && line.to_string().contains(step), "{line}");
            break;
        }
    };
    guide.say(&table.hold(&asked, 3.0));
    table.rows -= 200;
    guide.say(&table.hold(&asked, 3.0));
    said(&mut guide, "the clock of the samples goes back", "-1.99");
    table.rows += 360_000;
    guide.say(&table.hold(&asked, LONG_S));
    said(&mut guide, "the clock of the samples jumps forward", "3600.0");
    let advice = guide.until(None);
    assert_eq!(advice["readings"], 1, "{advice}");
    guide.say("quit\n");
    guide.child.wait().unwrap();
    let found = readings(folder.path());
    assert_eq!(found.len(), 1);
    is_sound(&table, &found[0], &asked);
}

/// With bias and scale known, gravity tells positions apart; `up` and `over` it does not.
#[test]
fn a_position_is_recognised_or_asked_for() {
    let folder = folder();
    let mut table = Table::new(3);
    let mut guide = Spoken::begin(folder.path(), &[]);
    let mut asked = guide.next()["next"]["position"].as_str().unwrap().to_string();
    guide.say("t_s,X,Y,Z\n");
    let mut know = |guide: &mut Spoken, label: &str, said: &str| {
        let text = table.hold(label, LONG_S);
        guide.say(&format!("{said}{text}"));
        guide.until(None)["next"]["position"].as_str().unwrap().to_string()
    };
    for label in ["up", "down", "left", "right", "nose", "tail"] {
        asked = know(&mut guide, label, &format!("position {label}\n"));
    }
    // another one than was asked for
    let other = if asked == "left" { "right" } else { "left" };
    know(&mut guide, other, "");
    is_sound(&table, readings(folder.path()).last().unwrap(), other);
    let text = table.hold("over", LONG_S);
    guide.say(&text);
    let which = guide.until(Some("which"));
    let candidates: Vec<&str> =
        which["held"]["candidates"].as_array().unwrap().iter().map(|own| own.as_str().unwrap()).collect();
    assert_eq!(candidates, ["up: roll 0 deg, pitch 0 deg", "over: roll 180 deg, pitch 180 deg"]);
    guide.say("position over\n");
    let advice = guide.until(None);
    assert_eq!(advice["newest"]["position"], "over");
    assert_eq!(advice["newest"]["agreement"], "agrees");
    guide.say("quit\n");
    guide.child.wait().unwrap();
    is_sound(&table, readings(folder.path()).last().unwrap(), "over");
}

/// A file with labels, killed at any moment: nothing that was accepted is lost, and the campaign has the same bytes.
#[test]
fn a_record_with_labels_is_followed_and_gone_on_with() {
    let mut table = Table::new(4);
    let mut text = String::from("t_s,X,Y,Z,position\n");
    for label in ["up", "down", "left", "right", "nose", "tail"] {
        text += &table.run(label, LONG_S, Some(label));
    }
    text += &(table.run("up", 1.0, Some("")) + "quit\n");
    let ended = |own: &Path, more: &[&str]| {
        let mut arguments = vec!["--samples", "table.csv", "--time", "t_s"];
        arguments.extend(more);
        let mut command = tumble(own, &arguments);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    };
    let whole = folder();
    std::fs::write(whole.path().join("table.csv"), &text).unwrap();
    let output = ended(whole.path(), &[]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    let found = readings(whole.path());
    let labels: Vec<&str> = found.iter().map(|own| own["position"].as_str().unwrap()).collect();
    assert_eq!(labels, ["up", "down", "left", "right", "nose", "tail"]);
    found.iter().zip(&labels).for_each(|(keys, label)| is_sound(&table, keys, label));
    // the record grows in two parts, and the guide is killed behind the first
    let own = folder();
    let path = own.path().join("table.csv");
    let half = text.match_indices('\n').nth(8000).unwrap().0;
    std::fs::write(&path, &text[..half]).unwrap();
    let mut child = ended(own.path(), &[]).stderr(Stdio::null()).spawn().unwrap();
    let journal = own.path().join("guided.journal.jsonl");
    while std::fs::read_to_string(&journal).map_or(0, |text| text.matches("\"reading\"").count()) < 2 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let mut file = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
    file.write_all(&text.as_bytes()[half..]).unwrap();
    let output = ended(own.path(), &["--resume"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["guided.journal.jsonl", "guided.campaign.json"] {
        let [one, other] = [&whole, &own].map(|own| std::fs::read_to_string(own.path().join(name)).unwrap());
        assert_eq!(one, other, "{name}");
    }
}

/// Three accelerometers and three gyros.
const SIX: &str = r#"{ "bench": { "id": "six", "site": { "latitude_deg": 48 }, "units": { "rate": "deg/s", "force": "g" },
    "chain": [ { "joint": "roll", "about": "x" }, { "joint": "pitch", "about": "y" } ],
    "sensors": { "X": { "unit": "V", "axes": { "I": "x" }, "model": "bx + kx*a_I" }, "Y": { "unit": "V", "axes": { "I": "y" }, "model": "by + ky*a_I" },
                 "Z": { "unit": "V", "axes": { "I": "z" }, "model": "bz + kz*a_I" }, "P": { "unit": "V", "axes": { "I": "x" }, "model": "bp + 0.01*w_I" },
                 "Q": { "unit": "V", "axes": { "I": "y" }, "model": "bq + 0.01*w_I" }, "R": { "unit": "V", "axes": { "I": "z" }, "model": "br + 0.01*w_I" } } },
  "estimate": { "bx": {}, "by": {}, "bz": {}, "kx": { "start": 1 }, "ky": { "start": 1 }, "kz": { "start": 1 }, "bp": {}, "bq": {}, "br": {} },
  "readings": [ { "position": "up", "roll_deg": 0, "pitch_deg": 0 }, { "position": "down", "roll_deg": 180, "pitch_deg": 0 },
    { "position": "left", "roll_deg": 90, "pitch_deg": 0 }, { "position": "right", "roll_deg": 270, "pitch_deg": 0 },
    { "position": "nose", "roll_deg": 0, "pitch_deg": 90 }, { "position": "tail", "roll_deg": 0, "pitch_deg": 270 } ] }"#;

/// Six channels of 1 kHz, every position held for two hours (a minute by default), 24 hours with `TUMBLE_LONG=1` (four minutes by default): the program's
/// memory does not grow. (With readings it does, slowly: the diagnosis has them all.) Prints memory and processor time a sample.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_samples() {
    const RATE: usize = 1000;
    let (positions, minutes) = (crate::draws::draws(4, 12), crate::draws::draws(1, 120));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("schedule.campaign.json"), SIX).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tumble"));
    command.current_dir(folder.path()).args(["guide", "schedule.campaign.json", "--json", "-", "--samples", "-"]);
    command.args(["--rate", "1000"]);
    for id in ["X", "Y", "Z", "P", "Q", "R"] {
        command.args(["--noise", &format!("{id}={WANTED}")]);
    }
    // a goal that these positions reach, and not in this time
    command.args(["--goal", "bx=2e-7", "--cost", "mounting=0", "--most", "1000"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let asked = std::sync::Arc::new(std::sync::Mutex::new((String::new(), 0)));
    let told = asked.clone();
    let answers = BufReader::new(child.stdout.take().unwrap()).lines();
    let reader = std::thread::spawn(move || {
        for line in answers.map_while(Result::ok) {
            let line: serde_json::Value = serde_json::from_str(&line).unwrap();
            let position = line["next"]["position"].as_str().unwrap_or_default();
            *told.lock().unwrap() = (position.to_string(), line["readings"].as_u64().unwrap());
        }
    });
    let schedule = parse(SIX);
    let point = schedule.reference_point();
    let truth = Truth { point, noise: Vec::new(), effects: Vec::new(), scatter: Vec::new() };
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut block = |values: &[f64], sd: f64, rows: usize| {
        let mut text = String::new();
        for _ in 0..rows {
            let cells = values.iter().map(|value| {
                let normal: f64 = StandardNormal.sample(&mut random);
                format!("{:.7}", value + sd * normal)
            });
            text += &(cells.collect::<Vec<_>>().join(",") + "\n");
        }
        text
    };
    let status = |key: &str| -> f64 {
        let text = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let line = text.lines().find(|line| line.starts_with(key)).unwrap().to_string();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1024.0
    };
    input.write_all(b"X,Y,Z,P,Q,R\n").unwrap();
    let mut peaks = Vec::new();
    for _ in 0..positions {
        while asked.lock().unwrap().0.is_empty() {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        let label = asked.lock().unwrap().0.clone();
        let set = schedule.readings.rows.iter().find(|own| own.position == label).unwrap();
        let read = measure(&schedule, &truth, &[], set, 1);
        let values: Vec<f64> = read.observations.iter().map(|own| own.value).collect();
        input.write_all(block(&values, 0.02, 2 * RATE).as_bytes()).unwrap();
        // ten seconds of noise, again and again
        let held = block(&values, SD, 10 * RATE);
        for _ in 0..6 * minutes {
            input.write_all(held.as_bytes()).unwrap();
        }
        peaks.push(status("VmHWM"));
    }
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    let ticks: Vec<f64> = stat.split_whitespace().skip(13).take(2).map(|own| own.parse().unwrap()).collect();
    drop(input);
    child.wait().unwrap();
    reader.join().unwrap();
    let samples = (positions * RATE * (60 * minutes + 2)) as f64;
    let first = peaks[0];
    println!(
        "{samples:.3e} samples of six channels, {} readings: peak memory {first:.1} MB after the first position, {:.1} MB at the end; {:.2} us of processor time a sample",
        asked.lock().unwrap().1,
        peaks[peaks.len() - 1],
        1e4 * (ticks[0] + ticks[1]) / samples
    );
    assert!(asked.lock().unwrap().1 as usize >= positions - 1);
    // readings take memory; samples that were kept would take a hundred times what is allowed for them here
    let bytes = 6.0 * 8.0 * samples;
    assert!(peaks[peaks.len() - 1] < 1.1 * first + 8.0 + 0.01 * bytes / 1e6);
}
