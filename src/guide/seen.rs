//! What the readings so far could have shown of effects that the model may lack, and what the next position is worth.
//!
//! ```text
//! T = c'(1 - H)c,  t = c'(1 - H)r          an effect's column given the model, at the readings that were taken
//! B = E exp(a t - a^2 T / 2),  a ~ N(+-m, s^2)           how much more probable the readings are with it than without
//! P(nothing is missing) = 1 / (1 + mean of B over the effects)          even odds beforehand, each effect alike
//! worth = sum over goals of ln(u / u') + what the reading tells of which effect is missing, or none, and of its size      [nats]
//! worth = ln |1 + A C A'| / 2,  while an unknown is not determined that could be
//! - sum over i of p_i ln sum over j of p_j exp(-D_ij)      D: Bhattacharyya's distance of the readings that two hypotheses predict
//! ```
//!
//! `m` and `s` are in units of the effect's standard uncertainty when every candidate was taken once. What a position changes, `u'` and `T'`, are
//! updates of low rank. The sum over pairs is a lower bound of the information about the hypothesis (A. Kolchinsky, B. D. Tracey, Entropy 19 (2017)
//! 361).
#![allow(
    clippy::indexing_slicing,
    reason = "a table has one column for each effect, with a row for each sensor at each position"
)]

use super::advice::Suspected;
use super::evidence::{Beliefs, Judge, Rows, Solved, Source, Told, same_state};
use crate::campaign::{Campaign, Reading, Readings};
use crate::design::RowOrigin;
use crate::diagnosis::{Alike, Effect, Prospect, directions};
use crate::elements::Parts;
use crate::error::Result;
use crate::linear::{Triangle, dot};
use crate::plan::{Costs, Goal, Noise, gradients};
use crate::simulate::Regressor;

/// Size of an effect that counts as missing, and its spread: ten to forty times its uncertainty when all candidates were taken, so that the whole
/// schedule would name it without fail.
const SIZE: f64 = 20.0;
const SPREAD: f64 = 7.0;

/// Candidates, and what each effect does there.
#[derive(Debug, Clone)]
pub(super) struct Table {
    pub positions: Vec<Reading>,
    effects: Vec<Column>,
    sensors: usize,
}

/// A position as a separate mounting: slopes, and effects, of a reading there.
type Block = (Vec<Vec<f64>>, Vec<Vec<f64>>);

#[derive(Debug, Clone)]
struct Column {
    name: String,
    regressor: String,
    /// One value for each sensor at each position.
    values: Vec<f64>,
    /// Its standard uncertainty when every candidate was taken once.
    u: f64,
}

impl Table {
    /// Of these positions; what an effect does there is taken at the reference point.
    pub fn new(model: &Campaign, positions: &[Reading], catalogue: &[Effect], noise: &Noise) -> Result<Self> {
        let rows = apart(positions);
        let all = model.with_readings(Readings { columns: model.readings.columns.clone(), rows });
        let foreseen = directions(&all, catalogue, noise)?;
        // what happens at one mounting alone is no matter where that mounting is not read; where it is, a reading there disagrees
        let lasting = |prospect: &&Prospect| !matches!(prospect.effect.kind, Regressor::Position(_));
        let members = |group: &Alike| group.members.iter().filter_map(|k| foreseen.prospects.get(*k)).find(lasting);
        let firsts = foreseen.groups.iter().filter_map(members);
        let effects: Vec<Column> = firsts
            .filter_map(|prospect| {
                Some(Column {
                    name: prospect.effect.name.clone(),
                    regressor: prospect.effect.regressor.clone(),
                    values: prospect.effect.column.clone(),
                    u: prospect.u?,
                })
            })
            .collect();
        Ok(Table { positions: positions.to_vec(), effects, sensors: model.bench.sensors.len() })
    }

