//! What is not estimable, by name, and which further position would separate it.

use super::names::{NamedCombination, describe};
use crate::campaign::{Campaign, JointState, Reading, Readings};
use crate::design::{DesignMatrix, Model};
use crate::elements::{Elements, Parts};
use crate::estimate::{self, Estimate, ScaleHints, System};
use crate::number;
use faer::Mat;

/// One rank defect.
#[derive(Debug, Clone, PartialEq)]
pub struct RankDefect {
    /// The combination that the readings leave free: parameters can move along it and no reading changes.
    pub free: NamedCombination,
    /// The direction along which it is free: parameters may move in these proportions and no reading changes.
    pub direction: NamedCombination,
    /// What is determined instead, of the parameters that take part.
    pub estimable: Vec<NamedCombination>,
    /// The further position that would separate it best, as joint states in chain order; `None` if none of this bench would.
    pub separate_by: Option<Vec<JointState>>,
    /// The columns that model lines read, and their values at that position.
    pub columns: Vec<(String, f64)>,
    /// The sensor to be read there, where it is one that is not read now.
    pub sensor: Option<usize>,
    /// Do readings respond to it, but only in the second order and within the uncertainty of what it is multiplied by, or only away from the
    /// point that was reached, and is no position known that would separate it? Then nothing is said of other positions.
    pub is_weak: bool,
}

/// A candidate separates when its row along the free direction is at least this share of the row's size.
const SEPARATES: f64 = 1e-3;
/// Above this share a position is good enough that positions with more joints moved are not tried.
const SEPARATES_WELL: f64 = 0.1;
const STEP_DEG: usize = 45;
/// More joints than this make the full sweep too long; the rest stay where the first reading has them.
const SWEPT_JOINTS: usize = 4;
/// Four joints in steps of 45 degrees.
const MOST_POSITIONS: usize = 4096;

/// So many of the best candidates are added to the readings, to see whether they lower the defect.
const VERIFIED: usize = 8;

/// Name every rank defect of an estimate and look for the position that would end it, as judged at the design's point.
///
/// A position is named only where the rank with its row added is larger than without. `weak` are unknowns that are held although readings
/// respond to them.
pub(crate) fn separations(
    campaign: &Campaign,
    model: &Model,
    design: &DesignMatrix,
    estimate: &Estimate,
    weak: &[usize],
) -> Vec<RankDefect> {
    if estimate.unknowns.not_estimable.is_empty() {
        return Vec::new();
    }
    let search = Search::new(campaign, model, design);
    estimate
        .unknowns
        .not_estimable
        .iter()
        .zip(&estimate.unknowns.free_directions)
        .map(|(combination, free)| {
            let involved: Vec<usize> = free.terms.iter().map(|(k, _)| *k).collect();
            let is_weak = involved.iter().any(|k| weak.contains(k));
            let (separate_by, columns, sensor) = match search.best(&free.terms) {
                Some(found) => (Some(found.joints), found.columns, found.sensor),
                None => (None, Vec::new(), None),
            };
            RankDefect {
                free: describe(campaign, combination),
                direction: describe(campaign, free),
                estimable: estimate
                    .unknowns
                    .estimable_combinations
                    .iter()
                    .filter(|c| c.terms.iter().any(|(k, _)| involved.contains(k)))
                    .map(|c| describe(campaign, c))
                    .collect(),
                is_weak: is_weak && separate_by.is_none(),
                separate_by,
                columns,
                sensor,
            }
        })
        .collect()
}

/// A further reading.
struct Further {
    joints: Vec<JointState>,
    columns: Vec<(String, f64)>,
    sensor: Option<usize>,
}

/// Candidate positions, and the readings that they would be added to.
struct Search<'a> {
    campaign: &'a Campaign,
    model: &'a Model,
    design: &'a DesignMatrix,
    schedule: Campaign,
    rank: Option<usize>,
}

