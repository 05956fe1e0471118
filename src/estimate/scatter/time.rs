//! What is estimated of noise that is correlated in time: variances and correlation times together.
//!
//! Where deviations with a memory are all that scatters beside the rows' own noise, one filter along time makes rows independent (`chain.rs`) and Newton's steps
//! lead to the top of the likelihood (`restricted.rs`). Where they meet other deviations in the same rows, correlation times are sought with the variances
//! (`problem.rs`), by the average information.
#![allow(
    clippy::indexing_slicing,
    reason = "`open` holds numbers of lines, with one range and value each; rows and levels are those of the system and the lines, which `System::check` and `ScatterLine::levels` have seen"
)]

use super::chain::{Chain, Part, TimeNoise};
use super::inference;
use super::problem::{Ended, FULL, Point, Problem, UNSEEN};
use super::restricted::{Limits, NEWTON_STEPS, NoiseModel, PartNoise, Slot, Sums, Top};
use super::{LineState, ScatterLine, Whitening, remember};
use crate::elements::Elements;
use crate::error::Result;
use faer::Mat;

/// Lines with every correlation time set.
pub(super) struct Timed {
    /// `None` where they are as they were.
    pub lines: Option<Vec<ScatterLine>>,
    /// Line, correlation time and its standard uncertainty, of those that were estimated.
    pub found: Vec<(usize, f64, Option<f64>)>,
    /// The variances found on the way; empty where nothing was searched.
    pub start: Vec<f64>,
    /// Where one filter along time was enough: the top of the likelihood.
    pub along: Option<Along>,
}

/// The likelihood along time, at its top.
pub(super) struct Along {
    pub model: NoiseModel,
    pub top: Top,
    /// How the unknowns follow the columns that the parts have.
    pub directions: Mat<f64>,
    /// For each free parameter behind those of the components, the line whose correlation time it is.
    pub times: Vec<usize>,
}

/// Steps of the search need no more digits than the deviance has.
const SEARCH: Limits = Limits { steps: FULL.steps, settled: 1e-8 };
/// Points of a first look at a correlation time.
const LOOK: usize = 7;
/// Variances of the deviation in those of the white noise at which a search may begin.
const RATIOS: [f64; 3] = [0.1, 2.0, 40.0];
/// Share of the plain estimate of a variance below which nothing is looked for.
const LEAST: f64 = 1e-12;
/// How far above the plain estimate a variance may be, in logarithms.
const FURTHEST: f64 = 60.0;

/// Set the correlation times of lines that have none, and find the variances where one filter along time is enough. `start` and `known` are variances and
/// correlation times from a step nearby; empty where there is none.
pub(super) fn with_times(problem: &Problem<'_>, start: &[f64], known: &[f64]) -> Result<Timed> {
    let lines = problem.lines;
    let open: Vec<usize> =
        (0..lines.len()).filter(|k| lines[*k].memory.as_ref().is_some_and(|m| m.tau.is_none())).collect();
    if lines.iter().all(|line| line.memory.is_none()) || problem.members.count + open.len() == 0 {
        return Ok(Timed { lines: None, found: Vec::new(), start: start.to_vec(), along: None });
    }
    let mut own = lines.to_vec();
    if let Some(chains) = Chains::of(problem)? {
        let along = chains.top(problem, start, known)?;
        let count = problem.members.count;
        let spread = super::restricted::spread(&along.top.found.bend, &along.inside());
        let mut found = Vec::with_capacity(open.len());
        for k in &open {
            let Some(at) = along.times.iter().position(|own| own == k).map(|place| count + place) else { continue };
            let tau = along.top.at[at].exp();
            remember(&mut own, *k, tau);
            let u = Some(tau * spread[(at, at)].sqrt()).filter(|u| *u > 0.0 && u.is_finite());
            found.push((*k, tau, u));
        }
        let theta = along.top.at[..count].iter().map(|x| x.exp()).collect();
        return Ok(Timed { lines: Some(own), found, start: theta, along: Some(along) });
    }
    if known.len() != open.len() {
        return problem.times_beside(&open, own);
    }
    open.iter().zip(known).for_each(|(k, tau)| remember(&mut own, *k, *tau));
    let found = open.iter().zip(known).map(|(k, tau)| (*k, *tau, None)).collect();
    Ok(Timed { lines: Some(own), found, start: start.to_vec(), along: None })
}

