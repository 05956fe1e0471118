//! `tumble new TABLE`: bench and campaign for a table of readings or a logger's record; `tumble new lab`: a lab file for certificates.
//!
//! ```text
//! titles and units of the table -> bench -> what each column is -> what is known -> campaign, checked -> files, written at once
//! ```
//!
//! Every answer is an option; what is not given is asked for at a terminal, and elsewhere is an error that names the option. Nothing is replaced.

mod answers;
mod benches;
mod columns;
mod lab;

use super::{Outcome, devices::DeviceCampaign, files, outputs::Outputs, session, show_error};
use crate::campaign::{Asked, Given, UnitUnderTest};
use crate::error::{Fault, Malformed, Result};
use crate::fit;
use crate::record::{self, Record, parted};
use crate::wire::{self, BenchRef, CampaignFile, KnownEntry, ReadingsRef, SamplesAs, Source};
use answers::{Answers, Quantity, pair};
use clap::{Args, Subcommand};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Options of `new`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct Arguments {
    #[command(subcommand)]
    other: Option<Other>,
    /// The table of readings, or the logger's record (CSV, Parquet, workbook, MATLAB, HDF5, MCAP; FILE#NAME: one table of several).
    #[arg(required = true)]
    table: Option<PathBuf>,
    /// A built-in bench, a bench file, or `own`: a bench made of `--chain` and `--model`.
    #[arg(long, value_name = "ID|FILE|own")]
    bench: Option<String>,
    /// For `--bench own`: joints and tilts (with `~`) from the ground to the sensor, each with its axis, for example `beta:x,~dtheta_y:y`; `none`.
    #[arg(long, value_name = "LINKS")]
    chain: Option<String>,
    /// For `--bench own`: a sensor with its model line, for example `V [mV] = V0 + kI*a_x`.
    #[arg(long, value_name = "LINE")]
    model: Vec<String>,
    /// Latitude of the bench in degrees, if the readings depend on the Earth rate.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    latitude: Option<String>,
    /// Meaning of columns that do not follow from their titles and units: `gamma_deg_s=Rate,V=Output (mV)`.
    #[arg(long, value_name = "KEY=TITLE", value_delimiter = ',')]
    columns: Vec<String>,
    /// The table is a logger's record: means of its standstills (still), every sample a reading (rows), or means by the labels in this column.
    #[arg(long, value_name = "still|rows|COLUMN")]
    samples: Option<String>,
    /// The table has readings of many devices: the column that identifies the device.
    #[arg(long, value_name = "COLUMN")]
    by: Option<String>,
    /// The column of times of a record; time_s, time, t or timestamp unless given.
    #[arg(long, value_name = "COLUMN", requires = "samples")]
    time: Option<String>,
    /// Sampling rate in Hz of a record without a column of times.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// A position of the record, in the order taken, or one for all: `pitch_deg=0,roll_deg=180`.
    #[arg(long, value_name = "KEY=VALUE,...")]
    position: Vec<String>,
    /// A known parameter: `kI=-2.92+-0.004 V/(deg/s)`; `NAME=0` alone leaves it out of the model. All others are estimated.
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    known: Vec<String>,
    /// Starting value of a parameter in which the model is not linear: `s_x=0.0024 m/s^2`.
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    start: Vec<String>,
    /// Serial number of the unit; a certificate needs it.
    #[arg(long)]
    serial: Option<String>,
    /// Day of the measurement; a certificate needs it.
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: Option<String>,
    /// The campaign file; by default TABLE.campaign.json in the folder of the table.
    #[arg(long, value_name = "FILE")]
    to: Option<PathBuf>,
}

/// What else can be new.
#[derive(Debug, Subcommand)]
enum Other {
    /// The identities of a calibration certificate (`tumble fit --dcc --lab`).
    Lab(lab::Arguments),
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let answers = Answers::here();
    match (&arguments.other, &arguments.table) {
        (Some(Other::Lab(lab)), _) => lab::run(lab, &answers),
        (None, Some(table)) => campaign(arguments, table, &answers),
        (None, None) => Ok(Outcome::Done), // clap asks for one of them
    }
}

