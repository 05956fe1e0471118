//! Readings, samples and commands, one a line: from standard input, or from a file that grows.

#[cfg(feature = "serial")]
use super::port::{Came, Port};
use super::table::State;
use crate::bench::Bench;
use crate::campaign::{Campaign, JointState, Label, Reading, Shared};
use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use crate::guide::{Agreement, Guide};
use crate::record::Record;
use crate::wire::{self, Cell, Named, ReadingFile};
use std::fs::File;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// How often a file is looked at: what was written in it is at most so old when it is read (with what is taken in once in 25 ms, less than the 50 ms that
/// a person notices). A look costs some microseconds.
const PAUSE: Duration = Duration::from_millis(10);

pub(super) enum Line {
    /// A reading, or of samples where the bench stands.
    Keys(ReadingFile),
    /// Take back a reading, the last one unless its number is given.
    Undo(Option<usize>),
    Quit,
    /// A row of samples.
    Row,
    /// Read what is held as it is.
    Take,
    Nothing,
}

pub(super) struct Lines {
    from: From,
    pub name: String,
    /// The titles, once they are known.
    pub titles: Option<String>,
    /// Lines that were given out.
    count: usize,
    /// Lines that a journal has already.
    skip: usize,
    /// Commands from standard input beside a file or a port.
    commands: Option<Receiver<String>>,
    /// What was read of a file or a port, and from where on it was not given out.
    unread: Vec<u8>,
    at: usize,
}

enum From {
    Input,
    File(Followed),
    /// A serial port; is the next line the first since it was opened?
    #[cfg(feature = "serial")]
    Port(Port, bool),
}

struct Followed {
    file: File,
    path: PathBuf,
    /// A serial port is a file, too, and has no lines that could be read again.
    regular: bool,
    read: u64,
}

pub(super) enum Next {
    Line(Numbered),
    /// Nothing more comes until a port is there again.
    #[cfg(feature = "serial")]
    Away(Malformed),
    /// It is.
    #[cfg(feature = "serial")]
    Back,
    End,
}

pub(super) struct Numbered {
    pub number: usize,
    pub text: String,
    /// Does a journal have it already?
    pub passed: bool,
}

impl Lines {
    fn new(from: From, name: String) -> Self {
        Lines { from, name, titles: None, count: 0, skip: 0, commands: None, unread: Vec::new(), at: 0 }
    }

    pub fn open(path: &Path) -> Result<Self> {
        if path == Path::new("-") {
            return Ok(Lines::new(From::Input, "standard input".into()));
        }
        let name = path.display().to_string();
        let cannot = |error| Malformed::new(Fault::File, format!("cannot read '{name}': {error}"));
        let file = File::open(path).map_err(cannot)?;
        let regular = file.metadata().is_ok_and(|metadata| metadata.is_file());
        Ok(Lines::new(From::File(Followed { file, path: path.to_path_buf(), regular, read: 0 }), name))
    }

    /// A serial port, `/dev/ttyUSB0:115200`.
    #[cfg(feature = "serial")]
    pub fn port(asked: &str) -> Result<Self> {
        let port = Port::open(asked)?;
        let name = port.name();
        Ok(Lines::new(From::Port(port, true), name))
    }

    /// Is it a file whose lines are there again after a kill?
    pub fn is_file(&self) -> bool {
        matches!(self.from, From::File(Followed { regular: true, .. }))
    }

    /// The journal has the lines up to this one.
    pub fn skip_to(&mut self, line: usize) {
        self.skip = self.skip.max(line);
    }

    /// Beside a file or a port, commands come from standard input.
    pub fn with_commands(mut self) -> Self {
        if !matches!(self.from, From::Input) {
            let (sender, receiver) = channel();
            std::thread::spawn(move || {
                let lines = std::io::stdin().lines().map_while(std::io::Result::ok);
                lines.map(|line| sender.send(line)).all(|sent| sent.is_ok())
            });
            self.commands = Some(receiver);
        }
        self
    }

