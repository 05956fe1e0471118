//! Positions that may be chosen: sweeps over joints and rates, forbidden zones, and the units in which they are chosen.

use super::effort::{grouped, mounting};
use super::whitened::level_of;
use crate::campaign::{Campaign, JointState, Label, Per, Reading, Readings, Shared, joint_keys};
use crate::error::{Fault, Malformed, Result};
use crate::fit::columns_read;
use crate::number;
use crate::units;

/// In what portions readings are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// One reading at a time.
    #[default]
    Reading,
    /// Both senses of a rate together.
    Pair,
    /// Every rate of a mounting together.
    Mounting,
}

/// A forbidden zone: joint keys (`alpha_deg`, `gamma_deg_s`) with the interval that is forbidden; a candidate in all of them is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    /// Key, lower and upper end; an interval of angles may run through 360 (300 to 60).
    pub limits: Vec<(String, f64, f64)>,
}

/// More candidates than this are refused: a coarser step, or a file of candidates, is the better question.
const MOST_CANDIDATES: usize = 200_000;

/// Every position of a full sweep: joints that the schedule holds still in steps of `step_deg`, joints that it turns in every state it has; a
/// joint that does both, both.
///
/// Samples and stated uncertainties are those of the first reading that turns in the same way. Columns that a model line reads (a temperature)
/// have the values at which the schedule reads, to a tenth of their ranges; other columns those of the last reading, which the further ones follow. A
/// bench without joints has the schedule's distinct readings as candidates.
/// Errors: a step that is not positive, or gives more than 200,000 positions.
pub fn sweep(campaign: &Campaign, step_deg: f64) -> Result<Readings> {
    sweep_with_rates(campaign, step_deg, &[])
}

/// The same with further rates (degrees per second) of every joint that the schedule turns.
///
/// Errors: those of [`sweep`], a rate that is zero or not finite, rates where no joint turns.
pub(crate) fn sweep_with_rates(campaign: &Campaign, step_deg: f64, rates: &[f64]) -> Result<Readings> {
    let rows = &campaign.readings.rows;
    let columns = campaign.readings.columns.clone();
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Ok(Readings { columns, rows: Vec::new() });
    };
    if !(step_deg > 0.0 && step_deg <= 360.0) {
        return Err(Malformed::new(Fault::Value, "the step of the sweep is not valid")
            .expected("degrees, above 0 and at most 360")
            .found(step_deg.to_string()));
    }
    if first.joints.is_empty() {
        let mut distinct: Vec<Reading> = Vec::new();
        for row in rows {
            if !distinct.iter().any(|other| other.columns == row.columns) {
                distinct.push(Reading { position: Label::default(), ..row.unread() });
            }
        }
        return Ok(Readings { columns, rows: distinct });
    }
    if let Some(rate) = rates.iter().find(|rate| **rate == 0.0 || !rate.is_finite()) {
        return Err(Malformed::new(Fault::Value, "a rate of the sweep is not valid")
            .expected("degrees per second, other than zero")
            .found(rate.to_string()));
    }
    let is_turned = |reading: &Reading| reading.joints.iter().any(|state| state.at_rate(1.0).is_some());
    if !rates.is_empty() && !rows.iter().any(is_turned) {
        return Err(Malformed::new(Fault::Value, "further rates are given, and no joint of the schedule turns")
            .expected("a schedule in which some joint has a rate (<joint>_deg_s)"));
    }
    let conditions = Conditions::new(campaign).columns(last);
    let mut states: Vec<Vec<JointState>> = Vec::new();
    let mut total = conditions.len() as f64;
    for joint in 0..first.joints.len() {
        let given = || rows.iter().filter_map(|r| r.joints.get(joint)).copied();
        let faster = given().flat_map(|state| rates.iter().filter_map(move |rate| state.at_rate(*rate)));
        let mut seen: Vec<JointState> = Vec::new();
        for state in given().chain(faster) {
            if !seen.contains(&state) {
                seen.push(state);
            }
        }
        // a joint that is both held and turned keeps the states in which it turns
        let (held, turning): (Vec<_>, Vec<_>) = seen.iter().partition(|own| matches!(own, JointState::Held { .. }));
        let steps = if held.is_empty() { 0.0 } else { (360.0 / step_deg - 1e-9).ceil() };
        total *= turning.len() as f64 + steps;
        if total > MOST_CANDIDATES as f64 {
            return Err(Malformed::new(
                Fault::Value,
                format!("a sweep in steps of {step_deg} deg has too many positions"),
            )
            .expected(format!("at most {MOST_CANDIDATES}; a larger step, or a file of candidates"))
            .found(format!("more than {total:.0}")));
        }
        let held = (0..number::count(steps)).map(|k| JointState::Held { angle_deg: k as f64 * step_deg });
        states.push(held.chain(turning).collect());
    }
    let mut combinations: Vec<Vec<JointState>> = vec![Vec::new()];
    for options in &states {
        combinations = combinations
            .iter()
            .flat_map(|before| options.iter().map(|state| before.iter().copied().chain([*state]).collect()))
            .collect();
    }
    let names: Vec<&str> = campaign.bench.joints().collect();
    // texts that lines of scatter refer to (an operator): like columns, those of the last reading
    let goes_by = |key: &String| campaign.scatter.iter().any(|line| line.per == Per::Column(key.clone()));
    let levels: Shared<(String, String)> = last.remarks.iter().filter(|(key, _)| goes_by(key)).cloned().collect();
    let stated = |row: &Reading| (row.samples, row.unread().planned_u);
    let at = |columns: &Shared<Option<f64>>| Reading { columns: columns.clone(), ..last.unread() };
    let uniform = rows.iter().all(|row| stated(row) == stated(first));
    // the bench takes no mean with two turning joints
    let rows = combinations
        .into_iter()
        .flat_map(|joints| conditions.iter().map(move |columns| (joints.clone(), columns)))
        .map(|(joints, columns)| {
            let turns_alike = |row: &&Reading| {
                let pairs = row.joints.iter().zip(&joints);
                pairs.filter(|(_, s)| !matches!(s, JointState::Held { .. })).all(|(other, s)| other == s)
            };
            let like = if uniform { first } else { rows.iter().find(turns_alike).unwrap_or(first) };
            Reading {
                columns: campaign.readings.position(&names, &at(columns), joints.clone()).columns,
                remarks: levels.clone(),
                ..campaign.readings.position(&names, like, joints)
            }
        })
        .filter(|reading| Reading::check_turning(&reading.joints, &names).is_ok())
        .collect();
    Ok(Readings { columns, rows })
}

