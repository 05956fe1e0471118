//! The readings of one position as a few rows that say the same.
//!
//! ```text
//! Q' [Z A y] / u = [T; 0],      the rows of one block of deviations and one component, Q orthogonal
//! ```
//!
//! Such rows have one variance factor whatever the variances come to, and the likelihood asks for sums over them that `Q` leaves as they are: squares,
//! redundancies, informations, the covariance of the unknowns. Rows of zeros count in the redundancy and in the determinant, and nowhere else. So the
//! search for the variances, which whitens the rows anew at each step, works on `deviations + unknowns + 1` rows for each position instead of all
//! readings, and finds the same: nothing is approximated. What belongs to single readings is made once, at the variances that were found.
#![allow(
    clippy::indexing_slicing,
    reason = "the pattern is that of the system, which `System::check` has seen: fronts hold rows and deviations below its numbers, and `class` has an entry for each row"
)]

use super::inference::LeftOut;
use super::pattern::ByRow;
use super::problem::{Ended, Problem};
use super::restricted::Limits;
use super::{Felt, ScatterLine};
use crate::error::Result;
use crate::estimate::fold::triangle_of;
use crate::estimate::{Group, System};
use faer::Mat;

/// Up to so many rows nothing is gained.
const FEW: usize = 512;
/// Rows whose standard uncertainties differ by more than this stay as they are: reflections would leave the rounding of the large ones in the small.
const ALIKE: f64 = 1e4;

/// A system of fewer rows with the same likelihood, but for [`LeftOut`].
pub(super) struct Condensed {
    system: System,
    lines: Vec<ScatterLine>,
    left_out: LeftOut,
}

/// The rows of one block of deviations and one component.
struct Class {
    rows: Vec<usize>,
    /// The front that holds their deviations; none where they feel no deviation.
    front: Option<usize>,
    group: Group,
}

impl Condensed {
    /// `None` where there are few rows, where not many share their deviations, or where deviations follow each other in time.
    pub fn new(problem: &Problem<'_>) -> Option<Self> {
        let Problem { system, lines, pattern, .. } = problem;
        let (m, n) = system.shape();
        if m <= FEW || !pattern.is_simple {
            return None;
        }
        let classes = classes(problem);
        let columns = |class: &Class| class.front.map_or(0, |f| pattern.fronts[f].columns.len());
        let least: usize = classes.iter().map(|class| class.rows.len().min(columns(class) + n + 1)).sum();
        if 2 * least > m {
            return None;
        }
        let pairs = lines.iter().zip(&pattern.first).flat_map(|(line, start)| {
            line.felt.iter().map(move |felt| (felt.row, (start.saturating_add(felt.level), felt.by)))
        });
        let felt = ByRow::new(m, pairs);
        let felt_by = vec![Vec::new(); lines.len()];
        let mut made = Made { columns: n + 1, rows: Vec::new(), u: Vec::new(), group: Vec::new(), felt: felt_by };
        let mut left_out = LeftOut { rows: vec![0.0; problem.groups], log_determinant: 0.0 };
        for class in &classes {
            let deviations = class.front.map_or(&[][..], |f| &pattern.fronts[f].columns);
            let line_of = |d: usize| pattern.first.partition_point(|start| *start <= d).saturating_sub(1);
            let named: Vec<(usize, usize)> =
                deviations.iter().map(|d| (line_of(*d), *d)).map(|(k, d)| (k, d - pattern.first[k])).collect();
            let size = deviations.len() + n + 1;
            let value = |row: usize, j: usize| match j.checked_sub(deviations.len()) {
                None => felt.of(row).iter().filter(|(d, _)| *d == deviations[j]).map(|(_, slope)| slope).sum(),
                Some(j) if j < n => system.rows[(row, j)],
                Some(_) => system.observed[row],
            };
            if class.rows.len() <= size || !alike(system, &class.rows) {
                for row in &class.rows {
                    made.push(|j| value(*row, j), 0, &named, system.u[*row], class.group);
                }
                continue;
            }
            let own = |i: usize, j: usize| value(class.rows[i], j) / system.u[class.rows[i]];
            let folded = triangle_of(class.rows.len(), size, own);
            (0..size).for_each(|i| made.push(|j| folded[(i, j)], i, &named, 1.0, class.group));
            left_out.log_determinant += class.rows.iter().map(|row| 2.0 * system.u[*row].ln()).sum::<f64>();
            if let Group::Estimated(g) = class.group {
                left_out.rows[g] += (class.rows.len() - size) as f64;
            }
        }
        // a level that no row feels would be lost at the end of its line
        let found = made.finish(lines, left_out);
        found.lines.iter().zip(*lines).all(|(few, all)| few.levels() == all.levels()).then_some(found)
    }
}

