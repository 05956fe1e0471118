//! The noise floor: stated, else from replicates, else from the residuals of the finished model; and the weighted residuals that go with it.

use super::common::NoiseFrom;
use crate::campaign::{Campaign, JointState};
use crate::design::{DesignMatrix, RowOrigin};
use crate::elements::numbered;
use crate::error::Result;
use crate::estimate::{Estimate, Floor, Group, System, Variances};
use crate::fit::{self, Weighting};
use crate::quality;
use faer::Mat;

/// Fewer degrees of freedom than this make no noise floor.
pub(super) const FEWEST_REPLICATES: usize = 4;

/// A model at one point, weighted so that its noise has (relative) unit variance and its rows are independent.
#[derive(Debug, Clone)]
pub(super) struct Weighted {
    /// The adjustment of the weighted system; its residuals are those of the readings.
    pub estimate: Estimate,
    /// `1/u` of each row, priors included; with lines of scatter one over the standard deviation of all that scatters in it.
    pub weight: Vec<f64>,
    /// The same of the noise of single rows.
    pub own_weight: Vec<f64>,
    /// What scatters beyond the noise of single rows.
    pub floor: Option<Floor>,
    /// Weighted residuals, `m`.
    pub residual: Vec<f64>,
    /// Their sum of squares.
    pub rss: f64,
    /// Where the noise comes from.
    pub from: NoiseFrom,
    /// Replicate group of each row, and the degrees of freedom within groups; empty unless the noise comes from them.
    pub replicates: Option<Replicates>,
}

impl Weighted {
    /// A column of the rows (a shorter one: zero beyond) as independent values of unit variance.
    pub fn whiten(&self, column: &[f64]) -> Vec<f64> {
        match &self.floor {
            None => column.iter().zip(&self.weight).map(|(v, w)| v * w).collect(),
            Some(floor) => {
                let mut column = column.to_vec();
                column.resize(self.weight.len(), 0.0);
                floor.whitening().whiten(&column)
            }
        }
    }

    /// `W' v` of weighted values: what they are at the readings.
    pub fn carry_back(&self, white: &[f64]) -> Vec<f64> {
        match &self.floor {
            None => self.whiten(white),
            Some(floor) => floor.whitening().carry_back(white),
        }
    }

    /// Sum of squares of a column so weighted.
    pub fn squares(&self, column: &[f64]) -> f64 {
        self.whiten(column).iter().map(|v| v * v).sum()
    }

    /// Norm of a column so weighted, scaled first so that no square overflows.
    pub fn norm(&self, column: &[f64]) -> f64 {
        let largest = column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let scaled: Vec<f64> = column.iter().map(|v| v / scale).collect();
        self.squares(&scaled).sqrt() * scale
    }

    /// Weighted columns of candidates as a matrix, `m x k`; each scaled, so that large or tiny terms are brought to one before the weights multiply them.
    pub fn columns<'a>(&self, columns: impl ExactSizeIterator<Item = &'a Vec<f64>>) -> Mat<f64> {
        let mut matrix = Mat::zeros(self.weight.len(), columns.len());
        for (j, column) in columns.enumerate() {
            let largest = column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
            let scale = if largest > 0.0 { largest } else { 1.0 };
            let scaled: Vec<f64> = column.iter().map(|v| v / scale).collect();
            matrix.col_as_slice_mut(j).iter_mut().zip(self.whiten(&scaled)).for_each(|(slot, v)| *slot = v);
        }
        matrix
    }

    /// Shift of every unknown by a column of the readings that is not in the model.
    pub fn absorbed(&self, column: &[f64]) -> Result<Vec<f64>> {
        match &self.floor {
            None => self.estimate.factor.solve(column),
            Some(_) => self.estimate.factor.solve(&self.whiten(column)),
        }
    }

    /// `ln |A'V^-1 A|` of another design's derivatives, with these weights.
    pub fn log_determinant(&self, campaign: &Campaign, design: &DesignMatrix) -> Result<f64> {
        let mut system = fit::weigh(campaign, design, Weighting::AsStated)?;
        let m = system.observed.len();
        for j in 0..system.rows.ncols() {
            let white = self.whiten(system.rows.col_as_slice(j));
            system.rows.col_as_slice_mut(j).copy_from_slice(&white);
        }
        (system.observed, system.u, system.group) = (vec![0.0; m], vec![1.0; m], vec![Group::Known; m]);
        Ok(fit::adjust_with_equations(campaign, design, &system)?.factor.log_determinant())
    }

    /// Coefficients of some columns, each given the others and the model.
    pub fn sizes_with<'a>(
        &self,
        design: &DesignMatrix,
        n: usize,
        columns: impl Iterator<Item = &'a Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let (m, readings) = (self.weight.len(), design.jacobian.nrows());
        let columns: Vec<&Vec<f64>> = columns.collect();
        let mut white = Mat::zeros(m, n + columns.len());
        for j in 0..white.ncols() {
            // columns end with the readings
            let column: Vec<f64> = match j.checked_sub(n).and_then(|k| columns.get(k)) {
                Some(column) => column.iter().copied().take(m).collect(),
                None => (0..readings).map(|i| design.jacobian[(i, j)]).collect(),
            };
            white.col_as_slice_mut(j).iter_mut().zip(self.whiten(&column)).for_each(|(slot, v)| *slot = v);
        }
        let system = System::known(white, self.residual.clone(), vec![1.0; m]);
        let mut solution = crate::estimate::adjust(&system, &crate::estimate::Settings::default())?.unknowns.solution;
        Ok(solution.split_off(n.min(solution.len())))
    }
}