    fn blocks(&self, judge: Judge, point: &[f64]) -> Result<Vec<Block>> {
        let positions = apart(&self.positions);
        // with scatter, readings of one call are not independent of each other
        let together = if judge.model.scatter.is_empty() { positions.len() } else { 1 };
        let mut blocks: Vec<Block> = Vec::with_capacity(positions.len());
        for (chunk, first) in positions.chunks(together.max(1)).zip((0..).step_by(together.max(1))) {
            let block = Rows::of(judge.model, judge.beliefs, chunk, point, judge.noise)?;
            let values = |effect: &Column| {
                let value = |origin: &RowOrigin| {
                    let at = (first + origin.reading) * self.sensors + origin.sensor;
                    effect.values.get(at).copied().unwrap_or(0.0)
                };
                block.white(block.design.rows.iter().map(value).collect())
            };
            let columns: Vec<Vec<f64>> = self.effects.iter().map(values).collect();
            let places: Vec<usize> = (0..block.design.rows.len()).collect();
            for rows in places.chunk_by(|a, b| block.design.rows[*a].reading == block.design.rows[*b].reading) {
                let of = |column: &Vec<f64>| rows.iter().map(|i| column[*i]).collect();
                blocks
                    .push((rows.iter().map(|i| block.slopes[*i].clone()).collect(), columns.iter().map(of).collect()));
            }
        }
        Ok(blocks)
    }

    /// The position of a reading in the table: the same joints and columns.
    pub fn find(&self, reading: &Reading) -> Option<usize> {
        self.positions.iter().position(|position| same_position(position, reading))
    }
}

/// The same setting with the same further columns.
pub(super) fn same_position(a: &Reading, b: &Reading) -> bool {
    a.joints.iter().zip(&b.joints).all(|(a, b)| same_state(a, b)) && (!a.joints.is_empty() || a.columns == b.columns)
}

/// Positions without readings, each a separate mounting.
fn apart(positions: &[Reading]) -> Vec<Reading> {
    let apart = |(k, reading): (usize, &Reading)| {
        let alone = positions.iter().filter(|other| other.position == reading.position).count() == 1;
        let label = &reading.position;
        let position = if alone && !label.is_empty() { label.clone() } else { format!("{label} ({})", k + 1).into() };
        Reading { position, ..reading.unread() }
    };
    positions.iter().enumerate().map(apart).collect()
}

/// The posterior of the readings, and what they would have shown.
#[derive(Debug, Clone)]
pub(super) struct Seen {
    beliefs: Beliefs,
    posterior: Told,
    blocks: Vec<Block>,
    /// What all positions tell, however often they are read.
    at_most: Option<Told>,
    effects: Vec<One>,
}

#[derive(Debug, Clone)]
struct One {
    name: String,
    regressor: String,
    u: f64,
    /// Information of its coefficient.
    t_square: f64,
    /// Mean and variance of its coefficient, if it is the one that is missing.
    mean: f64,
    variance: f64,
    /// What the model takes up of it.
    absorbed: Vec<f64>,
    /// Logarithm of how much more probable the readings are with it.
    evidence: f64,
}

/// What a position is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Worth {
    pub position: usize,
    pub nats: f64,
    pub cost: f64,
}

/// What is wanted of the next position.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// These goals, each with the u that it has now where a fit tells it.
    pub goals: &'a [(Goal, Option<f64>)],
    /// To see what may be missing.
    pub effects: bool,
    /// Where the bench stands.
    pub last: Option<&'a Reading>,
    pub costs: &'a Costs,
}

/// What setting a position and reading it costs from where the bench stands.
pub(super) fn cost_from(last: Option<&Reading>, position: &Reading, costs: &Costs) -> f64 {
    let run: Vec<Reading> = last.into_iter().chain([position]).cloned().collect();
    costs.work(&run).cost - costs.work(run.part(..run.len() - 1)).cost
}