    /// The next line. A file that grows is waited for, and so is a port that was unplugged.
    ///
    /// Errors: a file that cannot be read any more, is no longer there, or has become shorter.
    pub fn next(&mut self) -> Result<Next> {
        if matches!(self.from, From::Input) {
            let line = input().map_err(|error| broken(&self.name, error))?;
            return Ok(line.map_or(Next::End, |line| self.numbered(line, true)));
        }
        loop {
            if let Some(Ok(command)) = self.commands.as_ref().map(Receiver::try_recv) {
                return Ok(self.numbered(command, false));
            }
            if let Some(line) = whole(&mut self.unread, &mut self.at) {
                // the end of a row, of which the beginning came before the port was opened
                #[cfg(feature = "serial")]
                if let From::Port(_, fresh) = &mut self.from
                    && std::mem::take(fresh)
                    && line.starts_with(|c: char| c.is_ascii_digit() || "+-.,;\t ".contains(c))
                {
                    continue;
                }
                return Ok(self.numbered(line, true));
            }
            let mut block = vec![0; 1 << 16];
            let came = match &mut self.from {
                From::Input => return Ok(Next::End),
                From::File(opened) => opened.read(&mut block).map_err(|error| broken(&self.name, error))?,
                #[cfg(feature = "serial")]
                From::Port(port, fresh) => match port.read(&mut block) {
                    Came::Nothing => 0,
                    Came::Bytes(count) => count,
                    Came::Gone(why) => {
                        (self.at, *fresh) = (0, true);
                        self.unread.clear();
                        let said = format!("nothing more comes from the serial port '{}': {why}", self.name);
                        let waits = "the cable plugged in again: the guide waits for it, and goes on; or 'quit'";
                        return Ok(Next::Away(Malformed::new(Fault::File, said).expected(waits)));
                    }
                    Came::Back => return Ok(Next::Back),
                },
            };
            self.unread.extend_from_slice(block.part(..came));
        }
    }

    /// `counts`: it is one of the source's own.
    fn numbered(&mut self, text: String, counts: bool) -> Next {
        self.count += usize::from(counts);
        Next::Line(Numbered { number: self.count, text, passed: counts && self.count <= self.skip })
    }

    /// What a line says, among samples or among readings.
    ///
    /// Errors: it is neither a command, nor keys in JSON, nor a row below a line of titles.
    pub fn parse(&mut self, text: &str, samples: bool, bench: &Bench) -> Result<Line> {
        // the usual row
        if samples && self.titles.is_some() && text.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
            return Ok(Line::Row);
        }
        let text = text.trim().trim_start_matches('\u{feff}');
        // a board that was switched on anew says its titles again
        if samples && self.titles.as_deref() == Some(text) {
            return Ok(Line::Nothing);
        }
        if let Some(command) = command(text)? {
            return Ok(command);
        }
        match text.split_once(char::is_whitespace) {
            None if samples && text == "take" => return Ok(Line::Take),
            Some(("position", label)) if samples && self.titles.is_some() => {
                let label = Cell::Text(label.trim().to_string());
                return Ok(Line::Keys(Named(vec![("position".into(), label)])));
            }
            _ if text.starts_with('{') => return cells(text).map(Line::Keys),
            _ => {}
        }
        if !self.is_titled(text, Some(bench).filter(|_| !samples))? {
            return Ok(Line::Nothing);
        }
        if samples {
            return Ok(Line::Row);
        }
        let titles = self.titles.as_deref().unwrap_or_default();
        let rows = wire::table_cells(bench, Record::of_text(&self.name, format!("{titles}\n{text}\n"))?)?;
        Ok(rows.into_iter().next().map_or(Line::Nothing, Line::Keys))
    }

    /// Are there titles above this line? If not, it is they. Those of readings on a bench name a sensor: without one it is a word that was mistyped, under
    /// which no row could be read.
    fn is_titled(&mut self, text: &str, readings: Option<&Bench>) -> Result<bool> {
        if self.titles.is_some() {
            return Ok(true);
        }
        // what is no table at all is refused with the rows below it
        if let Ok(record) = Record::of_text(&self.name, format!("{text}\n")) {
            if !record.is_named() {
                return Err(Malformed::new(Fault::Missing, "there is no line of titles before the first row")
                    .expected("titles as in a campaign's readings, for example position,alpha_deg,V")
                    .found(format!("'{text}'")));
            }
            let keys = readings.map(|bench| wire::table_keys(bench, &record)).transpose()?.unwrap_or_default();
            let sensors = readings.into_iter().flat_map(|bench| &bench.sensors).map(|sensor| sensor.id.as_str());
            let sensors: Vec<&str> = sensors.collect();
            if readings.is_some() && !keys.iter().any(|(key, _)| sensors.contains(&key.as_str())) {
                let sensors = sensors.join(" or ");
                return Err(Malformed::new(
                    Fault::Syntax,
                    "the line is not a reading, a command or titles of a table",
                )
                .expected(format!(
                    "a JSON object with a number for {sensors}; undo, undo and a number, or quit; or titles with {sensors}"
                ))
                .found(format!("'{text}'")));
            }
        }
        self.titles = Some(text.to_string());
        Ok(false)
    }
}