/// What a finished model tells of the noise, where nothing else does.
#[derive(Debug, Clone)]
pub(super) struct Finished {
    /// Scale of each group of readings.
    pub scales: Vec<Option<f64>>,
    /// The variances of all that scatters.
    pub variances: Option<Variances>,
}

/// Rows with the same joint states, sensor and model inputs.
#[derive(Debug, Clone)]
pub(super) struct Replicates {
    /// Group of each row; each prior is a group.
    pub group: Vec<usize>,
    /// Rows minus groups.
    pub dof: usize,
}

impl Replicates {
    /// For each estimated group of the rows, the sum of squares within replicates and its degrees of freedom.
    fn pure(&self, system: &System) -> Vec<(f64, usize)> {
        let count = system.group.iter().filter_map(|g| if let Group::Estimated(g) = g { Some(g + 1) } else { None });
        // no readings, no cells
        let mut pure = vec![(0.0, 0_usize); count.max().unwrap_or(0)];
        let weight: Vec<f64> = system.u.iter().map(|u| 1.0 / u).collect();
        let observed: Vec<f64> = system.observed.iter().zip(&weight).map(|(y, w)| y * w).collect();
        let within = self.within(&observed, &weight);
        let mut seen = std::collections::HashSet::new();
        for ((group, v), replicate) in system.group.iter().zip(&within).zip(&self.group) {
            if let Group::Estimated(g) = group
                && let Some((sum, dof)) = pure.get_mut(*g)
            {
                *sum += v * v;
                *dof += usize::from(!seen.insert(*replicate));
            }
        }
        // replicates that agree exactly, as rows do that were entered more than once, show no noise: what is left is rounding
        let largest = observed.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
        let is_exact = |(sum, dof): &&mut (f64, usize)| quality::is_rounding(*sum, *dof, largest);
        pure.iter_mut().filter(is_exact).for_each(|(sum, _)| *sum = 0.0);
        pure
    }

    /// What is left of a weighted column when the mean of each group is taken out.
    pub fn within(&self, column: &[f64], weight: &[f64]) -> Vec<f64> {
        let count = self.group.iter().max().map_or(0, |g| g + 1);
        let (mut sum, mut square) = (vec![0.0; count], vec![0.0; count]);
        for ((g, c), w) in self.group.iter().zip(column).zip(weight) {
            if let (Some(sum), Some(square)) = (sum.get_mut(*g), square.get_mut(*g)) {
                *sum += c * w;
                *square += w * w;
            }
        }
        let mean = |g: usize| match (sum.get(g), square.get(g)) {
            (Some(sum), Some(square)) if *square > 0.0 => sum / square,
            _ => 0.0,
        };
        self.group.iter().zip(column).zip(weight).map(|((g, c), w)| c - w * mean(*g)).collect()
    }
}

