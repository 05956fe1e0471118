//! Which calibration errors explain measured navigation errors, and the gap with them in the mission.
//!
//! ```text
//! gap = measured - predicted(mission),     gap = J x + noise,     J: one signature for each error source (signatures.rs)
//! ```
//!
//! The search is that of `tumble diagnose` ([`crate::diagnosis`]): the smallest complete set, family-wise probabilities, aliases,
//! nothing forced. Errors enter a navigator not quite linearly: what was found is put into the full simulation, the signatures are laid
//! through that point (`gap + J x`, Gauss-Newton), and the search is repeated until it settles. Random walks that the mission states are
//! whitened away (`whiten.rs`). Known errors of the mission are the current model: what is found is a change of them.
//!
//! Deliberately absent: errors that change in time. They come out as unexplained.

use super::errors::{ImuErrors, Kind, Source};
use super::measured::{CHANNEL_NAMES, CHANNELS, Cell, Measured};
use super::mission::Mission;
use super::remainder::{self, ChannelGap, Course, Remainder};
use super::separate::{self, Separation};
use super::signatures::{self, System};
use super::whiten::whiten;
use crate::diagnosis::plain::{self, Answer, Question};
use crate::diagnosis::{NoiseFrom, Settings, Step, Verdict};
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{self, Fold, Group};
use crate::uncertainty::quantiles::{chi_square_survival, normal_survival};
use faer::Mat;

/// Another error that explains the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Alias {
    /// The error.
    pub source: Source,
    /// The change that it would need, SI; `None` where it is not estimable.
    pub value: Option<f64>,
    /// The same column exactly, or only a fit that is not significantly worse?
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// Would it need a size that no navigator's unit has?
    pub absurd: bool,
    /// A second error that must then stand in the place of another finding.
    pub together_with: Option<Source>,
}

/// An error that the mission misses.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The error.
    pub source: Source,
    /// What the mission has to be changed by, SI.
    pub value: f64,
    /// Its standard uncertainty, SI.
    pub u: Option<f64>,
    /// Student's t (normal where the noise is stated), the other findings given.
    pub t: f64,
    /// Family-wise probability of evidence as strong by chance.
    pub p: f64,
    /// Share of the gap's sum of squares that it takes off, the others given.
    pub explains: f64,
    /// What else it could be.
    pub aliases: Vec<Alias>,
    /// Motions that would tell, best first.
    pub separate_by: Vec<Separation>,
}

/// A gap, in standard uncertainties (of innovations, where the mission has random walks).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Root mean square.
    pub rms: f64,
    /// Largest by size.
    pub max: f64,
    /// Sum of squares.
    pub chi_square: f64,
    /// Values minus errors fitted.
    pub dof: usize,
    /// Probability of a sum of squares as large by chance; `None` where only residuals tell the noise.
    pub p: Option<f64>,
}

/// What nothing explains.
#[derive(Debug, Clone, PartialEq)]
pub struct Unexplained {
    /// In one sentence.
    pub pattern: String,
    /// Mean gap by channel and part of the run, the most significant first.
    pub cells: Vec<remainder::Cell>,
    /// The errors that come nearest together; they are not accepted.
    pub nearest: Vec<Source>,
    /// The share of the gap's sum of squares that they would take off.
    pub nearest_explains: f64,
}

/// A single value that noise does not explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suspect {
    /// The value.
    pub cell: Cell,
    /// What is left of it, in standard uncertainties (of innovations, where the mission has random walks).
    pub z: f64,
}

/// Everything that a diagnosis of navigation errors found.
#[derive(Debug, Clone, PartialEq)]
pub struct NavigationDiagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The errors, the strongest first.
    pub findings: Vec<Finding>,
    /// The mission's errors as given.
    pub before: ImuErrors,
    /// The same with what was found.
    pub after: ImuErrors,
    /// Where the noise comes from.
    pub noise: NoiseFrom,
    /// The gap before and after.
    pub gap: [Gap; 2],
    /// The same by run and channel, in the channel's own unit.
    pub channels: Vec<ChannelGap>,
    /// The gap in time, for a picture.
    pub courses: Vec<Course>,
    /// What is unexplained.
    pub unexplained: Option<Unexplained>,
    /// Single values that noise does not explain after all that was found, the furthest first; none where only residuals tell the noise.
    pub suspects: Vec<Suspect>,
    /// The search's record.
    pub steps: Vec<Step>,
    /// How many errors were tried, and how many of them are distinct here.
    pub candidates: (usize, usize),
    /// Errors that these data cannot show at any size that a navigator's unit has.
    pub invisible: Vec<Source>,
    /// How often the full simulation was flown for a refit, and whether it settled.
    pub refits: (usize, bool),
}