/// What is wanted, in numbers.
struct Weighing<'a> {
    seen: &'a Seen,
    /// Is an unknown not determined that could be?
    open: bool,
    effects: bool,
    /// Of each direction of a goal: `L^-1 a`, its variance, and the one that is wanted.
    limits: Vec<(Vec<f64>, f64, f64)>,
    /// Probability that nothing is missing, and of the effects that count.
    nothing: f64,
    likely: Vec<(usize, f64)>,
}

impl Weighing<'_> {
    /// Would all goals be met by a reading at a position that is held for this share of what was planned?
    fn meets(&self, (rows, _): &Block, share: f64) -> bool {
        let scale = share.sqrt();
        let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.iter().map(|a| a * scale).collect()).collect();
        let Some((through, factor)) = self.through(&rows) else { return false };
        self.limits.iter().all(|(along, variance, limit)| {
            let mut reduced: Vec<f64> = through.iter().map(|row| dot(row, along)).collect();
            factor.forward(&mut reduced);
            variance - dot(&reduced, &reduced) <= *limit
        })
    }

    /// The rows of a position by `L^-1`, and the factor of what they would spread by.
    fn through(&self, rows: &[Vec<f64>]) -> Option<(Vec<Vec<f64>>, Triangle)> {
        let through: Vec<Vec<f64>> = rows.iter().map(|row| self.seen.posterior.through(row)).collect();
        let spread = |i: usize, j: usize| f64::from(u8::from(i == j)) + dot(&through[i], &through[j]);
        let factor = Triangle::of(rows.len(), spread, |_| 0.0)?;
        Some((through, factor))
    }

    /// What a position tells, in nats.
    fn nats(&self, (rows, columns): &Block) -> Option<f64> {
        let seen = self.seen;
        let (through, factor) = self.through(rows)?;
        let square = |mut column: Vec<f64>| {
            factor.forward(&mut column);
            dot(&column, &column)
        };
        let of_goal = |(along, variance, limit): &(Vec<f64>, f64, f64)| {
            let less = variance - square(through.iter().map(|row| dot(row, along)).collect());
            // beyond the goal nothing is gained
            0.5 * (variance.max(*limit) / less.max(*limit)).ln()
        };
        let missing = || {
            let none =
                Hypothesis { probability: self.nothing, mean: vec![0.0; rows.len()], variance: vec![1.0; rows.len()] };
            let one = |(k, probability): &(usize, f64)| {
                let (effect, column) = (&seen.effects[*k], &columns[*k]);
                let mut error: Vec<f64> =
                    rows.iter().zip(column).map(|(row, f)| f - dot(row, &effect.absorbed)).collect();
                factor.forward(&mut error);
                let mean = error.iter().map(|e| effect.mean * e).collect();
                let variance = error.iter().map(|e| 1.0 + effect.variance * e * e).collect();
                Hypothesis { probability: *probability, mean, variance }
            };
            let all: Vec<Hypothesis> = [none].into_iter().chain(self.likely.iter().map(one)).collect();
            mutual_information(&all)
        };
        Some(match self.open {
            true => 0.5 * factor.log_determinant(),
            false if self.effects => self.limits.iter().map(of_goal).sum::<f64>() + missing(),
            false => self.limits.iter().map(of_goal).sum(),
        })
    }
}

