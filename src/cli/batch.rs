//! One answer a device: `tumble fit CAMPAIGN --by COLUMN`, `--readings FILE...`; with `--reports FOLDER` a page of its own for each device that is not in order or
//! stands apart, to which the summary leads; `tumble diagnose CAMPAIGN --by COLUMN`: which device has which effect.

use super::Outcome;
use super::devices::{DeviceCampaign, DeviceTable, Many, Passed};
use super::files::Catalogue;
use super::outputs::Outputs;
use super::pages::{self, Pages, Texts};
use super::rows::{Cell, Format, Kind, Rows, Shortest, Titles};
use crate::batch::{self, Device, Fleet, Row, Schedules, Summary, Verdict};
use crate::campaign::Campaign;
use crate::diagnosis::{self, Diagnosis, Finding};
use crate::document::{self, html};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Settings};
use crate::language::{Language, say};
use crate::report::{self, BatchReport};
use crate::wire;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::io::IsTerminal;
use std::path::{Component, Path, PathBuf};

/// Most devices whose rows are shown on a terminal.
const SHOWN: usize = 40;

pub(super) fn fit(
    question: &DeviceCampaign,
    many: &Many,
    settings: &Settings,
    reports: Option<&Path>,
    pages: &Pages,
    lang: Language,
) -> Result<Outcome> {
    let table = question.table(false, many.chart.as_deref())?;
    let template = &table.template;
    fit::check_level(settings.level)?;
    let names = report::batch_quantities(template);
    let mut outputs = pages.outputs([many.to.as_deref()])?;
    let terminal = std::io::stdout().is_terminal();
    let stdout = PathBuf::from("-");
    // rows go to the file, else to stdout unless a person sits there or a report goes there
    let target = match &many.to {
        Some(path) => Some(path.clone()),
        None if terminal || outputs.to_stdout() => None,
        None => Some(stdout.clone()),
    };
    let format = target.as_deref().map(Format::of).transpose()?.unwrap_or(Format::Csv);
    let to_stdout = outputs.to_stdout() || target.as_ref() == Some(&stdout);
    let (lot, limited) = (table.lot.as_deref(), !template.limits.is_empty());
    let titles = titles(table.by(), lot, &names, limited);
    let begin = || {
        target
            .as_ref()
            .map(|path| Rows::begin(path, format, outputs.open_held(path)?, titles.clone(), &names))
            .transpose()
    };
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
    if pages.json().is_some() || pages.is_asked_for() {
        found.inputs = table.inputs()?;
    }
    let devices = match reports {
        Some(folder) => self::reports(&table, folder, pages.linked(), &found, settings, lang)?,
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
    if let Some(path) = pages.json() {
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

/// Most devices that get a page.
const MOST_PAGES: usize = 100;

/// Pages of devices, and where the summary finds them.
#[derive(Debug, Default)]
struct Reports {
    texts: Texts,
    links: BTreeMap<String, String>,
}

/// Read the table again and fit those devices by themselves; `summary` is the page that leads to them.
fn reports(
    table: &DeviceTable<'_>,
    folder: &Path,
    summary: Option<&Path>,
    report: &BatchReport,
    settings: &Settings,
    lang: Language,
) -> Result<Reports> {
    let fitted =
        report.not_in_order.iter().filter(|entry| entry.verdict != Verdict::Malformed).map(|entry| &entry.label);
    let mut wanted: Vec<&String> = Vec::new();
    for label in fitted
        .chain(report.outlying.iter().map(|entry| &entry.label))
        .chain(report.noisy.iter().map(|entry| &entry.label))
    {
        if !wanted.contains(&label) && wanted.len() < MOST_PAGES {
            wanted.push(label);
        }
    }
    let names = file_names(&wanted);
    let inputs = table.inputs()?;
    let mut made = Reports::default();
    table.read(&mut |passed| {
        let Passed::Devices(devices, layout) = passed else {
            made = Reports::default();
            return Ok(true);
        };
        for device in &devices {
            let Some(name) = names.get(&device.label) else { continue };
            // what is wrong with a device that cannot be fitted stands in its row
            let Ok(fit) = table.campaign(layout, device).and_then(|campaign| fit::fit_owned(campaign, settings)) else {
                continue;
            };
            let mut page = pages::document_of(&fit, &report::fit_report(&fit), &inputs, lang);
            page.title = format!("{}: {}", device.label, page.title);
            let path = folder.join(name);
            made.links.insert(device.label.clone(), link(summary, &path));
            made.texts.push((path, html::render(&page)?.into_bytes()));
        }
        Ok(true)
    })?;
    Ok(made)
}

/// A file name for each label: letters, digits, `-`, `_` and `.` stay, everything else becomes `_`; two of one name are numbered.
fn file_names(labels: &[&String]) -> BTreeMap<String, String> {
    let mut taken = BTreeSet::new();
    let mut names = BTreeMap::new();
    for label in labels {
        let keeps = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        let plain: String = label.chars().take(80).map(|c| if keeps(c) { c } else { '_' }).collect();
        let plain = plain.trim_start_matches('.');
        let mut name = format!("{plain}.html");
        let mut number = 2;
        // files of one folder may not differ in capitals alone
        while !taken.insert(name.to_lowercase()) {
            name = format!("{plain}-{number}.html");
            number += 1;
        }
        names.insert((*label).clone(), name);
    }
    names
}

/// The way from a page to a file: relative where the file lies below the page's folder.
fn link(from: Option<&Path>, to: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let to = absolute(to);
    let folder = from.map(absolute).and_then(|page| page.parent().map(Path::to_path_buf));
    let below: PathBuf = match folder.and_then(|folder| to.strip_prefix(folder).ok().map(Path::to_path_buf)) {
        Some(below) => below,
        None => to,
    };
    let part = |part: Component<'_>| match part {
        Component::Normal(part) => Some(encoded(&part.to_string_lossy())),
        _ => None,
    };
    let parts: Vec<String> = below.components().filter_map(part).collect();
    format!("{}{}", if below.is_absolute() { "file:///" } else { "" }, parts.join("/"))
}

/// Bytes that an address does not have, in hexadecimal.
fn encoded(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => out.push(char::from(byte)),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}

/// Diagnose every device by itself.
pub(super) fn diagnose(
    question: &DeviceCampaign,
    many: &Many,
    catalogue: &Catalogue,
    settings: &diagnosis::Settings,
    lang: Language,
) -> Result<Outcome> {
    let table = question.table(true, None)?;
    // what is wrong with the question itself (the significance, the catalogue) is no device's answer
    settings.check()?;
    let mut outputs = Outputs::plan([many.to.as_deref()])?;
    let target = many.to.clone().unwrap_or_else(|| PathBuf::from("-"));
    let format = Format::of(&target)?;
    let bar = table.bar();
    let mut found: Vec<Diagnosed> = Vec::new();
    table.read(&mut |passed| {
        let Passed::Devices(devices, layout) = passed else {
            found.clear();
            bar.reset();
            return Ok(true);
        };
        let one = |device: &Device| {
            let campaign = table.campaign(layout, device);
            let diagnosed = campaign.and_then(|c| diagnosis::diagnose(&c, &catalogue.effects, settings));
            bar.inc(device.rows as u64);
            Diagnosed::new(device, &diagnosed.map_err(|error| wire::locate(error, &question.source)))
        };
        found.par_extend(devices.par_iter().map(one));
        Ok(true)
    })?;
    bar.finish_and_clear();
    let (mut effects, mut verdicts) = (BTreeMap::<(String, String), usize>::new(), BTreeMap::<&str, usize>::new());
    let mut cells = Vec::with_capacity(found.len());
    for diagnosed in found {
        *verdicts.entry(diagnosed.verdict).or_default() += 1;
        // one effect in several sensors of a device is one device
        let of_device: BTreeSet<(String, String)> = diagnosed.effects.into_iter().collect();
        of_device.into_iter().for_each(|effect| *effects.entry(effect).or_default() += 1);
        cells.push(diagnosed.cells);
    }
    let mut rows = Rows::begin(&target, format, outputs.open(&target)?, titles_of_diagnoses(table.by()), &[])?;
    rows.write(&cells)?;
    outputs.finish(rows.finish()?);
    outputs.write()?;
    let mut counts: Vec<((String, String), usize)> = effects.into_iter().collect();
    counts.sort_by_key(|b| std::cmp::Reverse(b.1));
    let said: Vec<String> = verdicts.iter().map(|(verdict, n)| format!("{n} {}", lang.term(verdict))).collect();
    let devices = lang.count(cells.len(), "device");
    let devices = say!(lang, "grouped-by", what = devices, by = table.by());
    let mut text = format!("{devices}{}{}\n", lang.colon(), said.join(lang.comma()));
    if !counts.is_empty() {
        let table = document::Rows::of(&counts)
            .right(say!(lang, "devices"), |(_, n)| *n)
            .name(say!(lang, "effect"), |((regressor, _), _)| regressor)
            .left(say!(lang, "meaning"), |((_, name), _)| lang.name(name));
        text += &format!("\n{}", document::terminal::alone(table, lang));
    }
    match &many.to {
        Some(_) => super::print(&text)?,
        // rows are on stdout
        None => super::note(text.trim_end()),
    }
    let nothing = diagnosis::Verdict::NothingMissing.name();
    Ok(if verdicts.keys().all(|verdict| *verdict == nothing) { Outcome::Done } else { Outcome::Rejected })
}

/// What stays of the diagnosis of a device.
struct Diagnosed {
    verdict: &'static str,
    /// Terms and names.
    effects: Vec<(String, String)>,
    cells: Vec<Cell<'static>>,
}

fn titles_of_diagnoses(by: &str) -> Titles {
    let names = ["verdict", "effects", "regressors", "names", "values", "u", "units", "p", "aliases", "why"];
    let kind = |name: &str| if name == "effects" { Kind::Count } else { Kind::Text };
    [(by.to_string(), Kind::Text)].into_iter().chain(names.map(|name| (name.to_string(), kind(name)))).collect()
}

impl Diagnosed {
    /// Its cells: how many effects, and the regressors, values, u, probabilities and aliases of all of them, parted by semicolons.
    fn new(device: &Device, diagnosis: &Result<Diagnosis>) -> Self {
        let verdict = diagnosis.as_ref().map_or("malformed", |diagnosis| diagnosis.verdict.name());
        let effects: &[Finding] = diagnosis.as_ref().map_or(&[], |diagnosis| &diagnosis.effects);
        let all = |of: &dyn Fn(&Finding) -> String| effects.iter().map(of).collect::<Vec<_>>().join("; ");
        let number = |x: Option<f64>| x.map_or(String::new(), |x| Shortest(x).to_string());
        let texts = [
            all(&|f| f.effect.regressor.clone()),
            all(&|f| f.effect.name.clone()),
            all(&|f| number(f.value)),
            all(&|f| number(f.u)),
            all(&|f| f.unit.clone()),
            all(&|f| number(Some(f.p))),
            all(&|f| f.aliases.iter().map(|alias| alias.regressor.as_str()).collect::<Vec<_>>().join(" or ")),
            diagnosis.as_ref().err().map_or(String::new(), |error| {
                let found = error.finding().map_or(String::new(), |found| format!("; found: {found}"));
                format!("{} ({}){found}", error.what(), error.place().path)
            }),
        ];
        let first = [Cell::Text(device.label.clone().into()), Cell::Text(verdict.into()), Cell::Count(effects.len())];
        let named = |finding: &Finding| (finding.effect.regressor.clone(), finding.effect.name.clone());
        Diagnosed {
            verdict,
            effects: effects.iter().map(named).collect(),
            cells: first.into_iter().chain(texts.map(|text| Cell::Text(text.into()))).collect(),
        }
    }
}