/// Rows as they are made.
struct Made {
    /// Unknowns, and one for what was observed.
    columns: usize,
    /// Derivatives by the unknowns, and what was observed, of one row after the other.
    rows: Vec<f64>,
    u: Vec<f64>,
    group: Vec<Group>,
    felt: Vec<Vec<Felt>>,
}

impl Made {
    /// One more row: `value` gives its derivatives by the deviations `named` (line and level), by the unknowns, and what was observed. Those before
    /// `from` are zero by construction.
    fn push(&mut self, value: impl Fn(usize) -> f64, from: usize, named: &[(usize, usize)], u: f64, group: Group) {
        let row = self.u.len();
        for (j, (line, level)) in named.iter().enumerate().skip(from) {
            self.felt[*line].push(Felt { row, level: *level, by: value(j) });
        }
        self.rows.extend((named.len()..named.len() + self.columns).map(value));
        self.u.push(u);
        self.group.push(group);
    }

    fn finish(self, lines: &[ScatterLine], left_out: LeftOut) -> Condensed {
        let (count, n) = (self.u.len(), self.columns - 1);
        let element = |i: usize, j: usize| self.rows[i * self.columns + j];
        let system = System {
            rows: Mat::from_fn(count, n, element),
            observed: (0..count).map(|i| element(i, n)).collect(),
            u: self.u,
            group: self.group,
        };
        let own = |(line, felt): (&ScatterLine, Vec<Felt>)| ScatterLine {
            felt,
            variance: line.variance,
            memory: line.memory.clone(),
        };
        Condensed { system, lines: lines.iter().zip(self.felt).map(own).collect(), left_out }
    }
}

/// The rows of each front, component by component, and those without a deviation.
fn classes(problem: &Problem<'_>) -> Vec<Class> {
    let Problem { system, pattern, groups, .. } = problem;
    let mut free = vec![true; system.observed.len()];
    let mut classes = Vec::new();
    let mut add = |rows: &mut dyn Iterator<Item = usize>, front: Option<usize>| {
        let mut own: Vec<Vec<usize>> = vec![Vec::new(); groups + 1];
        for row in rows {
            own[system.group[row].estimated().unwrap_or(*groups)].push(row);
        }
        for (g, rows) in own.into_iter().enumerate().filter(|(_, rows)| !rows.is_empty()) {
            let group = if g < *groups { Group::Estimated(g) } else { Group::Known };
            classes.push(Class { rows, front, group });
        }
    };
    for (f, front) in pattern.fronts.iter().enumerate() {
        front.rows.iter().for_each(|row| free[*row] = false);
        add(&mut front.rows.iter().copied(), Some(f));
    }
    add(&mut (0..free.len()).filter(|row| free[*row]), None);
    classes
}

/// Are the standard uncertainties of these rows of one size?
fn alike(system: &System, rows: &[usize]) -> bool {
    let u = || rows.iter().map(|row| system.u[*row]);
    u().fold(0.0, f64::max) <= ALIKE * u().fold(f64::INFINITY, f64::min)
}

impl<'a> Problem<'a> {
    /// The same question of the rows that stand for these. `plain` are the variances from which the search begins, where it begins anew.
    pub fn on<'b>(&self, fewer: &'b Condensed, begins: bool) -> Result<Problem<'b>>
    where
        'a: 'b,
    {
        let plain = if begins { Some(self.plain()?) } else { None };
        let mut small = self.again(&fewer.system, &fewer.lines)?;
        (small.left_out, small.plain) = (fewer.left_out.clone(), plain);
        Ok(small)
    }

    /// [`Problem::solve`] on fewer rows where that is possible; the adjustment and what is inferred from it are those of all rows.
    pub fn solve_all(&mut self, start: &[f64], limits: Limits) -> Result<Ended> {
        let Some(fewer) = Condensed::new(self) else { return self.solve(start, limits) };
        let mut small = self.on(&fewer, start.len() != self.members.count)?;
        let ended = small.solve(start, limits)?;
        // at the edge of what is a covariance, rounding decides: then all rows do
        let Some(point) = self.at(self.lines, &ended.theta)? else { return self.solve(start, limits) };
        self.state = small.state;
        let likelihood = self.likelihood(self.lines, &point, &ended.theta)?;
        Ok(Ended { point, likelihood, ..ended })
    }
}
