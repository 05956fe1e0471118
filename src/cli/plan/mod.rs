//! `tumble plan SCHEDULE`.

mod arguments;
mod asked;
mod find;

pub(super) use arguments::Arguments;

use super::pages::workbook;
use super::{Outcome, files};
use crate::campaign::{Campaign, Kind, Reading, Readings, Shared};
use crate::diagnosis;
use crate::document::html;
use crate::error::{Fault, Malformed, Result};
use crate::fit;
use crate::language::Language;
use crate::plan::{self, Costs, Goal, Noise, NoiseSource, Offer};
use crate::report::{self, Better, FindReport, Foreseen};
use crate::wire;
pub(super) use asked::{costs, named_number, parse_goals};
use asked::{criterion_name, extras, find_candidates, noise, request, term, values};
use find::shown_from;
use indicatif::ProgressBar;
use std::path::Path;

/// With more values than this, what a diagnosis could find is not foreseen.
const MOST_FORESEEN: usize = 100_000;

pub(super) fn run(arguments: &Arguments, lang: Language) -> Result<Outcome> {
    let (campaign, source, _) = files::campaign(&arguments.schedule)?;
    files::one_device(&campaign);
    let mut outputs = arguments.pages.outputs([arguments.write.as_deref(), arguments.sheet.as_deref()])?;
    // an option has no place in the file
    let located = |error: Malformed| match error.place().path.is_empty() {
        true => error,
        false => wire::locate(error, &source),
    };
    let mut asked = campaign;
    let extras = extras(arguments, &asked)?;
    let (mut without, mut coefficients) = (None, Vec::new());
    if !extras.is_empty() {
        let terms: Vec<plan::Term> = extras.iter().map(|extra| extra.term.clone()).collect();
        let (longer, names) = plan::extended(&asked, &terms).map_err(located)?;
        (without, coefficients) = (Some(std::mem::replace(&mut asked, longer)), names);
    }
    let fitted = asked.is_measured().then(|| fit::fit(&asked, &fit::Settings::default()).ok()).flatten();
    // the readings, which may be many, are lent to the campaign at the point of judging and not copied
    let at = values(&arguments.at, "--at", "K=1.3", &asked)?;
    let readings = std::mem::take(&mut asked.readings);
    let plan::Judged { mut campaign, from } = plan::judged_at(&asked, &at, fitted.as_ref())?;
    campaign.readings = readings;
    let noise = noise(arguments, &campaign, fitted.as_ref()).map_err(located)?;
    let costs = costs(&arguments.cost)?;
    if campaign.is_measured() {
        let planned = plan::planned(&campaign, &campaign.readings);
        asked.readings = std::mem::replace(&mut campaign.readings, planned);
    }
    let campaign = campaign;
    // a schedule is planned as it is
    let given = if asked.is_measured() { &asked.readings } else { &campaign.readings };
    let judgement = plan::judge(&campaign, &noise, &costs).map_err(located)?;
    let bar = ProgressBar::new_spinner();
    let request = request(arguments, &judgement, &bar)?;
    let catalogue = files::catalogue(arguments.effects.as_deref())?;
    let foresee = |schedule: &Campaign| {
        // a column of every effect for every value: beyond this, gigabytes
        if schedule.readings.rows.len().saturating_mul(schedule.bench.sensors.len()) > MOST_FORESEEN {
            return Ok(None);
        }
        let foreseen = diagnosis::foresee(schedule, &catalogue.effects, &noise);
        foreseen.map(Some).map_err(|error| catalogue.locate(error, &source))
    };
    let foresight = foresee(&campaign)?;
    let separates: Option<[String; 2]> = arguments.separate.clone().try_into().ok();
    let anew = arguments.choose.is_some()
        || arguments.budget.is_some()
        || !arguments.goal.is_empty()
        || !arguments.find.is_empty();
    let criterion = criterion_name(&request.criterion);
    let mut candidates = None;
    let (improvement, reached, separated);
    let mut better = None;
    let (mut goals, mut finds) = (Vec::<Goal>::new(), Vec::new());
    if anew || arguments.add.is_some() || separates.is_some() {
        let keeps = !anew || arguments.keep;
        let none = || Readings { rows: Vec::new(), columns: given.columns.clone() };
        let kept = if keeps { campaign.readings.clone() } else { none() };
        let offer = Offer { kept, candidates: find_candidates(arguments, &campaign)?, noise: noise.clone(), costs };
        if let Some(effects) = &separates {
            let term = |text: &str| term(text, &campaign, arguments.sensor.as_deref());
            let [a, b] = effects;
            let [a, b] = [term(a)?, term(b)?];
            separated = plan::separate(&campaign, &offer, [&a, &b], &request).map_err(located)?;
            better = Some(Better::Apart(&separated, effects));
        } else if arguments.goal.is_empty() && arguments.find.is_empty() {
            improvement = plan::improve(&campaign, &offer, &request).map_err(located)?;
            better = Some(Better::Best(&improvement, &criterion));
        } else {
            let coefficients =
                extras.iter().zip(&coefficients).filter_map(|(extra, name)| Some((extra, name, extra.size?)));
            for (extra, name, size) in coefficients {
                let Some(rule) = foresight.as_ref().map(|foresight| foresight.rule) else { continue };
                let (u, power) = (size / rule.size_for(arguments.power), arguments.power);
                let (effect, coefficient) = (extra.regressor.clone(), name.clone());
                goals.push(Goal { id: name.clone(), u });
                finds.push(FindReport { effect, coefficient, size, power, u });
            }
            // an effect shows beside tilts that are determined: from a degree on these are no small rotations, and nothing that is predicted holds
            let tilts = judgement.parameters.iter().filter(|parameter| parameter.kind == Kind::Tilt);
            let determined = tilts.filter(|parameter| !finds.is_empty() && parameter.u.is_some_and(|u| u < fit::STEEP));
            goals.extend(determined.map(|parameter| Goal { id: parameter.id.clone(), u: fit::STEEP }));
            for goal in parse_goals(&arguments.goal, &campaign)? {
                goals.retain(|other| other.id != goal.id);
                goals.push(goal);
            }
            let search =
                |goals: &[Goal]| plan::reach(&campaign, &offer, &request, goals, arguments.cheapest).map_err(located);
            let needs = |found: &plan::Reached| -> Result<Option<Vec<Option<f64>>>> {
                let Some(bare) = &without else { return Ok(None) };
                let foreseen = foresee(&bare.with_readings(found.improvement.schedule.readings.clone()))?;
                Ok(foreseen.map(|foreseen| shown_from(&foreseen, &extras, arguments.power)))
            };
            reached = find::reach(&mut goals, &mut finds, arguments.cheapest, search, needs)?;
            better = Some(Better::Goal(&reached));
        }
        candidates = Some(offer.candidates);
    }
    bar.finish_and_clear();
    let found = better.as_ref().map(|better| match better {
        Better::Best(improvement, _) => *improvement,
        Better::Goal(reached) => &reached.improvement,
        Better::Apart(separated, _) => &separated.improvement,
    });
    let missed = match &better {
        Some(Better::Goal(reached)) => !reached.goal.reached,
        Some(Better::Apart(separated, _)) => separated.after.iter().any(Option::is_none),
        _ => false,
    };
    let better_foresight = found.map(|improvement| foresee(&improvement.schedule)).transpose()?.flatten();
    let foreseen = Foreseen { given: foresight.as_ref(), better: better_foresight.as_ref() };
    let with_values = asked.is_measured().then(|| campaign.with_readings(asked.readings.clone()));
    let mut report = report::plan_report(
        with_values.as_ref().unwrap_or(&campaign),
        &noise,
        &judgement,
        better,
        foreseen,
        &request,
        &costs,
        &from,
    );
    report.finds = finds;
    if arguments.write.is_some() || arguments.sheet.is_some() {
        let (run, kept) = match found {
            Some(improvement) => (improvement.schedule.readings.clone(), improvement.kept),
            None => {
                // what is measured stays in front as it is
                let (done, open): (Vec<Reading>, Vec<Reading>) =
                    given.rows.iter().cloned().partition(|row| !row.observations.is_empty());
                let fixed = if open.is_empty() { 0 } else { done.len() };
                let rows = done.into_iter().chain(open).collect();
                let half = campaign.with_readings(Readings { rows, columns: given.columns.clone() });
                let whole = campaign.with_readings(plan::planned(&half, &half.readings));
                let run = plan::ordered(&whole, &noise, &costs, request.order, request.seed, fixed)?;
                let rows = half.readings.rows.iter().take(fixed).chain(run.rows.iter().skip(fixed)).cloned().collect();
                (Readings { rows, ..run }, fixed)
            }
        };
        // the file has the model of the one that was given
        let model = without.as_ref().unwrap_or(&asked);
        let schedule = model.with_readings(to_write(given, run, kept, found.is_some(), &noise));
        if let Some(path) = &arguments.write {
            let file = wire::campaign_file(&schedule, wire::bench_ref(&schedule));
            outputs.add(path, files::marked(&file)?);
        }
        if let Some(path) = &arguments.sheet {
            outputs.add(path, sheet(path, &schedule, &costs, lang)?);
        }
    }
    let document = |page: bool| {
        let drawn = Some((&campaign, candidates.as_ref().filter(|_| page)));
        report::plan_document(&report, drawn, !page && arguments.readings, lang)
    };
    arguments.pages.finish(outputs, &report, document)?;
    let defect = match found {
        Some(improvement) => !improvement.judgement.not_estimable.is_empty() || !improvement.unreachable.is_empty(),
        None => !judgement.not_estimable.is_empty() || judgement.lacking.is_some(),
    };
    Ok(if defect || missed { Outcome::Rejected } else { Outcome::Done })
}