/// Weigh the system of a design by the best noise there is; a finished model tells it where only that can. `share` multiplies the standard deviation of each sensor's noise
/// that is not stated; one for a sensor that is not among these.
pub(super) fn weigh(
    campaign: &Campaign,
    design: &DesignMatrix,
    finished: Option<&Finished>,
    share: &[f64],
) -> Result<Weighted> {
    if !campaign.scatter.is_empty() || fit::known_inputs(campaign, design).is_some() {
        return scattered(campaign, design, finished);
    }
    let scales = finished.map(|finished| finished.scales.as_slice());
    let system = fit::weigh(campaign, design, Weighting::AsStated)?;
    let groups = replicate_groups(campaign, design, system.observed.len());
    let unknown_scale = system.group.iter().any(|g| matches!(g, Group::Estimated(_)));
    let relative = fit::adjust_with_equations(campaign, design, &system)?;
    let mut from = NoiseFrom::Stated;
    let mut u = system.u.clone();
    if unknown_scale {
        let pure = groups.pure(&system);
        let enough = is_enough(&pure);
        from = if enough { NoiseFrom::Replicates } else { NoiseFrom::Residuals };
        for (i, (group, u)) in system.group.iter().zip(&mut u).enumerate() {
            if let Group::Estimated(g) = group {
                let noise = design.rows.get(i).and_then(|row| share.get(row.sensor)).copied().unwrap_or(1.0);
                let scale = match pure.get(*g) {
                    Some((sum, dof)) if enough => Some((sum / *dof as f64).sqrt()),
                    _ => scales.unwrap_or(&relative.group_scale).get(*g).copied().flatten(),
                };
                // a scale that is not determined, or zero, leaves the weights as they are
                *u *= noise * scale.filter(|s| *s > 0.0 && s.is_finite()).unwrap_or(1.0);
            }
        }
    }
    let known = System::known(system.rows, system.observed, u);
    let estimate = fit::adjust_with_equations(campaign, design, &known)?;
    let weight: Vec<f64> = known.u.iter().map(|u| 1.0 / u).collect();
    let residual: Vec<f64> = estimate.residuals.iter().zip(&weight).map(|(v, w)| v * w).collect();
    let rss = residual.iter().map(|v| v * v).sum();
    let replicates = (from == NoiseFrom::Replicates).then_some(groups);
    Ok(Weighted { estimate, own_weight: weight.clone(), weight, floor: None, residual, rss, from, replicates })
}

fn is_enough(pure: &[(f64, usize)]) -> bool {
    pure.iter().all(|(sum, dof)| *dof >= FEWEST_REPLICATES && *sum > 0.0)
}

/// The same where something scatters beyond the noise of single readings, or a known input is uncertain: rows are made independent before anything is compared.
///
/// Variances that are estimated are those of the finished model, or of the model as given.
fn scattered(campaign: &Campaign, design: &DesignMatrix, finished: Option<&Finished>) -> Result<Weighted> {
    let system = fit::weigh(campaign, design, Weighting::AsStated)?;
    let m = system.observed.len();
    let unknown_scale = system.group.iter().any(|g| matches!(g, Group::Estimated(_)));
    let estimated = campaign.scatter.iter().any(|line| {
        line.size == crate::campaign::Size::Estimated || line.over.as_ref().is_some_and(|over| over.tau.is_none())
    });
    let stated = fit::stated_variances(campaign);
    let repeated = (unknown_scale && !estimated).then(|| repeats(campaign, design, m)).flatten().and_then(|groups| {
        let pure = groups.pure(&system);
        (is_enough(&pure) && !pure.is_empty()).then_some((groups, pure))
    });
    let (variances, from, replicates) = match repeated {
        _ if !unknown_scale && !estimated => (Variances::known(Vec::new(), stated), NoiseFrom::Stated, None),
        Some((groups, pure)) => {
            let factor = pure.iter().map(|(sum, dof)| sum / *dof as f64).collect();
            (Variances::known(factor, stated), NoiseFrom::Replicates, Some(groups))
        }
        None => {
            let known = finished.and_then(|finished| finished.variances.clone());
            let known = known.filter(|variances| variances.lines.len() == stated.len());
            // scales of several sensors, and nothing else
            let scales = finished.filter(|_| stated.is_empty());
            let scales = scales.and_then(|finished| finished.scales.iter().copied().collect());
            let squares = |scales: Vec<f64>| scales.iter().map(|s| if *s > 0.0 { s * s } else { 1.0 }).collect();
            let variances = match (known, scales.map(squares)) {
                (Some(known), _) => known,
                (None, Some(scales)) => Variances::known(scales, stated),
                (None, None) => fit::scattered(campaign, design)?,
            };
            (variances, NoiseFrom::Residuals, None)
        }
    };
    let floor = fit::floor(campaign, design, &system, &variances);
    let white = floor.whitening().system(&system.rows, &system.observed);
    let mut estimate = fit::adjust_with_equations(campaign, design, &white)?;
    let residual = estimate.residuals.clone();
    let rss = residual.iter().map(|v| v * v).sum();
    estimate.residuals = system.residuals(&estimate.unknowns.solution);
    let inverse = |sd: &[f64]| -> Vec<f64> { sd.iter().map(|sd| 1.0 / sd).collect() };
    let (weight, own_weight) = (inverse(floor.total_sd()), inverse(floor.whitening().sd()));
    Ok(Weighted { estimate, weight, own_weight, floor: Some(floor), residual, rss, from, replicates })
}

