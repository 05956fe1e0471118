//! From a judgement and what was found beside it to the report of a plan.

use super::foresight::foresight_report;
use super::plan::*;
use super::separation::not_estimable;
use super::{ARCSEC, VERSION, position_keys};
use crate::campaign::{Campaign, Kind, Per, Reading, Scatter};
use crate::diagnosis::Foresight;
use crate::plan::{Costs, Goal, Improvement, Judgement, Noise, PointSource, Reached, Reason, Request, Separated, Work};
use crate::report::ReportKind;
use std::collections::BTreeMap;

/// What was found beside the judgement of the given schedule.
#[derive(Debug, Clone, Copy)]
pub enum Better<'a> {
    /// The best schedule by a criterion, and the criterion's name.
    Best(&'a Improvement, &'a str),
    /// The schedule that reaches goals.
    Goal(&'a Reached, &'a [Goal]),
    /// The schedule that tells two effects apart.
    Apart(&'a Separated, &'a [String; 2]),
}

/// What a diagnosis could find, of the given schedule and the better one.
#[derive(Debug, Clone, Copy, Default)]
pub struct Foreseen<'a> {
    /// Of the given one.
    pub given: Option<&'a Foresight>,
    /// Of the better one.
    pub better: Option<&'a Foresight>,
}

/// The report of a plan.
#[allow(clippy::too_many_arguments, reason = "each part of the report has its source")]
pub fn plan_report(
    campaign: &Campaign,
    noise: &Noise,
    judgement: &Judgement,
    better: Option<Better<'_>>,
    foreseen: Foreseen<'_>,
    request: &Request,
    costs: &Costs,
    from: &[PointSource],
) -> PlanReport {
    let given = judgement_report(campaign, judgement, foreseen.given);
    let sensors = campaign.bench.sensors.iter();
    let improved = better.map(|better| {
        let (improvement, criterion) = match better {
            Better::Best(improvement, criterion) => (improvement, criterion.to_string()),
            Better::Goal(reached, _) => (&reached.improvement, "goal".to_string()),
            Better::Apart(separated, [a, b]) => (&separated.improvement, format!("T:{a}|{b}")),
        };
        let to_run = to_run(campaign, improvement);
        let own = judgement_report(&improvement.schedule, &improvement.judgement, foreseen.better);
        let budget = request.budget.filter(|_| matches!(better, Better::Best(..)) && !request.may_cost_more);
        let effort = |work: &WorkReport| if budget.is_some() { work.cost } else { work.readings as f64 };
        ImprovedReport {
            criterion,
            budget,
            candidates: improvement.candidates,
            chosen: improvement.chosen,
            kept: improvement.kept,
            to_run: work(costs.work(&to_run)),
            cost_limit: improvement.limit,
            enumerated: improvement.enumerated,
            efficiency: improvement.efficiency,
            bound_gap: improvement.bound_gap,
            refined: improvement.refined.zip(request.refine.as_ref()).map(|(refined, wanted)| RefinedReport {
                resolution_deg: wanted.resolution_deg,
                moved: refined.moved,
                gain: refined.gain,
                finished: refined.finished,
            }),
            starts: improvement.starts,
            hits: improvement.hits,
            seed: request.seed,
            check: improvement.check,
            effort: if budget.is_some() { Effort::Cost } else { Effort::Readings },
            comparison: {
                let times = effort(&own.work) / effort(&given.work).max(f64::MIN_POSITIVE);
                match crate::plan::repeated(campaign, noise, times, costs) {
                    // what positions share does not average out
                    Some(repeated) => comparison(&given, &own, &judgement_report(campaign, &repeated, None), 1.0),
                    None => comparison(&given, &own, &given, times.recip().sqrt()),
                }
            },
            positions: positions(&improvement.schedule, &to_run),
            reasons: improvement.reasons.iter().map(|r| reason(campaign, r)).collect(),
            unreachable: improvement.unreachable.iter().map(|s| not_estimable(campaign, s)).collect(),
            frozen: improvement.frozen.iter().cloned().collect(),
            shared: shared(&improvement.schedule, improvement.kept),
            goal: match better {
                Better::Goal(reached, goals) => Some(goal_report(campaign, reached, goals)),
                Better::Best(..) | Better::Apart(..) => None,
            },
            separation: match better {
                Better::Apart(separated, effects) => {
                    let Separated { before, after, .. } = separated;
                    Some(DiscriminationReport { effects: effects.clone(), before: *before, after: *after })
                }
                Better::Best(..) | Better::Goal(..) => None,
            },
            judgement: own,
        }
    });
    PlanReport {
        tumble: VERSION.into(),
        report: ReportKind::Plan,
        bench: campaign.bench.id.clone(),
        identity: campaign.identity.clone(),
        model: sensors.clone().map(|s| (s.id.clone(), s.model.to_string())).collect(),
        noise: sensors
            .zip(&noise.sensors)
            .map(|(s, n)| (s.id.clone(), SensorNoiseReport { sd: n.sd, unit: s.unit.clone(), from: n.from }))
            .collect(),
        remount: noise
            .remount
            .iter()
            .filter_map(|(k, sd)| Some((campaign.parameters.get(*k)?.id.clone(), *sd)))
            .collect(),
        judged_at: point(campaign, from),
        finds: Vec::new(),
        schedule: given,
        improved,
    }
}