/// Columns that model lines read and no joint has (a temperature), but for times, which the order of the readings sets.
pub(crate) fn conditions_read(campaign: &Campaign) -> Vec<usize> {
    let second = units::Unit::parse("s").ok();
    let timed = |k: &usize| {
        let unit = units::Unit::parse(&units::of_column(campaign.readings.columns.get(*k)?)?).ok()?;
        unit.conversion(second.as_ref()?)
    };
    columns_read(campaign).into_iter().filter(|k| timed(k).is_none()).collect()
}

/// The conditions at which a schedule reads: values of [`conditions_read`].
pub(super) struct Conditions<'a> {
    /// Columns, and over what range their values go.
    read: Vec<(usize, f64)>,
    /// A reading of each.
    pub of: Vec<&'a Reading>,
}

impl<'a> Conditions<'a> {
    /// Readings that lie farthest from those already taken, the first of them the last of the schedule, until every reading lies near one.
    pub fn new(campaign: &'a Campaign) -> Self {
        /// Readings this near, as a share of a column's range, are of one condition. Of the two ends of a range one may be missed by it, next to the last
        /// reading: the `u` of a slope is at most 1/0.9 of what it could be.
        const ONE_CONDITION: f64 = 0.1;
        let columns = conditions_read(campaign);
        let complete = |row: &&Reading| columns.iter().all(|k| value(row, *k).is_some());
        let rows: Vec<&Reading> = campaign.readings.rows.iter().filter(complete).collect();
        let range = |k: &usize| {
            let values = || rows.iter().filter_map(|row| value(row, *k));
            (*k, values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min))
        };
        let mut conditions =
            Conditions { read: columns.iter().map(range).collect(), of: rows.last().copied().into_iter().collect() };
        let mut apart: Vec<f64> = rows.iter().map(|row| conditions.nearest(row).1).collect();
        while let Some((farthest, _)) =
            rows.iter().zip(&apart).filter(|(_, apart)| **apart > ONE_CONDITION).max_by(|a, b| a.1.total_cmp(b.1))
        {
            conditions.of.push(farthest);
            apart.iter_mut().zip(&rows).for_each(|(apart, row)| *apart = apart.min(conditions.apart(row, farthest)));
        }
        conditions
    }

    /// The condition that is nearest to a reading's, and how far it is.
    pub fn nearest(&self, row: &Reading) -> (usize, f64) {
        let apart = self.of.iter().map(|other| self.apart(row, other)).enumerate();
        apart.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }

    fn apart(&self, a: &Reading, b: &Reading) -> f64 {
        let share = |(k, range): &(usize, f64)| match (value(a, *k), value(b, *k)) {
            (Some(a), Some(b)) if *range > 0.0 => (a - b).abs() / range,
            _ => 0.0,
        };
        self.read.iter().map(share).fold(0.0, f64::max)
    }

    /// The columns of `last`, at each condition.
    fn columns(&self, last: &Reading) -> Vec<Shared<Option<f64>>> {
        let at = |row: &&Reading| {
            let mut columns = last.columns.clone();
            for (k, _) in &self.read {
                columns.get_mut(*k).into_iter().for_each(|slot| *slot = value(row, *k));
            }
            columns
        };
        if self.of.is_empty() { vec![last.columns.clone()] } else { self.of.iter().map(at).collect() }
    }

    /// The condition nearest to a reading's, in words.
    pub fn name(&self, row: &Reading) -> String {
        let of = self.of.get(self.nearest(row).0);
        let values = self.read.iter().filter_map(|(k, _)| value(of?, *k)).map(|value| value.to_string());
        values.collect::<Vec<_>>().join("\n")
    }
}

