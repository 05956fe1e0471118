//! One fit a device: `tumble fit CAMPAIGN --by COLUMN`, `--readings FILE...`.

use super::Outcome;
use super::batch_reports::{self, Reports};
use super::devices::{DeviceCampaign, Many, Others};
use super::pages::Pages;
use super::rows::{Columns, Format, Rows};
use crate::batch::{self, Device, Fleet, Layout, Row, Summary};
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::fit::Settings;
use crate::language::Language;
use crate::report;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Most devices whose rows are shown on a terminal.
const SHOWN: usize = 40;
/// One fit for each device.
pub(super) fn fit(
    question: &DeviceCampaign,
    many: &Many,
    settings: &Settings,
    (json, reports): (Option<&Path>, Option<&Path>),
    pages: &Pages,
    lang: Language,
) -> Result<Outcome> {
    let table = question.table(Others::Named(&question.file), many.chart.as_deref())?;
    let template = table.template()?;
    super::probability("level", settings.level, "0.95")?;
    let names = report::batch_quantities(template);
    let mut outputs = pages.outputs([many.to.as_deref(), json])?;
    let terminal = std::io::stdout().is_terminal();
    let stdout = PathBuf::from("-");
    // rows go to the file, else to stdout unless a person sits there or a report goes there
    let target = match &many.to {
        Some(path) => Some(path.clone()),
        None if terminal || outputs.to_stdout() => None,
        None => Some(stdout.clone()),
    };
    if let Some(path) = &target {
        Format::of(path)?;
    }
    let to_stdout = outputs.to_stdout() || target.as_ref() == Some(&stdout);
    let columns = Columns {
        by: table.by().to_string(),
        lot: table.lot().map(str::to_string),
        quantities: names.clone(),
        limited: !template.limits.is_empty(),
    };
    let begin = || target.as_ref().map(|path| Rows::begin(path, outputs.open_held(path)?, columns.clone())).transpose();
    let state =
        std::cell::RefCell::new(State { rows: begin()?, summary: Summary::new(names.len()), shown: Vec::new() });
    let bar = table.bar();
    let question_of = std::cell::RefCell::new(None::<Layout>);
    let schedules = std::cell::RefCell::new(None::<batch::Schedules>);
    table.read(
        &mut |devices, layout| {
            let of = |device: &Device| table.campaign(layout, device);
            let mut fleet = Fleet::with(&of, *settings, names.len(), schedules.borrow_mut().take().unwrap_or_default());
            let rows = fleet.fit(&devices, layout);
            *schedules.borrow_mut() = Some(fleet.into_schedules());
            *question_of.borrow_mut() = Some(layout.clone());
            let mut state = state.borrow_mut();
            rows.iter().for_each(|row| state.summary.add(row));
            let room = (SHOWN + 1).saturating_sub(state.shown.len());
            state.shown.extend(rows.iter().take(room).cloned());
            bar.inc(devices.iter().map(|device| device.rows as u64).sum());
            state.rows.as_mut().map_or(Ok(()), |out| out.write(&rows))?;
            let determined = rows.iter().filter(|row| row.rank == template.unknowns() && row.rank > 0).count();
            Ok(2 * determined >= rows.len())
        },
        &mut || {
            // the file that was begun is gone before it is begun anew under the same name
            state.borrow_mut().rows = None;
            *state.borrow_mut() = State { rows: begin()?, summary: Summary::new(names.len()), shown: Vec::new() };
            bar.reset();
            Ok(())
        },
    )?;
    bar.finish_and_clear();
    let State { rows, summary, shown } = state.into_inner();
    if summary.devices == 0 {
        return Err(Malformed::new(Fault::Missing, "there are no readings")
            .expected(format!("a table with the columns {} and those of a reading", table.by()))
            .at_path("readings"));
    }
    let mut found = report::batch_report(template, settings, table.by(), &summary);
    if json.is_some() || pages.is_asked_for() {
        found.inputs = table.inputs()?;
    }
    let devices = match reports {
        Some(folder) => batch_reports::reports(&table, folder, pages.linked(), &found, settings, lang)?,
        None => Reports::default(),
    };
    if let Some(folder) = reports.filter(|_| !devices.texts.is_empty()) {
        std::fs::create_dir_all(folder).map_err(|error| super::outputs::fault(folder, &error))?;
    }
    outputs.extend(devices.texts);
    if pages.is_asked_for() {
        outputs.extend(pages.page(&report::batch_document(
            &found,
            Some((template, &summary)),
            &devices.links,
            lang,
        ))?);
    }
    if let Some(path) = json {
        outputs.json(path, &found)?;
    }
    if let Some(out) = rows {
        outputs.finish(out.finish()?);
    }
    outputs.write()?;
    if !to_stdout {
        if many.to.is_none() && summary.devices <= SHOWN {
            super::show(&(report::batch_rows(template, table.by(), &shown, lang) + "\n"))?;
        }
        pages.print(&report::batch_document(&found, Some((template, &summary)), &BTreeMap::new(), lang))?;
    }
    let failed = found.conformity.as_ref().is_some_and(|own| own.fail + own.undecided > 0);
    let rejected = found.devices.rejected + found.devices.malformed > 0;
    Ok(if failed || rejected { Outcome::Rejected } else { Outcome::Done })
}

/// What a pass over the devices has found.
struct State {
    rows: Option<Rows>,
    summary: Summary,
    shown: Vec<Row>,
}

/// A text column that repeats the schedule: several devices that are about to be fitted as one?
pub(super) fn repeated(campaign: &Campaign) -> Option<String> {
    let (column, devices) = batch::repeats(campaign)?;
    Some(format!(
        "note: the column '{column}' repeats the schedule for {devices} labels, and all their readings are fitted together as one device; \
         --by {column} fits each by itself"
    ))
}
