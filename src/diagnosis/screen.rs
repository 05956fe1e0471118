//! Long campaigns: bad readings, remounted positions and steps in time are so many that they cannot all have columns. They need none to be
//! compared with the model ([`indicators`](super::indicators)), and only the strongest get one: one row for a bad reading, the rows of a label for
//! a position, a tail of the rows in time for a step, of which cumulative sums give every one in one pass over the rows.

use super::catalogue::{breaks, clock};
use super::indicators::{Indicators, Sums};
use super::noise::Weighted;
use crate::campaign::Campaign;
use crate::design::DesignMatrix;
use std::collections::{HashMap, HashSet};

/// A family with no more members than this gets all its columns.
const FEW: usize = 400;
/// Members that get a column otherwise, of each family and sensor, each time that it is looked at.
const TOP: usize = 48;

/// A member of a family that is scanned: its sensor, and what it is.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Scanned {
    /// One bad reading, by index.
    Reading(usize, usize),
    /// A remounted position, by label.
    Position(usize, String),
    /// A step at a time, by its bits.
    Break(usize, u64),
    /// Two readings exchanged, by index: always screened.
    Exchange(usize, usize, usize),
}

/// The members that get a column; everything of a family that is not screened.
#[derive(Debug, Clone, Default)]
pub(super) struct Chosen {
    readings: bool,
    positions: bool,
    breaks: bool,
    members: HashSet<Scanned>,
}

impl Chosen {
    /// Does this member get a column?
    pub fn has(&self, member: &Scanned) -> bool {
        let screened = match member {
            Scanned::Reading(..) => self.readings,
            Scanned::Position(..) => self.positions,
            Scanned::Break(..) => self.breaks,
            Scanned::Exchange(..) => true,
        };
        !screened || self.members.contains(member)
    }

    /// The pairs of readings of one sensor that get a column.
    pub fn pairs(&self, sensor: usize) -> Vec<(usize, usize)> {
        let mut pairs: Vec<(usize, usize)> = self
            .members
            .iter()
            .filter_map(|member| match member {
                Scanned::Exchange(of_sensor, a, b) if *of_sensor == sensor => Some((*a, *b)),
                _ => None,
            })
            .collect();
        pairs.sort_unstable();
        pairs
    }

    /// Take more members in; how many of them are new.
    pub fn add(&mut self, members: impl IntoIterator<Item = Scanned>) -> usize {
        members.into_iter().filter(|member| self.members.insert(member.clone())).count()
    }
}

/// Pairs of readings that get a column each time that they are looked at.
const PAIRS: usize = 6;
/// Readings with the largest residuals that are paired.
const PAIRED: usize = 400;

/// The pairs of readings of one sensor whose values, exchanged, take most off the sum of squares: some columns (not weighted, `m` each) being in the model
/// too, then with the best pair as well, and so on, as the first of several pairs hides the others.
pub(super) fn exchanged(
    campaign: &Campaign,
    design: &DesignMatrix,
    weighted: &Weighted,
    given: &[&Vec<f64>],
    rounds: usize,
) -> HashSet<Scanned> {
    let mut indicators = Indicators::new(weighted, given);
    let mut chosen = HashSet::new();
    for _ in 0..rounds {
        let pairs = pairs(campaign, design, &indicators);
        let Some(best) = pairs.first() else { break };
        let mut column = vec![0.0; weighted.weight.len()];
        for (row, sign) in best.rows.into_iter().zip([1.0, -1.0]) {
            column.iter_mut().skip(row).take(1).for_each(|v| *v = sign);
        }
        indicators.give(&column);
        let before = chosen.len();
        chosen.extend(pairs.into_iter().map(|pair| pair.member));
        if chosen.len() == before {
            break;
        }
    }
    chosen
}

/// Two rows, and what the sum of squares falls by with their values exchanged.
struct Pair {
    fall: f64,
    rows: [usize; 2],
    member: Scanned,
}

/// Those that take most off, the best first.
fn pairs(campaign: &Campaign, design: &DesignMatrix, indicators: &Indicators<'_>) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = Vec::new();
    for sensor in 0..campaign.bench.sensors.len() {
        let origins = design.rows.iter().enumerate().filter(|(_, origin)| origin.sensor == sensor);
        let mut rows: Vec<(usize, usize, f64, Sums, f64)> = origins
            .filter_map(|(i, origin)| {
                let reading = campaign.readings.rows.get(origin.reading)?;
                let value = reading.observations.iter().find(|o| o.sensor == sensor)?.value;
                let mut sums = indicators.none();
                indicators.add(i, &mut sums);
                let score = indicators.score(&sums).abs();
                Some((i, origin.reading, value, sums, score))
            })
            .collect();
        rows.sort_by(|a, b| b.4.total_cmp(&a.4));
        rows.truncate(PAIRED);
        for (n, (i, first, y, one, _)) in rows.iter().enumerate() {
            for (j, second, other, two, _) in rows.iter().skip(n + 1) {
                let fall = indicators.fall_with(one, two, y - other);
                if fall > 0.0 {
                    let member = Scanned::Exchange(sensor, *first.min(second), *first.max(second));
                    pairs.push(Pair { fall, rows: [*i, *j], member });
                }
            }
        }
    }
    let more = |a: &Pair, b: &Pair| b.fall.total_cmp(&a.fall);
    if pairs.len() > PAIRS {
        pairs.select_nth_unstable_by(PAIRS, more);
        pairs.truncate(PAIRS);
    }
    pairs.sort_by(more);
    pairs
}

