//! `tumble plan SCHEDULE`.

use super::outputs::Outputs;
use super::{Outcome, files};
use crate::campaign::{Campaign, Kind, Reading, Readings};
use crate::diagnosis;
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Fit};
use crate::plan::{
    self, Costs, Criterion, Goal, Judgement, Method, Noise, Offer, Order, Progress, Request, Term, Unit, Zone,
};
use crate::report::{self, Better, Foreseen};
use crate::simulate::Regressor;
use crate::wire;
use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use std::path::PathBuf;

/// What to judge, what to look for and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The schedule, or a campaign whose values play no part (but tell the noise).
    schedule: PathBuf,
    /// Standard deviation of one sample of a sensor, in its unit: V=9e-4 (a reading with n samples has it over the root of n). Repeat for each
    /// sensor.
    #[arg(long, value_name = "SENSOR=SD")]
    noise: Vec<String>,
    /// A tilt that every remounting scatters, with the standard deviation in arcsec: dtheta_y2=0.5.
    #[arg(long, value_name = "TILT=ARCSEC")]
    remount: Vec<String>,
    /// Expected size of the tilts in arcsec: known scale factors act through them, and no reading tells their size yet.
    #[arg(long, value_name = "ARCSEC", allow_negative_numbers = true)]
    tilts: Option<f64>,
    /// Judge at this value of an estimated parameter (arcsec for a tilt): K=1.3. Else at what the readings say, its start, its prior, or zero.
    #[arg(long, value_name = "NAME=VALUE")]
    at: Vec<String>,
    /// A catalogue of your own effects, tried beside the built-in ones (`tumble schema effects` has its form).
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// Find the best schedule of so many readings that costs no more than the given one does for as many (--budget: another limit).
    #[arg(long, value_name = "N", conflicts_with_all = ["add", "goal"])]
    choose: Option<usize>,
    /// With --choose: whatever it costs.
    #[arg(long, requires = "choose", conflicts_with = "budget")]
    any_cost: bool,
    /// Keep the schedule and find the best so many readings to add.
    #[arg(long, value_name = "N", conflicts_with = "goal")]
    add: Option<usize>,
    /// Keep the schedule and find the positions to add (2, or --add N) that tell two effects apart: a_S a_S^2, or tilt:dtheta_z1 a_S.
    #[arg(long, num_args = 2, value_names = ["EFFECT", "EFFECT"], conflicts_with_all = ["choose", "goal", "budget"])]
    separate: Vec<String>,
    /// With --separate: the sensor that may have the effects, where the bench has several.
    #[arg(long, value_name = "SENSOR", requires = "separate")]
    sensor: Option<String>,
    /// Find the fewest readings for a standard uncertainty: 1 (arcsec, every estimated angle), dtheta_y2=0.5 or gamma=1 for a derived angle
    /// (arcsec; its unit for a coefficient).
    #[arg(long, value_name = "[NAME=]U", group = "searched")]
    goal: Vec<String>,
    /// Find the best schedule that costs no more than this, with the costs of --cost.
    #[arg(long, value_name = "COST", group = "searched", conflicts_with = "add", allow_negative_numbers = true)]
    budget: Option<f64>,
    /// With --goal or --budget: keep the schedule and add to it.
    #[arg(long, requires = "searched")]
    keep: bool,
    /// With --goal: the cheapest schedule that is found, instead of the fewest readings.
    #[arg(long, requires = "goal")]
    cheapest: bool,
    /// With --goal: the most readings that may be chosen.
    #[arg(long, value_name = "N", default_value_t = 600)]
    most: usize,
    /// D (volume of the confidence ellipsoid), A (sum of the angles' variances), G (largest predicted reading), I (mean of the predicted
    /// readings), or a quantity: dtheta_z2, gamma.
    #[arg(long, value_name = "D|A|G|I|NAME", default_value = "D")]
    criterion: String,
    /// Portions in which readings are chosen: single readings, both senses of a rate, all rates of a mounting.
    #[arg(long, value_enum, default_value_t = UnitArgument::Reading)]
    unit: UnitArgument,
    /// A schedule whose positions are the candidates (its lists sweep joints and rates); a sweep of the bench unless given.
    #[arg(long, value_name = "FILE")]
    candidates: Option<PathBuf>,
    /// Step of the sweep over joints that stand still.
    #[arg(long, value_name = "DEG", default_value_t = 45.0, allow_negative_numbers = true)]
    step: f64,
    /// A zone that no candidate may lie in: alpha_deg=100:170 or alpha_deg=100:170,beta_deg=0:90 (both at once).
    #[arg(long, value_name = "ZONE")]
    forbid: Vec<String>,
    /// How often one portion may be chosen.
    #[arg(long, value_name = "N")]
    repeats: Option<usize>,
    /// Fedorov exchange, or coordinate exchange for very many candidates.
    #[arg(long, value_enum, default_value_t = MethodArgument::Fedorov)]
    method: MethodArgument,
    /// Costs: mounting=10, rate=1, reading=1.
    #[arg(long, value_name = "WHAT=COST")]
    cost: Vec<String>,
    /// Starts of the exchange.
    #[arg(long, value_name = "N", default_value_t = 100)]
    starts: usize,
    /// Seed; the same seed gives the same schedule.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Order of the schedule found.
    #[arg(long, value_enum, default_value_t = OrderArgument::Abba)]
    order: OrderArgument,
    /// Write the schedule found (or, without a search, the given one in that order) as a campaign file.
    #[arg(short, long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Write the report as JSON to a file, or to stdout with '-'.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the report as one HTML page with a picture of the positions.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Also list every value with its leverage and minimal detectable bias.
    #[arg(long)]
    readings: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum UnitArgument {
    Reading,
    Pair,
    Mounting,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MethodArgument {
    Fedorov,
    Coordinate,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum OrderArgument {
    Given,
    Abba,
    Random,
}

/// Positions that are added to tell two effects apart.
const ADDED: usize = 2;
/// More starts than this are a slip of the keyboard; the effort that they may take is limited besides.
const MOST_STARTS: usize = 1_000_000;
/// With more values than this, what a diagnosis could find is not foreseen.
const MOST_FORESEEN: usize = 100_000;
/// More readings than this are not chosen.
const MOST_READINGS: usize = 100_000;

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (campaign, source) = files::campaign(&arguments.schedule)?;
    let (html, json) = (arguments.html.as_deref(), arguments.json.as_deref());
    let mut outputs = Outputs::plan([arguments.write.as_deref(), html, json])?;
    // an option has no place in the file
    let located = |error: Malformed| match error.place().path.is_empty() {
        true => error,
        false => wire::locate(error, &source),
    };
    let asked = campaign;
    let fitted = match asked.is_measured() {
        true => fit::fit(&asked, &fit::Settings::default()).ok(),
        false => None,
    };
    let plan::Judged { campaign, from } = plan::judged_at(&asked, &point(&arguments.at, &asked)?, fitted.as_ref())?;
    let noise = noise(arguments, &campaign, fitted.as_ref()).map_err(located)?;
    let costs = costs(&arguments.cost)?;
    let positions = plan::positions_only(&campaign.readings);
    let campaign = campaign.with_readings(plan::planned(&campaign, &campaign.readings));
    let judgement = plan::judge(&campaign, &noise, &costs).map_err(located)?;
    let bar = ProgressBar::new_spinner();
    let request = request(arguments, &judgement, &bar)?;
    let catalogue = super::diagnose::catalogue(arguments.effects.as_deref())?;
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
    let anew = arguments.choose.is_some() || arguments.budget.is_some() || !arguments.goal.is_empty();
    let mut candidates = None;
    let (mut best, mut reached, mut separated, mut goals) = (None, None, None, Vec::new());
    if anew || arguments.add.is_some() || separates.is_some() {
        let keeps = !anew || arguments.keep;
        let kept = if keeps { campaign.readings.clone() } else { Readings { rows: Vec::new(), ..positions } };
        let offer = Offer { kept, candidates: find_candidates(arguments, &campaign)?, noise: noise.clone(), costs };
        if let Some(effects) = &separates {
            let [a, b] = terms(effects, &campaign, arguments.sensor.as_deref())?;
            separated = Some(plan::separate(&campaign, &offer, [&a, &b], &request).map_err(located)?);
        } else if arguments.goal.is_empty() {
            best = Some(plan::improve(&campaign, &offer, &request).map_err(located)?);
        } else {
            goals = parse_goals(&arguments.goal, &campaign)?;
            reached = Some(plan::reach(&campaign, &offer, &request, &goals, arguments.cheapest).map_err(located)?);
        }
        candidates = Some(offer.candidates);
    }
    bar.finish_and_clear();
    let criterion = criterion_name(&request.criterion);
    let better = match (&best, &reached, separated.as_ref().zip(separates.as_ref())) {
        (Some(improvement), ..) => Some(Better::Best(improvement, &criterion)),
        (_, Some(reached), _) => Some(Better::Goal(reached, &goals)),
        (_, _, Some((separated, effects))) => Some(Better::Apart(separated, effects)),
        _ => None,
    };
    let found = match better {
        Some(Better::Best(improvement, _)) => Some(improvement),
        Some(Better::Goal(reached, _)) => Some(&reached.improvement),
        Some(Better::Apart(separated, _)) => Some(&separated.improvement),
        None => None,
    };
    let better_foresight = found.map(|improvement| foresee(&improvement.schedule)).transpose()?.flatten();
    let foreseen = Foreseen { given: foresight.as_ref(), better: better_foresight.as_ref() };
    let report = report::plan_report(
        &asked_at(&campaign, &asked),
        &noise,
        &judgement,
        better,
        foreseen,
        &request,
        &costs,
        &from,
    );
    if let Some(path) = &arguments.write {
        let (run, kept) = match found {
            Some(improvement) => (improvement.schedule.readings.clone(), improvement.kept),
            None => {
                // what is measured stays in front as it is
                let (done, rest): (Vec<Reading>, Vec<Reading>) =
                    asked.readings.rows.iter().cloned().partition(|row| !row.observations.is_empty());
                let fixed = if rest.is_empty() { 0 } else { done.len() };
                let rows = done.into_iter().chain(rest).collect();
                let half = campaign.with_readings(Readings { rows, ..asked.readings.clone() });
                let whole = campaign.with_readings(plan::planned(&half, &half.readings));
                let run = plan::ordered(&whole, &noise, &costs, request.order, request.seed, fixed)?;
                (
                    Readings {
                        rows: half
                            .readings
                            .rows
                            .iter()
                            .take(fixed)
                            .chain(run.rows.iter().skip(fixed))
                            .cloned()
                            .collect(),
                        ..run
                    },
                    fixed,
                )
            }
        };
        let schedule = asked.with_readings(to_write(&asked.readings, run, kept, found.is_some()));
        let file = wire::campaign_file(&schedule, wire::bench_ref(&schedule));
        outputs.add(path, files::json(&file)?);
    }
    if let Some(path) = &arguments.html {
        let page = report::html::plan_page(&campaign, &report, candidates.as_ref())?;
        outputs.add(path, report::html::render(&page)?);
    }
    if let Some(path) = &arguments.json {
        outputs.add(path, files::json(&report)?);
    }
    let to_stdout = outputs.to_stdout();
    outputs.write()?;
    if !to_stdout {
        super::print(&report::plan_table(&report, arguments.readings))?;
    }
    let defect = match found {
        Some(improvement) => !improvement.judgement.not_estimable.is_empty() || !improvement.unreachable.is_empty(),
        None => !judgement.not_estimable.is_empty() || judgement.lacking.is_some(),
    };
    let apart = separated.is_none_or(|s| s.after.iter().all(Option::is_some));
    Ok(if defect || !apart || reached.is_some_and(|r| !r.reached) { Outcome::Rejected } else { Outcome::Done })
}

/// The campaign at the point of judging with the values that it has.
fn asked_at(judged: &Campaign, asked: &Campaign) -> Campaign {
    judged.with_readings(asked.readings.clone())
}

/// What a written schedule has: the first `kept` rows as they were, values and all, the others without values. Beside values an uncertainty alone
/// would be read as one without its value, so it is left out there.
fn to_write(asked: &Readings, run: Readings, kept: usize, in_order: bool) -> Readings {
    let measured = asked.rows.iter().any(|row| !row.observations.is_empty()) && kept > 0;
    let row = |(k, row): (usize, &Reading)| match asked.rows.get(k).filter(|_| k < kept && in_order) {
        Some(own) => own.clone(),
        None if k < kept => row.clone(),
        None if measured => Reading { planned_u: Vec::new(), ..row.unread() },
        None => row.unread(),
    };
    Readings { rows: run.rows.iter().enumerate().map(row).collect(), columns: run.columns.clone() }
}

/// The two effects to be told apart.
fn terms(effects: &[String; 2], campaign: &Campaign, sensor: Option<&str>) -> Result<[Term; 2]> {
    let ids: Vec<&str> = campaign.bench.sensors.iter().map(|s| s.id.as_str()).collect();
    let sensor = match (sensor, ids.as_slice()) {
        (Some(id), _) => Some(ids.iter().position(|own| *own == id).ok_or_else(|| {
            Malformed::new(Fault::UnknownName, format!("--sensor names '{id}', which is no sensor here"))
                .expected(format!("one of {}", ids.join(", ")))
                .found(format!("'{id}'"))
        })?),
        (None, [_]) => Some(0),
        (None, _) => None,
    };
    let term = |text: &String| {
        let regressor = Regressor::parse(campaign, sensor, text)?;
        let common = matches!(regressor, Regressor::Tilt(_) | Regressor::Known(_));
        if sensor.is_none() && !common {
            let what = format!("'{text}' belongs to one sensor, and there are {}", ids.len());
            return Err(
                Malformed::new(Fault::Missing, what).expected(format!("--sensor with one of {}", ids.join(", ")))
            );
        }
        Ok(Term { sensor: sensor.filter(|_| !common), regressor })
    };
    let [a, b] = effects;
    Ok([term(a)?, term(b)?])
}

fn find_candidates(arguments: &Arguments, campaign: &Campaign) -> Result<Readings> {
    let candidates = match &arguments.candidates {
        None => plan::sweep(campaign, arguments.step)?,
        Some(path) => {
            let (other, source) = files::campaign(path)?;
            let located = |error| wire::locate(error, &source);
            let candidates = plan::from_schedule(campaign, &other).map_err(located)?;
            if candidates.rows.is_empty() {
                let error = Malformed::new(Fault::Missing, "there are no candidate positions");
                return Err(located(error.expected("at least one position to choose from").at_path("readings")));
            }
            candidates
        }
    };
    let zones = arguments.forbid.iter().map(|text| zone(text)).collect::<Result<Vec<Zone>>>()?;
    plan::without(campaign, candidates, &zones)
}

fn request(arguments: &Arguments, given: &Judgement, bar: &ProgressBar) -> Result<Request> {
    if arguments.starts == 0 || arguments.starts > MOST_STARTS {
        return Err(Malformed::new(Fault::Value, "the number of starts is not possible")
            .expected(format!("1 to {MOST_STARTS}"))
            .found(arguments.starts.to_string()));
    }
    let wanted = arguments.choose.or(arguments.add);
    let counts = |k: usize| {
        if k == 0 || k > MOST_READINGS {
            return Err(Malformed::new(Fault::Value, "so many readings cannot be planned")
                .expected(format!("a positive number, at most {MOST_READINGS}"))
                .found(k.to_string()));
        }
        Ok(k)
    };
    let readings = match wanted {
        Some(k) => counts(k)?,
        None if arguments.budget.is_some() => 0,
        None if arguments.separate.is_empty() => counts(arguments.most)?,
        None => ADDED,
    };
    // costs count: as many readings as the given schedule has cost no more than it does
    let work = given.work;
    let own = work.cost * (readings as f64 / work.readings.max(1) as f64).max(1.0);
    let limit = arguments.choose.filter(|_| !arguments.any_cost && own > 0.0).map(|_| own);
    let spinner = bar.clone();
    Ok(Request {
        readings,
        budget: arguments.budget.or(limit),
        may_cost_more: arguments.budget.is_none(),
        progress: Progress::new(move |what, done, of| {
            spinner.set_message(format!("searching: {done} of {of} {what}"));
            spinner.tick();
        }),
        criterion: match arguments.criterion.as_str() {
            "D" | "d" => Criterion::D,
            "A" | "a" => Criterion::A,
            "G" | "g" => Criterion::G,
            "I" | "i" => Criterion::I,
            name => Criterion::C(name.to_string()),
        },
        unit: match arguments.unit {
            UnitArgument::Reading => Unit::Reading,
            UnitArgument::Pair => Unit::Pair,
            UnitArgument::Mounting => Unit::Mounting,
        },
        method: match arguments.method {
            MethodArgument::Fedorov => Method::Fedorov,
            MethodArgument::Coordinate => Method::Coordinate,
        },
        most_repeats: arguments.repeats.unwrap_or(usize::MAX),
        starts: arguments.starts,
        seed: arguments.seed,
        order: match arguments.order {
            OrderArgument::Given => Order::AsGiven,
            OrderArgument::Abba => Order::Abba,
            OrderArgument::Random => Order::Random,
        },
    })
}

fn criterion_name(criterion: &Criterion) -> String {
    match criterion {
        Criterion::D => "D".into(),
        Criterion::A => "A".into(),
        Criterion::G => "G".into(),
        Criterion::I => "I".into(),
        Criterion::C(id) => format!("c:{id}"),
    }
}

/// `NAME=NUMBER`.
fn named_number(text: &str, option: &str, example: &str) -> Result<(String, f64)> {
    let parts = text.split_once('=').map(|(name, value)| (name.trim(), value.trim().parse::<f64>()));
    match parts {
        Some((name, Ok(value))) if !name.is_empty() => Ok((name.to_string(), value)),
        _ => Err(Malformed::new(Fault::Syntax, format!("{option} is not understood"))
            .expected(format!("NAME=NUMBER, for example {example}"))
            .found(format!("'{text}'"))),
    }
}

/// `NAME=VALUE`, arcseconds for a tilt.
fn point(given: &[String], campaign: &Campaign) -> Result<Vec<(String, f64)>> {
    let one = |text: &String| {
        let (id, value) = named_number(text, "--at", "K=1.3")?;
        let tilt = campaign.parameters.iter().any(|p| p.id == id && p.kind == Kind::Tilt);
        Ok((id, if tilt { value / report::ARCSEC } else { value }))
    };
    given.iter().map(one).collect()
}

fn noise(arguments: &Arguments, campaign: &Campaign, fitted: Option<&Fit>) -> Result<Noise> {
    let given: Vec<(String, f64)> =
        arguments.noise.iter().map(|text| named_number(text, "--noise", "V=9e-4")).collect::<Result<_>>()?;
    let mut remount = Vec::new();
    for text in &arguments.remount {
        let (id, sd) = named_number(text, "--remount", "dtheta_y2=0.5")?;
        let is_tilt = campaign.parameters.iter().any(|p| p.id == id && p.kind == Kind::Tilt);
        remount.push((id, if is_tilt { sd / report::ARCSEC } else { sd }));
    }
    let tilts = arguments.tilts.map(|arcsec| match arcsec >= 0.0 && arcsec.is_finite() {
        true => Ok(arcsec / report::ARCSEC),
        false => Err(Malformed::new(Fault::Value, "the expected size of the tilts is not possible")
            .expected("arcseconds, zero or more")
            .found(arcsec.to_string())),
    });
    Ok(Noise { tilts: tilts.transpose()?, ..Noise::with_fit(campaign, &given, &remount, fitted)? })
}

fn costs(given: &[String]) -> Result<Costs> {
    let mut costs = Costs::default();
    for text in given {
        let (what, cost) = named_number(text, "--cost", "mounting=10")?;
        match what.as_str() {
            "reading" => costs.reading = cost,
            "rate" => costs.rate_change = cost,
            "mounting" => costs.mounting = cost,
            _ => {
                return Err(Malformed::new(Fault::UnknownName, format!("'{what}' has no cost here"))
                    .expected("one of mounting, rate, reading")
                    .found(format!("'{what}'")));
            }
        }
    }
    costs.check()?;
    Ok(costs)
}

/// `1` for every angle, or `NAME=U`; arcseconds for tilts.
fn parse_goals(given: &[String], campaign: &Campaign) -> Result<Vec<Goal>> {
    let mut goals: Vec<Goal> = Vec::new();
    for text in given {
        let fresh: Vec<Goal> = match text.trim().parse::<f64>() {
            Ok(arcsec) => {
                let tilts = campaign.estimated().iter().filter(|p| p.kind == Kind::Tilt);
                tilts.map(|p| Goal { id: p.id.clone(), u: arcsec / report::ARCSEC }).collect()
            }
            Err(_) => {
                let (id, u) = named_number(text, "--goal", "1 (arcsec, every angle) or dtheta_y2=0.5")?;
                vec![Goal { u: if plan::is_angle(campaign, &id) { u / report::ARCSEC } else { u }, id }]
            }
        };
        // a later goal for one parameter replaces the general one
        for goal in fresh {
            goals.retain(|other| other.id != goal.id);
            goals.push(goal);
        }
    }
    Ok(goals)
}

/// `alpha_deg=100:170,beta_deg=0:90`.
fn zone(text: &str) -> Result<Zone> {
    let limit = |part: &str| -> Option<(String, f64, f64)> {
        let (key, interval) = part.split_once('=')?;
        let (low, high) = interval.split_once(':')?;
        Some((key.trim().to_string(), low.trim().parse().ok()?, high.trim().parse().ok()?))
    };
    let limits: Option<Vec<_>> = text.split(',').map(limit).collect();
    limits.map(|limits| Zone { limits }).ok_or_else(|| {
        Malformed::new(Fault::Syntax, "--forbid is not understood")
            .expected("KEY=LOW:HIGH, for example alpha_deg=100:170 or alpha_deg=100:170,beta_deg=0:90")
            .found(format!("'{text}'"))
    })
}
