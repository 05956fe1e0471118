//! A run sheet: the readings of a schedule in the order to run, with empty cells for what is read, as a document and as a table that goes back
//! as the readings of a campaign.

use super::provenance::begin;
use super::scene::scene_figure;
use super::separation::position_keys;
use crate::campaign::{Campaign, Reading};
use crate::document::number::trimmed;
use crate::document::{Document, Rows, Section};
use crate::language::{Language, say};
use crate::plan::{Costs, mountings};

/// More mountings than this are not drawn: two stand side by side, so these are ten printed pages.
const DRAWN: usize = 60;

/// What a table of readings has: columns of joints, of other inputs and of numbers of samples, one row a reading.
struct Columns {
    joints: Vec<String>,
    inputs: Vec<usize>,
    /// Is a reading the mean of several samples?
    averaged: bool,
}

impl Columns {
    fn of(schedule: &Campaign) -> Self {
        let rows = &schedule.readings.rows;
        let mut joints = Vec::new();
        for name in schedule.bench.joints() {
            for suffix in ["_deg", "_deg_s", "_turns"] {
                let key = format!("{name}{suffix}");
                if rows.iter().any(|row| position_keys(schedule, &row.joints).contains_key(&key)) {
                    joints.push(key);
                }
            }
        }
        let columns = schedule.readings.columns.iter().enumerate();
        let inputs = columns.filter(|(_, name)| !joints.contains(*name)).map(|(k, _)| k).collect();
        Columns { joints, inputs, averaged: rows.iter().any(|row| row.samples != 1.0) }
    }

    fn titles(&self, schedule: &Campaign) -> Vec<String> {
        let inputs = self.inputs.iter().filter_map(|k| schedule.readings.columns.get(*k));
        let samples = self.averaged.then(|| "n".to_string());
        self.joints.iter().chain(inputs).cloned().chain(samples).collect()
    }

    fn cells(&self, schedule: &Campaign, row: &Reading) -> Vec<String> {
        let keys = position_keys(schedule, &row.joints);
        let joints = self.joints.iter().map(|key| keys.get(key).copied());
        let inputs = self.inputs.iter().map(|k| row.columns.get(*k).copied().flatten());
        let samples = self.averaged.then_some(Some(row.samples));
        joints
            .chain(inputs)
            .chain(samples)
            .map(|value| value.map(|value| value.to_string()).unwrap_or_default())
            .collect()
    }
}

/// The schedule as CSV: one row a reading in the order to run, an empty column for each sensor (with its value where it is read already). Filled in,
/// it is a table of readings (`"readings": "sheet.csv"`, or `--readings`).
pub fn sheet_csv(schedule: &Campaign) -> String {
    let columns = Columns::of(schedule);
    let labelled = schedule.readings.rows.iter().any(|row| !row.position.is_empty());
    let mut titles = if labelled { vec!["position".to_string()] } else { Vec::new() };
    titles.extend(columns.titles(schedule));
    // uncertainties stand beside the values
    let u_of =
        |row: &Reading, sensor: usize| row.unread().planned_u.into_iter().find(|(k, _)| *k == sensor).map(|(_, u)| u);
    let has_u = |sensor: &usize| schedule.readings.rows.iter().any(|row| u_of(row, *sensor).is_some());
    let with_u: Vec<usize> = (0..schedule.bench.sensors.len()).filter(has_u).collect();
    for (k, sensor) in schedule.bench.sensors.iter().enumerate() {
        titles.push(sensor.id.clone());
        titles.extend(with_u.contains(&k).then(|| format!("{}_u", sensor.id)));
    }
    let mut table = csv::Writer::from_writer(Vec::new());
    let mut whole = table.write_record(&titles).is_ok();
    for row in &schedule.readings.rows {
        let mut cells = if labelled { vec![row.position.to_string()] } else { Vec::new() };
        cells.extend(columns.cells(schedule, row));
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
    let columns = Columns::of(schedule);
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
    for (k, title) in columns.titles(schedule).into_iter().enumerate() {
        table =
            table.decimal(title, |(_, row, ..)| columns.cells(schedule, row).into_iter().nth(k).unwrap_or_default());
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
        .fact(say!(lang, "bench"), format!("`{}`", schedule.bench.id))
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