impl Seen {
    /// Of the readings as they were solved.
    pub fn new(table: &Table, judge: Judge, taken: &[Reading], solved: &Solved) -> Result<Self> {
        let Solved { point, rows, posterior, .. } = solved;
        let (white, white_residual) = (&rows.slopes, &rows.white_residual);
        let blocks = table.blocks(judge, point)?;
        let every: Vec<Vec<f64>> =
            blocks.iter().flat_map(|(rows, _)| rows).map(|row| row.iter().map(|a| a * OFTEN).collect()).collect();
        let at_most = Told::of(judge.beliefs, &every);
        let places: Vec<Option<usize>> = taken.iter().map(|reading| table.find(reading)).collect();
        let residual: Vec<f64> =
            white.iter().zip(white_residual).map(|(row, v)| v - dot(row, &posterior.estimate)).collect();
        let effects = table.effects.iter().map(|effect| {
            let value = |origin: &RowOrigin| {
                let place = places.get(origin.reading).copied().flatten()?;
                effect.values.get(place * table.sensors + origin.sensor).copied()
            };
            let column = rows.white(rows.design.rows.iter().map(|origin| value(origin).unwrap_or(0.0)).collect());
            let absorbed = posterior.solved(white, &column);
            let left: Vec<f64> = white.iter().zip(&column).map(|(row, c)| c - dot(row, &absorbed)).collect();
            // what rounding leaves of a column that the model takes up is nothing
            let t_square = dot(&left, &column).max(0.0);
            let t = dot(&column, &residual);
            let (evidence, mean, variance) = weighed(t * effect.u, t_square * effect.u * effect.u);
            let (mean, variance) = (mean * effect.u, variance * effect.u * effect.u);
            let (name, regressor) = (effect.name.clone(), effect.regressor.clone());
            One { name, regressor, u: effect.u, t_square, mean, variance, absorbed, evidence }
        });
        let effects = effects.collect();
        Ok(Seen { beliefs: judge.beliefs.clone(), posterior: posterior.clone(), blocks, at_most, effects })
    }

    /// Every effect with the logarithm of how much more probable it makes the readings.
    pub fn explanations(&self) -> Vec<(String, f64)> {
        self.effects.iter().map(|effect| (effect.name.clone(), effect.evidence)).collect()
    }

    /// The effects that are most probable, with their probabilities.
    pub fn suspected(&self) -> Vec<Suspected> {
        let share = self.nothing_missing() / self.effects.len().max(1) as f64;
        let one = |effect: &One| Suspected {
            regressor: effect.regressor.clone(),
            name: effect.name.clone(),
            probability: share * effect.evidence.exp(),
        };
        let mut all: Vec<Suspected> = self.effects.iter().map(one).filter(|s| s.probability > LEAST).collect();
        all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        all.truncate(MOST);
        all
    }

    /// Probability that no effect of the catalogue, large enough for the whole schedule to name it, is missing.
    pub fn nothing_missing(&self) -> f64 {
        if self.effects.is_empty() {
            return 1.0;
        }
        let mean = self.effects.iter().map(|effect| effect.evidence.exp()).sum::<f64>() / self.effects.len() as f64;
        1.0 / (1.0 + mean)
    }

    /// Effects whose readings, if they were there, could still not be told from readings without them: readings without them would not make them
    /// twenty times less probable (0.95 of even odds).
    pub fn unseen(&self) -> usize {
        let shows = |effect: &&One| weighed(0.0, effect.t_square * effect.u * effect.u).0 < (1.0_f64 / 20.0).ln();
        self.effects.len() - self.effects.iter().filter(shows).count()
    }

    /// Do the readings not determine yet what these positions could: a parameter, or where they leave one undetermined what would be read at
    /// them?
    pub fn is_open(&self, model: &Campaign) -> bool {
        let (beliefs, posterior) = (&self.beliefs, &self.posterior);
        let could =
            |along: &Vec<f64>| self.at_most.as_ref().is_some_and(|possible| possible.determines(beliefs, along));
        let (possible, never): (Vec<_>, Vec<_>) = (0..model.unknowns()).map(|k| self.unit(k)).partition(could);
        // more than half of the variance of a reading, with its noise of one, is due to what was supposed
        let unpredicted = |row: &Vec<f64>| {
            let (variance, supposed) = posterior.variance_from(beliefs, row, &[Source::Supposed, Source::Nothing]);
            supposed > 0.5 * (variance + 1.0)
        };
        let mut rows = self.blocks.iter().flat_map(|(rows, _)| rows);
        possible.iter().any(|along| !posterior.determines(beliefs, along))
            || (!never.is_empty() && rows.any(unpredicted))
    }