/// Rows that differ only by the noise of single readings: replicates at one level of everything that scatters. `None` where something scatters anew
/// in each reading.
fn repeats(campaign: &Campaign, design: &DesignMatrix, rows: usize) -> Option<Replicates> {
    let mut groups = replicate_groups(campaign, design, rows);
    for line in &campaign.scatter {
        if line.per == crate::campaign::Per::Reading || line.over.is_some() {
            return None;
        }
        let (levels, _) = line.per.levels(campaign);
        let level = |i: usize| design.rows.get(i).and_then(|origin| levels.get(origin.reading).copied().flatten());
        let (group, count) = numbered(groups.group.iter().enumerate().map(|(i, group)| (*group, level(i))));
        groups = Replicates { group, dof: rows - count };
    }
    Some(groups)
}

/// Group rows by sensor, joint states and the columns that the model lines use; each prior is a group.
fn replicate_groups(campaign: &Campaign, design: &DesignMatrix, rows: usize) -> Replicates {
    let used: Vec<usize> = (0..campaign.readings.columns.len())
        .filter(|k| {
            let column = campaign.readings.columns.get(*k).map_or("", String::as_str);
            campaign.bench.sensors.iter().any(|sensor| sensor.model.names().contains(&column))
        })
        .collect();
    let key = |origin: &RowOrigin| {
        let mut key = vec![origin.sensor as u64];
        if let Some(reading) = campaign.readings.rows.get(origin.reading) {
            for state in &reading.joints {
                key.push(u64::from(matches!(state, JointState::WholeTurns { .. })));
                key.extend(state.bits());
            }
            // readings that both lack it are alike in it
            key.extend(used.iter().map(|k| reading.columns.get(*k).copied().flatten().unwrap_or(f64::NAN).to_bits()));
        }
        key
    };
    let (group, count) = apart_beyond(design.rows.iter().map(key), rows);
    Replicates { group, dof: rows - count.min(rows) }
}

/// The position of each row by its label (by the joints' states where there is none); each prior is a position.
pub(super) fn positions(campaign: &Campaign, design: &DesignMatrix, rows: usize) -> Vec<usize> {
    let label = |origin: &RowOrigin| {
        campaign.readings.rows.get(origin.reading).map_or(String::new(), |reading| {
            if reading.position.is_empty() { format!("{:?}", reading.joints) } else { reading.position.to_string() }
        })
    };
    apart_beyond(design.rows.iter().map(label), rows).0
}

/// The numbers of the keys of the first rows, the others being each by itself; and how many numbers there are.
fn apart_beyond<K: std::hash::Hash + Eq>(keys: impl Iterator<Item = K>, rows: usize) -> (Vec<usize>, usize) {
    let (mut numbers, count) = numbered(keys);
    let others = rows.saturating_sub(numbers.len());
    numbers.extend(count..count + others);
    (numbers, count + others)
}
