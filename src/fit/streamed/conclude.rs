//! The last pass over a record, and the result as that of any fit.
#![allow(
    clippy::indexing_slicing,
    reason = "every list here has one entry for each sensor, and each sensor's list of points begins with the one at hand"
)]

use super::bins::{Binned, Directed, Input, MOST};
use super::noise::{Found, Together, together};
use super::octaves::Noise;
use super::question::{Folding, Part, Question};
use super::residuals::Residuals;
use super::{Rows, Sample, Streamed};
use crate::campaign::Campaign;
use crate::design;
use crate::error::{Fault, Malformed, Result};
use crate::estimate::{
    Block, Chain, Estimate, Group, Likelihood, LineState, NoiseModel, NoisePart, PartNoise, Slot, System, Unknowns,
};
use crate::fit::noise::{ScatterSources, VarianceSource};
use crate::fit::parameters::{BudgetInputs, Told};
use crate::fit::{Checks, Constraints, Estimator, Fit, in_uncertainties, separate, system};
use crate::linear::subtract;
use crate::quality;
use crate::uncertainty::Evaluation;
use faer::Mat;
use std::collections::HashMap;

pub(super) fn conclude(
    campaign: Campaign,
    mut question: Question,
    rows: &mut dyn Rows,
    sample: &Sample,
    start: Fit,
    found: Found,
    point: Vec<f64>,
) -> Result<Fit> {
    let settings = question.settings;
    let sensors = question.sensors.len();
    // the scale of white noise alone is that of the last pass
    let open: Vec<bool> = (0..sensors).map(|s| found.free[s][0] && found.noise[s].deviation == 0.0).collect();
    let is_exact = settings.estimator == Estimator::Exact;
    let first = match is_exact && question.carried.is_empty() {
        true => None,
        false => Some(solved(&mut question, rows, &found.noise, &open, &point)?),
    };
    let change = match &first {
        Some(own) if !is_exact => own.found.unknowns.solution.clone(),
        _ => vec![0.0; question.unknowns],
    };
    // the residuals are tested with the known inputs where the readings have them
    let whole = match first.as_ref().and_then(|own| own.extended.as_ref()) {
        Some((own, _)) => {
            let step = &own.unknowns.solution;
            question.in_own_units(&Mat::from_fn(step.len(), 1, |j, _| step[j])).col_as_slice(0).to_vec()
        }
        None => change.clone(),
    };
    let inputs = inputs(&campaign, sample, &question);
    let further: Vec<usize> = inputs.iter().map(|input| input.column).collect();
    let (n, carried) = (question.unknowns, question.carried.len());
    let mut folding: Vec<Folding> = found.noise.iter().map(|noise| Folding::new(n, carried, *noise)).collect();
    // of noise that is correlated in time: sums in directions of the unknowns, and in those that the noise was estimated in
    let beside = question.in_own_units(&found.tested);
    let bases: Vec<&Mat<f64>> = match &found.directions {
        Some(directions) if carried > 0 => vec![directions, &beside],
        Some(directions) => vec![directions],
        None => Vec::new(),
    };
    let chain = |noise: &Noise| bases.iter().map(|own| Chain::new(own.ncols() + 1, noise.variances(), true)).collect();
    let mut chains: Vec<Vec<Chain>> =
        found.noise.iter().map(|noise| if noise.deviation > 0.0 { chain(noise) } else { Vec::new() }).collect();
    let mut binned: Vec<Binned> = (0..sensors).map(|_| Binned::new(inputs.len(), found.tested.ncols())).collect();
    let mut residuals: Vec<Residuals> = (0..sensors).map(|_| Residuals::new()).collect();
    let mut independent: HashMap<(usize, usize), f64> = HashMap::new();
    // of the rows as they were read
    let mut squares: f64 = question.prior_block(&point).observed.iter().map(|left| left * left).sum();
    question.walk(rows, &point, &further, &mut |s, chunk| {
        let rows = folding[s].push(chunk.rows, chunk.time, chunk.relative)?;
        for (chain, basis) in chains[s].iter_mut().zip(&bases) {
            chain.push(chunk.turned(basis, &change).as_ref(), chunk.time, chunk.relative)?;
        }
        let mut left = chunk.observed().to_vec();
        subtract(&mut left, chunk.rows, &change);
        squares += left.iter().zip(chunk.relative).map(|(left, relative)| (left / relative).powi(2)).sum::<f64>();
        let observed = rows.col_as_slice(rows.ncols() - 1);
        let turned = crate::linear::turned(&rows, observed, &beside, &[]);
        binned[s].push(&inputs, chunk, &left, (&turned, &folding[s]));
        let mut whitened = observed.to_vec();
        subtract(&mut whitened, &rows, &whole);
        residuals[s].take(chunk.numbers, chunk.values, &left, &whitened);
        let before = |own: &u64| chunk.numbers.first().is_some_and(|first| own < first);
        let kept = sample.numbers.iter().enumerate().skip(sample.numbers.partition_point(before));
        for (k, number) in kept.take_while(|(_, own)| chunk.numbers.last().is_some_and(|last| *own <= last)) {
            if let Ok(i) = chunk.numbers.binary_search(number) {
                independent.insert((k, s), whitened[i]);
            }
        }
        Ok(())
    })?;
    let parts: Vec<Option<Part>> = question.parts(folding);
    let solved = together(&question, &parts, &open, &point)?;
    let directions = match &found.directions {
        Some(directions) => directions.clone(),
        None => solved.found.factor.whitened_directions(),
    };
    let mut along: Vec<Vec<NoisePart>> =
        chains.into_iter().map(|own| own.into_iter().rev().map(Chain::part).collect()).collect();
    // of white noise the sums are those of its triangle
    let mut likelihood = |blocks: &[Block], directions: Mat<f64>| {
        let mut of_time = |k: usize| along[*solved.order.get(k)?].pop();
        let each = blocks.iter().enumerate();
        let parts: Vec<NoisePart> =
            each.map(|(k, own)| of_time(k).unwrap_or_else(|| own.part(&directions, &change))).collect();
        Noised::new(&found, &solved.scale, &solved.order, &parts, directions)
    };
    let noised = likelihood(&solved.rows.blocks, directions)?;
    let told = match &solved.extended {
        Some((_, rows)) if !bases.is_empty() => Some(likelihood(&rows.blocks, found.tested.clone())?),
        Some((own, rows)) => Some(likelihood(&rows.blocks, own.factor.whitened_directions())?),
        None => None,
    };
    let mut bins = Vec::new();
    if let Some(of_all) = Directed::new(&solved, &found.tested) {
        for (s, own) in binned.into_iter().enumerate().filter(|(s, _)| question.is_read(*s)) {
            bins.extend(own.conclude(&inputs, campaign.sensor_id(s), &of_all, solved.scale[s]));
        }
    }
    let tested = bins.len().max(1) as f64;
    bins.iter_mut().for_each(|own| own.rejected = own.p * tested < 1.0 - settings.level);
    let tests: Vec<_> = residuals
        .into_iter()
        .enumerate()
        .filter(|(s, _)| question.is_read(*s))
        .map(|(s, own)| own.conclude((s, campaign.sensor_id(s).to_string()), solved.scale[s]))
        .collect();

    // from here on the fit of the sample is made that of the record
    let mut solution = point.clone();
    solution.iter_mut().zip(&change).for_each(|(x, dx)| *x += dx);
    let model = design::Model::new(&campaign)?;
    let at = design::assemble(&campaign, &model, &point)?;
    let at_solution =
        if settings.estimator == Estimator::Linear { at.at(&campaign, &model, &solution)? } else { at.clone() };
    let weighed = system::weigh(&campaign, &at, settings.weighting)?;
    let values: u64 = parts.iter().flatten().map(|part| part.rows).sum();
    let all = values + question.priors.len() as u64;
    let dof = all.saturating_sub(solved.found.unknowns.rank as u64);
    let counts: Vec<u64> = parts.iter().map(|part| part.as_ref().map_or(0, |part| part.rows)).collect();
    let noise = noised.sources(told.as_ref(), &campaign, &question, &found, &solved, &counts);
    let sizes = &found.noise;
    let estimate =
        estimate(&start.estimate, (&at, &weighed), (&solved, squares), sizes, &change, crate::number::index(dof));
    let known = campaign
        .uncertain()
        .enumerate()
        .map(|(k, (parameter, known))| {
            let follow = solved.rows.follow(&solved.found.factor, k)?;
            Ok((parameter, known, follow.iter().map(|c| -c).collect()))
        })
        .collect::<Result<Vec<_>>>()?;
    let level = settings.level;
    let budgets = BudgetInputs {
        campaign: &campaign,
        estimate: &estimate,
        noise: &noise,
        known,
        level,
        weak: &[],
        judged_at: None,
    };
    let Told { parameters, covariance, derived, combinations, known: known_sensitivities } =
        budgets.told(&solution, &solution, &Constraints::None)?;
    let linear = match settings.estimator {
        Estimator::Exact if !question.is_linear => {
            let reference = campaign.reference_point();
            let step = self::solved(&mut question, rows, &found.noise, &open, &reference)?;
            reference.iter().zip(&step.found.unknowns.solution).map(|(x, dx)| x + dx).collect()
        }
        _ => solution.iter().copied().take(question.unknowns).collect::<Vec<f64>>(),
    };
    let change: Vec<f64> = solution.iter().zip(&linear).map(|(exact, linear)| exact - linear).collect();
    let nonlinearity = in_uncertainties(&parameters, &change);
    let of_row = |(origin, u): (&design::RowOrigin, &f64)| {
        let s = origin.sensor;
        let studentized = independent.get(&(origin.reading, s)).map(|w| w / solved.scale[s].sqrt());
        (total(sizes, &solved, s, *u), studentized)
    };
    let quality: Vec<(f64, Option<f64>)> = at.rows.iter().zip(&weighed.u).map(of_row).collect();
    let studentized: Vec<f64> = quality.iter().filter_map(|(_, studentized)| *studentized).collect();
    let is_stated = noise.sources.iter().all(|source| !source.estimated);
    let known_groups = weighed.group.iter().all(|group| *group == Group::Known);
    let tested = Estimate { sum_of_squares: solved.sum_of_squares(), ..estimate.clone() };
    let global_test = quality::global_test(&weighed, &tested, settings.level).filter(|_| is_stated && known_groups);
    let not_estimable = separate::separations(&campaign, &model, &at, &estimate, &[]);
    let runs = tests.iter().filter_map(|own| Some((own.index, own.runs?))).collect();
    Ok(Fit {
        checks: Checks { runs, normality: quality::normality(&studentized), ..Checks::default() },
        settings,
        design: at_solution,
        system: weighed,
        point: solution,
        parameters,
        covariance,
        derived,
        combinations,
        conditional: Vec::new(),
        noise,
        known_sensitivities,
        settled: found.settled && solved.found.settled,
        tested: None,
        global_test,
        not_estimable,
        convergence: found.convergence.map(|record| crate::fit::Convergence { linear, ..record }),
        nonlinearity,
        streamed: Some(Streamed {
            rows: sample.rows,
            values,
            passes: question.passes + 1,
            numbers: sample.numbers.clone(),
            dof,
            sensors: tests,
            bins,
            quality,
        }),
        estimate,
        campaign,
        // without constraints, nothing robust
        ..start
    })
}

