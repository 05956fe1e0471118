//! Data snooping: which readings cannot be of one piece with the others, and what a fault that nobody finds would do.
//!
//! W. Baarda, A Testing Procedure for Use in Geodetic Networks (1968). Each reading in turn is given a shift of its own; the one that takes
//! most from the sum of squares is a suspect if that is significant over *all* readings (Sidak), and the search goes on with its shift
//! estimated. Where the variance is estimated, the test is the t test of the shift (A. J. Pope 1976, in its exact form).

use crate::uncertainty::quantiles;
use faer::MatRef;

/// A system after its adjustment, as snooping sees it: whitened residuals and the readings' unit errors in the whitened rows.
#[derive(Debug, Clone)]
pub struct Whitened<'a> {
    /// Thin orthonormal basis of the whitened rows, `m x rank`.
    pub q: MatRef<'a, f64>,
    /// Whitened residuals, `m`.
    pub residuals: Vec<f64>,
    /// For each reading, its unit error in the whitened rows (row and value).
    pub indicators: Vec<Vec<(usize, f64)>>,
    /// Degrees of freedom.
    pub dof: usize,
    /// Is the common variance known to be 1? Otherwise it is estimated from these residuals.
    pub variance_known: bool,
}

/// A reading that does not agree with the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suspect {
    /// Row of the reading.
    pub row: usize,
    /// Its shift against the others, in the sensor's unit, estimated with all suspects at once.
    pub shift: f64,
    /// Standard uncertainty of the shift.
    pub u: f64,
    /// `shift / u`: normal, or Student t where the variance is estimated.
    pub w: f64,
    /// Probability of so large a value among all readings if none were bad (Sidak).
    pub p: f64,
}

/// What snooping found.
#[derive(Debug, Clone, PartialEq)]
pub struct Snooping {
    /// Readings that could be tested.
    pub tested: usize,
    /// Significance for each single reading that keeps the whole search at one minus the level.
    pub single_level: f64,
    /// Suspects, the most significant first.
    pub suspects: Vec<Suspect>,
}

/// A reading counts as untestable below this redundancy.
const UNCHECKED: f64 = 1e-9;
/// Most suspects.
const MOST: usize = 50;

impl Whitened<'_> {
    /// Square of a reading's unit error in the whitened rows.
    fn size(&self, row: usize) -> f64 {
        self.indicators.get(row).map_or(0.0, |column| column.iter().map(|(_, c)| c * c).sum())
    }

    /// A reading's unit error along a direction.
    fn along(&self, row: usize, unit: &[f64]) -> f64 {
        let column = self.indicators.get(row).map(Vec::as_slice).unwrap_or_default();
        column.iter().map(|(i, c)| unit.get(*i).copied().unwrap_or_default() * c).sum()
    }

    /// `c' P Q_vv P c` of each reading: one over the variance of its shift.
    fn redundancy(&self, row: usize) -> f64 {
        let Some(column) = self.indicators.get(row) else { return 0.0 };
        let whole = self.size(row);
        let mut square = whole;
        for k in 0..self.q.ncols() {
            square -= column.iter().map(|(i, c)| self.q[(*i, k)] * c).sum::<f64>().powi(2);
        }
        if square > UNCHECKED * whole { square } else { 0.0 }
    }

    /// The part of a reading's unit error that no unknown and none of `extra` explains.
    fn remainder(&self, extra: &[Vec<f64>], row: usize) -> Vec<f64> {
        let mut rest = vec![0.0; self.residuals.len()];
        for (i, c) in self.indicators.get(row).map(Vec::as_slice).unwrap_or_default() {
            if let Some(slot) = rest.get_mut(*i) {
                *slot = *c;
            }
        }
        for _ in 0..2 {
            for k in 0..self.q.ncols() {
                let along: f64 = rest.iter().enumerate().map(|(i, r)| self.q[(i, k)] * r).sum();
                rest.iter_mut().enumerate().for_each(|(i, r)| *r -= along * self.q[(i, k)]);
            }
            for unit in extra {
                let along: f64 = rest.iter().zip(unit).map(|(r, u)| r * u).sum();
                rest.iter_mut().zip(unit).for_each(|(r, u)| *r -= along * u);
            }
        }
        rest
    }

    /// The fault of each reading that a test at 0.1 % finds with 80 % power, in its own unit, for a common variance `s^2`.
    pub fn detectable(&self, s: f64) -> Vec<Option<f64>> {
        let delta = super::baarda_delta();
        (0..self.indicators.len())
            .map(|row| Some(self.redundancy(row)).filter(|r| *r > 0.0).map(|r| delta * s / r.sqrt()))
            .collect()
    }
}