    fn unit(&self, parameter: usize) -> Vec<f64> {
        let unit: Vec<f64> = (0..=parameter).map(|k| f64::from(u8::from(k == parameter))).collect();
        self.beliefs.along(&unit)
    }

    /// The directions of a goal among the unknowns.
    fn directions(&self, model: &Campaign, goal: &Goal) -> Result<Vec<Vec<f64>>> {
        if let Some(k) = model.parameter_index(&goal.id) {
            return Ok(vec![self.unit(k)]);
        }
        let Some(quantity) = model.derived.iter().find(|q| q.id == goal.id) else {
            return Ok(Vec::new());
        };
        Ok(gradients(model, quantity)?.0.iter().map(|gradient| self.beliefs.along(gradient)).collect())
    }

    /// What is wanted, in numbers.
    fn weighing<'a>(&'a self, model: &Campaign, wanted: &Wanted) -> Result<Weighing<'a>> {
        let open = self.is_open(model);
        let mut limits: Vec<(Vec<f64>, f64, f64)> = Vec::new();
        for (goal, u) in wanted.goals.iter().filter(|_| !open) {
            for direction in self.directions(model, goal)? {
                let variance = self.posterior.variance(&direction);
                // a fit that knows less than these rows, of aliases say, has further to go
                let ratio = u.map_or(1.0, |u| (variance / (u * u)).min(1.0));
                limits.push((self.posterior.through(&direction), variance, ratio * goal.u * goal.u));
            }
        }
        let nothing = self.nothing_missing();
        let share = nothing / self.effects.len().max(1) as f64;
        let likely: Vec<(usize, f64)> = (self.effects.iter().enumerate())
            .map(|(k, effect)| (k, share * effect.evidence.exp()))
            .filter(|(_, probability)| *probability > LEAST * share || *probability > LEAST)
            .collect();
        Ok(Weighing { seen: self, open, effects: wanted.effects, limits, nothing, likely })
    }

    /// What each position is worth, for its cost, the best first; nothing where no position tells anything.
    pub fn worth(&self, table: &Table, model: &Campaign, wanted: &Wanted) -> Result<Vec<Worth>> {
        let weighing = self.weighing(model, wanted)?;
        let one = |(position, block): (usize, &Block)| {
            Some(Worth {
                position,
                nats: weighing.nats(block)?,
                cost: cost_from(wanted.last, &table.positions[position], wanted.costs),
            })
        };
        let mut all: Vec<Worth> = self.blocks.iter().enumerate().filter_map(one).collect();
        let rate = |worth: &Worth| worth.nats / worth.cost.max(f64::MIN_POSITIVE);
        all.retain(|worth| worth.nats > NOTHING);
        all.sort_by(|a, b| rate(b).total_cmp(&rate(a)));
        Ok(all)
    }

    /// What all positions tell together where each is read so many times, in nats.
    pub fn together(&self, model: &Campaign, wanted: &Wanted, times: usize) -> Result<Option<f64>> {
        let root = (times as f64).sqrt();
        let often = |values: &Vec<f64>| values.iter().map(|value| value * root).collect::<Vec<f64>>();
        let rows = self.blocks.iter().flat_map(|(rows, _)| rows).map(often).collect();
        let column = |k: usize| self.blocks.iter().flat_map(|(_, columns)| often(&columns[k])).collect();
        let columns = (0..self.effects.len()).map(column).collect();
        Ok(self.weighing(model, wanted)?.nats(&(rows, columns)))
    }

    /// What share of the planned length a position is to be held for (in steps of two, for white noise): the smallest with which all goals are met, where
    /// nothing else is wanted; otherwise all of it.
    pub fn worth_holding(&self, table: &Table, model: &Campaign, wanted: &Wanted, position: &Reading) -> Result<f64> {
        let weighing = self.weighing(model, wanted)?;
        let block = table.find(position).and_then(|place| self.blocks.get(place));
        let Some(block) = block.filter(|_| !weighing.open && !wanted.effects) else { return Ok(1.0) };
        let shares = (0..=HALVINGS).rev().map(|k| 0.5_f64.powi(k));
        Ok(shares.into_iter().find(|share| weighing.meets(block, *share)).unwrap_or(1.0))
    }

    /// Goals that all candidates together, however often they are taken, do not reach.
    pub fn unreachable(&self, model: &Campaign, goals: &[Goal]) -> Result<Vec<String>> {
        let mut unreachable = Vec::new();
        for goal in goals {
            let directions = self.directions(model, goal)?;
            let reached = |direction: &Vec<f64>| {
                self.at_most.as_ref().is_some_and(|all| {
                    all.determines(&self.beliefs, direction) && all.variance(direction) <= goal.u * goal.u
                })
            };
            if directions.is_empty() || !directions.iter().all(reached) {
                unreachable.push(goal.id.clone());
            }
        }
        Ok(unreachable)
    }
}

