//! Quality of each row of a system, and the global test of all.

use crate::elements::Elements;
use crate::estimate::{Estimate, Group, System};
use crate::uncertainty::quantiles;

/// Quality of one row of the system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowQuality {
    /// Observed minus fitted, in the sensor's unit.
    pub residual: f64,
    /// Standard uncertainty that the adjustment used, group scale included; `None` if the scale could not be estimated.
    pub u: Option<f64>,
    /// Diagonal of the hat matrix.
    pub leverage: f64,
    /// Redundancy number, `1 - leverage`.
    pub redundancy: f64,
    /// Internally studentized residual, `v / (u sqrt r)`; `None` where the reading is not checked by any other. Where readings share deviations,
    /// `v` is what is left when these are taken out.
    pub studentized: Option<f64>,
    /// Minimal detectable bias, `u delta0 / sqrt r`, in the sensor's unit.
    pub mdb: Option<f64>,
}

/// Significance at which a single reading is bad (Baarda's alpha).
pub(crate) const ALPHA: f64 = 0.001;

/// Non-centrality `delta0 = z(1 - alpha/2) + z(power)` of the minimal detectable bias, alpha = `ALPHA`, power = 0.80 (Baarda's 4.13).
pub fn baarda_delta() -> f64 {
    // both probabilities lie between 0 and 1, where there is a quantile
    let z = |p| quantiles::normal_quantile(p).unwrap_or(0.0);
    z(1.0 - ALPHA / 2.0) + z(0.80)
}

/// Below this redundancy number a reading counts as unchecked: its residual is rounding.
pub(crate) const UNCHECKED: f64 = 1e-9;

/// What the numbers of rows come from where it is not their estimate alone: known inputs or deviations that are shared have a part in it.
#[derive(Debug, Clone)]
pub(crate) struct Tested {
    /// Redundancy number of each row.
    pub redundancy: Vec<f64>,
    /// Residuals over standard deviations; what is shared is taken out of them.
    pub standardized: Vec<f64>,
    /// Of rows with deviations of their own ([`Scattered::alone`](crate::estimate::Scattered::alone)): where what they have for themselves stands in both, and its
    /// standard deviation with a sign.
    pub alone: Vec<(usize, f64)>,
}

impl RowQuality {
    /// Quality of a row of a system and its estimate; `delta` is [`baarda_delta`].
    ///
    /// With deviations that are shared, `V = R + Z D Z'`, a row's redundancy number is `u^2 (V^-1 - V^-1 A (A' V^-1 A)^-1 A' V^-1)_ii` and its studentized
    /// residual `u (V^-1 v)_i / sqrt r` (K.-R. Koch, Parameter Estimation and Hypothesis Testing in Linear Models, 1999, 4.3): the test of one wrong reading.
    pub(crate) fn of(system: &System, estimate: &Estimate, tested: Option<&Tested>, delta: f64, row: usize) -> Self {
        let at = |list: &[f64]| list.at(row);
        let scale = match system.group.get(row) {
            Some(Group::Estimated(g)) => estimate.group_scale.get(*g).copied().flatten(),
            _ => Some(1.0),
        };
        let u = scale.map(|scale| scale * at(&system.u));
        let residual = at(&estimate.residuals);
        let redundancy = at(tested.map_or(&estimate.redundancy, |tested| &tested.redundancy));
        let leverage = tested.map_or_else(|| at(&estimate.leverage), |_| 1.0 - redundancy);
        // in units of what the row has for itself: redundancy number, residual and standard deviation
        let own = u.map(|u| match tested.map(|tested| (tested, tested.alone.get(row))) {
            Some((tested, Some((place, sd)))) => {
                (tested.redundancy.at(*place), tested.standardized.at(*place) * sd.signum(), sd.abs())
            }
            Some((tested, None)) => (redundancy, at(&tested.standardized), u),
            None => (redundancy, residual / u, u),
        });
        let checked = own.filter(|(redundancy, _, sd)| *redundancy > UNCHECKED && *sd > 0.0);
        let studentized = checked.map(|(redundancy, residual, _)| residual / redundancy.sqrt());
        let mdb = checked.map(|(redundancy, _, sd)| delta * sd / redundancy.sqrt());
        RowQuality { residual, u, leverage, redundancy, studentized, mdb }
    }
}

/// Global test of a model whose readings all have stated uncertainties: `sum (v/u)^2` against chi-square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlobalTest {
    /// The statistic.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub dof: usize,
    /// Probability of a larger value if model and uncertainties are right.
    pub p: f64,
    /// Is `p` below one minus the level?
    pub rejected: bool,
}

/// The global chi-square test; `None` where an uncertainty was estimated from these readings, or nothing is redundant.
pub fn global_test(system: &System, estimate: &Estimate, level: f64) -> Option<GlobalTest> {
    if estimate.dof == 0 || system.group.iter().any(|group| matches!(group, Group::Estimated(_))) {
        return None;
    }
    let p = quantiles::chi_square_survival(estimate.sum_of_squares, estimate.dof as f64)?;
    Some(GlobalTest { chi_square: estimate.sum_of_squares, dof: estimate.dof, p, rejected: p < 1.0 - level })
}