impl<'a> Search<'a> {
    fn new(campaign: &'a Campaign, model: &'a Model, design: &'a DesignMatrix) -> Self {
        let schedule = campaign.with_readings(candidates(campaign));
        let rank = rank_with(campaign, design, &[]);
        Search { campaign, model, design, schedule, rank }
    }

    /// The simplest position whose row along the direction is long, and which raises the rank.
    fn best(&self, direction: &[(usize, f64)]) -> Option<Further> {
        let unknowns = self.campaign.unknowns();
        let mut work = self.model.workspace();
        let mut row = vec![0.0; self.campaign.parameters.len()];
        let mut found: Vec<(f64, usize, usize, Vec<f64>)> = Vec::new();
        let mut moved = 0;
        let mut is_well = false;
        for (reading, state) in self.schedule.readings.rows.iter().enumerate() {
            // positions come with the fewest joints and columns moved first; more are tried only while none separates well
            let moves = moved_from_first(state, self.campaign);
            if moves > moved && is_well {
                break;
            }
            moved = moves;
            for sensor in 0..self.campaign.bench.sensors.len() {
                let point = &self.design.point;
                if self.model.predict(&self.schedule, reading, sensor, point, &mut row, &mut work).is_err() {
                    continue;
                }
                let terms = || direction.iter().map(|(k, c)| row.at(*k) * c);
                let (along, size) = (terms().sum::<f64>().abs(), terms().map(f64::abs).sum::<f64>());
                if along > SEPARATES * size && along.is_finite() {
                    is_well |= along > SEPARATES_WELL * size;
                    found.push((along, reading, sensor, row.part(..unknowns).to_vec()));
                }
            }
        }
        // of those that are equal in single precision the first: fewest joints moved
        found.sort_by(|a, b| number::single(b.0).total_cmp(&number::single(a.0)).then(a.1.cmp(&b.1)));
        let raises = |row: &[f64]| rank_with(self.campaign, self.design, row) > self.rank;
        let (_, reading, sensor, _) = found.iter().take(VERIFIED).find(|(.., row)| raises(row))?;
        let reading = self.schedule.readings.rows.get(*reading)?;
        let value =
            |k: usize| Some((self.schedule.readings.columns.get(k)?.clone(), *reading.columns.get(k)?.as_ref()?));
        let is_read = self.design.rows.iter().any(|origin| origin.sensor == *sensor);
        Some(Further {
            joints: reading.joints.to_vec(),
            columns: columns_read(self.campaign).into_iter().filter_map(value).collect(),
            sensor: (!is_read).then_some(*sensor),
        })
    }
}

/// The rank of a design's rows and the campaign's priors, with one more row if it has any entry.
fn rank_with(campaign: &Campaign, design: &DesignMatrix, row: &[f64]) -> Option<usize> {
    let unknowns = campaign.unknowns();
    let priors: Vec<usize> = campaign.priors().map(|(k, ..)| k).collect();
    let readings = design.jacobian.nrows();
    let count = readings + priors.len() + usize::from(!row.is_empty());
    let rows = Mat::from_fn(count, unknowns, |i, j| match i.checked_sub(readings) {
        None => design.jacobian[(i, j)],
        Some(p) if p < priors.len() => f64::from(priors.get(p) == Some(&j)),
        Some(_) => row.at(j),
    });
    let system = System::known(rows, vec![0.0; count], vec![1.0; count]);
    let settings = estimate::Settings { refinements: 0, ..estimate::Settings::default() };
    estimate::solve(&system, &ScaleHints::default(), &settings).ok().map(|solution| solution.rank)
}

