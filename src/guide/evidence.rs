//! What readings say of each other: the joint density of some, predicted from others.
//!
//! ```text
//! d = r_R - A_R x,   V = I + A_R C A_R',   ln p(R | O) = -1/2 d'V^-1 d - 1/2 ln |V| + constant
//! ```
//!
//! `r` and `A` are residuals and derivatives at one point, made independent and of unit variance with the covariance of noise and scatter, those of `O`
//! first; `x` and `C` the estimate from `O`. Unknowns are the estimated parameters and the known inputs with an uncertainty, whose prior is a row.
#![allow(
    clippy::indexing_slicing,
    reason = "`Rows` are made with one column for each unknown; blocks are cut at their own lengths"
)]

use crate::campaign::{Campaign, Reading, Readings, Role};
use crate::design::{self, DesignMatrix, Model, RowOrigin};
use crate::error::Result;
use crate::fit;
use crate::linear::{Triangle, dot};
use crate::plan::Noise;

/// Standard deviation of an unknown about which nothing is known, in units of what one reading of a column's size tells of it.
const LOOSE: f64 = 1e6;
/// A reading whose prediction is so many times less certain than itself is not predicted.
pub(super) const NOT_PREDICTED: f64 = 1e3;

/// Rows about a point: what each value differs from the model there, and how the model's value follows the unknowns.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    pub origins: Vec<RowOrigin>,
    /// By unknown, for each row.
    pub slopes: Vec<Vec<f64>>,
    /// Value less prediction; zero where nothing was read.
    pub rest: Vec<f64>,
    /// `L` of the rows' covariance.
    root: Option<Triangle>,
    /// Standard deviations, where rows are independent.
    sd: Vec<f64>,
    pub design: DesignMatrix,
}

/// Which parameters are unknown, by index: the estimated, then the known with an uncertainty; and the standard deviation beforehand of those that
/// have one, with the distance of the prior value from the point.
pub(super) fn unknowns(campaign: &Campaign, point: &[f64]) -> (Vec<usize>, Vec<Option<(f64, f64)>>) {
    let of = |(k, parameter): (usize, &crate::campaign::Parameter)| {
        let away = |value: f64| value - point.get(k).copied().unwrap_or(value);
        match &parameter.role {
            Role::Estimated { prior, .. } => Some((k, prior.map(|own| (away(own.value), own.u)))),
            Role::Known(known) if known.u > 0.0 => Some((k, Some((away(known.value), known.u)))),
            _ => None,
        }
    };
    campaign.parameters.iter().enumerate().filter_map(of).unzip()
}

impl Rows {
    /// Rows of a campaign's readings; where none has a value, of every sensor at each position.
    pub fn new(campaign: &Campaign, point: &[f64], noise: &Noise) -> Result<Self> {
        let model = Model::new(campaign)?;
        let design = design::assemble(campaign, &model, point)?;
        let (which, _) = unknowns(campaign, point);
        let reading = |origin: &RowOrigin| campaign.readings.rows.get(origin.reading);
        let sd: Vec<f64> = design.rows.iter().map(|o| reading(o).map_or(1.0, |own| noise.u(own, o.sensor))).collect();
        let value =
            |o: &RowOrigin| reading(o)?.observations.iter().find(|own| own.sensor == o.sensor).map(|own| own.value);
        let rest = design.rows.iter().zip(&design.predicted).map(|(o, f)| value(o).map_or(0.0, |y| y - f)).collect();
        let slopes = (0..design.rows.len()).map(|i| which.iter().map(|k| design.jacobian[(i, *k)]).collect()).collect();
        let root = (!campaign.scatter.is_empty()).then(|| covariance(campaign, &design, &sd, noise)).flatten();
        Ok(Rows { origins: design.rows.clone(), slopes, rest, root, sd, design })
    }