/// Which families a campaign is too long for.
pub(super) fn chosen(campaign: &Campaign) -> Chosen {
    let labels: HashSet<&str> = campaign.readings.rows.iter().map(|reading| reading.position.as_str()).collect();
    Chosen {
        readings: campaign.readings.rows.len() > FEW,
        positions: labels.len() > FEW,
        breaks: breaks(campaign).len() > FEW,
        members: HashSet::new(),
    }
}

/// The evidence for every member of every screened family.
pub(super) struct Screen {
    families: Vec<Vec<(Scanned, f64)>>,
}

impl Screen {
    /// Evidence given that some columns (not weighted, `m` each) are in the model too.
    pub fn new(
        campaign: &Campaign,
        design: &DesignMatrix,
        weighted: &Weighted,
        chosen: &Chosen,
        given: &[&Vec<f64>],
    ) -> Self {
        let mut families = Vec::new();
        if !(chosen.readings || chosen.positions || chosen.breaks) {
            return Screen { families };
        }
        let rows = Indicators::new(weighted, given);
        let times = breaks(campaign);
        let time = campaign.readings.columns.iter().position(|column| column == clock(campaign));
        for sensor in 0..campaign.bench.sensors.len() {
            let rows_of = || design.rows.iter().enumerate().filter(move |(_, origin)| origin.sensor == sensor);
            if chosen.readings {
                let one = |(i, origin): (usize, &crate::design::RowOrigin)| {
                    let mut sums = rows.none();
                    rows.add(i, &mut sums);
                    (Scanned::Reading(sensor, origin.reading), rows.score(&sums))
                };
                families.push(rows_of().map(one).collect());
            }
            if chosen.positions {
                let mut labels: HashMap<&str, Sums> = HashMap::new();
                for (i, origin) in rows_of() {
                    let label = campaign.readings.rows.get(origin.reading).map_or("", |r| r.position.as_str());
                    rows.add(i, labels.entry(label).or_insert_with(|| rows.none()));
                }
                let labelled = labels.into_iter().filter(|(label, _)| !label.is_empty());
                let mut family: Vec<(Scanned, f64)> = labelled
                    .map(|(label, sums)| (Scanned::Position(sensor, label.into()), rows.score(&sums)))
                    .collect();
                family.sort_by(|a, b| a.1.total_cmp(&b.1).then_with(|| label(&a.0).cmp(label(&b.0))));
                families.push(family);
            }
            if let (true, Some(column)) = (chosen.breaks, time) {
                let at = |reading: usize| campaign.readings.rows.get(reading)?.columns.get(column).copied().flatten();
                let mut late: Vec<(f64, usize)> =
                    rows_of().filter_map(|(i, origin)| at(origin.reading).map(|t| (t, i))).collect();
                late.sort_by(|a, b| a.0.total_cmp(&b.0));
                let mut sums = rows.none();
                let mut family = Vec::with_capacity(times.len());
                for (_, at) in times.iter().rev() {
                    while let Some((_, i)) = late.last().copied().filter(|(t, _)| t >= at) {
                        rows.add(i, &mut sums);
                        late.pop();
                    }
                    family.push((Scanned::Break(sensor, at.to_bits()), rows.score(&sums)));
                }
                families.push(family);
            }
        }
        Screen { families }
    }

    /// The strongest members of each family, of which none has a column yet; with their scores.
    pub fn strongest(&self, chosen: &Chosen) -> Vec<(Scanned, f64)> {
        let mut strongest = Vec::new();
        for family in &self.families {
            let mut ranked: Vec<&(Scanned, f64)> = family.iter().filter(|(member, _)| !chosen.has(member)).collect();
            let far = |a: &&(Scanned, f64), b: &&(Scanned, f64)| b.1.abs().total_cmp(&a.1.abs());
            if ranked.len() > TOP {
                ranked.select_nth_unstable_by(TOP, far);
                ranked.truncate(TOP);
            }
            ranked.sort_by(far);
            strongest.extend(ranked.into_iter().cloned());
        }
        strongest
    }

    /// How many members have no column: tests that were made all the same.
    pub fn without_column(&self, chosen: &Chosen) -> usize {
        self.families.iter().flatten().filter(|(member, _)| !chosen.has(member)).count()
    }
}

fn label(member: &Scanned) -> &str {
    match member {
        Scanned::Position(_, label) => label,
        _ => "",
    }
}