/// Positions that this bench could take: every joint that the schedule holds still, in steps of 45 degrees; every joint that it turns, with
/// the states that the schedule has, and those with the sense of the rate reversed. Columns are those of the first reading; each that a model line
/// reads, and all of them together, also with other values, at the first reading's joints. Simplest first: fewer joints and columns away from the
/// first reading's.
pub fn candidates(campaign: &Campaign) -> Readings {
    let Some(first) = campaign.readings.rows.first() else { return Readings::default() };
    let rows = &campaign.readings.rows;
    let mut states: Vec<Vec<JointState>> = Vec::new();
    for joint in 0..first.joints.len() {
        let mut seen: Vec<JointState> = Vec::new();
        for state in rows.iter().filter_map(|r| r.joints.get(joint)) {
            if seen.len() < 16 && !seen.contains(state) {
                seen.push(*state);
            }
        }
        for state in seen.clone() {
            let reversed = state.reversed();
            if !seen.contains(&reversed) {
                seen.push(reversed);
            }
        }
        let held = seen.iter().all(|state| matches!(state, JointState::Held { .. }));
        if held && joint < SWEPT_JOINTS {
            for angle in (0..360).step_by(STEP_DEG) {
                let state = JointState::Held { angle_deg: angle as f64 };
                if !seen.contains(&state) {
                    seen.push(state);
                }
            }
        }
        states.push(seen);
    }
    let mut combinations: Vec<Vec<JointState>> = vec![Vec::new()];
    for options in &states {
        combinations = combinations
            .iter()
            .flat_map(|before| {
                options.iter().map(move |state| {
                    let mut next = before.clone();
                    next.push(*state);
                    next
                })
            })
            .take(MOST_POSITIONS)
            .collect();
    }
    let names: Vec<&str> = campaign.bench.joints().collect();
    let at = |joints: Vec<JointState>| campaign.readings.position(&names, first, joints);
    // two joints that turn in one mean are no reading
    let can_be_read = |reading: &Reading| Reading::check_turning(&reading.joints, &names).is_ok();
    let mut rows: Vec<Reading> = combinations.into_iter().map(at).filter(can_be_read).collect();
    let read = columns_read(campaign);
    let with = |k: usize, value: f64, mut reading: Reading| {
        reading.columns.get_mut(k).into_iter().for_each(|slot| *slot = Some(value));
        reading
    };
    let mut together = at(first.joints.to_vec());
    for k in &read {
        let mut values = other_values(campaign, *k);
        rows.extend(values.iter().map(|value| with(*k, *value, at(first.joints.to_vec()))));
        together = with(*k, values.pop().unwrap_or(1.0), together);
    }
    rows.extend((read.len() > 1).then_some(together));
    rows.sort_by_key(|reading| moved_from_first(reading, campaign));
    Readings { columns: campaign.readings.columns.clone(), rows }
}

/// Columns that model lines read, but for those of joints.
pub(crate) fn columns_read(campaign: &Campaign) -> Vec<usize> {
    let read = |column: &str| campaign.bench.sensors.iter().any(|sensor| sensor.model.names().contains(&column));
    let columns = campaign.readings.columns.iter().enumerate();
    columns.filter(|(_, column)| read(column) && !campaign.bench.is_of_joint(column)).map(|(k, _)| k).collect()
}

/// Other values of a column than the first reading's: those of other readings, zero, the opposite, and twice it (one for zero).
fn other_values(campaign: &Campaign, k: usize) -> Vec<f64> {
    let mut seen = campaign.readings.rows.iter().filter_map(|reading| reading.columns.get(k).copied().flatten());
    let Some(first) = seen.next() else { return vec![0.0, 1.0] };
    let mut values: Vec<f64> = Vec::new();
    let more = if first == 0.0 { vec![-1.0, 1.0] } else { vec![0.0, -first, 2.0 * first] };
    for value in seen.take(MOST_POSITIONS).chain(more) {
        if value != first && !values.contains(&value) {
            values.push(value);
        }
    }
    // the last ones are not of the readings
    let spare = values.len().saturating_sub(16);
    values.drain(..spare);
    values
}

/// How many joints stand or turn otherwise than in the first reading, and how many columns that no joint has are others.
fn moved_from_first(reading: &Reading, campaign: &Campaign) -> usize {
    let Some(first) = campaign.readings.rows.first() else { return 0 };
    let joints = reading.joints.iter().zip(&first.joints).filter(|(own, first)| own != first).count();
    joints + columns_read(campaign).into_iter().filter(|k| reading.columns.get(*k) != first.columns.get(*k)).count()
}