    /// A column over the rows, made independent as the rows are.
    pub fn white(&self, mut column: Vec<f64>) -> Vec<f64> {
        match &self.root {
            Some(root) => root.forward(&mut column),
            None => column.iter_mut().zip(&self.sd).for_each(|(value, sd)| *value /= sd),
        }
        column
    }

    /// Slopes and residuals, made independent.
    pub fn whitened(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let count = self.slopes.first().map_or(0, Vec::len);
        let columns: Vec<Vec<f64>> =
            (0..count).map(|k| self.white(self.slopes.iter().map(|row| row[k]).collect())).collect();
        let rows = (0..self.slopes.len()).map(|i| columns.iter().map(|column| column[i]).collect()).collect();
        (rows, self.white(self.rest.clone()))
    }
}

/// `L` of `diag(u^2) + sum of variance g g'` over the deviations of every line of scatter; `None` where it is not positive definite.
fn covariance(campaign: &Campaign, design: &DesignMatrix, sd: &[f64], noise: &Noise) -> Option<Triangle> {
    let rows = design.rows.len();
    let mut sum = vec![vec![0.0; rows]; rows];
    for (i, sd) in fit::own_noise(campaign, design, sd).iter().enumerate() {
        sum[i][i] += sd * sd;
    }
    for (line, variance) in fit::scatter_lines(campaign, design, sd).iter().zip(&noise.lines) {
        for a in &line.felt {
            for b in &line.felt {
                let together = match &line.memory {
                    None => f64::from(u8::from(a.level == b.level)),
                    Some(memory) => match (memory.run.get(a.level), memory.run.get(b.level), memory.tau) {
                        (Some(one), Some(other), Some(tau)) if one == other => {
                            (-(memory.time[a.level] - memory.time[b.level]).abs() / tau).exp()
                        }
                        _ => f64::from(u8::from(a.level == b.level)),
                    },
                };
                sum[a.row][b.row] += variance * together * a.by * b.by;
            }
        }
    }
    Triangle::of(rows, |i, j| sum[i][j], |_| 0.0)
}

/// What rows that are independent and of unit variance tell of the unknowns.
#[derive(Debug, Clone)]
pub(super) struct Told {
    scale: Vec<f64>,
    factor: Triangle,
    /// The estimate, from the point.
    pub estimate: Vec<f64>,
}

impl Told {
    /// From rows and priors; `None` where numbers leave their range.
    pub fn new(rows: &[Vec<f64>], rest: &[f64], priors: &[Option<(f64, f64)>], sizes: &[f64]) -> Option<Self> {
        let n = priors.len();
        let scale: Vec<f64> = sizes.iter().map(|size| if *size > 0.0 { size.recip() } else { 1.0 }).collect();
        let mut right = vec![0.0; n];
        let mut information = vec![vec![0.0; n]; n];
        for (row, rest) in rows.iter().zip(rest) {
            let own: Vec<f64> = row.iter().zip(&scale).map(|(a, s)| a * s).collect();
            for i in 0..n {
                right[i] += own[i] * rest;
                for j in 0..=i {
                    information[i][j] += own[i] * own[j];
                }
            }
        }
        for (k, prior) in priors.iter().enumerate() {
            information[k][k] += LOOSE.powi(-2);
            if let Some((away, u)) = prior {
                let weight = (scale[k] / u).powi(2);
                information[k][k] += weight;
                right[k] += weight * away / scale[k];
            }
        }
        let factor = Triangle::of(n, |i, j| information[i][j], |_| 0.0)?;
        let estimate = factor.solve(&right).iter().zip(&scale).map(|(x, s)| x * s).collect();
        Some(Told { scale, factor, estimate })
    }

    /// `L^-1 a`, so that `a' C b` is a product of two of them.
    pub fn through(&self, along: &[f64]) -> Vec<f64> {
        let mut own: Vec<f64> = along.iter().zip(&self.scale).map(|(a, s)| a * s).collect();
        self.factor.forward(&mut own);
        own
    }

    /// `a' C a`.
    pub fn variance(&self, along: &[f64]) -> f64 {
        let own = self.through(along);
        dot(&own, &own)
    }