/// Most rounds of search, refit and full simulation.
const PASSES: usize = 8;
/// A refit has settled when no error moves by more than this share of its standard uncertainty.
const SETTLED: f64 = 0.02;
/// Scales of the noise have settled when none moves by more than this share.
const STEADY: f64 = 0.02;
/// An error that even at its largest admissible size stays below so many standard deviations cannot be seen.
const UNSEEN: f64 = 5.0;

/// One question, and what is common to all passes.
struct Case<'a> {
    mission: &'a Mission,
    measured: &'a Measured,
    sources: Vec<Source>,
    system: System,
    values: Vec<f64>,
    channel: Vec<usize>,
    from: NoiseFrom,
    settings: Settings,
}

/// Diagnose measured navigation errors of a mission.
///
/// Errors: a significance outside (0, 1); random walks in the mission, but measured values without `u`; a navigator that the mission's own
/// errors carry over a pole.
///
/// ```
/// use tumble::navigate::{diagnose, errors::{ImuErrors, Source}, measured::{Measured, MeasuredRow}};
/// use tumble::navigate::{mission::{Mission, Site}, motion::Motion, signatures};
/// let site = Site { latitude: 0.8, longitude: 0.0, altitude: 0.0 };
/// let mission = Mission::new(site, 0.1, 7200.0, 60.0, Motion::default())?;
/// let times: Vec<f64> = (0..=120).map(|k| 60.0 * f64::from(k)).collect();
/// let hidden = ImuErrors::single(Source::named("accelerometer_bias_x").unwrap(), 1e-4);
/// let mut measured = Measured::default();
/// for (time, z) in times.iter().zip(signatures::predicted(&mission, &mission.motion, &hidden, &times)) {
///     measured.push(0, MeasuredRow { time: *time, value: z.map(Some), u: [1e-5, 1e-5, 1e-5, 0.01, 0.01, 5.0, 5.0].map(Some) });
/// }
/// let found = diagnose::diagnose(&mission, &measured, &Default::default())?;
/// assert_eq!(found.findings[0].source.id(), "accelerometer_bias_x");
/// assert!((found.findings[0].value / 1e-4 - 1.0).abs() < 1e-6);
/// # Ok::<(), tumble::error::Malformed>(())
/// ```
pub fn diagnose(mission: &Mission, measured: &Measured, settings: &Settings) -> Result<NavigationDiagnosis> {
    let case = Case::new(mission, measured, settings)?;
    let mut predicted = signatures::prediction(mission, measured, &mission.errors);
    let gap: Vec<f64> = case.values.iter().zip(&predicted).map(|(y, p)| y - p).collect();
    if gap.iter().any(|v| !v.is_finite()) {
        return Err(Malformed::new(Fault::Value, "the mission's own errors carry its navigator over a pole")
            .at_path("errors")
            .expected("errors with which the mission can be flown"));
    }
    let mut u = case.first_u(&gap);
    let mut change = vec![0.0; case.sources.len()];
    let mut named: Option<Vec<usize>> = None;
    let (mut refits, mut settled) = (0, false);
    let mut look = case.look(&u, &case.laid(&predicted, &change))?;
    for _ in 0..PASSES {
        let set = look.set();
        let Some(fit) = look.fit(&set).filter(|fit| !set.is_empty() && case.is_possible(&set, fit)) else {
            settled = set.is_empty();
            break;
        };
        let moved = set.iter().zip(&fit).any(|(j, (value, u))| {
            let before = change.get(*j).copied().unwrap_or_default();
            (value - before).abs() > SETTLED * u
        });
        let same = named.as_ref() == Some(&set);
        if same && !moved {
            settled = true;
            break;
        }
        change = case.as_change(&set, &fit);
        let flown = signatures::prediction(mission, measured, &case.with(&change));
        if flown.iter().any(|v| !v.is_finite()) {
            break;
        }
        predicted = flown;
        refits += 1;
        if case.from == NoiseFrom::Residuals {
            let left: Vec<f64> = case.values.iter().zip(&predicted).map(|(y, p)| y - p).collect();
            let better = case.u_of(&left, set.len(), &gap);
            let steady = better.iter().zip(&u).all(|(a, b)| (a - b).abs() <= STEADY * b);
            if !steady {
                u = better;
            }
        }
        named = Some(set);
        look = case.look(&u, &case.laid(&predicted, &change))?;
    }
    case.conclude(look, &gap, &predicted, &change, &u, (refits, settled))
}

