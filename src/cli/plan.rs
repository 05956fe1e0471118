//! `tumble plan SCHEDULE`.

use super::{Outcome, files, simulate};
use crate::campaign::{Campaign, Kind, Reading, Readings};
use crate::error::{Fault, Malformed, Result};
use crate::plan::{self, Costs, Criterion, Goal, Method, Noise, Offer, Order, Request, Unit, Zone};
use crate::report::{self, Better};
use crate::wire;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What to judge, what to look for and what to write.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The schedule, or a campaign whose values play no part (but tell the noise).
    schedule: PathBuf,
    /// Standard deviation of one reading of a sensor, in its unit: V=9e-4. Repeat for each sensor.
    #[arg(long, value_name = "SENSOR=SD")]
    noise: Vec<String>,
    /// A tilt that every remounting scatters, with the standard deviation in arcsec: dtheta_y2=0.5.
    #[arg(long, value_name = "TILT=ARCSEC")]
    remount: Vec<String>,
    /// Find the best schedule of so many readings.
    #[arg(long, value_name = "N", conflicts_with_all = ["add", "goal"])]
    choose: Option<usize>,
    /// Keep the schedule and find the best so many readings to add.
    #[arg(long, value_name = "N", conflicts_with = "goal")]
    add: Option<usize>,
    /// Find the fewest readings for a standard uncertainty: 1 (arcsec, every angle), or dtheta_y2=0.5 (arcsec; its unit for a coefficient).
    #[arg(long, value_name = "[NAME=]U")]
    goal: Vec<String>,
    /// With --goal: keep the schedule and add to it.
    #[arg(long, requires = "goal")]
    keep: bool,
    /// With --goal: the cheapest schedule instead of the fewest readings.
    #[arg(long, requires = "goal")]
    cheapest: bool,
    /// With --goal: the most readings that may be chosen.
    #[arg(long, value_name = "N", default_value_t = 600)]
    most: usize,
    /// D (volume of the confidence ellipsoid), A (sum of the angles' variances), G (largest predicted reading), or a quantity: dtheta_z2.
    #[arg(long, value_name = "D|A|G|NAME", default_value = "D")]
    criterion: String,
    /// Portions in which readings are chosen: single readings, both senses of a rate, all rates of a mounting.
    #[arg(long, value_enum, default_value_t = UnitArgument::Reading)]
    unit: UnitArgument,
    /// A schedule whose positions are the candidates (its lists sweep joints and rates); a sweep of the bench unless given.
    #[arg(long, value_name = "FILE")]
    candidates: Option<PathBuf>,
    /// Step of the sweep over joints that stand still.
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
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

/// More starts than this are a slip of the keyboard.
const MOST_STARTS: usize = 1_000_000;