fn value(row: &Reading, column: usize) -> Option<f64> {
    row.columns.get(column).copied().flatten()
}

/// Columns of no joint that have several values in the schedule, and one only in the candidates: a sweep takes those that no model line reads from the
/// last reading.
pub(super) fn frozen(campaign: &Campaign, candidates: &Readings) -> Vec<(String, f64)> {
    // the one value of a column, where it has one
    let single = |rows: &[Reading], k: usize| {
        let mut values = rows.iter().map(|row| row.columns.get(k).copied().flatten());
        let first = values.next().flatten()?;
        values.all(|v| v == Some(first)).then_some(first)
    };
    let columns = campaign.readings.columns.iter().enumerate().filter(|(_, name)| !campaign.bench.is_of_joint(name));
    columns
        .filter(|(k, _)| single(&campaign.readings.rows, *k).is_none())
        .filter_map(|(k, name)| Some((name.clone(), single(&candidates.rows, k)?)))
        .collect()
}

/// Candidates from another schedule, with the columns of `campaign`. Errors: another bench.
pub(crate) fn from_schedule(campaign: &Campaign, candidates: &Campaign) -> Result<Readings> {
    let same = |a: &Campaign| (a.bench.id.clone(), a.bench.joints().map(str::to_string).collect::<Vec<_>>());
    if same(campaign) != same(candidates) {
        return Err(Malformed::new(Fault::Value, "the candidates are positions of another bench")
            .expected(format!("a schedule on {}", campaign.bench.id))
            .found(candidates.bench.id.clone())
            .at_path("bench"));
    }
    let columns = campaign.readings.columns.clone();
    let at = |name: &String| candidates.readings.columns.iter().position(|c| c == name);
    let rows = candidates
        .readings
        .rows
        .iter()
        .map(|row| Reading {
            columns: columns.iter().map(|name| at(name).and_then(|k| row.columns.get(k).copied().flatten())).collect(),
            ..row.unread()
        })
        .collect();
    Ok(Readings { columns, rows })
}