impl<'a> Case<'a> {
    fn new(mission: &'a Mission, measured: &'a Measured, settings: &Settings) -> Result<Self> {
        if !(settings.significance > 0.0 && settings.significance < 1.0) {
            return Err(Malformed::new(Fault::Value, "the significance is no probability")
                .expected("a number between 0 and 1, for example 0.01")
                .found(settings.significance.to_string()));
        }
        let stated = measured.cells().all(|cell| cell.u.is_some());
        if mission.errors.is_noisy() && !stated {
            return Err(Malformed::new(Fault::Missing, "random walks and unknown noise cannot be told apart")
                .expected("a standard uncertainty (a column with _u) of everything measured, or a mission without random walks"));
        }
        Ok(Case {
            mission,
            measured,
            sources: Source::catalogue(),
            system: System::new(mission, measured),
            values: measured.cells().map(|cell| cell.value).collect(),
            channel: measured.cells().map(|cell| cell.channel).collect(),
            from: if stated { NoiseFrom::Stated } else { NoiseFrom::Residuals },
            settings: *settings,
        })
    }

    /// Stated standard uncertainties; where there are none, the gap's own size.
    fn first_u(&self, gap: &[f64]) -> Vec<f64> {
        let sizes = self.sizes(gap, 0);
        self.measured.cells().map(|cell| cell.u.unwrap_or(sizes[cell.channel.min(CHANNELS - 1)])).collect()
    }

    /// The same from what a fit left; no less than what rounding makes of the gap.
    fn u_of(&self, left: &[f64], fitted: usize, gap: &[f64]) -> Vec<f64> {
        let (sizes, first) = (self.sizes(left, fitted), self.sizes(gap, 0));
        let of = |channel: usize| sizes[channel].max(1e-9 * first[channel]);
        self.measured.cells().map(|cell| cell.u.unwrap_or(of(cell.channel.min(CHANNELS - 1)))).collect()
    }

    /// Root mean square of each channel, less the share of degrees of freedom that a fit took.
    fn sizes(&self, values: &[f64], fitted: usize) -> [f64; CHANNELS] {
        let mut sums = [(0.0, 0.0); CHANNELS];
        for (value, channel) in values.iter().zip(&self.channel) {
            sums.get_mut(*channel).into_iter().for_each(|(sum, count)| {
                *sum += value * value;
                *count += 1.0;
            });
        }
        let kept = 1.0 - (fitted as f64 / self.values.len().max(1) as f64).min(0.9);
        sums.map(|(sum, count): (f64, f64)| if sum > 0.0 { (sum / (count * kept)).sqrt() } else { 1.0 })
    }

    /// The mission's errors with a change.
    fn with(&self, change: &[f64]) -> ImuErrors {
        let mut errors = self.mission.errors;
        for (source, value) in self.sources.iter().zip(change).filter(|(_, value)| **value != 0.0) {
            source.set(&mut errors, source.of(&self.mission.errors) + value);
        }
        errors
    }

    /// `measured - predicted + J change`: the gap as a linear model through the point that was simulated.
    fn laid(&self, predicted: &[f64], change: &[f64]) -> Vec<f64> {
        let mut laid: Vec<f64> = self.values.iter().zip(predicted).map(|(y, p)| y - p).collect();
        for (column, value) in self.system.columns.iter().zip(change).filter(|(_, value)| **value != 0.0) {
            laid.iter_mut().zip(column).for_each(|(y, c)| *y += c * value);
        }
        laid
    }

