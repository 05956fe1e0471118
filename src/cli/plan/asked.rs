//! Options of `tumble plan` in the terms of the library.

use super::super::files;
use super::arguments::Arguments;
use crate::campaign::{Campaign, Kind, Readings};
use crate::error::{Fault, Malformed, Result, probability};
use crate::fit::Fit;
use crate::plan::{self, Costs, Criterion, Goal, Judgement, Noise, Progress, Refinement, Request, Term, Zone};
use crate::report;
use crate::simulate::Regressor;
use crate::wire;
use indicatif::ProgressBar;

/// Positions that are added to discriminate two effects.
const ADDED: usize = 2;
/// More starts than this are a slip of the keyboard; the effort that they may take is limited besides.
const MOST_STARTS: usize = 1_000_000;
/// More readings than this are not chosen.
const MOST_READINGS: usize = 100_000;

/// An effect as reports write it, of the sensor that is named or the only one.
pub(super) fn term(text: &str, campaign: &Campaign, sensor: Option<&str>) -> Result<Term> {
    let ids: Vec<&str> = campaign.bench.sensors.iter().map(|s| s.id.as_str()).collect();
    let sensor = match (sensor, ids.as_slice()) {
        (Some(id), _) => Some(ids.iter().position(|known| *known == id).ok_or_else(|| {
            Malformed::unknown(format!("--sensor names '{id}', which is not a sensor here"), id, &ids)
        })?),
        (None, [_]) => Some(0),
        (None, _) => None,
    };
    let regressor = Regressor::parse(campaign, sensor, text)?;
    let common = matches!(regressor, Regressor::Tilt(_) | Regressor::Known(_));
    if sensor.is_none() && !common {
        let what = format!("'{text}' belongs to one sensor, and there are {}", ids.len());
        return Err(Malformed::new(Fault::Missing, what).expected(format!("--sensor with one of {}", ids.join(", "))));
    }
    Ok(Term { sensor: sensor.filter(|_| !common), regressor })
}

/// An effect that becomes an unknown of the plan.
pub(super) struct Extra {
    pub term: Term,
    pub regressor: String,
    /// The size that must be found, radians for tilts; `None` for one that is only kept apart.
    pub size: Option<f64>,
}

pub(super) fn extras(arguments: &Arguments, campaign: &Campaign) -> Result<Vec<Extra>> {
    let sensor = arguments.sensor.as_deref();
    let mut extras = Vec::new();
    for text in &arguments.find {
        let (regressor, size) = named_number(text, "--find", "a_S=1e-3")?;
        if !(size > 0.0 && size.is_finite()) {
            return Err(Malformed::new(Fault::Value, format!("the size of {regressor} to be detected is not valid"))
                .expected("a positive number, in the unit of its coefficient (arcsec for a tilt)")
                .found(size.to_string()));
        }
        let term = term(&regressor, campaign, sensor)?;
        let size = if matches!(term.regressor, Regressor::Tilt(_)) { size / report::ARCSEC } else { size };
        extras.push(Extra { term, regressor, size: Some(size) });
    }
    for text in &arguments.beside {
        extras.push(Extra { term: term(text, campaign, sensor)?, regressor: text.clone(), size: None });
    }
    probability("power", arguments.power, "0.9")?;
    Ok(extras)
}

pub(super) fn find_candidates(arguments: &Arguments, campaign: &Campaign) -> Result<Readings> {
    let candidates = match &arguments.candidates {
        None => plan::sweep_with_rates(campaign, arguments.step, &arguments.rates)?,
        Some(path) => {
            let (other, source, _) = files::campaign(path)?;
            let located = |error| wire::locate(error, &source);
            let candidates = plan::from_schedule(campaign, &other).map_err(located)?;
            if candidates.rows.is_empty() {
                let error = Malformed::new(Fault::Missing, "there are no candidate positions");
                return Err(located(error.expected("at least one position to choose from").at_path("readings")));
            }
            candidates
        }
    };
    plan::without(campaign, candidates, &zones(arguments)?)
}

fn zones(arguments: &Arguments) -> Result<Vec<Zone>> {
    arguments.forbid.iter().map(|text| zone(text)).collect()
}