impl Followed {
    /// What was written in addition, or nothing after a pause.
    fn read(&mut self, block: &mut [u8]) -> std::io::Result<usize> {
        let gone = std::io::Error::other;
        if self.regular && self.file.metadata()?.len() < self.read {
            return Err(gone("it has become shorter"));
        }
        let more = self.file.read(block)?;
        if more == 0 && !is_there(&self.file, &self.path) {
            return Err(gone("the file was removed, or replaced by another"));
        }
        if more == 0 {
            std::thread::sleep(PAUSE);
        }
        self.read += more as u64;
        Ok(more)
    }
}

/// A line of standard input, or of whom an embedded command speaks with; `None` at the end.
fn input() -> std::io::Result<Option<String>> {
    if let Some(line) = crate::cli::session::spoken() {
        return Ok(line);
    }
    let mut bytes = Vec::new();
    let read = std::io::stdin().lock().read_until(b'\n', &mut bytes)?;
    Ok((read > 0).then(|| String::from_utf8_lossy(&bytes).trim_end().to_string()))
}

fn broken(name: &str, error: std::io::Error) -> Malformed {
    Malformed::new(Fault::File, format!("no more readings come from '{name}': {error}"))
        .expected("a source that stays; --resume goes on with what was accepted")
}

/// A command that every source has, or an empty line.
fn command(text: &str) -> Result<Option<Line>> {
    let mut words = text.split_whitespace();
    Ok(Some(match (words.next(), words.next(), words.next()) {
        (None, ..) => Line::Nothing,
        (Some("quit"), None, _) => Line::Quit,
        (Some("undo"), None, _) => Line::Undo(None),
        (Some("undo"), Some(number), None) => Line::Undo(Some(number.parse().map_err(|_| {
            Malformed::new(Fault::Syntax, "'undo' is not understood")
                .expected("undo, or undo and the number of a reading")
                .found(format!("'{number}'"))
        })?)),
        _ => return Ok(None),
    }))
}

/// The next whole line of what came; where there is none, what was given out is dropped.
fn whole(unread: &mut Vec<u8>, at: &mut usize) -> Option<String> {
    let waiting = unread.part(*at..);
    let Some(end) = waiting.iter().position(|byte| *byte == b'\n') else {
        unread.drain(..std::mem::take(at));
        return None;
    };
    let line = String::from_utf8_lossy(waiting.part(..end)).trim_end().to_string();
    *at += end + 1;
    Some(line)
}

fn cells(text: &str) -> Result<ReadingFile> {
    serde_json::from_str(text).map_err(|error| {
        let said = error.to_string();
        // the line of the source is said already; this text has one only
        let place = format!(" at line {} column {}", error.line(), error.column());
        let said = said.strip_suffix(&place).unwrap_or(&said);
        Malformed::new(Fault::Syntax, format!("the line is not a reading: {said} at column {}", error.column()))
            .expected("a JSON object as in a campaign's readings, for example {\"V\": 0.0123}")
    })
}