/// Logarithms of the least and largest variance factor of white noise, from what it is if nothing else scatters and from that of rounding.
pub(crate) fn white_range(plain: f64, floor: f64) -> (f64, f64) {
    ((LEAST * plain).max(floor).ln(), plain.ln() + FURTHEST)
}

/// The same of the variance of a deviation, from the variance of the white noise beside it.
pub(crate) fn deviation_range(white: f64) -> (f64, f64) {
    (white.ln() + UNSEEN.ln(), white.ln() + FURTHEST)
}

/// `from` to `to`, so many, evenly.
fn spaced((from, to): (f64, f64), count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| from + (to - from) * k as f64 / (count.max(2) - 1) as f64)
}

/// Rows of one line and one group, or of one group without a line, in the order of time.
struct Series {
    /// The last column is what was observed.
    rows: Mat<f64>,
    time: Vec<f64>,
    sd: Vec<f64>,
    /// Where runs begin.
    begins: Vec<usize>,
    /// `log` of the square of what the rows were divided by.
    logarithm: f64,
}

impl Series {
    fn part(&self, noise: TimeNoise, derivatives: bool) -> Result<Part> {
        let mut chain = Chain::new(self.rows.ncols(), noise, derivatives);
        let ends = self.begins.iter().skip(1).copied().chain([self.sd.len()]);
        for (from, to) in self.begins.iter().zip(ends) {
            chain.begin();
            chain.push(self.rows.subrows(*from, to - from), &self.time[*from..to], &self.sd[*from..to])?;
        }
        let mut part = chain.part();
        part.log_determinant[0] += self.logarithm;
        Ok(part)
    }
}

/// All rows as series, and what is free of their noise.
struct Chains {
    series: Vec<Series>,
    model: NoiseModel,
    times: Vec<usize>,
    directions: Mat<f64>,
    /// Variance factor of each series' white noise as if nothing else scattered, and variance of its relative noise.
    plain: Vec<(f64, f64)>,
}