/// A run sheet in the format that its name ends in.
fn sheet(path: &Path, schedule: &Campaign, costs: &Costs, lang: Language) -> Result<Vec<u8>> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "csv" => Ok(report::sheet_csv(schedule).into_bytes()),
        "html" => Ok(html::render(&report::sheet_document(schedule, costs, lang))?.into_bytes()),
        "xlsx" => workbook(&report::sheet_document(schedule, costs, lang)),
        _ => Err(Malformed::new(Fault::Value, "a run sheet is written as a page, a workbook or a table")
            .expected("a name that ends in .html, .xlsx or .csv")
            .found(format!("'{}'", path.display()))),
    }
}

/// What a written schedule has: the first `kept` rows as they were, values and all, the others without values. Beside values an uncertainty alone
/// would be read as one without its value, so it is left out there. Noise that was given stands at every row of a schedule without values, for what is promised holds where
/// it is known, and a sensor's readings all state their uncertainty or none does.
fn to_write(asked: &Readings, run: Readings, kept: usize, in_order: bool, noise: &Noise) -> Readings {
    let measured = asked.rows.iter().any(|row| !row.observations.is_empty()) && kept > 0;
    let row = |(k, row): (usize, &Reading)| {
        let mut row = match asked.rows.get(k).filter(|_| k < kept && in_order) {
            Some(schedule) => schedule.clone(),
            None if k < kept => row.clone(),
            None => row.unread(),
        };
        if measured && k >= kept {
            row.planned_u = Shared::default();
        }
        if !measured {
            let given = noise.sensors.iter().enumerate().filter(|(_, own)| own.from == NoiseSource::Given);
            let mut planned_u = row.planned_u.to_vec();
            for (sensor, _) in given {
                planned_u.retain(|(other, _)| *other != sensor);
                planned_u.push((sensor, noise.u(&row, sensor)));
            }
            planned_u.sort_by_key(|(sensor, _)| *sensor);
            row.planned_u = planned_u.into();
        }
        row
    };
    Readings { rows: run.rows.iter().enumerate().map(row).collect(), columns: run.columns.clone() }
}