fn campaign(arguments: &Arguments, table: &Path, answers: &Answers) -> Result<Outcome> {
    let (file, _) = parted(table);
    let stem = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("new").to_string()
    };
    let to = arguments.to.clone();
    let to = to.unwrap_or_else(|| table.with_file_name(format!("{}.campaign.json", stem(&file))));
    // a bench that is made goes by the campaign's name
    let stem = stem(&to);
    let folder = to.parent().map(Path::to_path_buf).unwrap_or_default();
    free(&to)?;
    let record = Record::at(table)?;
    session::reads(&file);
    let titles: Vec<record::Column> = record.columns().to_vec();
    drop(record);
    super::show(&format!("{}: {}\n", table.display(), record::listed(&titles)))?;
    let samples = answers.one(
        arguments.samples.as_deref(),
        ("--samples", "a logger's record? still, rows or a column of labels; empty: each row is a reading"),
        Some(""),
        |text| match text {
            "" | "still" | "rows" => Ok(text.to_string()),
            label => columns::column(&titles, label).map(|_| label.to_string()),
        },
    )?;
    let device = |text: &str| match text {
        "" => Ok(None),
        title => columns::column(&titles, title).map(|_| Some(title.to_string())),
    };
    let question = "readings of many devices? the column that identifies the device; empty: of one";
    let device = match (samples.as_str(), &arguments.by) {
        ("", given) => answers.one(given.as_deref(), ("--by", question), Some(""), device)?,
        (_, None) => None,
        (_, Some(_)) => {
            return Err(Malformed::new(Fault::Value, "--by separates devices, and a record is of one device")
                .expected("--by COLUMN without --samples"));
        }
    };

    let (mut bench, mut chosen) = benches::chosen(arguments, answers, &titles, &stem, &folder)?;
    let whole = samples.is_empty();
    let taken = device.as_deref().unwrap_or(&samples);
    let time = arguments.time.iter().map(|title| format!("time_s={title}"));
    let said: Vec<String> = columns::whole_titles(&arguments.columns).into_iter().chain(time).collect();
    let mut map = columns::mapped(&bench, (table, &titles), &said, answers, (taken, whole))?;
    let used = titles.iter().zip(&map.used).filter(|(_, used)| **used).map(|(column, _)| column);
    let keyed: Vec<(&str, &record::Column)> = map.keys.iter().map(String::as_str).zip(used).collect();
    if let Some(changed) = benches::in_units_of(&bench, &chosen, &keyed, &stem, &folder)? {
        (bench, chosen) = changed;
    }
    let unused: Vec<&str> = (titles.iter().zip(&map.used))
        .filter(|(column, used)| !**used && column.title != taken && column.name != taken)
        .map(|(column, _)| column.title.as_str())
        .collect();
    if !unused.is_empty() {
        super::show(&format!(
            "not read by this bench: {} (--columns KEY=TITLE says what a column is)\n",
            unused.join(", ")
        ))?;
    }
    let unsaid = columns::unsaid_units(&bench, &keyed);
    if !unsaid.is_empty() {
        super::show(&format!("no unit in the title: {} (\"Title (UNIT)\" says another one)\n", unsaid.join(", ")))?;
    }
    // a record has its clock by itself
    let clock = map.renamed.iter().position(|(key, _)| key == "time_s").filter(|_| !whole);
    let clock = clock.map(|k| map.renamed.remove(k).1);
    let mut campaign: CampaignFile = serde_json::from_value(json!({ "bench": "", "readings": [] }))
        .map_err(|error| Malformed::new(Fault::Value, error.to_string()))?;
    campaign.bench = chosen.reference;
    campaign.site = benches::site(arguments, answers, &bench, chosen.is_theirs)?;
    campaign.columns = wire::Named(map.renamed);
    campaign.by = device;
    let name = in_folder(&folder, table);
    campaign.readings = match samples.as_str() {
        "" => ReadingsRef::Path(name),
        how => {
            let complete = |rows: &[_]| columns::complete(&bench, &map.keys, rows, table, &titles);
            let positions = columns::positions(&bench, &arguments.position, answers, complete)?;
            ReadingsRef::Samples(Box::new(wire::SamplesFile {
                samples: name,
                taken_as: (how == "rows").then_some(SamplesAs::Rows),
                by: (how != "rows" && how != "still").then(|| how.to_string()),
                time: clock,
                rate_hz: arguments.rate,
                positions,
                ..wire::SamplesFile::default()
            }))
        }
    };
    // what the bench has and the columns leave as parameters: nothing is asked for yet
    let read = |campaign: &CampaignFile| -> Result<(crate::campaign::Campaign, Option<fit::Fit>)> {
        let mut file = campaign.clone();
        if let Some(bench) = &chosen.new {
            file.bench = BenchRef::Inline(Box::new(bench.clone()));
        }
        let source = Source { name: to.display().to_string(), text: files::json(&file)? };
        let mut folder = files::Beside::new(&to);
        if file.has_rows() {
            return Ok((wire::read_rows_of(&file, &source, &mut folder, None)?.0, None));
        }
        let campaign = match file.by {
            Some(_) => DeviceCampaign::of(&to, source)?.survey()?.first,
            None => wire::campaign_from(file, &source, &mut folder)?,
        };
        if campaign.readings.rows.is_empty() {
            return Err(Malformed::new(Fault::Missing, format!("'{}' has no readings", table.display()))
                .expected("rows with values below the titles"));
        }
        let is_asked = campaign.unknowns() > 0 && campaign.is_measured();
        let fitted = is_asked.then(|| fit::fit(&campaign, &fit::Settings::default())).transpose()?;
        Ok((campaign, fitted))
    };
    // what the bench states itself (its gravity, a rate) is no question
    let open = |parameter: &crate::campaign::Parameter| !matches!(parameter.role, crate::campaign::Role::Known(_));
    let all = loop {
        match read(&campaign) {
            // what is wrong in the table may be mended while the program waits
            Err(error) if answers.asks => {
                show_error::show(&error);
                answers.one(None, ("", "the table is not read; correct it, then press Enter"), Some(""), |_| Ok(()))?;
            }
            done => break done?.0.parameters.into_iter().filter(open),
        }
    };
    let parameters: Vec<(String, String)> = all.map(|parameter| (parameter.id, parameter.unit)).collect();
    let known = |given: &[String], ask: &str| -> Result<Vec<Quantity>> {
        answers.several(given, ask, |text| Quantity::of(text, &parameters))
    };
    let listed: Vec<String> = parameters.iter().map(|(id, unit)| format!("{id} [{unit}]")).collect();
    let ask = format!("known values among {} (NAME=VALUE[+-U] [UNIT]; NAME=0: not in the model)", listed.join(", "));
    let mut given = known(&arguments.known, &ask)?;
    let start = |text: &str| Quantity::of(text, &parameters);
    let mut starts = arguments.start.iter().map(|text| start(text)).collect::<Result<Vec<_>>>()?;
    let doubts = loop {
        let estimated = parameters.iter().filter(|(id, _)| given.iter().all(|g| g.name != *id));
        campaign.estimate = wire::Named(
            estimated
                .map(|(id, _)| {
                    let start = starts.iter().rfind(|s| s.name == *id);
                    let unit = start.and_then(|s| s.unit.clone());
                    (id.clone(), Asked { start: start.map(|s| s.value), unit, ..Asked::default() })
                })
                .collect(),
        );
        let stated = given.iter().filter(|g| !g.is_zero());
        let named = stated.map(|g| {
            let known = Given { value: g.value, unit: g.unit.clone(), u: g.u, ..Given::default() };
            (g.name.clone(), KnownEntry::Known(known))
        });
        campaign.known = wire::Named(named.collect());
        let fitted = match read(&campaign) {
            Ok((_, fitted)) => fitted,
            // a person at a terminal has not answered for nothing
            Err(error) if answers.asks => {
                show_error::show(&error);
                let ask = "starting values of estimates in which the model is not linear (NAME=VALUE [UNIT])";
                let more = answers.several(&[], ask, start)?;
                if more.is_empty() {
                    return Err(error);
                }
                starts.extend(more);
                continue;
            }
            Err(error) => return Err(error),
        };
        let doubts = fitted.map_or(Vec::new(), |fit| fit.not_estimable);
        let names: Vec<&str> = doubts.iter().flat_map(|d| &d.direction.terms).map(|(id, _)| id.as_str()).collect();
        if names.is_empty() || !answers.asks {
            break doubts;
        }
        let ask = format!("these readings do not separate {}: which is known, or zero?", names.join(", "));
        let more = known(&[], &ask)?;
        if more.is_empty() {
            break doubts;
        }
        given.extend(more);
    };
    let answer = |given: &Option<String>, option: &str, question: &str, fits: fn(&str) -> bool| {
        let question = format!("{question}, which a certificate needs; empty: none");
        answers.one(given.as_deref(), (option, &question), Some(""), |text| match text.is_empty() || fits(text) {
            true => Ok(Some(text.to_string()).filter(|text| !text.is_empty())),
            false => {
                Err(Malformed::new(Fault::Value, "this is not a day").expected("YYYY-MM-DD").found(format!("'{text}'")))
            }
        })
    };
    let serial = answer(&arguments.serial, "--serial", "serial number of the unit", |_| true)?;
    campaign.unit = serial.map(|serial| UnitUnderTest { serial: Some(serial), ..UnitUnderTest::default() });
    campaign.date = answer(&arguments.date, "--date", "day of the measurement, YYYY-MM-DD", |text| {
        crate::compare::calibrations::day_number(text).is_some()
    })?;
    let mut texts = vec![(to.clone(), headed("campaign", REMARK, &campaign)?)];
    if let Some(bench) = &chosen.new {
        texts.push((chosen.path.clone(), headed("bench", "see the notes", bench)?));
    }
    let kinds = if chosen.new.is_some() { &["campaign", "bench"][..] } else { &["campaign"] };
    let names = write(texts, &to, kinds)?;
    super::show(&format!("wrote {names}\n{}: {}\n", to.display(), super::check::check(&to)?))?;
    let terms = doubts.iter().map(|doubt| &doubt.direction.terms);
    let (alone, combined): (Vec<_>, Vec<_>) = terms.partition(|terms| terms.len() == 1);
    let named = |terms: &[&Vec<(String, f64)>]| {
        let names: Vec<&str> = terms.iter().flat_map(|terms| terms.iter()).map(|(id, _)| id.as_str()).collect();
        names.join(", ")
    };
    let mut why: Vec<String> = Vec::new();
    if !alone.is_empty() {
        why.push(format!("no reading depends on {}. State what is known of them", named(&alone)));
    }
    why.extend(combined.iter().map(|terms| {
        let names = named(&[*terms]);
        format!(
            "these readings determine a combination of {names} only, not each of them. State the value of one of them"
        )
    }));
    for why in why {
        super::show(&format!(
            "NOT DETERMINED: {why} (move it from \"estimate\" to \"known\"), or delete it from \"estimate\": it then counts as zero\n"
        ))?;
    }
    // of each combination the last in the bench's order, where it would begin
    let (mut fewer, mut open, mut options) = (campaign, doubts.clone(), Vec::new());
    while let Some(doubt) = open.first() {
        let combined = |id: &str| doubt.direction.terms.iter().any(|(own, _)| own == id);
        let Some(last) = fewer.estimate.0.iter().rposition(|(id, _)| combined(id)) else { break };
        let (id, Asked { start, unit, .. }) = fewer.estimate.0.remove(last);
        let value = start.unwrap_or(0.0);
        let quantity = match &unit {
            Some(unit) => shell_word(Path::new(&format!("{id}={value} {unit}"))),
            None => format!("{id}={value}"),
        };
        options.push(format!("--known {quantity}"));
        if value != 0.0 {
            fewer.known.0.push((id, KnownEntry::Known(Given { value, unit, ..Given::default() })));
        }
        let Ok((_, fitted)) = read(&fewer) else { break };
        open = fitted.map_or(Vec::new(), |fit| fit.not_estimable);
    }
    if !options.is_empty() && open.is_empty() {
        let options = options.join(" ");
        super::show(&format!("for example: with {options} these readings determine all others\n"))?;
    }
    super::show(&format!("next: tumble fit {}\n", shell_word(&to)))?;
    Ok(if doubts.is_empty() { Outcome::Done } else { Outcome::Rejected })
}