impl Chains {
    /// `None` where other deviations are felt, where rows of different variance follow each other in a chain, or where nothing is left to tell of noise.
    fn of(problem: &Problem<'_>) -> Result<Option<Self>> {
        let Problem { system, lines, .. } = problem;
        let m = system.observed.len();
        let mut own: Vec<Option<(usize, usize, f64)>> = vec![None; m];
        let mut group_of_run = std::collections::HashMap::new();
        for (k, line) in lines.iter().enumerate() {
            for felt in line.felt.iter().filter(|felt| felt.by != 0.0 && felt.row < m) {
                let Some(memory) = &line.memory else { return Ok(None) };
                let run = memory.run.get(felt.level).copied().unwrap_or(0); // one run where none are told apart
                let group = problem.members.rows[felt.row];
                if own[felt.row].replace((k, felt.level, felt.by)).is_some()
                    || *group_of_run.entry((k, run)).or_insert(group) != group
                {
                    return Ok(None);
                }
            }
        }
        let plain = problem.adjust(system)?;
        let weight = &plain.factor.weight;
        let (q, n) = (&plain.factor.q, plain.factor.rank());
        let mut parts: std::collections::BTreeMap<(Option<usize>, Option<usize>), Vec<(usize, f64, usize)>> =
            std::collections::BTreeMap::new();
        for (row, own) in own.iter().enumerate() {
            let line = own.map(|(k, ..)| k);
            let (run, time) = own
                .and_then(|(k, level, _)| {
                    let memory = lines[k].memory.as_ref()?;
                    Some((memory.run.get(level).copied().unwrap_or(0), memory.time.at(level))) // likewise
                })
                .unwrap_or_default();
            parts.entry((line, problem.members.rows[row])).or_default().push((run, time, row));
        }
        let count = problem.members.count;
        let mut chains = Chains {
            series: Vec::with_capacity(parts.len()),
            model: NoiseModel { parts: Vec::with_capacity(parts.len()), range: vec![(0.0, 0.0); count], columns: n },
            times: Vec::new(),
            directions: plain.factor.whitened_directions(),
            plain: Vec::with_capacity(parts.len()),
        };
        for ((line, group), mut rows) in parts {
            rows.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
            let by = |row: usize| own[row].map_or(1.0, |(.., by)| by);
            let value = |i: usize, j: usize| {
                let row = rows[i].2;
                (if j < n { q[(row, j)] / weight[row] } else { plain.residuals[row] }) / by(row)
            };
            let sd: Vec<f64> = rows.iter().map(|(.., row)| system.u[*row] / by(*row).abs()).collect();
            let begins = (0..rows.len()).filter(|i| *i == 0 || line.is_some() && rows[*i].0 != rows[i - 1].0).collect();
            chains.series.push(Series {
                rows: Mat::from_fn(rows.len(), n + 1, value),
                time: rows.iter().map(|own| own.1).collect(),
                begins,
                logarithm: 2.0 * rows.iter().map(|(.., row)| by(*row).abs().ln()).sum::<f64>(),
                sd,
            });
            let sd = &chains.series[chains.series.len() - 1].sd;
            let natural = rows.len() as f64 / sd.iter().map(|sd| 1.0 / (sd * sd)).sum::<f64>();
            let factor = match group {
                Some(g) => plain.scale_or_one(g).powi(2).max(problem.floor[g]),
                None => 1.0,
            };
            if !(factor > 0.0 && natural > 0.0 && (factor * natural).is_finite()) {
                return Ok(None);
            }
            if let Some(g) = group {
                chains.model.range[g] = white_range(factor, problem.floor[g]);
            }
            let deviation = line.and_then(|k| {
                let memory = lines[k].memory.as_ref()?;
                let size = match (lines[k].variance, problem.component[k]) {
                    (None, Some(c)) => {
                        chains.model.range[c] = deviation_range(factor * natural);
                        Slot::Free(c)
                    }
                    (variance, _) => Slot::Stated(variance.unwrap_or(0.0)), // neither stated nor a component: not felt
                };
                let time = match memory.tau {
                    Some(tau) => Slot::Stated(tau),
                    None => {
                        if chains.times.last() != Some(&k) {
                            // parts come line by line
                            chains.model.range.push(lines[k].tau_range());
                            chains.times.push(k);
                        }
                        Slot::Free(count + chains.times.len() - 1)
                    }
                };
                Some((size, time))
            });
            chains.model.parts.push(PartNoise { white: group.map_or(Slot::Stated(1.0), Slot::Free), deviation });
            chains.plain.push((factor, natural));
        }
        Ok(Some(chains))
    }

    /// The top of the likelihood, from variances and correlation times nearby if there are some.
    fn top(self, problem: &Problem<'_>, start: &[f64], known: &[f64]) -> Result<Along> {
        let count = problem.members.count;
        let nearby = start.len() == count && known.len() == self.times.len() && start.iter().all(|t| *t > 0.0);
        let begin = if nearby {
            start.iter().chain(known).map(|x| x.ln()).collect()
        } else {
            let mut look = |s: usize, noise: TimeNoise| self.series[s].part(noise, false);
            self.model.begin(&self.plain, &mut look)?
        };
        let mut gather = |noises: &[TimeNoise]| {
            self.series.iter().zip(noises).map(|(series, noise)| series.part(*noise, true)).collect()
        };
        let top = self.model.top(&begin, NEWTON_STEPS, &mut gather)?;
        Ok(Along { model: self.model, top, directions: self.directions, times: self.times })
    }
}

