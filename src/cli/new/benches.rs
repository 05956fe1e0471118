//! Which bench: a built-in one, a file, or one that is made here.

use super::answers::Answers;
use super::columns::{complete, proposed};
use super::{Arguments, free, in_folder};
use crate::bench::{self, Bench, Link};
use crate::campaign::is_axis_input;
use crate::cli::files;
use crate::error::{Fault, Malformed, Result};
use crate::record::{Column, find, title};
use crate::units::Unit;
use crate::wire::{self, BenchFile, BenchRef, SensorFile, SiteFile, Source};
use serde_json::json;
use std::path::{Path, PathBuf};

/// How a campaign refers to its bench.
pub(super) struct Chosen {
    pub reference: BenchRef,
    /// A bench that is made here, and the file that it goes to.
    pub new: Option<BenchFile>,
    pub path: PathBuf,
    /// Is it the user's, with its site?
    pub is_theirs: bool,
}

/// A chain in one line, from the ground to the sensors: joints in brackets, `~` for a tilt.
pub(super) fn drawn(bench: &Bench) -> String {
    let mut line = String::from(if bench.chain.is_empty() { "no chain" } else { "ground" });
    for link in &bench.chain {
        match link {
            Link::Joint { name, about, .. } => line += &format!("--({name} {})", format!("{about:?}").to_lowercase()),
            Link::Tilt { .. } => line += "~",
        }
    }
    let sensors: Vec<&str> = bench.sensors.iter().map(|sensor| sensor.id.as_str()).collect();
    format!("{line}--[{}]", sensors.join(" "))
}

pub(super) fn chosen(
    arguments: &Arguments,
    answers: &Answers,
    columns: &[Column],
    stem: &str,
    folder: &Path,
) -> Result<(Bench, Chosen)> {
    // how many columns a bench reads, if they are all that it needs
    let fits = |bench: &Bench| -> Option<usize> {
        let keys: Vec<String> = proposed(bench, columns).into_iter().flatten().collect();
        complete(bench, &keys, &[], Path::new(""), columns).ok()?;
        // a joint that only turns is for sensors of rates
        let has = |joint: &str, end: &str| keys.iter().any(|key| key.strip_prefix(joint) == Some(end));
        let turns = bench.joints().any(|joint| has(joint, "_deg_s") && !has(joint, "_deg"));
        let inputs = || bench.sensors.iter().flat_map(|sensor| sensor.model.names());
        let follows = inputs().any(|name| name.starts_with("w_") && is_axis_input(bench, name));
        (follows || !turns).then_some(keys.len())
    };
    let all: Vec<Bench> = bench::built_ins().iter().filter_map(|b| Bench::named(b.id).ok()).collect();
    let mut fitting: Vec<(usize, &Bench)> = all.iter().filter_map(|bench| Some((fits(bench)?, bench))).collect();
    fitting.sort_by_key(|(read, _)| std::cmp::Reverse(*read));
    let fitting: Vec<&Bench> = fitting.into_iter().map(|(_, bench)| bench).collect();
    let others: Vec<&Bench> = all.iter().filter(|bench| fitting.iter().all(|own| own.id != bench.id)).collect();
    if answers.asks && arguments.bench.is_none() {
        let line = |bench: &&Bench| format!("{}\n    {}\n    {}\n", bench.id, bench.title, drawn(bench));
        let list: String = fitting.iter().chain(&others).map(line).collect();
        crate::cli::note(&format!(
            "{list}own\n    made here, joint by joint\n( ) a joint, ~ a small unknown tilt, [ ] sensors"
        ));
    }
    let ids: Vec<&str> = fitting.iter().map(|bench| bench.id.as_str()).collect();
    let hint = match ids.is_empty() {
        true => "the bench: a built-in one (tumble bench list), a file, or own".to_string(),
        false => format!("the bench: {} (whose columns this table has), another, a file, or own", ids.join(", ")),
    };
    // a person may take the first that fits; nobody takes one unasked
    let proposal = ids.first().copied().filter(|_| answers.asks);
    answers.one(arguments.bench.as_deref(), ("--bench ID|FILE|own", &hint), proposal, |name| {
        let of = |reference: &str, is_theirs| Chosen {
            reference: BenchRef::Named(reference.to_string()),
            new: None,
            path: PathBuf::new(),
            is_theirs,
        };
        if name == "own" {
            let path = folder.join(format!("{stem}.bench.json"));
            free(&path)?;
            let file = own(arguments, answers, columns, stem)?;
            let bench = file.clone().into_bench()?;
            let chosen = Chosen { new: Some(file), ..of(&format!("{stem}.bench.json"), false) };
            return Ok((bench, Chosen { path, ..chosen }));
        }
        match Bench::named(name) {
            Ok(bench) => Ok((bench, of(name, false))),
            Err(_) if Path::new(name).exists() => {
                let bench = wire::read_bench(&files::read(Path::new(name))?)?;
                Ok((bench, of(&in_folder(folder, Path::new(name)), true)))
            }
            Err(_) => Err(Malformed::new(Fault::UnknownName, format!("there is no bench '{name}'"))
                .expected("a built-in bench (tumble bench list), a bench file, or own")),
        }
    })
}