/// One pass at a point with the noise as it was found.
fn solved(
    question: &mut Question,
    rows: &mut dyn Rows,
    noise: &[Noise],
    open: &[bool],
    point: &[f64],
) -> Result<Together> {
    let parts = question.fold(rows, point, noise, &mut |_, _| {})?;
    together(question, &parts, open, point)
}

/// Inputs over whose ranges the residuals are looked at: times, joints, and what the model lines use.
fn inputs(campaign: &Campaign, sample: &Sample, question: &Question) -> Vec<Input> {
    let names: Vec<&str> = campaign.bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
    let over: Vec<usize> = question.sensors.iter().filter_map(|own| own.line.map(|(_, column)| column)).collect();
    let joint = |column: &str| campaign.bench.is_of_joint(column);
    let columns = sample.readings.columns.iter().zip(&sample.ranges).enumerate();
    columns
        .filter(|(k, (name, (low, high)))| {
            let asked = over.contains(k) || *name == "time_s" || joint(name) || names.contains(&name.as_str());
            asked && high > low && (high - low).is_finite()
        })
        .map(|(column, (name, (low, high)))| Input { column, name: name.clone(), low: *low, high: *high })
        .take(MOST)
        .collect()
}

/// The adjustment of all rows in the words of that of the sample.
fn estimate(
    sample: &Estimate,
    (at, weighed): (&design::DesignMatrix, &System),
    (solved, squares): (&Together, f64),
    noise: &[Noise],
    change: &[f64],
    dof: usize,
) -> Estimate {
    let folded = &solved.found;
    let residuals = weighed.residuals(change);
    let mut group_scale = vec![None; sample.group_scale.len()];
    let mut group_redundancy = vec![0.0; sample.group_scale.len()];
    for (origin, group) in at.rows.iter().zip(&weighed.group) {
        let Group::Estimated(g) = *group else { continue };
        let s = origin.sensor;
        let sd = noise[s].white * solved.scale[s].sqrt();
        group_scale.resize(group_scale.len().max(g + 1), None);
        group_redundancy.resize(group_scale.len(), 0.0);
        group_scale[g] = (solved.redundancy[s] > 0.0).then_some(sd);
        group_redundancy[g] = solved.redundancy[s];
    }
    let n = change.len();
    let leverage: Vec<f64> = (0..weighed.observed.len())
        .map(|i| {
            let row = |j: usize| weighed.rows[(i, j)];
            let form: f64 =
                (0..n).map(|j| row(j) * (0..n).map(|k| folded.unknowns.cofactor[(j, k)] * row(k)).sum::<f64>()).sum();
            let u = at.rows.get(i).map_or(weighed.u[i], |origin| total(noise, solved, origin.sensor, weighed.u[i]));
            (form / (u * u)).clamp(0.0, 1.0)
        })
        .collect();
    // one sensor whose noise is estimated: squares of the rows as they were read, in its own unit, as of readings in memory
    let own_unit = group_scale.len() == 1 && weighed.group.iter().all(|g| *g != Group::Known);
    let sum_of_squares = if own_unit { squares } else { folded.sum_of_squares };
    let unknowns =
        Unknowns { solution: change.to_vec(), covariance: folded.unknowns.cofactor.clone(), ..folded.unknowns.clone() };
    Estimate {
        unknowns,
        residuals,
        redundancy: leverage.iter().map(|h| 1.0 - h).collect(),
        leverage,
        sum_of_squares,
        dof,
        group_scale,
        group_redundancy,
        ..sample.clone()
    }
}