/// Search for bad readings among the first `readings` rows; `None` where nothing can be tested.
pub fn snoop(system: &Whitened<'_>, readings: usize, level: f64) -> Option<Snooping> {
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let readings = readings.min(system.indicators.len());
    let mut tested = (0..readings).filter(|row| system.redundancy(*row) > 0.0).count();
    tested = tested.max(1);
    let single_level = -((level.ln()) / tested as f64).exp_m1();
    let mut residuals = system.residuals.clone();
    let mut extra: Vec<Vec<f64>> = Vec::new();
    let mut rows: Vec<usize> = Vec::new();
    let spare = if system.variance_known { 0 } else { 1 };
    if system.dof <= spare {
        return None;
    }
    // more suspects than half of the redundancy, or than this many, are no longer a few bad readings: the model is wrong
    let most = (system.dof / 2).clamp(1, MOST);
    let mut redundancies: Vec<f64> = (0..readings).map(|row| system.redundancy(row)).collect();
    let whole: Vec<f64> = (0..readings).map(|row| system.size(row)).collect();
    while rows.len() < most && system.dof > rows.len() + spare {
        let square = norm(&residuals);
        let mut best: Option<(usize, f64)> = None;
        for row in (0..readings).filter(|row| !rows.contains(row)) {
            let left = redundancies.get(row).copied().unwrap_or_default();
            let redundancy = if left > UNCHECKED * whole.get(row).copied().unwrap_or_default() { left } else { 0.0 };
            let along: f64 = system
                .indicators
                .get(row)
                .map_or(0.0, |c| c.iter().map(|(i, c)| residuals.get(*i).copied().unwrap_or_default() * c).sum());
            if redundancy > 0.0 && best.is_none_or(|(_, gain)| along * along / redundancy > gain) {
                best = Some((row, along * along / redundancy));
            }
        }
        let Some((row, gain)) = best else { break };
        let dof = system.dof - rows.len();
        if !(probability(system.variance_known, gain, square, dof)? < single_level) {
            break;
        }
        let mut unit = system.remainder(&extra, row);
        let length = norm(&unit).sqrt();
        unit.iter_mut().for_each(|u| *u /= length);
        let along: f64 = unit.iter().zip(&residuals).map(|(u, v)| u * v).sum();
        residuals.iter_mut().zip(&unit).for_each(|(v, u)| *v -= along * u);
        for (row, left) in redundancies.iter_mut().enumerate() {
            *left -= system.along(row, &unit).powi(2);
        }
        extra.push(unit);
        rows.push(row);
    }
    // what the first suspects seemed to explain, later ones may explain better
    loop {
        let suspects = together(system, &rows, tested)?;
        let weakest = suspects.iter().max_by(|a, b| a.p.total_cmp(&b.p));
        match weakest.filter(|s| s.p > 1.0 - level) {
            Some(weak) => rows.retain(|row| *row != weak.row),
            None => {
                let mut suspects = suspects;
                suspects.sort_by(|a, b| b.w.abs().total_cmp(&a.w.abs()));
                return Some(Snooping { tested, single_level, suspects });
            }
        }
    }
}

/// Probability of a gain at least so large, for one reading.
fn probability(variance_known: bool, gain: f64, square: f64, dof: usize) -> Option<f64> {
    if variance_known {
        return quantiles::chi_square_survival(gain, 1.0);
    }
    let rest = (square - gain).max(0.0) / (dof as f64 - 1.0);
    // residuals that are rounding of the ones before say nothing
    if !(rest > f64::EPSILON * f64::EPSILON * square) {
        return Some(if gain > 0.0 { 0.0 } else { 1.0 });
    }
    quantiles::student_t_two_sided((gain / rest).sqrt(), dof as f64 - 1.0)
}

/// Shifts of all suspects at once.
fn together(system: &Whitened<'_>, rows: &[usize], tested: usize) -> Option<Vec<Suspect>> {
    let mut suspects = Vec::new();
    let mut all: Vec<Vec<f64>> = Vec::new();
    for row in rows {
        all.push(system.remainder(&[], *row));
    }
    let count = rows.len();
    let dof = system.dof - count;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let normal = faer::Mat::from_fn(count, count, |a, b| dot(&all[a], &all[b]));
    let right = faer::Mat::from_fn(count, 1, |a, _| dot(&all[a], &system.residuals));
    use faer::linalg::solvers::Solve;
    let factor = normal.full_piv_lu();
    let shift = factor.solve(right);
    let inverse = factor.solve(faer::Mat::<f64>::identity(count, count));
    let mut rest = system.residuals.clone();
    for (a, column) in all.iter().enumerate() {
        rest.iter_mut().zip(column).for_each(|(v, c)| *v -= shift[(a, 0)] * c);
    }
    let variance = if system.variance_known { 1.0 } else { dot(&rest, &rest) / dof.max(1) as f64 };
    for (a, row) in rows.iter().enumerate() {
        let u = (variance * inverse[(a, a)]).sqrt();
        let w = shift[(a, 0)] / u;
        let single = if system.variance_known {
            quantiles::chi_square_survival(w * w, 1.0)?
        } else if u > 0.0 {
            quantiles::student_t_two_sided(w, dof.max(1) as f64)?
        } else {
            0.0
        };
        let p = -(tested as f64 * (-single).ln_1p()).exp_m1();
        suspects.push(Suspect { row: *row, shift: shift[(a, 0)], u, w, p });
    }
    Some(suspects)
}