    fn as_change(&self, set: &[usize], fit: &[(f64, f64)]) -> Vec<f64> {
        let mut change = vec![0.0; self.sources.len()];
        for (j, (value, _)) in set.iter().zip(fit) {
            change.get_mut(*j).into_iter().for_each(|slot| *slot = *value);
        }
        change
    }

    /// Would the mission still be one?
    fn is_possible(&self, set: &[usize], fit: &[(f64, f64)]) -> bool {
        set.iter().zip(fit).all(|(j, (value, _))| !self.is_absurd(*j, *value))
    }

    fn is_absurd(&self, index: usize, value: f64) -> bool {
        self.sources
            .get(index)
            .is_none_or(|source| !((source.of(&self.mission.errors) + value).abs() <= source.limit()))
    }

    /// One search with the noise and the linear model as they are.
    fn look(&self, u: &[f64], laid: &[f64]) -> Result<Look> {
        let mut columns = self.system.columns.clone();
        columns.push(laid.to_vec());
        whiten(self.measured, &self.system.walks, u, &mut columns);
        let mut invisible = Vec::new();
        let mut scale = Vec::with_capacity(columns.len());
        for (j, column) in columns.iter_mut().enumerate() {
            let norm = column.iter().map(|v| v * v).sum::<f64>().sqrt();
            if let Some(source) = self.sources.get(j)
                && !(norm * source.limit() > UNSEEN)
            {
                invisible.push(*source);
                column.fill(0.0);
            }
            let size = if norm > 0.0 && j < self.sources.len() { norm } else { 1.0 };
            column.iter_mut().for_each(|v| *v /= size);
            scale.push(size);
        }
        let triangle = fold(&columns)?;
        let k = self.sources.len();
        let column = |j: usize| (0..=k).map(|i| triangle[(i, j)]).collect::<Vec<f64>>();
        let folded: Vec<Vec<f64>> = (0..k).map(column).collect();
        let residual = column(k);
        let handicap: Vec<f64> = self
            .sources
            .iter()
            .enumerate()
            .map(|(j, source)| {
                let own = folded.get(j).map(Vec::as_slice).unwrap_or_default();
                let square: f64 = own.iter().map(|v| v * v).sum();
                let along: f64 = own.iter().zip(&residual).map(|(a, b)| a * b).sum();
                let alone = if square > 0.0 { along / square / scale.get(j).copied().unwrap_or(1.0) } else { 0.0 };
                0.4 * rank(source) + if self.is_absurd(j, alone) { 5.0 } else { 0.0 }
            })
            .collect();
        let answer = plain::search(&Question {
            columns: &folded,
            residual: &residual,
            rows: self.values.len(),
            from: self.from,
            handicap: &handicap,
            significance: self.settings.significance,
        })?;
        Ok(Look { answer, folded, residual, scale, invisible })
    }

    fn gap(&self, left: &[f64], u: &[f64], fitted: usize) -> Gap {
        let mut columns = [left.to_vec()];
        whiten(self.measured, &self.system.walks, u, &mut columns);
        let [white] = columns;
        let chi_square: f64 = white.iter().map(|v| v * v).sum();
        let dof = white.len().saturating_sub(fitted);
        let max = white.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
        let stated = self.from == NoiseFrom::Stated && dof > 0;
        let p = if stated { chi_square_survival(chi_square, dof as f64) } else { None };
        Gap { rms: (chi_square / dof.max(1) as f64).sqrt(), max, chi_square, dof, p }
    }

