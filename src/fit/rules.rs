//! The campaign's constraints at a point of linearisation: equations and inequalities of the step, and what became of them.

use crate::campaign::{Campaign, Constraint};
use crate::elements::Elements;
use crate::estimate::{Elimination, Equation, Equations, Inequality, Side, System};
use crate::linear::norm;
use faer::Mat;

/// What became of the constraints.
#[derive(Debug, Clone)]
pub enum Constraints {
    /// The campaign has none.
    None,
    /// All are met.
    Met {
        /// Those that hold the estimate back; an equation is never listed.
        active: Vec<ActiveConstraint>,
        /// By how much all of them together raise chi-square.
        cost: f64,
        /// Covariance of the constrained estimate from the readings, on the active face; `None` where nothing is active.
        on_face: Option<Mat<f64>>,
        /// The estimate that only the equations restrict, all estimated parameters.
        free: Vec<f64>,
        /// A root of its covariance: the metric in which the nearest admissible values are found.
        along: Mat<f64>,
        /// What the equations cost, where there are such.
        equations: Option<Cost>,
    },
    /// No values meet them all: these, by index in the campaign, contradict each other. None was applied.
    Contradictory(Vec<usize>),
    /// The inequalities were not applied: the readings leave a combination free, or the solver gave up.
    NotApplied,
}

/// What constraints cost together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// By how much they raise chi-square.
    pub chi_square: f64,
    /// How many unknowns they take from the adjustment.
    pub count: usize,
    /// Degrees of freedom of the adjustment without them.
    pub dof: usize,
}

/// A constraint that holds the estimate back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveConstraint {
    /// Index in the campaign.
    pub constraint: usize,
    /// Which side.
    pub side: Side,
    /// Decrease of chi-square for each unit (radian for tilts) by which it gives way.
    pub multiplier: f64,
    /// By how much chi-square would be smaller without it.
    pub cost: f64,
}

/// Equations and inequalities of the change from a point; each with its constraint's index.
#[derive(Clone, Default)]
pub(super) struct Rules {
    pub equations: Vec<Equation>,
    pub equation_of: Vec<usize>,
    pub inequalities: Vec<Inequality>,
    pub inequality_of: Vec<usize>,
}

impl Rules {
    /// The equations eliminated from a system of the unknowns (nothing where there are none); or the constraints of the campaign that contradict each other.
    pub fn eliminate(&self, system: &System, unknowns: usize) -> (Option<Elimination>, Option<Vec<usize>>) {
        if self.equations.is_empty() {
            return (None, None);
        }
        let square =
            |j: usize| system.rows.col_as_slice(j).iter().zip(&system.u).map(|(a, u)| (a / u).powi(2)).sum::<f64>();
        let scale: Vec<f64> = (0..unknowns).map(|j| square(j).sqrt()).collect();
        match Equations::new(unknowns, &scale, &self.equations) {
            Equations::Consistent(elimination) => (Some(elimination), None),
            Equations::Contradictory(which) => (None, Some(self.equations_named(&which))),
        }
    }

    pub(super) fn at(campaign: &Campaign, point: &[f64]) -> Self {
        let mut rules = Rules::default();
        let at = |j: &usize| point.at(*j);
        for (k, constraint) in campaign.constraints.iter().enumerate() {
            match constraint {
                Constraint::Linear { terms, lower, upper } => {
                    let here: f64 = terms.iter().map(|(j, c)| c * at(j)).sum();
                    if lower == upper {
                        rules.equations.push(Equation { terms: terms.clone(), value: lower - here });
                        rules.equation_of.push(k);
                    } else {
                        let (lower, upper) = (lower - here, upper - here);
                        rules.inequalities.push(Inequality::Range { terms: terms.clone(), lower, upper });
                        rules.inequality_of.push(k);
                    }
                }
                Constraint::Norm { of, at_most } => {
                    let of = of.iter().map(|j| (*j, at(j))).collect();
                    rules.inequalities.push(Inequality::Norm { of, at_most: *at_most });
                    rules.inequality_of.push(k);
                }
            }
        }
        rules
    }

    /// Campaign indices of equations.
    pub(super) fn equations_named(&self, which: &[usize]) -> Vec<usize> {
        which.iter().filter_map(|k| self.equation_of.get(*k).copied()).collect()
    }

    /// Campaign indices of inequalities.
    pub(super) fn inequalities_named(&self, which: &[usize]) -> Vec<usize> {
        which.iter().filter_map(|k| self.inequality_of.get(*k).copied()).collect()
    }
}