pub(super) fn run(arguments: &Arguments) -> Result<Outcome> {
    let (campaign, source) = files::campaign(&arguments.schedule)?;
    let located = |error| wire::locate(error, &source);
    let noise = noise(arguments, &campaign).map_err(located)?;
    let costs = costs(&arguments.cost)?;
    let positions = positions_of(&campaign);
    let judgement = plan::judge(&campaign, &noise, &costs).map_err(located)?;
    let request = request(arguments)?;
    let searches = arguments.choose.is_some() || arguments.add.is_some() || !arguments.goal.is_empty();
    let mut candidates = None;
    let (mut best, mut reached, mut goals) = (None, None, Vec::new());
    if searches {
        let keeps = arguments.add.is_some() || arguments.keep;
        let kept = if keeps { campaign.readings.clone() } else { Readings { rows: Vec::new(), ..positions } };
        let offer = Offer { kept, candidates: find_candidates(arguments, &campaign)?, noise: noise.clone(), costs };
        if arguments.goal.is_empty() {
            best = Some(plan::improve(&campaign, &offer, &request).map_err(located)?);
        } else {
            goals = parse_goals(&arguments.goal, &campaign)?;
            reached = Some(plan::reach(&campaign, &offer, &request, &goals, arguments.cheapest).map_err(located)?);
        }
        candidates = Some(offer.candidates);
    }
    let criterion = criterion_name(&request.criterion);
    let better = match (&best, &reached) {
        (Some(improvement), _) => Some(Better::Best(improvement, &criterion)),
        (None, Some(reached)) => Some(Better::Goal(reached, &goals)),
        (None, None) => None,
    };
    let report = report::plan_report(&campaign, &noise, &judgement, better, arguments.seed);
    let found = best.as_ref().or(reached.as_ref().map(|r| &r.improvement));
    if let Some(path) = &arguments.write {
        let schedule = match found {
            Some(improvement) => improvement.schedule.clone(),
            None => {
                let unvalued = campaign.with_readings(positions_of(&campaign));
                campaign.with_readings(plan::ordered(&unvalued, &noise, request.order, request.seed)?)
            }
        };
        let file = wire::campaign_file(&schedule, simulate::bench_ref(&schedule));
        files::write_or_print(path, &files::json(&file)?)?;
    }
    if let Some(path) = &arguments.html {
        let page = report::html::plan_page(&campaign, &report, candidates.as_ref())?;
        files::write(path, &report::html::render(&page)?)?;
    }
    if let Some(path) = &arguments.json {
        files::write_or_print(path, &files::json(&report)?)?;
    }
    let to_stdout = |path: &Option<PathBuf>| path.as_deref().is_some_and(|path| path.as_os_str() == "-");
    if !to_stdout(&arguments.json) && !to_stdout(&arguments.write) {
        super::print(&report::plan_table(&report, arguments.readings));
    }
    let defect = match found {
        Some(improvement) => !improvement.judgement.not_estimable.is_empty() || !improvement.unreachable.is_empty(),
        None => !judgement.not_estimable.is_empty(),
    };
    Ok(if defect || reached.is_some_and(|r| !r.reached) { Outcome::Rejected } else { Outcome::Done })
}

/// The campaign's positions without its values.
fn positions_of(campaign: &Campaign) -> Readings {
    let rows = campaign.readings.rows.iter();
    let rows = rows.map(|reading| Reading { observations: Vec::new(), ..reading.clone() }).collect();
    Readings { columns: campaign.readings.columns.clone(), rows }
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

fn request(arguments: &Arguments) -> Result<Request> {
    if arguments.starts == 0 || arguments.starts > MOST_STARTS {
        return Err(Malformed::new(Fault::Value, "the number of starts is not possible")
            .expected(format!("1 to {MOST_STARTS}"))
            .found(arguments.starts.to_string()));
    }
    Ok(Request {
        readings: arguments.choose.or(arguments.add).unwrap_or(arguments.most),
        criterion: match arguments.criterion.as_str() {
            "D" | "d" => Criterion::D,
            "A" | "a" => Criterion::A,
            "G" | "g" => Criterion::G,
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

fn noise(arguments: &Arguments, campaign: &Campaign) -> Result<Noise> {
    let given: Vec<(String, f64)> =
        arguments.noise.iter().map(|text| named_number(text, "--noise", "V=9e-4")).collect::<Result<_>>()?;
    let mut remount = Vec::new();
    for text in &arguments.remount {
        let (id, sd) = named_number(text, "--remount", "dtheta_y2=0.5")?;
        let is_tilt = campaign.parameters.iter().any(|p| p.id == id && p.kind == Kind::Tilt);
        remount.push((id, if is_tilt { sd / report::ARCSEC } else { sd }));
    }
    Noise::new(campaign, &given, &remount)
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
                let is_tilt = campaign.parameters.iter().any(|p| p.id == id && p.kind == Kind::Tilt);
                vec![Goal { u: if is_tilt { u / report::ARCSEC } else { u }, id }]
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