impl NoiseModel {
    /// Where the steps begin: for each part the best of a few noises, the others white. `plain` are each part's variance factor as if nothing were correlated, and the
    /// variance of its relative noise; `look` brings a part at some noise.
    pub(super) fn begin(
        &self,
        plain: &[(f64, f64)],
        look: &mut dyn FnMut(usize, TimeNoise) -> Result<Part>,
    ) -> Result<Vec<f64>> {
        let white = |(factor, _): &(f64, f64)| TimeNoise { white: *factor, deviation: 0.0, tau: 1.0 };
        let mut noises: Vec<TimeNoise> = plain.iter().map(white).collect();
        let mut parts = noises.iter().enumerate().map(|(s, noise)| look(s, *noise)).collect::<Result<Vec<Part>>>()?;
        let mut at = vec![0.0; self.range.len()];
        for s in 0..plain.len() {
            let own = self.parts[s];
            let mut best: Option<(f64, TimeNoise, Part)> = None;
            for noise in own.starts(plain[s], &self.range) {
                noises[s] = noise;
                parts[s] = look(s, noise)?;
                self.parts.iter().zip(&noises).for_each(|(own, noise)| own.set(*noise, &mut at));
                // a part that is not looked for yet is white
                let white = noises.iter().map(|noise| PartNoise::known(*noise)).collect();
                let here = NoiseModel { parts: white, range: Vec::new(), columns: self.columns };
                let Some(found) = here.likelihood(&[], &parts) else { continue };
                if best.as_ref().is_none_or(|(least, ..)| found.deviance < *least) {
                    best = Some((found.deviance, noise, parts[s].clone()));
                }
            }
            if let Some((_, noise, part)) = best {
                (noises[s], parts[s]) = (noise, part);
            }
        }
        self.parts.iter().zip(&noises).for_each(|(own, noise)| own.set(*noise, &mut at));
        Ok(at)
    }
}

impl PartNoise {
    /// Noises at which a search may begin.
    fn starts(&self, (factor, natural): (f64, f64), range: &[(f64, f64)]) -> Vec<TimeNoise> {
        let Some((size, time)) = self.deviation else {
            let white = if let Slot::Stated(white) = self.white { white } else { factor };
            return vec![TimeNoise { white, deviation: 0.0, tau: 1.0 }];
        };
        let times: Vec<f64> = match time {
            Slot::Stated(tau) => vec![tau],
            Slot::Free(k) => spaced(range[k], LOOK).map(f64::exp).collect(),
        };
        let sizes: Vec<(f64, f64)> = match (self.white, size) {
            (Slot::Free(_), Slot::Free(_)) => {
                RATIOS.map(|r| (factor / (1.0 + r), factor * natural * r / (1.0 + r))).to_vec()
            }
            (Slot::Stated(white), Slot::Free(_)) => RATIOS.map(|r| (white, white * natural * r)).to_vec(),
            (Slot::Free(_), Slot::Stated(q)) => RATIOS.map(|r| (factor / (1.0 + r), q)).to_vec(),
            (Slot::Stated(white), Slot::Stated(q)) => vec![(white, q)],
        };
        let with = |tau: f64| {
            sizes.iter().map(move |(white, deviation)| TimeNoise { white: *white, deviation: *deviation, tau })
        };
        times.into_iter().flat_map(with).collect()
    }

    /// The logarithms of what is free.
    fn set(&self, noise: TimeNoise, at: &mut [f64]) {
        let mut put = |slot: Slot, value: f64| {
            if let Slot::Free(k) = slot {
                at[k] = value.max(f64::MIN_POSITIVE).ln();
            }
        };
        put(self.white, noise.white);
        if let Some((size, time)) = self.deviation {
            put(size, noise.deviation);
            put(time, noise.tau);
        }
    }

    fn known(noise: TimeNoise) -> Self {
        let deviation = (noise.deviation > 0.0).then_some((Slot::Stated(noise.deviation), Slot::Stated(noise.tau)));
        PartNoise { white: Slot::Stated(noise.white), deviation }
    }
}