/// Write texts and, beside the first, the schemas of these kinds that are not there yet: their names.
fn write(mut texts: Vec<(PathBuf, String)>, first: &Path, kinds: &[&str]) -> Result<String> {
    for kind in kinds {
        let path = first.with_file_name(format!("{kind}.schema.json"));
        if let (false, Some(schema)) = (path.exists(), crate::report::schema(kind)) {
            texts.push((path, files::json(&schema)?));
        }
    }
    let names: Vec<String> = texts.iter().map(|(path, _)| path.display().to_string()).collect();
    let mut outputs = Outputs::plan(texts.iter().map(|(path, _)| Some(path.as_path())))?;
    outputs.extend(texts);
    outputs.write()?;
    Ok(names.join(", "))
}

/// What a campaign says to the person who goes on with it.
const REMARK: &str =
    "\"estimate\" is determined by the readings, \"known\" is taken as given with its u, what is in neither is zero";

/// A file as JSON with a reference to its schema, and a remark.
fn headed(kind: &str, remark: &str, value: &impl serde::Serialize) -> Result<String> {
    let (text, remark) = (files::json(value)?, files::json(&remark)?);
    let body = text.strip_prefix("{\n").unwrap_or(&text);
    Ok(format!("{{\n  \"$schema\": \"{kind}.schema.json\",\n  \"$comment\": {},\n{body}", remark.trim_end()))
}

/// A path as a shell takes it for one word.
fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:@%,".contains(c) || (cfg!(windows) && c == '\\');
    match text.chars().all(is_plain) {
        true => text,
        false if cfg!(windows) => format!("\"{text}\""),
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}

fn free(path: &Path) -> Result<()> {
    match path.exists() {
        false => Ok(()),
        true => Err(Malformed::new(Fault::File, format!("'{}' exists, and is not replaced", path.display()))
            .expected("a name that is free: --to FILE")),
    }
}

/// A path as a file in `folder` names it: its bare name if it is in this folder.
fn in_folder(folder: &Path, path: &Path) -> String {
    let there = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if there == folder {
        return name;
    }
    let there = there.canonicalize().ok().filter(|whole| !whole.as_os_str().is_empty());
    let there = there.or_else(|| std::env::current_dir().ok()).unwrap_or_default();
    there.join(name).display().to_string()
}
