//! Data snooping: which readings cannot be of one piece with the others, and what a fault that nobody finds would do.
//!
//! W. Baarda, A Testing Procedure for Use in Geodetic Networks (1968). Each reading in turn is given a shift of its own; the one that takes
//! most from the sum of squares is a suspect if that is significant over *all* readings (Sidak), and the search goes on with its shift
//! estimated. Where the variance is estimated, the test is the t test of the shift (A. J. Pope 1976, in its exact form).

use super::UNCHECKED;
use crate::elements::Elements;
use crate::linear::{self, Triangle};
use crate::uncertainty::quantiles;
use faer::MatRef;

/// A system after its adjustment, as snooping sees it: standardised residuals, and what a unit error of a reading leaves of itself.
pub(crate) struct Whitened<'a> {
    /// Standard deviation of what each reading has for itself, and where that stands among the residuals; with the sign in which the reading feels it.
    pub sd: Vec<f64>,
    pub place: Vec<usize>,
    /// Redundancy number of each reading, the diagonal of `P`.
    pub redundancy: Vec<f64>,
    /// Standardised residuals, `P y`.
    pub residuals: Vec<f64>,
    /// `P e_i` for a reading.
    pub remainder: Box<dyn Fn(usize) -> Vec<f64> + 'a>,
    /// Degrees of freedom.
    pub dof: usize,
    /// The largest reading over its standard deviation: residuals of some epsilons of it are rounding.
    pub largest: f64,
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

/// Residuals of at most so much of the largest reading are rounding: of itself, and of the products that it is compared with.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Most suspects.
const MOST: usize = 50;

/// Are standardised residuals with this sum of squares no more than the rounding of so many readings? Then they say nothing of the model.
pub(crate) fn is_rounding(squares: f64, readings: usize, largest: f64) -> bool {
    squares <= readings as f64 * (ROUNDING * largest).powi(2)
}

impl<'a> Whitened<'a> {
    /// Readings that are independent of each other, from the orthonormal basis `q` of the weighted rows.
    pub fn independent(
        q: MatRef<'a, f64>,
        weight: &[f64],
        residuals: &[f64],
        largest: f64,
        dof: usize,
        variance_known: bool,
    ) -> Self {
        let used = |i: usize| (0..q.ncols()).map(|k| q[(i, k)] * q[(i, k)]).sum::<f64>();
        let remainder = move |row: usize| {
            let mut projected = vec![0.0; q.nrows()];
            if let Some(shifted) = projected.get_mut(row) {
                *shifted = 1.0;
            }
            linear::project_out(&mut projected, q);
            projected
        };
        Whitened {
            sd: weight.iter().map(|w| 1.0 / w).collect(),
            place: (0..weight.len()).collect(),
            redundancy: (0..weight.len()).map(|i| 1.0 - used(i)).collect(),
            residuals: residuals.iter().zip(weight).map(|(v, w)| v * w).collect(),
            remainder: Box::new(remainder),
            dof,
            largest,
            variance_known,
        }
    }

    fn sd(&self, row: usize) -> f64 {
        self.sd.at(row)
    }

    /// A reading's redundancy number, zero where no other reading checks it.
    fn checked(&self, row: usize) -> f64 {
        // rows beyond the readings are priors, which nothing checks
        self.redundancy.get(row).copied().filter(|r| *r > UNCHECKED).unwrap_or(0.0)
    }

    /// The part of a reading's standardised error that no unknown and none of `extra` explains.
    fn remainder(&self, extra: &[Vec<f64>], row: usize) -> Vec<f64> {
        let mut remainder = (self.remainder)(row);
        linear::project(&mut remainder, extra);
        linear::project(&mut remainder, extra);
        remainder
    }

    /// The fault of each reading that a test at 0.1 % finds with 80 % power, in its own unit, for a common variance `s^2`.
    pub fn detectable(&self, s: f64) -> Vec<Option<f64>> {
        let delta = super::baarda_delta();
        let redundancy = |row: usize| Some(self.checked(row)).filter(|r| *r > 0.0);
        (0..self.sd.len()).map(|row| redundancy(row).map(|r| delta * s * self.sd(row).abs() / r.sqrt())).collect()
    }
}

/// Search for bad readings among the first `readings` rows; `None` where nothing can be tested.
pub(crate) fn snoop(system: &Whitened<'_>, readings: usize, level: f64) -> Option<Snooping> {
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let readings = readings.min(system.sd.len());
    let mut tested = (0..readings).filter(|row| system.checked(*row) > 0.0).count();
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
    let mut redundancies: Vec<f64> = (0..readings).map(|row| system.checked(row)).collect();
    while rows.len() < most && system.dof > rows.len() + spare {
        let square = norm(&residuals);
        let mut best: Option<(usize, f64)> = None;
        for row in (0..readings).filter(|row| !rows.contains(row)) {
            let left = redundancies.at(row);
            let redundancy = if left > UNCHECKED { left } else { 0.0 };
            let along = residuals.at(system.place.at(row));
            let heard = redundancy > 0.0 && along.abs() > ROUNDING * system.largest;
            if heard && best.is_none_or(|(_, gain)| along * along / redundancy > gain) {
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
        linear::project(&mut residuals, &[&unit]);
        for (row, left) in redundancies.iter_mut().enumerate() {
            *left -= unit.at(system.place.at(row)).powi(2);
        }
        extra.push(unit);
        rows.push(row);
    }
    if rows.is_empty() {
        return Some(Snooping { tested, single_level, suspects: Vec::new() });
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
    let variance = (square - gain).max(0.0) / (dof as f64 - 1.0);
    // residuals that are rounding of the ones before say nothing
    if !(variance > f64::EPSILON * f64::EPSILON * square) {
        return Some(if gain > 0.0 { 0.0 } else { 1.0 });
    }
    quantiles::student_t_two_sided((gain / variance).sqrt(), dof as f64 - 1.0)
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
    // R of the columns' QR: the shifts solve R s = Q'v, and their covariance is R^-1 R^-T
    let qr = faer::Mat::from_fn(system.residuals.len(), count, |i, a| all.at(a).at(i)).qr();
    let r = qr.thin_R();
    let triangle = Triangle::of_upper(count, |i, j| r[(i, j)]);
    let right = faer::Mat::from_fn(system.residuals.len(), 1, |i, _| system.residuals.at(i));
    let along = qr.compute_thin_Q().transpose() * right;
    let mut shifts: Vec<f64> = along.col_as_slice(0).to_vec();
    triangle.backward(&mut shifts);
    let mut residuals = system.residuals.clone();
    for (shift, column) in shifts.iter().zip(&all) {
        residuals.iter_mut().zip(column).for_each(|(v, c)| *v -= shift * c);
    }
    let variance = if system.variance_known { 1.0 } else { linear::dot(&residuals, &residuals) / dof.max(1) as f64 };
    for ((row, shift), column) in rows.iter().zip(shifts).zip(triangle.inverse_columns()) {
        // the shift of a standardised reading, in the reading's unit
        let sd = system.sd(*row);
        let u = variance.sqrt() * linear::norm(&column) * sd.abs();
        let w = shift * sd / u;
        let single = if system.variance_known {
            quantiles::chi_square_survival(w * w, 1.0)?
        } else if u > 0.0 {
            quantiles::student_t_two_sided(w, dof.max(1) as f64)?
        } else {
            0.0
        };
        let p = -(tested as f64 * (-single).ln_1p()).exp_m1();
        suspects.push(Suspect { row: *row, shift: shift * sd, u, w, p });
    }
    Some(suspects)
}