/// Leave out what lies in a forbidden zone. Errors: a key that no joint has, an interval that is none, nothing left.
pub fn without(campaign: &Campaign, candidates: Readings, zones: &[Zone]) -> Result<Readings> {
    let keys: Vec<String> = campaign.bench.joints().flat_map(|j| [format!("{j}_deg"), format!("{j}_deg_s")]).collect();
    for (key, low, high) in zones.iter().flat_map(|zone| &zone.limits) {
        if !keys.contains(key) {
            return Err(Malformed::new(
                Fault::UnknownKey,
                format!("a forbidden zone names '{key}', which no joint has"),
            )
            .expected(format!("one of {}", keys.join(", ")))
            .found(format!("'{key}'")));
        }
        let ordered = low <= high || key.ends_with("_deg");
        if !ordered || !low.is_finite() || !high.is_finite() {
            return Err(Malformed::new(Fault::Value, format!("the forbidden interval of {key} is none"))
                .expected("lower:upper, for example alpha_deg=100:170; an interval of angles may run through 360, as alpha_deg=300:60")
                .found(format!("{low}:{high}")));
        }
    }
    let before = candidates.rows.len();
    let joints: Vec<&str> = campaign.bench.joints().collect();
    let Readings { columns, rows } = candidates;
    let rows: Vec<Reading> = rows.into_iter().filter(|reading| !is_forbidden(&joints, zones, reading)).collect();
    if rows.is_empty() && before > 0 {
        return Err(Malformed::new(Fault::Missing, "the forbidden zones leave no candidate")
            .expected("zones that leave some positions")
            .found(format!("all {before} candidates are forbidden")));
    }
    Ok(Readings { columns, rows })
}

/// Does a reading lie in one of the zones?
pub(super) fn is_forbidden(joints: &[&str], zones: &[Zone], reading: &Reading) -> bool {
    let value = |key: &str| {
        joints.iter().zip(&reading.joints).find_map(|(joint, state)| {
            let (deg, deg_s, _) = state.keys();
            let suffix = key.strip_prefix(joint)?;
            if suffix == "_deg" { deg } else { deg_s.filter(|_| suffix == "_deg_s") }
        })
    };
    let inside = |(key, low, high): &(String, f64, f64)| {
        value(key).is_some_and(|v| {
            // 300:60 is the interval from 300 through 360 to 60
            let width = if high < low { (high - low).rem_euclid(360.0) } else { high - low };
            if key.ends_with("_deg") { (v - low).rem_euclid(360.0) <= width } else { (*low..=*high).contains(&v) }
        })
    };
    zones.iter().any(|zone| !zone.limits.is_empty() && zone.limits.iter().all(inside))
}

/// Candidates in the portions in which they are chosen; all portions have the same number of readings.
///
/// Errors: no candidates; a candidate without its opposite sense (pairs); mountings with different numbers of readings.
pub(super) fn portions(campaign: &Campaign, candidates: &Readings, unit: Unit) -> Result<Vec<Vec<Reading>>> {
    let joints = &campaign.bench.joints().collect::<Vec<_>>();
    if candidates.rows.is_empty() {
        return Err(Malformed::new(Fault::Missing, "there are no candidate positions")
            .expected("at least one position to choose from")
            .found("an empty list"));
    }
    // candidates of one portion share this key; another day is another mounting
    let key = |k: usize, reading: &Reading| match unit {
        Unit::Reading => (k.to_string(), Vec::new()),
        Unit::Mounting | Unit::Pair => {
            let rates = reading.joints.iter().map(|joint| joint.rate_deg_s().abs().to_bits());
            let level = level_of(campaign, candidates, reading);
            (format!("{:?} {level}", mounting(reading)), rates.filter(|_| unit == Unit::Pair).collect())
        }
    };
    let mut groups = grouped(candidates.rows.iter().enumerate().map(|(k, reading)| (reading.clone(), key(k, reading))));
    for group in &mut groups {
        let mut distinct: Vec<Reading> = Vec::with_capacity(group.len());
        for reading in group.drain(..) {
            if !distinct.iter().any(|other| other.joints == reading.joints && other.columns == reading.columns) {
                distinct.push(reading);
            }
        }
        *group = distinct;
    }
    let size = groups.iter().map(Vec::len).max().unwrap_or(1);
    if let Some(short) = groups.iter().find(|group| group.len() != size) {
        let what = match unit {
            Unit::Pair => "a candidate has no replacement of the opposite sense",
            _ => "the mountings of the candidates have different numbers of readings",
        };
        // a group has members
        let place = short.first().map(|r| described(joints, r)).unwrap_or_default();
        return Err(Malformed::new(Fault::Missing, what)
            .expected(format!("{size} readings in each portion, as others have; single readings always go"))
            .argument("unit", "reading")
            .found(format!("{} at {place}", short.len())));
    }
    Ok(groups)
}

/// A position in words: `alpha_deg 90, gamma_deg_s 20`.
fn described(joints: &[&str], reading: &Reading) -> String {
    let keys = joint_keys(joints.iter().copied(), &reading.joints).map(|(key, value)| format!("{key} {value}"));
    keys.collect::<Vec<_>>().join(", ")
}
