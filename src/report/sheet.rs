//! A run sheet: the readings of a schedule in the order to run, with empty cells for what is read, as a document and as a table that goes back
//! as the readings of a campaign.

use super::provenance::begin;
use super::scene::scene_figure;
use super::separation::{PositionReport, position_keys};
use crate::campaign::{Campaign, Reading};
use crate::document::number::trimmed;
use crate::document::{Document, Rows, Section};
use crate::language::{Language, code, say};
use crate::plan::{Costs, mountings};

/// More mountings than this are not drawn: two stand side by side, so these are ten printed pages.
const DRAWN: usize = 60;

/// The columns of joints, of other inputs and of numbers of samples, each with its title and a cell for each reading.
fn columns(schedule: &Campaign) -> Vec<(String, Vec<String>)> {
    let rows = &schedule.readings.rows;
    let said = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let keys: Vec<PositionReport> = rows.iter().map(|row| position_keys(schedule, &row.joints)).collect();
    let joints =
        schedule.bench.joints().flat_map(|name| ["_deg", "_deg_s", "_turns"].map(|key| format!("{name}{key}")));
    let joints: Vec<String> = joints.filter(|key| keys.iter().any(|keys| keys.contains_key(key))).collect();
    let inputs = schedule.readings.columns.iter().enumerate().filter(|(_, name)| !joints.contains(*name));
    let inputs = inputs.map(|(k, name)| {
        let cells = rows.iter().map(|row| said(row.columns.get(k).copied().flatten()));
        (name.clone(), cells.collect())
    });
    // is a reading the mean of several samples?
    let averaged = rows.iter().any(|row| row.samples != 1.0);
    let samples = averaged.then(|| ("n".to_string(), rows.iter().map(|row| row.samples.to_string()).collect()));
    let of_joint = |key: &String| (key.clone(), keys.iter().map(|keys| said(keys.get(key).copied())).collect());
    joints.iter().map(of_joint).chain(inputs).chain(samples).collect()
}

/// The schedule as CSV: one row a reading in the order to run, an empty column for each sensor (with its value where it is read already). Filled in,
/// it is a table of readings (`"readings": "sheet.csv"`, or `--readings`).
pub fn sheet_csv(schedule: &Campaign) -> String {
    let columns = columns(schedule);
    let labelled = schedule.readings.rows.iter().any(|row| !row.position.is_empty());
    let mut titles = if labelled { vec!["position".to_string()] } else { Vec::new() };
    titles.extend(columns.iter().map(|(title, _)| title.clone()));
    // uncertainties stand beside the values
    let u_of =
        |row: &Reading, sensor: usize| row.unread().planned_u.iter().find(|(k, _)| *k == sensor).map(|(_, u)| *u);
    let has_u = |sensor: &usize| schedule.readings.rows.iter().any(|row| u_of(row, *sensor).is_some());
    let with_u: Vec<usize> = (0..schedule.bench.sensors.len()).filter(has_u).collect();
    for (k, sensor) in schedule.bench.sensors.iter().enumerate() {
        titles.push(sensor.id.clone());
        titles.extend(with_u.contains(&k).then(|| format!("{}_u", sensor.id)));
    }
    let mut table = csv::Writer::from_writer(Vec::new());
    let mut whole = table.write_record(&titles).is_ok();
    for (k, row) in schedule.readings.rows.iter().enumerate() {
        let mut cells = if labelled { vec![row.position.to_string()] } else { Vec::new() };
        cells.extend(columns.iter().filter_map(|(_, cells)| cells.get(k).cloned()));
        for sensor in 0..schedule.bench.sensors.len() {
            cells.push(value_of(row, sensor).unwrap_or_default());
            let u = || u_of(row, sensor).map_or(String::new(), |u| u.to_string());
            cells.extend(with_u.contains(&sensor).then(u));
        }
        whole &= table.write_record(&cells).is_ok();
    }
    let text = table.into_inner().ok().filter(|_| whole).and_then(|bytes| String::from_utf8(bytes).ok());
    // memory takes every record, and all of them have as many cells as there are titles
    text.unwrap_or_default()
}

fn value_of(row: &Reading, sensor: usize) -> Option<String> {
    let observation = row.observations.iter().find(|observation| observation.sensor == sensor)?;
    Some(observation.value.to_string())
}

/// The same for a person: each mounting drawn, and the readings with what they cost up to each of them.
pub fn sheet_document(schedule: &Campaign, costs: &Costs, lang: Language) -> Document {
    let rows = &schedule.readings.rows;
    let of = mountings(rows);
    let work = costs.work(rows);
    let begins = std::iter::once(None).chain(of.iter().map(Some)).zip(&of).map(|(before, key)| before != Some(key));
    let numbered = rows.iter().zip(&of).zip(begins).enumerate();
    let mut table = Rows::of(numbered.map(|(k, ((row, mounting), new))| (k, row, *mounting, new)))
        .right("#", |(k, ..)| k + 1)
        .left(
            say!(lang, "mounting"),
            |(_, row, mounting, new)| if new { name_of(row, mounting) } else { String::new() },
        )
        .rule(|(k, .., new)| new && k > 0);
    for (title, cells) in columns(schedule) {
        table = table.decimal(title, |(k, ..)| cells.get(k).cloned().unwrap_or_default());
    }
    for (k, sensor) in schedule.bench.sensors.iter().enumerate() {
        let title = if sensor.unit.is_empty() { sensor.id.clone() } else { format!("{} ({})", sensor.id, sensor.unit) };
        table = table.decimal(title, |(_, row, ..)| value_of(row, k).unwrap_or_else(|| BLANK.into()));
    }
    let table = table
        .decimal(say!(lang, "cost-so-far"), |(k, ..)| trimmed(rows.get(..=k).map_or(0.0, |done| costs.work(done).cost)))
        .left(say!(lang, "note"), |_| BLANK);
    let mut figures = Vec::new();
    let mut drawn: Vec<usize> = Vec::new();
    for (row, mounting) in rows.iter().zip(&of) {
        if !drawn.contains(mounting) && drawn.len() < DRAWN {
            drawn.push(*mounting);
            let caption = format!("{} {}", lang.title(say!(lang, "mounting")), name_of(row, *mounting));
            figures.push(scene_figure(&schedule.bench, &row.joints, caption, lang));
        }
    }
    begin(say!(lang, "run-sheet", bench = lang.name(&schedule.bench.title)), &[], lang)
        .fact(say!(lang, "bench"), code(&schedule.bench.id))
        .fact(say!(lang, "readings"), work.readings.to_string())
        .fact(say!(lang, "mountings"), work.mountings.to_string())
        .fact(say!(lang, "cost"), trimmed(work.cost))
        .section(Section::new(say!(lang, "readings")).prose(say!(lang, "run-sheet-how")).table(table))
        .section(Section::new(say!(lang, "mountings")).figures(figures))
}

/// A cell to write in.
const BLANK: &str = "________";

fn name_of(row: &Reading, mounting: usize) -> String {
    if row.position.is_empty() { (mounting + 1).to_string() } else { row.position.to_string() }
}