/// A built-in bench whose sensors have the units of the table's columns, where these do not convert (m/s^2 for a bench in LSB): its model lines hold in any.
///
/// Errors: a name that is not free.
pub(super) fn in_units_of(
    bench: &Bench,
    chosen: &Chosen,
    columns: &[(&str, &Column)],
    stem: &str,
    folder: &Path,
) -> Result<Option<(Bench, Chosen)>> {
    let BenchRef::Named(id) = &chosen.reference else { return Ok(None) };
    let Some(text) = bench::built_in(id).map(|b| b.text) else { return Ok(None) };
    let mut file: BenchFile = wire::parse(&Source { name: id.clone(), text: text.into() })?;
    let mut differs = false;
    for ((_, sensor), given) in file.sensors.0.iter_mut().zip(&bench.sensors) {
        let column = columns.iter().find(|(key, _)| *key == given.id).and_then(|(_, column)| column.unit.clone());
        let units = column.as_deref().map(Unit::parse).zip(Some(Unit::parse(&given.unit)));
        if let (Some(unit), Some((Ok(theirs), Ok(its)))) = (column, units)
            && !unit.is_empty()
            && !given.unit.is_empty()
            && theirs.conversion(&its).is_none()
        {
            sensor.unit = unit;
            differs = true;
        }
    }
    if !differs {
        return Ok(None);
    }
    let path = folder.join(format!("{stem}.bench.json"));
    free(&path)?;
    file.id = stem.to_string();
    let reference = BenchRef::Named(format!("{stem}.bench.json"));
    let bench = file.clone().into_bench()?;
    Ok(Some((bench, Chosen { reference, new: Some(file), path, is_theirs: false })))
}

fn own(arguments: &Arguments, answers: &Answers, columns: &[Column], stem: &str) -> Result<BenchFile> {
    let given: Vec<String> = arguments.chain.clone().into_iter().collect();
    if given.is_empty() && !answers.asks {
        return Err(Malformed::new(Fault::Missing, "not given, and no terminal to ask at: the chain of the bench")
            .expected(
                "--chain beta:x,~dtheta_y:y (joints, and tilts with ~, from the ground to the sensor), or --chain none",
            ));
    }
    let question = "joints and tilts from the ground (x east, y north, z up) to the sensor, as beta:x or ~dtheta_y:y";
    let link = |text: &str| {
        let (kind, name) = text.strip_prefix('~').map_or(("joint", text), |name| ("tilt", name));
        match name.rsplit_once(':') {
            _ if text == "none" => Ok(None),
            Some((name, about @ ("x" | "y" | "z"))) => Ok(Some(json!({ kind: name.trim(), "about": about }))),
            _ => Err(Malformed::new(Fault::Value, "this is neither a joint nor a tilt")
                .expected("NAME:AXIS or ~NAME:AXIS, the axis x, y or z")
                .found(format!("'{text}'"))),
        }
    };
    let links = |text: &str| text.split(',').map(|part| link(part.trim())).collect::<Result<Vec<_>>>();
    let chain = answers.several(&given, question, links)?;
    let question =
        "sensors, as V [mV] = V0 + k*a_x (rates w_x, w_y, w_z and specific forces a_x, a_y, a_z in the last frame)";
    let sensors = answers.several(&arguments.model, question, |text| {
        let (name, model) = super::pair(text)?;
        let (id, unit) = title(&name);
        // a unit that is not said is that of the column
        let named = arguments.columns.iter().filter_map(|text| super::pair(text).ok()).find(|(key, _)| *key == id);
        let column = find(columns, named.as_ref().map_or(&id, |(_, title)| title)).and_then(|k| columns.get(k));
        let unit = unit.or_else(|| column?.unit.clone()).unwrap_or_default();
        crate::algebra::Expression::parse(&model)?;
        Ok((id, SensorFile { unit, axes: wire::Named::default(), turn: None, input_axis: None, model }))
    })?;
    if sensors.is_empty() {
        return Err(Malformed::new(Fault::Missing, "a bench has a sensor").expected("--model 'V [mV] = V0 + k*a_x'"));
    }
    let chain: Vec<_> = chain.into_iter().flatten().flatten().collect();
    let ids: Vec<&str> = sensors.iter().map(|(id, _)| id.as_str()).collect();
    let joints: Vec<&str> = chain.iter().filter_map(|link| link.get("joint")?.as_str()).collect();
    let title = match joints.is_empty() {
        true => format!("{stem}: {}", ids.join(", ")),
        false => format!("{stem}: {} on {}", ids.join(", "), joints.join(", ")),
    };
    let mut file: BenchFile = serde_json::from_value(json!({
        "id": stem, "title": title,
        "notes": [
            "readings give each joint NAME as NAME_deg at rest, or NAME_deg_s while it turns (the mean over whole turns)",
            "a tilt is a small unknown angle, estimated in rad and arcsec; every other name in a model line is a column of the readings or a coefficient"
        ],
        "chain": chain, "sensors": {}
    }))
    .map_err(|error| Malformed::new(Fault::Value, error.to_string()))?;
    file.sensors = wire::Named(sensors);
    Ok(file)
}

/// The site of the bench, if it matters: the Earth turns every gyro.
pub(super) fn site(
    arguments: &Arguments,
    answers: &Answers,
    bench: &Bench,
    is_theirs: bool,
) -> Result<Option<SiteFile>> {
    let rates = bench.sensors.iter().any(|sensor| sensor.model.names().iter().any(|name| name.starts_with("w_")));
    if arguments.latitude.is_none() && (!rates || bench.chain.is_empty() || (is_theirs && bench.site.is_some())) {
        return Ok(None);
    }
    let question = (
        "--latitude DEG",
        "the latitude of the bench in degrees, north positive (the Earth's rate is in the readings)",
    );
    answers.one(arguments.latitude.as_deref(), question, None, |text| {
        let latitude = text.parse().ok().filter(|deg: &f64| deg.abs() <= 90.0).ok_or_else(|| {
            Malformed::new(Fault::Value, "this is not a latitude")
                .expected("-90 to 90, with a decimal point")
                .found(format!("'{text}'"))
        })?;
        Ok(Some(SiteFile { latitude_deg: Some(latitude), ..SiteFile::default() }))
    })
}