/// The point at which schedules are judged: the campaign's reference point.
/// Columns by which the positions after the first `kept` share deviations, with their values there.
fn shared(schedule: &Campaign, kept: usize) -> Vec<SharedReport> {
    let readings = &schedule.readings;
    let of = |line: &Scatter| {
        let Per::Column(column) = &line.per else { return None };
        let mut levels: Vec<String> = Vec::new();
        for level in readings.rows.iter().skip(kept).filter_map(|row| line.per.level_name(readings, row)) {
            if !levels.iter().any(|own| *own == level) {
                levels.push(level.into_owned());
            }
        }
        (!levels.is_empty()).then(|| SharedReport { line: line.name(schedule), column: column.clone(), levels })
    };
    schedule.scatter.iter().filter_map(of).collect()
}

fn point(campaign: &Campaign, from: &[PointSource]) -> Vec<PointReport> {
    let values = campaign.estimated().iter().zip(from);
    values
        .map(|(p, from)| PointReport {
            id: p.id.clone(),
            value: p.reference(),
            unit: p.unit.clone(),
            arcsec: (p.kind == Kind::Tilt).then(|| p.reference() * ARCSEC),
            from: *from,
        })
        .collect()
}

fn work(work: Work) -> WorkReport {
    WorkReport { readings: work.readings, mountings: work.mountings, rate_changes: work.rate_changes, cost: work.cost }
}

/// With more values than this they are not listed one by one: each takes two kilobytes of a report.
const MOST_LISTED: usize = 20_000;

fn judgement_report(campaign: &Campaign, judgement: &Judgement, foresight: Option<&Foresight>) -> JudgementReport {
    let ids: Vec<String> = judgement.parameters.iter().map(|p| p.id.clone()).collect();
    let n = ids.len();
    let is_tilt: Vec<bool> = judgement.parameters.iter().map(|p| p.kind == Kind::Tilt).collect();
    let fault = |k: usize| {
        let checked = judgement.readings.iter().filter(|r| r.mdb.is_some());
        checked.filter_map(|r| r.effect.get(k)).map(|e| e.abs()).reduce(f64::max)
    };
    let listed = if judgement.readings.len() > MOST_LISTED { 0 } else { judgement.readings.len() };
    JudgementReport {
        unchecked: judgement.readings.iter().filter(|r| r.mdb.is_none()).count(),
        work: work(judgement.work),
        rank: judgement.rank,
        dof: judgement.dof,
        condition: judgement.condition,
        parameters: judgement
            .parameters
            .iter()
            .enumerate()
            .map(|(k, p)| PredictedReport {
                undetected_fault: fault(k),
                undetected_fault_arcsec: fault(k).filter(|_| p.kind == Kind::Tilt).map(|e| e * ARCSEC),
                id: p.id.clone(),
                kind: p.kind,
                unit: p.unit.clone(),
                u: p.u,
                u_arcsec: p.u.filter(|_| p.kind == Kind::Tilt).map(|u| u * ARCSEC),
                from_readings: p.from_readings,
                from_known: p.from_known,
            })
            .collect(),
        derived: judgement
            .derived
            .iter()
            .map(|d| PredictedDerivedReport {
                id: d.id.clone(),
                line: d.line.clone(),
                unit: d.unit.clone(),
                u: d.u,
                u_arcsec: d.u.filter(|_| d.is_angle).map(|u| u * ARCSEC),
                is_largest: d.is_largest,
            })
            .collect(),
        correlation: CorrelationReport {
            matrix: (0..n).map(|i| (0..n).map(|j| judgement.correlation(i, j)).collect()).collect(),
            order: ids.clone(),
        },
        not_estimable: judgement.not_estimable.iter().map(|s| not_estimable(campaign, s)).collect(),
        lacking: judgement.lacking.as_ref().map(|lacking| {
            let names = |list: &[usize]| list.iter().filter_map(|k| ids.get(*k)).cloned().collect();
            LackingReport { untold: names(&lacking.untold), needs: names(&lacking.needs) }
        }),
        bounds_not_counted: judgement.bounds,
        drift: judgement.drift,
        through_tilts: judgement.through_tilts.as_ref().map(|through| {
            let parameter = judgement.parameters.get(through.parameter);
            ThroughTiltsReport {
                tilts_arcsec: through.size * ARCSEC,
                counted: through.counted,
                known: through.known.clone(),
                parameter: campaign.parameter_id(through.parameter).to_string(),
                u: through.u,
                u_arcsec: parameter.filter(|p| p.kind == Kind::Tilt).map(|_| through.u * ARCSEC),
            }
        }),
        effects: foresight.map(|foresight| foresight_report(campaign, foresight)),
        readings: judgement
            .readings
            .iter()
            .take(listed)
            .map(|r| {
                let reading = campaign.readings.rows.get(r.origin.reading);
                let effects = ids.iter().zip(&r.effect).filter(|_| r.mdb.is_some());
                let tilts = effects.clone().zip(&is_tilt).filter(|(_, tilt)| **tilt);
                PlannedReadingReport {
                    index: r.origin.reading + 1,
                    position: campaign.position_of(r.origin.reading).to_string(),
                    at: reading.map(|r| position_keys(campaign, &r.joints)).unwrap_or_default(),
                    sensor: campaign.sensor_id(r.origin.sensor).to_string(),
                    u: r.u,
                    leverage: r.leverage,
                    mdb: r.mdb,
                    effect_arcsec: tilts.map(|((id, e), _)| (id.clone(), e * ARCSEC)).collect(),
                    effect: effects.map(|(id, e)| (id.clone(), *e)).collect(),
                }
            })
            .collect(),
    }
}