/// Is this still the file at the path?
fn is_there(file: &File, path: &Path) -> bool {
    match (file.metadata(), std::fs::metadata(path)) {
        #[cfg(unix)]
        (Ok(here), Ok(there)) => {
            use std::os::unix::fs::MetadataExt;
            (here.dev(), here.ino()) == (there.dev(), there.ino())
        }
        (here, there) => here.is_ok() && there.is_ok(),
    }
}

/// The label that keys of a reading say.
fn label(cells: &ReadingFile) -> Option<String> {
    cells.0.iter().find_map(|(key, cell)| match cell {
        Cell::Text(text) if key == "position" => Some(text.clone()),
        Cell::Number(number) if key == "position" => Some(number.to_string()),
        _ => None,
    })
}

/// Is a position the one of this label, if there is one?
fn is_labelled(label: Option<&str>) -> impl Fn(&&Reading) -> bool {
    move |reading| label.is_none_or(|label| reading.position == label)
}

/// The position that keys of a reading are taken for: of their label, or as asked for.
pub(super) fn base<'a>(keys: &ReadingFile, guide: &'a Guide, asked: Option<&'a Reading>) -> Option<&'a Reading> {
    let label = label(keys);
    let is_labelled = is_labelled(label.as_deref());
    asked.filter(&is_labelled).or_else(|| guide.candidates().iter().find(&is_labelled))
}

/// A reading of a line. Joints that it does not name stand as in the candidate of its label, or as asked for.
///
/// Errors: those of a campaign's readings; a key that the campaign does not have; a joint of which nothing tells the state, or of which positions of
/// one label have several.
pub(super) fn reading(
    cells: ReadingFile,
    campaign: &Campaign,
    guide: &Guide,
    asked: Option<&Reading>,
) -> Result<Reading> {
    let label = label(&cells);
    let is_labelled = is_labelled(label.as_deref());
    let labelled: Vec<&Reading> = match asked.filter(&is_labelled) {
        Some(asked) => vec![asked],
        None if label.is_some() => guide.candidates().iter().filter(&is_labelled).collect(),
        None => Vec::new(),
    };
    let labels = || guide.candidates().iter().map(|c| c.position.as_str()).filter(|c| !c.is_empty());
    if let (Some(label), true) = (&label, labelled.is_empty() && labels().next().is_some())
        && !cells.0.iter().any(|(key, _)| campaign.bench.is_of_joint(key))
    {
        let mut known: Vec<&str> = labels().collect();
        known.dedup();
        return Err(Malformed::new(Fault::UnknownName, "the schedule has no position of this label")
            .expected(format!("one of {}; or how each joint stands", known.join(", ")))
            .found(format!("'{label}'")));
    }
    let base = labelled.first().copied().or(asked);
    let mut full = cells;
    for (key, cell) in &mut full.0 {
        if let (true, Cell::Number(number)) = (key == "position", &*cell) {
            *cell = Cell::Text(number.to_string());
        }
    }
    for (k, joint) in campaign.bench.joints().enumerate() {
        let given = |suffix: &str| full.0.iter().any(|(key, _)| key.strip_prefix(joint) == Some(suffix));
        if ["_deg", "_deg_s", "_turns"].into_iter().any(given) {
            continue;
        }
        let state = |r: &Reading| r.joints.get(k).copied();
        if let Some(other) = labelled.iter().find(|r| base.is_some_and(|base| state(base) != state(r))) {
            let settings: Vec<String> =
                base.into_iter().chain([*other]).map(|r| crate::guide::setting(campaign, &r.joints)).collect();
            return Err(Malformed::new(Fault::Missing, format!("the line does not say how {joint} stands"))
                .expected(format!("{joint}_deg or {joint}_deg_s: the label has several settings"))
                .found(settings.join("; ")));
        }
        let given = base.and_then(|r| r.joints.get(k)).into_iter().flat_map(JointState::given);
        full.0.extend(given.map(|(suffix, value)| (format!("{joint}{suffix}"), Cell::Number(value))));
    }
    let read = wire::read_rows(&campaign.bench, vec![full])?;
    let columns = &campaign.readings.columns;
    if let Some(strange) = read.columns.iter().find(|name| !columns.contains(name)) {
        let sensors: Vec<&str> = campaign.bench.sensors.iter().map(|sensor| sensor.id.as_str()).collect();
        return Err(Malformed::new(Fault::UnknownKey, format!("the campaign's readings have no '{strange}'"))
            .expected(format!("the joints, {}, position, n, or one of: {}", sensors.join(", "), columns.join(", ")))
            .found(format!("'{strange}'")));
    }
    let Some(row) = read.rows.into_iter().next() else {
        return Err(Malformed::new(Fault::Missing, "the line has no reading"));
    };
    let names: Vec<&str> = campaign.bench.joints().collect();
    let like = base.or(guide.candidates().first());
    let follows =
        like.map_or(Shared::default(), |like| campaign.readings.position(&names, like, row.joints.clone()).columns);
    let value = |(k, name): (usize, &String)| {
        let stated =
            read.columns.iter().position(|column| column == name).and_then(|at| row.columns.get(at).copied().flatten());
        stated.or(follows.get(k).copied().flatten())
    };
    let values = columns.iter().enumerate().map(value).collect();
    // a setting of the schedule has its label there
    let same = |candidate: &&Reading| candidate.joints == row.joints;
    let position = match (&label, base.filter(|base| base.joints == row.joints)) {
        (Some(label), _) => label.as_str().into(),
        (None, Some(base)) => base.position.clone(),
        (None, None) => guide.candidates().iter().find(same).map_or(Label::default(), |c| c.position.clone()),
    };
    Ok(Reading { position, columns: values, ..row })
}

