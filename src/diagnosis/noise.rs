//! The noise floor: stated, else from replicates, else from the residuals of the finished model; and the weighted residuals that go with it.

use crate::campaign::{Campaign, JointState};
use crate::design::DesignMatrix;
use crate::error::Result;
use crate::estimate::{Estimate, Group, System};
use crate::fit::{self, Weighting};
use faer::Mat;
use std::collections::HashMap;

/// Where the noise floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseFrom {
    /// Stated standard uncertainties of the readings.
    Stated,
    /// Scatter of readings with the same joint states and model inputs.
    Replicates,
    /// Residuals of the finished model: nothing else tells, so completeness cannot be tested against it.
    Residuals,
}

impl NoiseFrom {
    /// As reports write it.
    pub fn name(self) -> &'static str {
        match self {
            NoiseFrom::Stated => "stated",
            NoiseFrom::Replicates => "replicates",
            NoiseFrom::Residuals => "residuals",
        }
    }
}

/// Fewer degrees of freedom than this make no noise floor.
const FEWEST_REPLICATES: usize = 4;

/// A model at one point, weighted so that its noise has (relative) unit variance.
#[derive(Debug, Clone)]
pub(super) struct Weighted {
    /// The adjustment of the weighted system.
    pub estimate: Estimate,
    /// `1/u` of each row, priors included.
    pub weight: Vec<f64>,
    /// Weighted residuals, `m`.
    pub residual: Vec<f64>,
    /// Their sum of squares.
    pub rss: f64,
    /// Where the noise comes from.
    pub from: NoiseFrom,
    /// Replicate group of each row, and the degrees of freedom within groups; empty unless the noise comes from them.
    pub replicates: Option<Replicates>,
}

/// Rows with the same joint states, sensor and model inputs.
#[derive(Debug, Clone)]
pub(super) struct Replicates {
    /// Group of each row; priors have groups of their own.
    pub group: Vec<usize>,
    /// Rows minus groups.
    pub dof: usize,
}

impl Replicates {
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

/// Weigh the system of a design by the best noise there is; `scales` are those of the finished model, where only it can tell.
pub(super) fn weigh(campaign: &Campaign, design: &DesignMatrix, scales: Option<&[Option<f64>]>) -> Result<Weighted> {
    let system = fit::weigh(campaign, design, Weighting::AsStated)?;
    let groups = replicate_groups(campaign, design, system.observed.len());
    let unknown_scale = system.group.iter().any(|g| matches!(g, Group::Estimated(_)));
    let relative = fit::adjust_with_equations(campaign, design, &system)?;
    let mut from = NoiseFrom::Stated;
    let mut u = system.u.clone();
    if unknown_scale {
        let count = relative.group_scale.len();
        let mut pure = vec![(0.0, 0_usize); count];
        let weight: Vec<f64> = system.u.iter().map(|u| 1.0 / u).collect();
        let observed: Vec<f64> = system.observed.iter().zip(&weight).map(|(y, w)| y * w).collect();
        let within = groups.within(&observed, &weight);
        let mut seen = std::collections::HashSet::new();
        for ((group, v), replicate) in system.group.iter().zip(&within).zip(&groups.group) {
            if let Group::Estimated(g) = group
                && let Some((sum, dof)) = pure.get_mut(*g)
            {
                *sum += v * v;
                *dof += usize::from(!seen.insert(*replicate));
            }
        }
        let enough = pure.iter().all(|(sum, dof)| *dof >= FEWEST_REPLICATES && *sum > 0.0);
        from = if enough { NoiseFrom::Replicates } else { NoiseFrom::Residuals };
        for (group, u) in system.group.iter().zip(&mut u) {
            if let Group::Estimated(g) = group {
                let scale = match pure.get(*g) {
                    Some((sum, dof)) if enough => Some((sum / *dof as f64).sqrt()),
                    _ => scales.unwrap_or(&relative.group_scale).get(*g).copied().flatten(),
                };
                *u *= scale.filter(|s| *s > 0.0 && s.is_finite()).unwrap_or(1.0);
            }
        }
    }
    let known =
        System { rows: system.rows, observed: system.observed, u, group: vec![Group::Known; groups.group.len()] };
    let estimate = fit::adjust_with_equations(campaign, design, &known)?;
    let weight: Vec<f64> = known.u.iter().map(|u| 1.0 / u).collect();
    let residual: Vec<f64> = estimate.residuals.iter().zip(&weight).map(|(v, w)| v * w).collect();
    let rss = residual.iter().map(|v| v * v).sum();
    let replicates = (from == NoiseFrom::Replicates).then_some(groups);
    Ok(Weighted { estimate, weight, residual, rss, from, replicates })
}

/// Group rows by sensor, joint states and the columns that the model lines use; each prior is a group of its own.
fn replicate_groups(campaign: &Campaign, design: &DesignMatrix, rows: usize) -> Replicates {
    let used: Vec<usize> = (0..campaign.readings.columns.len())
        .filter(|k| {
            let column = campaign.readings.columns.get(*k).map_or("", String::as_str);
            campaign.bench.sensors.iter().any(|sensor| sensor.model.names().contains(&column))
        })
        .collect();
    let mut seen: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut group = Vec::with_capacity(rows);
    for origin in &design.rows {
        let mut key = vec![origin.sensor as u64];
        if let Some(reading) = campaign.readings.rows.get(origin.reading) {
            for state in &reading.joints {
                let (deg, deg_s, turns) = state.keys();
                let kind = matches!(state, JointState::WholeTurns { .. });
                key.push(u64::from(kind));
                key.extend([deg, deg_s, turns].map(|v| v.map_or(u64::MAX, |v| (v + 0.0).to_bits())));
            }
            key.extend(used.iter().map(|k| reading.columns.get(*k).copied().flatten().unwrap_or_default().to_bits()));
        }
        let next = seen.len();
        group.push(*seen.entry(key).or_insert(next));
    }
    let mut next = seen.len();
    while group.len() < rows {
        group.push(next);
        next += 1;
    }
    let dof = rows - next.min(rows);
    Replicates { group, dof }
}

/// The position of each row by its label (by the joints' states where there is none); each prior is a position of its own.
pub(super) fn positions(campaign: &Campaign, design: &DesignMatrix, rows: usize) -> Vec<usize> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut position = Vec::with_capacity(rows);
    for origin in &design.rows {
        let label = campaign.readings.rows.get(origin.reading).map_or(String::new(), |reading| {
            if reading.position.is_empty() { format!("{:?}", reading.joints) } else { reading.position.clone() }
        });
        let next = seen.len();
        position.push(*seen.entry(label).or_insert(next));
    }
    let first = seen.len();
    position.extend((0..rows.saturating_sub(design.rows.len())).map(|k| first + k));
    position
}

/// Weighted columns of candidates as a matrix, `m x k`.
pub(super) fn weighted_columns<'a>(columns: impl ExactSizeIterator<Item = &'a Vec<f64>>, weight: &[f64]) -> Mat<f64> {
    let mut matrix = Mat::zeros(weight.len(), columns.len());
    for (j, column) in columns.enumerate() {
        // large or tiny terms are brought to one before the weights multiply them
        let largest = column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let scale = if largest > 0.0 { largest } else { 1.0 };
        for ((slot, value), w) in matrix.col_as_slice_mut(j).iter_mut().zip(column).zip(weight) {
            *slot = value / scale * w;
        }
    }
    matrix
}