    fn conclude(
        &self,
        look: Look,
        gap: &[f64],
        predicted: &[f64],
        change: &[f64],
        u: &[f64],
        refits: (usize, bool),
    ) -> Result<NavigationDiagnosis> {
        let left: Vec<f64> = self.values.iter().zip(predicted).map(|(y, p)| y - p).collect();
        let name = |j: &usize| self.sources.get(*j).map_or(String::new(), Source::id);
        let steps: Vec<Step> = look
            .answer
            .steps
            .iter()
            .map(|step| Step {
                with: step.with.iter().map(name).collect(),
                strongest: step.strongest.map(|(j, t, p)| (name(&j), t, p)),
                global_p: step.global,
            })
            .collect();
        let set = look.set();
        let before = self.gap(gap, u, 0);
        let after = self.gap(&left, u, set.len());
        // what the linear model accepts must hold in the full simulation
        let holds = after.p.is_none_or(|p| p > 0.2 * self.settings.significance) && refits.1;
        let fit = look.fit(&set).filter(|fit| self.is_possible(&set, fit) && holds);
        let (verdict, findings) = match (&look.answer.verdict, &fit) {
            _ if self.values.len() < 3 => (Verdict::NotDiagnosable, Vec::new()),
            (plain::Verdict::Nothing, _) => (Verdict::NothingMissing, Vec::new()),
            (plain::Verdict::Found(members), Some(fit)) => {
                let mut findings = self.findings(&look, members, fit);
                separate::separate(self.mission, self.measured, u, &look, &set, &mut findings)?;
                findings.sort_by(|a, b| b.t.abs().total_cmp(&a.t.abs()));
                (Verdict::EffectsFound, findings)
            }
            _ => (Verdict::Unexplained, Vec::new()),
        };
        let found = verdict == Verdict::EffectsFound;
        let (change, left, after) = if found { (change.to_vec(), &left[..], after) } else { (Vec::new(), gap, before) };
        let suspects = if verdict == Verdict::Unexplained { Vec::new() } else { self.suspects(left, u) };
        // what no name explains is not nothing
        let verdict = match verdict {
            Verdict::NothingMissing if !suspects.is_empty() => Verdict::Unexplained,
            other => other,
        };
        let rest = Remainder { mission: self.mission, measured: self.measured, u, before: gap, after: left };
        let unexplained = (verdict == Verdict::Unexplained).then(|| {
            let share = match &look.answer.verdict {
                plain::Verdict::Unexplained(_, share) => *share,
                plain::Verdict::Found(members) => members.iter().map(|m| m.explains).sum::<f64>().min(1.0),
                plain::Verdict::Nothing => 0.0,
            };
            let (cells, mut pattern) = rest.pattern();
            if let Some(worst) = suspects.first() {
                let name = CHANNEL_NAMES.get(worst.cell.channel).copied().unwrap_or_default();
                let more = suspects.len() - 1;
                let more = if more > 0 { format!(" (and {more} more)") } else { String::new() };
                pattern = format!(
                    "the gap is noise but for single values: {name} at {} s is {:.1} u off{more}",
                    worst.cell.time, worst.z
                );
            }
            let nearest = set.iter().filter_map(|j| self.sources.get(*j).copied()).collect();
            Unexplained { pattern, cells, nearest, nearest_explains: share }
        });
        Ok(NavigationDiagnosis {
            verdict,
            findings,
            before: self.mission.errors,
            after: self.with(&change),
            noise: self.from,
            gap: [before, after],
            channels: rest.channels(),
            courses: rest.courses(),
            unexplained,
            suspects,
            steps,
            candidates: (self.sources.len(), look.answer.tests),
            invisible: look.invisible,
            refits,
        })
    }

    /// Single values further off than noise goes among so many, with what the significance leaves for them.
    fn suspects(&self, left: &[f64], u: &[f64]) -> Vec<Suspect> {
        if self.from != NoiseFrom::Stated {
            return Vec::new();
        }
        let mut columns = [left.to_vec()];
        whiten(self.measured, &self.system.walks, u, &mut columns);
        let [white] = columns;
        let level = 0.1 * self.settings.significance / white.len().max(1) as f64;
        let far = |z: f64| normal_survival(z.abs()).is_some_and(|p| 2.0 * p < level);
        let pairs = self.measured.cells().zip(white).filter(|(_, z)| far(*z));
        let mut suspects: Vec<Suspect> = pairs.map(|(cell, z)| Suspect { cell, z }).collect();
        suspects.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        suspects
    }