impl Along {
    /// Parameters whose information is told: those inside their ranges.
    pub fn inside(&self) -> Vec<usize> {
        (0..self.top.at.len()).filter(|k| !self.top.at_end[*k]).collect()
    }

    /// Covariance of the estimated variances, relative, `count` of them: components, then correlation times as `leaning` numbers them; and what estimating
    /// them adds to the covariance of the unknowns.
    pub fn costs(&self, count: usize, leaning: &[Option<usize>]) -> (Mat<f64>, Mat<f64>) {
        let components = self.top.at.len() - self.times.len();
        let place = |k: usize| k.checked_sub(components).map_or(Some(k), |time| leaning[self.times[time]]);
        let among: Vec<usize> = self.inside().into_iter().filter(|k| place(*k).is_some()).collect();
        let (own, correction) = self.top.found.costs(Some(&self.model), &among);
        let mut spread = Mat::zeros(count, count);
        for (k, a) in among.iter().filter_map(|k| Some((k, place(*k)?))) {
            for (h, b) in among.iter().filter_map(|h| Some((h, place(*h)?))) {
                spread[(a, b)] = own[(*k, *h)];
            }
        }
        (spread, &self.directions * correction * self.directions.transpose())
    }
}

impl Problem<'_> {
    /// The adjustment with variances that were found along time; `None` where the rows do not tell some of them apart.
    pub(super) fn ended_along(&mut self, along: &Along, theta: &[f64]) -> Result<Option<Ended>> {
        let point = self.at_or_fail(theta)?;
        let likelihood = self.likelihood(self.lines, &point, theta)?;
        let at_floor = along.top.at_end[..self.members.count].to_vec();
        let separated = self.separated(&likelihood);
        if (0..self.members.count).any(|c| !at_floor[c] && !separated.contains(&c)) {
            return Ok(None);
        }
        let could_be = |c: usize| {
            // the least factor of a group is what rounding makes of its rows: no zero
            let rounding = self.floor.get(c).is_some_and(|floor| theta[c] <= floor * (1.0 + 1e-9));
            let spread = (2.0 / likelihood.expected[(c, c)]).sqrt();
            Some((theta[c] * spread).sqrt()).filter(|sd| at_floor[c] && !rounding && sd.is_finite())
        };
        let could_be = (0..self.members.count).map(could_be).collect();
        for (component, state) in self.component.iter().zip(&mut self.state) {
            if component.is_some_and(|c| at_floor[c]) {
                *state = LineState::AtZero;
            }
        }
        Ok(Some(Ended {
            theta: theta.to_vec(),
            times: Vec::new(),
            point,
            likelihood,
            kept: (0..self.members.count).collect(),
            at_floor,
            restricted: None,
            could_be,
            is_open: false,
            iterations: along.top.iterations,
            converged: along.top.converged,
        }))
    }
}

