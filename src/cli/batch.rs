//! One fit a device: `tumble fit CAMPAIGN --by COLUMN`, `--readings FILE...`.

use super::Outcome;
use super::batch_reports::{self, Reports};
use super::devices::{DeviceCampaign, Many, Passed};
use super::pages::Pages;
use super::rows::{Cell, Format, Kind, Rows, Titles};
use crate::batch::{self, Device, Fleet, Row, Schedules, Summary};
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Settings};
use crate::language::Language;
use crate::report;
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Most devices whose rows are shown on a terminal.
const SHOWN: usize = 40;

pub(super) fn fit(
    question: &DeviceCampaign,
    many: &Many,
    settings: &Settings,
    (json, reports): (Option<&Path>, Option<&Path>),
    pages: &Pages,
    lang: Language,
) -> Result<Outcome> {
    let table = question.table(false, many.chart.as_deref())?;
    let template = &table.template;
    fit::check_level(settings.level)?;
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
    let (lot, limited) = (table.lot.as_deref(), !template.limits.is_empty());
    let titles = titles(table.by(), lot, &names, limited);
    let begin =
        || target.as_ref().map(|path| Rows::begin(path, outputs.open_held(path)?, titles.clone(), &names)).transpose();
    let (mut rows, mut summary, mut shown) = (begin()?, Summary::new(names.len()), Vec::<Row>::new());
    let bar = table.bar();
    let mut schedules = Schedules::default();
    table.read(&mut |passed| {
        let Passed::Devices(devices, layout) = passed else {
            // the file that was begun is gone before it is begun anew under the same name
            drop(rows.take());
            (rows, summary, shown) = (begin()?, Summary::new(names.len()), Vec::new());
            bar.reset();
            return Ok(true);
        };
        let of = |device: &Device| table.campaign(layout, device);
        let mut fleet = Fleet::with(&of, *settings, names.len(), std::mem::take(&mut schedules));
        let fitted = fleet.fit(&devices, layout);
        schedules = fleet.into_schedules();
        fitted.iter().for_each(|row| summary.add(row));
        shown.extend(fitted.iter().take((SHOWN + 1).saturating_sub(shown.len())).cloned());
        bar.inc(devices.iter().map(|device| device.rows as u64).sum());
        if let Some(rows) = &mut rows {
            rows.write(&fitted.iter().map(|row| cells(row, lot.is_some(), limited)).collect::<Vec<_>>())?;
        }
        let determined = fitted.iter().filter(|row| row.rank == template.unknowns() && row.rank > 0).count();
        Ok(2 * determined >= fitted.len())
    })?;
    bar.finish_and_clear();
    if summary.devices.all == 0 {
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
    if let Some(rows) = rows {
        outputs.finish(rows.finish()?);
    }
    outputs.write()?;
    if !to_stdout {
        if many.to.is_none() && summary.devices.all <= SHOWN {
            super::show(&(report::batch_rows(template, table.by(), &shown, lang) + "\n"))?;
        }
        pages.print(&report::batch_document(&found, Some((template, &summary)), &BTreeMap::new(), lang))?;
    }
    let failed = found.conformity.as_ref().is_some_and(|counts| counts.fail + counts.undecided > 0);
    let rejected = found.devices.rejected + found.devices.malformed > 0;
    Ok(if failed || rejected { Outcome::Rejected } else { Outcome::Done })
}

/// What a row has, in order: what identifies the device, its verdicts, each quantity with u and U, the tests.
fn titles(by: &str, lot: Option<&str>, quantities: &[(String, String)], limited: bool) -> Titles {
    let mut titles = vec![(by.to_string(), Kind::Text)];
    let texts = lot.into_iter().chain(["verdict"]).chain(limited.then_some("conformity"));
    titles.extend(texts.map(|name| (name.to_string(), Kind::Text)));
    for (id, _) in quantities {
        titles.extend(["", "_u", "_U"].map(|end| (format!("{id}{end}"), Kind::Number)));
    }
    titles.extend(["readings", "rank", "dof"].map(|name| (name.to_string(), Kind::Count)));
    let tests = ["residual_sd", "chi_square_p", "lack_of_fit_p", "runs_p", "normality_p"];
    titles.extend(tests.map(|name| (name.to_string(), Kind::Number)));
    titles.extend(["suspects", "schedule", "why"].map(|name| (name.to_string(), Kind::Text)));
    titles
}

/// The cells of a row, in the order of the titles.
fn cells(row: &Row, has_lot: bool, limited: bool) -> Vec<Cell<'_>> {
    let mut cells = Vec::with_capacity(14 + 3 * row.value.len());
    let conformity = limited.then(|| row.conformity.map_or("", |outcome| outcome.name()));
    let texts = has_lot.then_some(row.lot.as_str()).into_iter().chain([row.verdict.name()]).chain(conformity);
    cells.extend([row.label.as_str()].into_iter().chain(texts).map(|text| Cell::Text(text.into())));
    for ((value, u), expanded) in row.value.iter().zip(&row.u).zip(&row.expanded) {
        cells.extend([value, u, expanded].map(|x| Cell::Number(*x)));
    }
    cells.extend([row.readings, row.rank, row.dof].map(Cell::Count));
    let tests = [row.residual_sd, row.chi_square_p, row.lack_of_fit_p, row.runs_p, row.normality_p];
    cells.extend(tests.map(Cell::Number));
    let suspects = row.suspects.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
    cells.push(Cell::Text(suspects.into()));
    cells.extend([row.solved.name(), row.why.as_str()].map(|text| Cell::Text(text.into())));
    cells
}

/// Say so where a text column repeats the schedule: several devices that are about to be fitted as one.
pub(super) fn note_repeated(campaign: &Campaign) {
    let Some((column, devices)) = batch::repeats(campaign) else { return };
    super::note(&format!(
        "note: the column '{column}' repeats the schedule for {devices} labels, and all their readings are fitted together as one device; \
         --by {column} fits each by itself"
    ));
}