/// The readings of a better schedule that have no value yet; `campaign` has the values, of what was kept.
fn to_run(campaign: &Campaign, improvement: &Improvement) -> Vec<Reading> {
    let done = |k: usize| {
        k < improvement.kept && campaign.readings.rows.get(k).is_some_and(|row| !row.observations.is_empty())
    };
    let rows = improvement.schedule.readings.rows.iter().enumerate();
    rows.filter(|(k, _)| !done(*k)).map(|(_, row)| row.clone()).collect()
}

fn reason(campaign: &Campaign, reason: &Reason) -> ReasonReport {
    let parameter = campaign.parameter_id(reason.parameter).to_string();
    ReasonReport { position: reason.position.clone(), parameter, grows: reason.grows }
}

fn positions(schedule: &Campaign, rows: &[Reading]) -> Vec<PlannedPositionReport> {
    let readings = &schedule.readings;
    let levels = |row: &Reading| -> BTreeMap<String, String> {
        let of = |line: &Scatter| match &line.per {
            Per::Column(column) => Some((column.clone(), line.per.level_name(readings, row)?.into_owned())),
            _ => None,
        };
        schedule.scatter.iter().filter_map(of).collect()
    };
    rows.iter()
        .map(|r| PlannedPositionReport {
            position: r.position.clone(),
            at: position_keys(schedule, &r.joints),
            levels: levels(r),
        })
        .collect()
}

/// `equal` is the given schedule at equal effort, but for the factor `by`.
fn comparison(
    given: &JudgementReport,
    better: &JudgementReport,
    equal: &JudgementReport,
    by: f64,
) -> Vec<ComparisonReport> {
    let line = |id: &str, unit: &str, given: Option<f64>, equal: Option<f64>, better: Option<f64>| ComparisonReport {
        id: id.to_string(),
        unit: unit.to_string(),
        given,
        equal_effort: equal.map(|u| u * by),
        better,
        gain: equal.zip(better).filter(|(_, b)| *b > 0.0).map(|(e, b)| e * by / b),
    };
    let own = |u: Option<f64>, arcsec: Option<f64>, is_angle: bool| if is_angle { arcsec } else { u };
    let parameters = given.parameters.iter().zip(&better.parameters).zip(&equal.parameters).map(|((g, b), e)| {
        let angle = g.kind == Kind::Tilt;
        let unit = if angle { "arcsec" } else { g.unit.as_str() };
        line(&g.id, unit, own(g.u, g.u_arcsec, angle), own(e.u, e.u_arcsec, angle), own(b.u, b.u_arcsec, angle))
    });
    let derived = given.derived.iter().zip(&better.derived).zip(&equal.derived).map(|((g, b), e)| {
        let angle = g.u_arcsec.is_some() || b.u_arcsec.is_some();
        line(
            &g.id,
            if angle { "arcsec" } else { g.unit.as_str() },
            own(g.u, g.u_arcsec, angle),
            own(e.u, e.u_arcsec, angle),
            own(b.u, b.u_arcsec, angle),
        )
    });
    parameters.chain(derived).collect()
}

fn goal_report(campaign: &Campaign, reached: &Reached, goals: &[Goal]) -> GoalReport {
    let limit = |goal: &Goal| {
        let tilt = crate::plan::is_angle(campaign, &goal.id);
        (goal.id.clone(), if tilt { goal.u * ARCSEC } else { goal.u })
    };
    GoalReport {
        limits: goals.iter().map(limit).collect(),
        reached: reached.reached,
        largest_share: reached.largest_share,
        is_fewest: reached.is_fewest,
        is_cheapest_found: reached.is_cheapest_found,
        impossible: reached.impossible.clone(),
    }
}