impl Problem<'_> {
    /// The correlation times of the lines `open` beside other deviations: each from the best of a few, then together with the variances.
    fn times_beside(&self, open: &[usize], mut lines: Vec<ScatterLine>) -> Result<Timed> {
        let ranges: Vec<(f64, f64)> = open.iter().map(|k| lines[*k].tau_range()).collect();
        open.iter().zip(&ranges).for_each(|(k, (low, high))| remember(&mut lines, *k, (0.5 * (low + high)).exp()));
        let mut start = Vec::new();
        for (k, range) in open.iter().zip(&ranges) {
            let mut best: Option<(f64, f64)> = None;
            for x in spaced(*range, LOOK) {
                remember(&mut lines, *k, x.exp());
                let ended = self.again(self.system, &lines)?.solve_all(&start, SEARCH)?;
                // a start at zero would stay there
                let usable = ended.converged && !ended.at_floor.contains(&true) && ended.theta.iter().all(|t| *t > 0.0);
                if best.is_none_or(|(least, _)| ended.point.deviance < least) {
                    best = Some((ended.point.deviance, x));
                    start = if usable { ended.theta } else { Vec::new() };
                }
            }
            best.into_iter().for_each(|(_, x)| remember(&mut lines, *k, x.exp()));
        }
        let mut problem = self.again(self.system, &lines)?;
        problem.times = open.to_vec();
        let Ended { theta, times, likelihood, kept, at_floor, .. } = problem.solve(&start, FULL)?;
        let count = self.members.count;
        let inside = |j: &usize| times[*j].ln() > ranges[*j].0 && times[*j].ln() < ranges[*j].1;
        let free = kept.into_iter().filter(|c| !at_floor[*c]);
        let among: Vec<usize> = free.chain((0..open.len()).filter(inside).map(|j| count + j)).collect();
        let spread = super::restricted::spread(&likelihood.expected, &among);
        let u = |j: usize| Some(times[j] * spread[(count + j, count + j)].sqrt()).filter(|u| *u > 0.0 && u.is_finite());
        let found = open.iter().enumerate().map(|(j, k)| (*k, times[j], u(j))).collect();
        open.iter().zip(&times).for_each(|(k, tau)| remember(&mut lines, *k, *tau));
        let settled = theta.iter().all(|t| *t > 0.0) && !at_floor.contains(&true);
        Ok(Timed { lines: Some(lines), found, start: if settled { theta } else { Vec::new() }, along: None })
    }

    /// Adds the logarithm of a line's correlation time to the parameters of a likelihood.
    pub(super) fn lean(
        &self,
        lines: &[ScatterLine],
        point: &Point,
        line: usize,
        theta: &[f64],
        (sums, turned): (&mut Sums, &mut Vec<Mat<f64>>),
    ) {
        let (whitening, q) = (&point.whitening, &point.estimate.factor.q);
        let columns = q.ncols() + 1;
        let column = |k: usize| if k < q.ncols() { q.col_as_slice(k) } else { &point.estimate.residuals };
        let mut white = Mat::zeros(q.nrows(), columns);
        for k in 0..columns {
            let back = whitening.carry_back(column(k));
            let own = lean(&lines[line], self.variances(theta)[line], &back);
            white.col_as_slice_mut(k).copy_from_slice(&whitening.whiten(&own));
        }
        let gram = Mat::from_fn(columns, columns, |a, b| -crate::linear::dot(column(a), white.col_as_slice(b)));
        let first = (&gram + gram.transpose()) * faer::Scale(0.5);
        let slope = self.log_determinant_slope(lines, line, whitening.sd(), theta);
        let unknown = vec![None; turned.len() + 1];
        inference::add(sums, turned, (first, white), slope, unknown);
    }

    /// `tr(V^-1 V_k)` for the logarithm of a correlation time: central differences of the logarithm of the determinant, of fourth order.
    fn log_determinant_slope(&self, lines: &[ScatterLine], line: usize, sd: &[f64], theta: &[f64]) -> f64 {
        const STEP: f64 = 1e-2;
        let variances = self.variances(theta);
        let mut lines = lines.to_vec();
        // the line has a correlation time: it is one of those that were set
        let tau = lines[line].memory.as_ref().and_then(|memory| memory.tau).unwrap_or(1.0);
        let mut at = |x: f64| {
            remember(&mut lines, line, tau * (x * STEP).exp());
            Whitening::new(&self.pattern, sd, &lines, &variances).log_determinant()
        };
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * STEP)
    }
}

/// `tau dV/dtau y` of a line.
fn lean(line: &ScatterLine, variance: f64, values: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; values.len()];
    let Some((memory, tau)) = line.memory.as_ref().and_then(|memory| Some((memory, memory.tau?))) else { return out };
    let (felt, order) = (line.gathered(values), memory.order(line.levels()));
    let before = memory.carried(&felt, tau, order.iter());
    let after = memory.carried(&felt, tau, order.iter().rev());
    for own in line.felt.iter().filter(|own| own.row < values.len()) {
        out[own.row] += own.by * variance * (before[own.level].1 + after[own.level].1);
    }
    out
}