    /// What rows with these residuals would be estimated as: `C A' f`.
    pub fn solved(&self, rows: &[Vec<f64>], column: &[f64]) -> Vec<f64> {
        let n = self.scale.len();
        let right: Vec<f64> =
            (0..n).map(|k| rows.iter().zip(column).map(|(row, f)| row[k] * f).sum::<f64>() * self.scale[k]).collect();
        self.factor.solve(&right).iter().zip(&self.scale).map(|(x, s)| x * s).collect()
    }
}

/// Rows predicted from others: their differences and the covariance of these.
#[derive(Debug, Clone)]
pub(super) struct Predicted {
    pub difference: Vec<f64>,
    pub covariance: Vec<Vec<f64>>,
}

impl Predicted {
    pub fn new(told: &Told, rows: &[Vec<f64>], rest: &[f64]) -> Self {
        let through: Vec<Vec<f64>> = rows.iter().map(|row| told.through(row)).collect();
        let difference = rows.iter().zip(rest).map(|(row, rest)| rest - dot(row, &told.estimate)).collect();
        let entry = |i: usize, j: usize| f64::from(u8::from(i == j)) + dot(&through[i], &through[j]);
        let covariance = (0..rows.len()).map(|i| (0..rows.len()).map(|j| entry(i, j)).collect()).collect();
        Predicted { difference, covariance }
    }

    /// Those rows that the others do predict.
    pub fn told(&self) -> Predicted {
        let kept: Vec<usize> =
            (0..self.difference.len()).filter(|i| self.covariance[*i][*i] < NOT_PREDICTED.powi(2)).collect();
        Predicted {
            difference: kept.iter().map(|i| self.difference[*i]).collect(),
            covariance: kept.iter().map(|i| kept.iter().map(|j| self.covariance[*i][*j]).collect()).collect(),
        }
    }

    fn factor(&self, more: impl Fn(usize, usize) -> f64) -> Option<Triangle> {
        Triangle::of(self.difference.len(), |i, j| self.covariance[i][j] + more(i, j), |_| 0.0)
    }

    /// `d'V^-1 d`.
    pub fn square(&self) -> Option<f64> {
        let mut own = self.difference.clone();
        self.factor(|_, _| 0.0)?.forward(&mut own);
        Some(dot(&own, &own))
    }

    /// `ln p` but for the constant, with a further covariance.
    pub fn log_density(&self, more: impl Fn(usize, usize) -> f64) -> Option<f64> {
        let factor = self.factor(more)?;
        let mut own = self.difference.clone();
        factor.forward(&mut own);
        let value = -0.5 * (dot(&own, &own) + factor.log_determinant());
        value.is_finite().then_some(value)
    }
}

/// Sizes of the columns of unknowns over rows.
pub(super) fn sizes(rows: &[Vec<f64>], count: usize) -> Vec<f64> {
    (0..count).map(|k| rows.iter().fold(0.0_f64, |most, row| most.max(row[k].abs()))).collect()
}

/// Readings `from`, at the given joints and values, predicted from the others: rows in the order others, then `from`.
pub(super) fn predicted(
    campaign: &Campaign,
    others: &[Reading],
    own: &[Reading],
    point: &[f64],
    noise: &Noise,
) -> Result<Option<(Predicted, Rows)>> {
    let rows = others.iter().chain(own).cloned().collect();
    let joined = campaign.with_readings(Readings { columns: campaign.readings.columns.clone(), rows });
    let rows = Rows::new(&joined, point, noise)?;
    let (_, priors) = unknowns(&joined, point);
    let (white, rest) = rows.whitened();
    let at = rows.origins.iter().take_while(|origin| origin.reading < others.len()).count();
    let Some(told) = Told::new(&white[..at], &rest[..at], &priors, &sizes(&white, priors.len())) else {
        return Ok(None);
    };
    Ok(Some((Predicted::new(&told, &white[at..], &rest[at..]), rows)))
}