/// The most effects that are listed as suspected, and their least probability.
const MOST: usize = 8;
const LEAST: f64 = 0.001;
/// Fewer nats than these are nothing.
const NOTHING: f64 = 1e-6;
/// Halvings of the length of a hold that are weighed: down to eight times what u is planned as, which is beyond what one more reading is asked for.
const HALVINGS: i32 = 6;
/// Readings, as a square root, that represent any number of them.
const OFTEN: f64 = 1e2;

/// `ln B`, and mean and variance of the effect's size, with `t` and `T` in units of its uncertainty when all candidates were taken.
fn weighed(t: f64, information: f64) -> (f64, f64, f64) {
    let s = SPREAD * SPREAD;
    let variance = (information + 1.0 / s).recip();
    let mean = |m: f64| variance * (t + m / s);
    let side = |m: f64| 0.5 * (mean(m).powi(2) / variance - m * m / s);
    let (a, b) = (side(SIZE), side(-SIZE));
    let most = a.max(b);
    let (a, b) = ((a - most).exp(), (b - most).exp());
    let share = a / (a + b);
    let both = share * mean(SIZE) + (1.0 - share) * mean(-SIZE);
    let apart = share * (1.0 - share) * (mean(SIZE) - mean(-SIZE)).powi(2);
    (-0.5 * (s * information).ln_1p() + most + (0.5 * (a + b)).ln(), both, variance + apart)
}

/// What the reading of a position would be under a hypothesis, in coordinates in which it is independent and of unit variance if nothing is missing.
struct Hypothesis {
    probability: f64,
    mean: Vec<f64>,
    variance: Vec<f64>,
}

/// Nats that a reading tells of which hypothesis holds, and of the size of its effect.
fn mutual_information(all: &[Hypothesis]) -> f64 {
    // exp(-D) of Bhattacharyya's distance D, value by value
    let overlap = |a: &Hypothesis, b: &Hypothesis| {
        let (mut product, mut apart) = (1.0, 0.0);
        for (((m, n), v), w) in a.mean.iter().zip(&b.mean).zip(&a.variance).zip(&b.variance) {
            let sum = v + w;
            product *= 4.0 * v * w / (sum * sum);
            apart += (m - n).powi(2) / sum;
        }
        product.powf(0.25) * (-0.25 * apart).exp()
    };
    let mut sums: Vec<f64> = all.iter().map(|h| h.probability).collect();
    for (i, a) in all.iter().enumerate() {
        for (j, b) in all.iter().enumerate().skip(i + 1) {
            let shared = overlap(a, b);
            sums[i] += b.probability * shared;
            sums[j] += a.probability * shared;
        }
    }
    let which = all.iter().zip(&sums).map(|(h, sum)| -h.probability * sum.ln()).sum::<f64>();
    let size = |h: &Hypothesis| h.probability * 0.5 * h.variance.iter().map(|v| v.ln()).sum::<f64>();
    which.max(0.0) + all.iter().map(size).sum::<f64>()
}
