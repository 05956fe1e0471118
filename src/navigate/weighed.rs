//! A question in fewer rows: its columns weighed and of unit norm.

use super::case::Case;
use super::cause::Cause;
use super::changing::Columns;
use super::products::INDEPENDENT;
use super::shortened::Shortened;
use super::whiten::Filter;
use crate::linear::{dot, normalise, orthonormal, project};
use std::cell::OnceCell;
use std::rc::Rc;

/// Of each bias and channel its waves: period, s, and the weighed columns of cosine and sine.
pub(super) type Waves = Vec<(Cause, Vec<(f64, [Vec<f64>; 2])>)>;

/// A question in fewer rows: its columns weighed and of unit norm, with their norms; the same for every state with the same values left out.
pub(super) struct Weighed {
    /// The columns and random walks from which it was made.
    columns: Rc<Columns>,
    out: Vec<usize>,
    pub short: Shortened,
    /// What columns are made of, at these rows.
    pub made: Columns,
    pub unit: Vec<(Rc<Vec<f64>>, f64)>,
    filter: Filter,
    /// Waves that are tried (`periodic.rs`).
    pub waves: OnceCell<Waves>,
}

/// What changes in time, given some causes: by how much it reduces the sum of squares, and its size.
pub(super) struct CourseFit {
    pub cause: Cause,
    pub size: f64,
    pub gain: f64,
}

/// What is given when a wave is fitted: an orthonormal basis of the causes, and the residual orthogonal to it.
pub(super) type Given = (Vec<Vec<f64>>, Vec<f64>);

/// A column of unit norm, and its norm before.
pub(super) fn unit(mut column: Vec<f64>) -> (Rc<Vec<f64>>, f64) {
    let norm = normalise(&mut column);
    (Rc::new(column), norm)
}

impl Weighed {
    pub fn new(case: &Case<'_>, u: &[f64], out: &[usize]) -> Weighed {
        let u = case.without(u, out);
        let mut short = Shortened::new(case.measured, &u);
        if short.is_blurred(&case.columns.walks.instants) {
            short = Shortened::picked(case.measured, &u);
        }
        let mut weighed = Weighed::of_rows(case, short, out);
        weighed.unit = weighed.rows(case.raw.iter()).into_iter().map(unit).collect();
        weighed
    }

    /// In these rows, without the columns of unit norm: for the few columns of a set.
    pub fn of_rows(case: &Case<'_>, short: Shortened, out: &[usize]) -> Weighed {
        let made = case.columns.shortened(&short);
        let (columns, out) = (case.columns.clone(), out.to_vec());
        let filter = Filter::new(&short.measured, &made.walks, &short.u);
        Weighed { columns, out, short, made, unit: Vec::new(), filter, waves: OnceCell::new() }
    }

    pub fn is_of(&self, case: &Case<'_>, out: &[usize]) -> bool {
        Rc::ptr_eq(&self.columns, &case.columns) && self.out == out
    }

    /// Columns over all values in these rows, weighed.
    pub fn rows<'b>(&self, columns: impl Iterator<Item = &'b Vec<f64>>) -> Vec<Vec<f64>> {
        let mut weighed: Vec<Vec<f64>> = columns.map(|column| self.short.column(column)).collect();
        self.weigh(&mut weighed);
        weighed
    }

    /// Columns over these rows, weighed.
    pub fn weigh(&self, columns: &mut [Vec<f64>]) {
        columns.iter_mut().for_each(|column| self.filter.apply(column));
    }

    /// The weighed column of a cause that need not be one of the question's.
    pub fn of(&self, case: &Case<'_>, cause: &Cause) -> Vec<f64> {
        let mut column = [match case.causes.iter().position(|other| other == cause).and_then(|j| case.raw.get(j)) {
            Some(raw) => self.short.column(raw),
            None => self.made.of(cause),
        }];
        self.weigh(&mut column);
        let [column] = column;
        column
    }

    /// Places of the values that are left out.
    pub fn out(&self) -> Vec<usize> {
        self.short.out(&self.out)
    }

    /// A cause given others.
    pub(super) fn fit(&self, cause: Cause, (basis, residual): &Given) -> Option<CourseFit> {
        let mut columns = [self.made.of(&cause)];
        self.weigh(&mut columns);
        let [mut column] = columns;
        let whole = dot(&column, &column);
        project(&mut column, basis);
        let (outside, along) = (dot(&column, &column), dot(&column, residual));
        (outside > INDEPENDENT * whole).then(|| CourseFit {
            cause,
            size: along / outside,
            gain: along * along / outside,
        })
    }

    pub(super) fn given(&self, fixed: impl IntoIterator<Item = Vec<f64>>, mut residual: Vec<f64>) -> Given {
        let basis = orthonormal(fixed, INDEPENDENT);
        project(&mut residual, &basis);
        (basis, residual)
    }
}
