//! Long campaigns: bad readings, remounted positions and steps in time are so many that they cannot all have columns. They need none to be
//! compared with the model, and only the strongest get one: one row for a bad reading, the rows of a label for
//! a position, a tail of the rows in time for a step, of which cumulative sums give every one in one pass over the rows.
//!
//! Columns of ones at some rows (a bad reading, the rows of a label, a tail in time) compared with the model without being made:
//!
//! ```text
//! c = sum of e_i over rows R,   c' . r = sum b_i,   |c'|^2 = c'V^-1 c - |sum a_i|^2        b = W'r,  a_i: row i of W'Q, of independent rows W = diag(w)
//! ```

use super::catalogue::{breaks, clock};
use super::noise::Weighted;
use super::score::VISIBLE;
use crate::campaign::Campaign;
use crate::design::{DesignMatrix, RowOrigin};
use crate::elements::Elements;
use crate::linear::{dot, norm, normalise, project};
use std::cmp::Ordering;
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

    /// Take more members in.
    pub fn add(&mut self, members: impl IntoIterator<Item = Scanned>) {
        self.members.extend(members);
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
    first(pairs, PAIRS, |a, b| b.fall.total_cmp(&a.fall))
}

/// The first of a list in an order, at most so many.
fn first<T>(mut list: Vec<T>, most: usize, order: impl Fn(&T, &T) -> Ordering) -> Vec<T> {
    if list.len() > most {
        list.select_nth_unstable_by(most, &order);
        list.truncate(most);
    }
    list.sort_by(order);
    list
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
                let one = |(i, origin): (usize, &RowOrigin)| {
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

    /// The strongest members of each family, of which none has a column yet.
    pub fn strongest(&self, chosen: &Chosen) -> Vec<Scanned> {
        let of = |family: &Vec<(Scanned, f64)>| {
            let open = family.iter().filter(|(member, _)| !chosen.has(member)).collect();
            let strongest = first(open, TOP, |(_, a), (_, b)| b.abs().total_cmp(&a.abs()));
            strongest.into_iter().map(|(member, _)| member.clone()).collect::<Vec<_>>()
        };
        self.families.iter().flat_map(of).collect()
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

/// A model, and further directions, as sensitivities of its readings.
pub(super) struct Indicators<'a> {
    weighted: &'a Weighted,
    /// Orthonormal, of independent rows, and what is left of the readings there.
    white: Vec<Vec<f64>>,
    left: Vec<f64>,
    directions: Vec<Vec<f64>>,
    residual: Vec<f64>,
    /// Diagonal of `V^-1`, where rows are not independent.
    diagonal: Option<Vec<f64>>,
}

/// The sums over the rows of one column.
#[derive(Clone)]
pub(super) struct Sums {
    square: f64,
    product: f64,
    along: Vec<f64>,
    /// The rows, where they are not independent.
    rows: Vec<usize>,
}

impl<'a> Indicators<'a> {
    /// With the model, and some columns (not weighted, `m` each).
    pub fn new(weighted: &'a Weighted, given: &[&Vec<f64>]) -> Self {
        let q = weighted.estimate.factor.thin_q();
        let white: Vec<Vec<f64>> = (0..q.ncols()).map(|k| q.col(k).iter().copied().collect()).collect();
        let diagonal = weighted.floor.as_ref().map(|floor| {
            let whitening = floor.whitening();
            let alone = whitening.redundancies(faer::Mat::zeros(weighted.weight.len(), 0).as_ref());
            alone.iter().zip(whitening.sd()).map(|(left, sd)| left / (sd * sd)).collect()
        });
        let directions = white.iter().map(|direction| weighted.carry_back(direction)).collect();
        let left = weighted.residual.clone();
        let residual = weighted.carry_back(&left);
        let mut indicators = Indicators { weighted, white, left, directions, residual, diagonal };
        given.iter().for_each(|column| indicators.give(column));
        indicators
    }

    /// One column more (not weighted, `m`) in the model.
    pub fn give(&mut self, column: &[f64]) {
        let largest = column.iter().fold(f64::MIN_POSITIVE, |largest, v| largest.max(v.abs()));
        let scaled: Vec<f64> = column.iter().map(|v| v / largest).collect();
        let mut direction = self.weighted.whiten(&scaled);
        let before = norm(&direction);
        (0..2).for_each(|_| project(&mut direction, &self.white));
        if normalise(&mut direction) > VISIBLE * before {
            let along = dot(&direction, &self.left);
            self.left.iter_mut().zip(&direction).for_each(|(r, d)| *r -= along * d);
            self.residual = self.weighted.carry_back(&self.left);
            self.directions.push(self.weighted.carry_back(&direction));
            self.white.push(direction);
        }
    }

    /// A column of no rows.
    pub fn none(&self) -> Sums {
        Sums { square: 0.0, product: 0.0, along: vec![0.0; self.directions.len()], rows: Vec::new() }
    }

    /// One row more.
    pub fn add(&self, i: usize, sums: &mut Sums) {
        match self.diagonal {
            Some(_) => sums.rows.push(i),
            None => sums.square += self.weighted.weight.at(i) * self.weighted.weight.at(i),
        }
        sums.product += self.residual.at(i);
        for (sum, direction) in sums.along.iter_mut().zip(&self.directions) {
            *sum += direction.at(i);
        }
    }

    /// What `size` times the difference of two single rows takes off the sum of squares: `2 s c'r - s^2 |c'|^2`. Rows that are not independent count
    /// as if they were.
    pub fn fall_with(&self, one: &Sums, two: &Sums, size: f64) -> f64 {
        let along: f64 = one.along.iter().zip(&two.along).map(|(a, b)| (a - b) * (a - b)).sum();
        let left = (self.square(one) + self.square(two) - along).max(0.0);
        2.0 * size * (one.product - two.product) - size * size * left
    }

    /// Score of a column, its square the drop of the sum of squares; 0 for one that the model absorbs.
    pub fn score(&self, sums: &Sums) -> f64 {
        let square = self.square(sums);
        let left = square - sums.along.iter().map(|a| a * a).sum::<f64>();
        if left > 1e-10 * square { sums.product / left.sqrt() } else { 0.0 }
    }

    /// `c' V^-1 c`.
    fn square(&self, sums: &Sums) -> f64 {
        match (&self.diagonal, sums.rows.as_slice()) {
            (None, _) => sums.square,
            (Some(diagonal), [row]) => diagonal.at(*row),
            (Some(_), rows) => {
                let mut column = vec![0.0; self.weighted.weight.len()];
                for row in rows {
                    column.iter_mut().skip(*row).take(1).for_each(|v| *v = 1.0);
                }
                self.weighted.squares(&column)
            }
        }
    }
}