/// Two constraints on the same combination that no value of it meets, however little is missing: told by comparing numbers, where a solver has
/// a tolerance.
pub(super) fn contradiction(campaign: &Campaign) -> Option<Vec<usize>> {
    type Range = (Vec<(usize, f64)>, f64, f64);
    let normal = |constraint: &Constraint| -> Option<Range> {
        let Constraint::Linear { terms, lower, upper } = constraint else { return None };
        let mut terms: Vec<(usize, f64)> = terms.iter().copied().filter(|(_, c)| *c != 0.0).collect();
        terms.sort_unstable_by_key(|(k, _)| *k);
        let first = terms.first()?.1;
        terms.iter_mut().for_each(|(_, c)| *c /= first);
        let (a, b) = (lower / first, upper / first);
        Some((terms, a.min(b), a.max(b)))
    };
    let ranges: Vec<Option<Range>> = campaign.constraints.iter().map(normal).collect();
    let same = |a: &[(usize, f64)], b: &[(usize, f64)]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() <= 1e-14 * a.1.abs())
    };
    for (i, own) in ranges.iter().enumerate() {
        for (j, other) in ranges.iter().enumerate().skip(i + 1) {
            let (Some(own), Some(other)) = (own, other) else { continue };
            let (lower, upper) = (own.1.max(other.1), own.2.min(other.2));
            if same(&own.0, &other.0) && lower > upper + 4.0 * f64::EPSILON * lower.abs().max(upper.abs()) {
                return Some(vec![i, j]);
            }
        }
    }
    None
}

/// Does this point meet every constraint (to rounding)?
pub(super) fn is_feasible(campaign: &Campaign, point: &[f64]) -> bool {
    let at = |j: &usize| point.at(*j);
    campaign.constraints.iter().all(|constraint| match constraint {
        Constraint::Linear { terms, lower, upper } => {
            let value: f64 = terms.iter().map(|(j, c)| c * at(j)).sum();
            let reach: f64 = terms.iter().map(|(j, c)| (c * at(j)).abs()).sum();
            let room = 1e-12 * reach;
            value >= lower - room && value <= upper + room
        }
        Constraint::Norm { of, at_most } => {
            of.iter().map(|j| at(j) * at(j)).sum::<f64>().sqrt() <= at_most * (1.0 + 1e-12)
        }
    })
}

/// Values that constraints on this combination of parameters (or a norm of all that are in it) allow it.
pub(super) fn allowed(campaign: &Campaign, along: &[f64]) -> (f64, f64) {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let largest = along.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    for constraint in &campaign.constraints {
        let (a, b) = match constraint {
            Constraint::Linear { terms, lower, upper } => {
                let mut own = vec![0.0; along.len()];
                terms.iter().for_each(|(j, c)| own.iter_mut().skip(*j).take(1).for_each(|slot| *slot += c));
                let Some((c, of)) = own.iter().zip(along).find(|(_, of)| of.abs() == largest) else { continue };
                let times = c / of;
                // to the rounding of a quotient and a product
                let same = |(c, of): (&f64, &f64)| (c - times * of).abs() <= 1e-14 * (times * largest).abs();
                if !(times.abs() > 0.0) || !own.iter().zip(along).all(same) {
                    continue;
                }
                (lower / times, upper / times)
            }
            Constraint::Norm { of, at_most } => {
                if along.iter().enumerate().any(|(k, c)| *c != 0.0 && !of.contains(&k)) {
                    continue;
                }
                let most = at_most * norm(along);
                (-most, most)
            }
        };
        (low, high) = (low.max(a.min(b)), high.min(a.max(b)));
    }
    (low, high)
}

/// Parameters that the equations leave one value.
pub(super) fn fixed(campaign: &Campaign, point: &[f64]) -> Vec<usize> {
    let unknowns = campaign.unknowns();
    match Equations::new(unknowns, &[], &Rules::at(campaign, point).equations) {
        Equations::Consistent(elimination) => (0..unknowns).filter(|k| elimination.fixes(*k)).collect(),
        Equations::Contradictory(_) => Vec::new(),
    }
}

/// Parameters that an active constraint names.
pub(super) fn at_bound(campaign: &Campaign, constraints: &Constraints) -> Vec<usize> {
    let Constraints::Met { active, .. } = constraints else { return Vec::new() };
    active.iter().filter_map(|a| campaign.constraints.get(a.constraint)).flat_map(named_by).collect()
}

/// Put a parameter that is bounded by itself on its bound to the last digit.
pub(super) fn snap(campaign: &Campaign, constraints: &Constraints, point: &mut [f64]) {
    let Constraints::Met { active, .. } = constraints else { return };
    for a in active {
        if let Some(Constraint::Linear { terms, lower, upper }) = campaign.constraints.get(a.constraint)
            && let [(j, c)] = terms.as_slice()
            && let Some(value) = point.get_mut(*j)
        {
            *value = if a.side == Side::Lower { lower / c } else { upper / c };
        }
    }
}

/// Parameters that a constraint names.
fn named_by(constraint: &Constraint) -> Vec<usize> {
    match constraint {
        Constraint::Linear { terms, .. } => terms.iter().filter(|(_, c)| *c != 0.0).map(|(j, _)| *j).collect(),
        Constraint::Norm { of, .. } => of.clone(),
    }
}