/// Where a reading of samples belongs.
pub(super) enum Placed {
    Here(Reading),
    /// Several settings agree.
    Which(Vec<String>),
}

/// The position of a reading: what its keys say, else the one that was asked for, unless its values do not agree with that one and another does.
///
/// Errors: those of a reading.
pub(super) fn placed(cells: &ReadingFile, state: State) -> Result<Placed> {
    let State { campaign, guide, asked, .. } = state;
    let joints = campaign.bench.joints();
    let says =
        |joint: &str| cells.0.iter().any(|(key, _)| key.strip_prefix(joint).is_some_and(|s| s.starts_with("_deg")));
    let by_joints = joints.filter(|joint| says(joint)).count() > 0;
    let named = label(cells);
    let is_named = is_labelled(named.as_deref());
    let settings: Vec<&Reading> = guide.candidates().iter().filter(&is_named).collect();
    let is_stated = by_joints || named.is_some() && settings.len() < 2;
    if is_stated || asked.is_none() && named.is_none() {
        return reading(cells.clone(), campaign, guide, asked).map(Placed::Here);
    }
    let at = |base: &Reading| reading(cells.clone(), campaign, guide, Some(base));
    if let Some(reading) = asked.filter(&is_named) {
        let reading = at(reading)?;
        if guide.would_agree(&reading)? != Agreement::Disagrees {
            return Ok(Placed::Here(reading));
        }
    }
    let mut possible: Vec<(Reading, Agreement)> = Vec::new();
    for reading in settings {
        // a setting at which the model lacks a column cannot be compared
        if let Ok(reading) = at(reading)
            && let Ok(found) = guide.would_agree(&reading)
            && found != Agreement::Disagrees
        {
            possible.push((reading, found));
        }
    }
    let agrees = possible.iter().any(|(_, found)| *found == Agreement::Agrees);
    match (possible.as_slice(), asked.filter(&is_named)) {
        ([(reading, _)], _) if agrees => Ok(Placed::Here(reading.clone())),
        (several, _) if agrees => {
            let one = |(reading, _): &(Reading, Agreement)| {
                format!("{}: {}", reading.position, crate::guide::setting(campaign, &reading.joints))
            };
            Ok(Placed::Which(several.iter().map(one).collect()))
        }
        (_, Some(asked)) => at(asked).map(Placed::Here),
        _ => reading(cells.clone(), campaign, guide, asked).map(Placed::Here),
    }
}