    fn findings(&self, look: &Look, members: &[plain::Member], fit: &[(f64, f64)]) -> Vec<Finding> {
        let set: Vec<usize> = members.iter().map(|member| member.index).collect();
        let source = |j: usize| self.sources.get(j).copied();
        let finding = |place: usize, member: &plain::Member, (value, u): (f64, f64)| -> Option<Finding> {
            let alias = |own: &plain::Alias| -> Option<Alias> {
                let mut other = set.clone();
                other.iter_mut().enumerate().for_each(|(k, slot)| match own.together {
                    _ if k == place => *slot = own.index,
                    Some(second) => *slot = second,
                    None => {}
                });
                let value = look.fit(&other).and_then(|fit| fit.get(place).map(|(value, _)| *value));
                Some(Alias {
                    source: source(own.index)?,
                    value,
                    exact: own.exact,
                    excess: own.excess,
                    absurd: value.is_some_and(|value| self.is_absurd(own.index, value)),
                    together_with: own.together.and_then(source),
                })
            };
            let mut aliases: Vec<Alias> = member.aliases.iter().filter_map(alias).collect();
            let order = |a: &Alias| (a.absurd, !a.exact, a.together_with.is_some(), rank(&a.source) as u8);
            aliases.sort_by(|a, b| order(a).cmp(&order(b)).then(a.excess.total_cmp(&b.excess)));
            Some(Finding {
                source: source(member.index)?,
                value,
                u: Some(u).filter(|u| u.is_finite()),
                t: member.t,
                p: member.p,
                explains: member.explains,
                aliases,
                separate_by: Vec::new(),
            })
        };
        members.iter().zip(fit).enumerate().filter_map(|(k, (member, fit))| finding(k, member, *fit)).collect()
    }
}

/// One search: its answer, and the folded system that it looked at.
pub(super) struct Look {
    pub answer: Answer,
    /// Weighted columns of all sources, folded and scaled; zero where nothing can be seen.
    pub folded: Vec<Vec<f64>>,
    pub residual: Vec<f64>,
    /// What each column was divided by.
    pub scale: Vec<f64>,
    pub invisible: Vec<Source>,
}

impl Look {
    /// What was found, or what came nearest.
    fn set(&self) -> Vec<usize> {
        match &self.answer.verdict {
            plain::Verdict::Nothing => Vec::new(),
            plain::Verdict::Found(members) => members.iter().map(|member| member.index).collect(),
            plain::Verdict::Unexplained(nearest, _) => nearest.clone(),
        }
    }

    /// Least squares of some sources alone: value and standard uncertainty of each, SI; `None` where they are not independent.
    fn fit(&self, set: &[usize]) -> Option<Vec<(f64, f64)>> {
        let columns: Option<Vec<&Vec<f64>>> = set.iter().map(|j| self.folded.get(*j)).collect();
        let columns = columns?;
        let m = self.residual.len();
        let rows = Mat::from_fn(m, columns.len(), |i, j| columns.get(j).and_then(|c| c.get(i)).copied().unwrap_or(0.0));
        let system =
            estimate::System { rows, observed: self.residual.clone(), u: vec![1.0; m], group: vec![Group::Known; m] };
        let estimate = estimate::adjust(&system, &estimate::Settings::default()).ok()?;
        if estimate.rank < set.len() {
            return None;
        }
        let scale = |k: usize| set.get(k).and_then(|j| self.scale.get(*j)).copied().unwrap_or(1.0);
        let pairs = estimate.solution.iter().zip(&estimate.standard_uncertainty).enumerate();
        Some(pairs.map(|(k, (value, u))| (value / scale(k), u.unwrap_or(f64::INFINITY) / scale(k))).collect())
    }
}

/// Order among errors that the data cannot tell apart: the most common first.
fn rank(source: &Source) -> f64 {
    match source.kind {
        Kind::Bias => 0.0,
        Kind::ScaleFactor | Kind::Installation => 1.0,
        Kind::Attitude => 2.0,
        Kind::Velocity | Kind::Position => 3.0,
        Kind::SecondOrder => 4.0,
    }
}

/// The triangle that has the inner products of all columns.
fn fold(columns: &[Vec<f64>]) -> Result<Mat<f64>> {
    let (observed, unknowns) = match columns.split_last() {
        Some((last, others)) => (last.as_slice(), others),
        None => (&[][..], &[][..]),
    };
    let mut fold = Fold::new(unknowns.len());
    let block = 4 * columns.len().max(1);
    for (at, part) in observed.chunks(block).enumerate() {
        let value = |i: usize, j: usize| unknowns.get(j).and_then(|c| c.get(at * block + i)).copied().unwrap_or(0.0);
        let rows = Mat::from_fn(part.len(), unknowns.len(), value);
        fold.push(rows.as_ref(), part, &vec![1.0; part.len()])?;
    }
    Ok(fold.triangle().to_owned())
}