pub(super) fn request(arguments: &Arguments, given: &Judgement, bar: &ProgressBar) -> Result<Request> {
    if arguments.starts == 0 || arguments.starts > MOST_STARTS {
        return Err(Malformed::new(Fault::Value, "the number of starts is not valid")
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
    // costs count: no more than the given schedule, in proportion for more readings than it has
    let work = given.work;
    let cost = work.cost * (readings as f64 / work.readings.max(1) as f64).max(1.0);
    let limit = arguments.choose.filter(|_| !arguments.any_cost && cost > 0.0).map(|_| cost);
    let spinner = bar.clone();
    Ok(Request {
        readings,
        budget: arguments.budget.or(limit),
        may_cost_more: arguments.budget.is_none(),
        progress: Progress::new(move |what, done, of| {
            spinner.set_message(format!("searching: {done} of {of} {what}"));
            spinner.tick();
        }),
        criterion: criterion(&arguments.criterion),
        unit: arguments.unit,
        method: arguments.method,
        most_repeats: arguments.repeats.unwrap_or(usize::MAX),
        starts: arguments.starts,
        seed: arguments.seed,
        refine: match arguments.refine {
            Some(resolution_deg) => Some(Refinement { resolution_deg, zones: zones(arguments)? }),
            None => None,
        },
        order: arguments.order,
    })
}

/// Criteria of all unknowns.
const CRITERIA: [(&str, Criterion); 5] =
    [("D", Criterion::D), ("A", Criterion::A), ("G", Criterion::G), ("I", Criterion::I), ("E", Criterion::E)];

/// One of these in either case, or that of a quantity.
fn criterion(text: &str) -> Criterion {
    let named = CRITERIA.into_iter().find(|(name, _)| name.eq_ignore_ascii_case(text));
    named.map_or_else(|| Criterion::C(text.to_string()), |(_, criterion)| criterion)
}

pub(super) fn criterion_name(criterion: &Criterion) -> String {
    match criterion {
        Criterion::C(id) => format!("c:{id}"),
        other => CRITERIA.iter().find(|(_, criterion)| criterion == other).map_or("", |(name, _)| name).to_string(),
    }
}

pub(in crate::cli) fn named_number(text: &str, option: &str, example: &str) -> Result<(String, f64)> {
    let parts = text.split_once('=').map(|(name, value)| (name.trim(), value.trim().parse::<f64>()));
    match parts {
        Some((name, Ok(value))) if !name.is_empty() => Ok((name.to_string(), value)),
        _ => Err(Malformed::new(Fault::Syntax, format!("{option} is not understood"))
            .expected(format!("NAME=NUMBER, for example {example}"))
            .found(format!("'{text}'"))),
    }
}

/// `NAME=VALUE` of each: a tilt's value in arcseconds, or another parameter's in its own unit.
pub(super) fn values(given: &[String], option: &str, example: &str, campaign: &Campaign) -> Result<Vec<(String, f64)>> {
    let one = |text: &String| {
        let (id, value) = named_number(text, option, example)?;
        let is_tilt = campaign.parameters.iter().any(|p| p.id == id && p.kind == Kind::Tilt);
        Ok((id, if is_tilt { value / report::ARCSEC } else { value }))
    };
    given.iter().map(one).collect()
}

pub(super) fn noise(arguments: &Arguments, campaign: &Campaign, fitted: Option<&Fit>) -> Result<Noise> {
    let given: Vec<(String, f64)> =
        arguments.noise.iter().map(|text| named_number(text, "--noise", "V=9e-4")).collect::<Result<_>>()?;
    let remount = values(&arguments.remount, "--remount", "dtheta_y2=0.5", campaign)?;
    let tilts = arguments.tilts.map(|arcsec| match arcsec >= 0.0 && arcsec.is_finite() {
        true => Ok(arcsec / report::ARCSEC),
        false => Err(Malformed::new(Fault::Value, "the expected size of the tilts is not valid")
            .expected("arcseconds, zero or more")
            .found(arcsec.to_string())),
    });
    Ok(Noise { tilts: tilts.transpose()?, ..Noise::with_fit(campaign, &given, &remount, fitted)? })
}

pub(in crate::cli) fn costs(given: &[String]) -> Result<Costs> {
    let mut costs = Costs::default();
    let mut soak = 0.0;
    for text in given {
        let (what, cost) = named_number(text, "--cost", "mounting=10")?;
        match what.as_str() {
            "reading" => costs.reading = cost,
            "rate" => costs.rate_change = cost,
            "mounting" => costs.mounting = cost,
            "soak" => soak = cost,
            "degree" => costs.index = cost,
            _ => {
                return Err(Malformed::new(Fault::UnknownName, format!("'{what}' has no cost here"))
                    .expected("one of mounting, rate, reading, soak, degree")
                    .found(format!("'{what}'")));
            }
        }
    }
    // the wait comes with every mounting
    costs.mounting += soak;
    costs.check()?;
    Ok(costs)
}

/// `1` for every angle, or `NAME=U`; arcseconds for tilts.
pub(in crate::cli) fn parse_goals(given: &[String], campaign: &Campaign) -> Result<Vec<Goal>> {
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