/// Standard deviation of a value of a sensor, white noise and deviation together.
fn total(noise: &[Noise], solved: &Together, s: usize, relative: f64) -> f64 {
    let Noise { white, deviation, .. } = noise[s];
    (solved.scale[s] * ((white * relative).powi(2) + deviation * deviation)).sqrt()
}

/// Where a sensor's parameters stand: variance factor of its white noise, variance of its deviation, correlation time.
type Places = [Option<usize>; 3];

/// The likelihood at what was found, with its derivatives by all that the noise has.
pub(super) struct Noised {
    likelihood: Likelihood,
    model: NoiseModel,
    places: Vec<Places>,
    directions: Mat<f64>,
}

impl Noised {
    /// `parts` are the sums of the sensors that are read and of the priors, in `directions`; `scale` multiplies the white noise that a sensor without a deviation
    /// was folded with.
    ///
    /// Errors: sums in which the directions are not independent.
    pub(super) fn new(
        found: &Found,
        scale: &[f64],
        read: &[usize],
        parts: &[NoisePart],
        directions: Mat<f64>,
    ) -> Result<Self> {
        let mut model = NoiseModel { parts: Vec::new(), range: Vec::new(), columns: directions.ncols() };
        let (mut at, mut places) = (Vec::new(), vec![Places::default(); scale.len()]);
        for s in read {
            let Noise { white, deviation, tau } = found.noise[*s];
            let values = match deviation > 0.0 {
                true => vec![white * white, deviation * deviation, tau],
                false => vec![scale[*s]],
            };
            for (place, value) in places[*s].iter_mut().zip(values) {
                *place = Some(at.len());
                at.push(value.ln());
            }
            let slot = |k: usize| places[*s][k].map(Slot::Free);
            let white = slot(0).unwrap_or(Slot::Stated(1.0));
            model.parts.push(PartNoise { white, deviation: slot(1).zip(slot(2)) });
        }
        model.parts.push(PartNoise { white: Slot::Stated(1.0), deviation: None });
        model.range = vec![(f64::NEG_INFINITY, f64::INFINITY); at.len()];
        let likelihood = model.likelihood(&at, parts).ok_or_else(|| {
            Malformed::new(Fault::Value, "the rows of the record do not separate the unknowns")
                .expected("unknowns that the readings separate, or fewer of them in \"estimate\"")
        })?;
        Ok(Noised { likelihood, model, places, directions })
    }

    /// A matrix in the directions, in the unknowns.
    fn back(&self, own: &Mat<f64>) -> Mat<f64> {
        &self.directions * own * self.directions.transpose()
    }

    /// The derivative of the covariance by the logarithm of a sensor's parameter.
    fn slope(&self, s: usize, which: usize) -> Option<Mat<f64>> {
        let place = self.places[s][which]?;
        Some(self.back(&self.likelihood.slope(place)))
    }

    /// Every source of scatter; `rows` are those of each sensor, `told` what the noise was estimated beside.
    pub(super) fn sources(
        &self,
        told: Option<&Noised>,
        campaign: &Campaign,
        question: &Question,
        found: &Found,
        solved: &Together,
        rows: &[u64],
    ) -> ScatterSources {
        let n = question.unknowns;
        // what was estimated, by its place among the parameters
        let pairs = found.free.iter().flatten().zip(self.places.iter().flatten());
        let among: Vec<usize> = pairs.filter_map(|(is_free, place)| place.filter(|_| *is_free)).collect();
        let told = told.unwrap_or(self);
        let (covariances, correction) = told.likelihood.costs(Some(&told.model), &among);
        let spread = Mat::from_fn(among.len(), among.len(), |a, b| covariances[(among[a], among[b])]);
        let component = |s: usize, which: usize| {
            let place = self.places[s][which]?;
            among.iter().position(|own| *own == place)
        };
        let dof = |component: Option<usize>, stated: f64| component.map_or(stated, |c| 2.0 / spread[(c, c)]);
        let (mut sources, mut over, mut leans) = (Vec::new(), Vec::new(), Vec::new());
        let mut determined = true;
        for (s, own) in question.sensors.iter().enumerate().filter(|(s, _)| question.is_read(*s)) {
            let size = found.noise[s];
            let levels = crate::number::index(rows[s]);
            let white = component(s, 0);
            determined &= white.is_none() || solved.redundancy[s] > 0.0;
            let name = format!("readings of {}", campaign.sensor_id(s));
            let share = |which: usize| self.slope(s, which).unwrap_or_else(|| Mat::zeros(n, n));
            let (variance, state, part) = match (found.white_at_zero[s], white) {
                (true, _) => (0.0, LineState::AtZero, Mat::zeros(n, n)),
                (false, Some(_)) => (size.white * size.white * solved.scale[s], LineState::Estimated, share(0)),
                (false, None) => (1.0, LineState::Stated, share(0)),
            };
            sources.push(VarianceSource {
                evaluation: Evaluation::TypeA,
                estimated: state != LineState::Stated,
                dof: dof(white, f64::INFINITY),
                variance,
                state,
                component: white,
                sensor: Some(s),
                ..VarianceSource::stated(name, part, levels)
            });
            let Some((k, line)) = own.line.and_then(|(k, _)| Some((k, campaign.scatter.get(k)?))) else { continue };
            let own = VarianceSource::line(campaign, k, line, share(1), levels);
            let stated_tau = line.over.as_ref().and_then(|over| over.tau);
            let tau = component(s, 2);
            let u_tau = tau.map(|k| spread[(k, k)].sqrt() * size.tau).filter(|u| u.is_finite());
            over.push(VarianceSource {
                variance: size.deviation * size.deviation,
                state: match (found.at_zero[s], own.estimated) {
                    (true, _) => LineState::AtZero,
                    (false, false) => LineState::Stated,
                    (false, true) => LineState::Estimated,
                },
                tau: (!found.at_zero[s] || stated_tau.is_some()).then_some((stated_tau.unwrap_or(size.tau), u_tau)),
                dof: dof(component(s, 1), own.dof),
                component: component(s, 1),
                ..own
            });
            leans.extend(tau.zip(self.slope(s, 2)));
        }
        let c = &solved.found.unknowns.cofactor;
        if !question.priors.is_empty() {
            let share =
                |i: usize, j: usize| question.priors.iter().map(|(k, _, u)| c[(i, *k)] * c[(*k, j)] / (u * u)).sum();
            let (share, count) = (Mat::from_fn(n, n, share), question.priors.len());
            sources.push(VarianceSource::stated("priors".into(), share, count));
        }
        sources.extend(over);
        ScatterSources::jointly(
            sources,
            c,
            (spread, told.back(&correction).submatrix(0, 0, n, n).to_owned()),
            leans,
            determined,
        )
    }
}
