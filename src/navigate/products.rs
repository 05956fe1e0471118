//! Least squares of a few of many columns, on inner products alone.
#![allow(
    clippy::indexing_slicing,
    reason = "products and norms have one entry for each column, and sets hold numbers of these columns"
)]

use crate::elements::Elements;
use crate::linear::{Triangle, dot, normalise};
use crate::uncertainty::quantiles::{normal_quantile, normal_survival};
use std::cell::RefCell;
use std::rc::Rc;

/// A column depends on others where no more than this share of its square is orthogonal to them.
pub(super) const INDEPENDENT: f64 = 1e-7;

/// Inner products of columns (weighted, of unit norm) with each other and with a residual.
pub(super) struct Products {
    pub columns: Vec<Rc<Vec<f64>>>,
    pub residual: Vec<f64>,
    /// Rows of `C' C`, computed on demand: those of the columns of sets so far.
    gram: RefCell<Vec<Option<Rc<Vec<f64>>>>>,
    /// Its diagonal.
    squares: Vec<f64>,
    /// `C' r`.
    along: Vec<f64>,
    /// `r' r`.
    square: f64,
}

/// A set solved: its coefficients (of the unit columns), the inverse of its products, and the residual sum of squares.
pub(super) struct Solved {
    pub values: Vec<f64>,
    pub inverse: Vec<Vec<f64>>,
    pub rss: f64,
}

impl Products {
    /// Columns may be zero.
    pub fn new(columns: Vec<Rc<Vec<f64>>>, residual: &[f64]) -> Products {
        let along = columns.iter().map(|column| dot(column, residual)).collect();
        let squares = columns.iter().map(|column| dot(column, column)).collect();
        let gram = RefCell::new(vec![None; columns.len()]);
        let (square, residual) = (dot(residual, residual), residual.to_vec());
        Products { columns, residual, gram, squares, along, square }
    }

    /// The same of columns that are scaled to unit norm here, with their norms.
    pub fn normalised(mut columns: Vec<Vec<f64>>, residual: &[f64]) -> (Products, Vec<f64>) {
        let norms = columns.iter_mut().map(|column| normalise(column)).collect();
        (Products::new(columns.into_iter().map(Rc::new).collect(), residual), norms)
    }

    /// Products of one column with all.
    fn row(&self, i: usize) -> Rc<Vec<f64>> {
        if let Some(row) = self.gram.borrow().get(i).and_then(Clone::clone) {
            return row;
        }
        let this = &self.columns[i];
        let row: Rc<Vec<f64>> = Rc::new(self.columns.iter().map(|column| dot(this, column)).collect());
        self.gram.borrow_mut().get_mut(i).into_iter().for_each(|slot| *slot = Some(row.clone()));
        row
    }

    fn product(&self, i: usize, j: usize) -> f64 {
        if i == j { self.squares.at(i) } else { self.row(i).at(j) }
    }

    /// Least squares of a set; `None` where its columns are not independent.
    pub fn solve(&self, set: &[usize]) -> Option<Solved> {
        self.damped(set, 0.0)
    }

    /// The same with so much added to the square of each column (Levenberg and Marquardt's step); `rss` is that of the linear model.
    pub fn damped(&self, set: &[usize], damping: f64) -> Option<Solved> {
        let entry = |a: usize, b: usize| match (set.get(a), set.get(b)) {
            (Some(a), Some(b)) => self.product(*a, *b) * if a == b { 1.0 + damping } else { 1.0 },
            // both are below `set.len()`
            _ => f64::NAN,
        };
        let least = |a: usize| set.get(a).map_or(f64::NAN, |a| INDEPENDENT * self.product(*a, *a));
        let triangle = Triangle::of(set.len(), entry, least)?;
        let along: Vec<f64> = set.iter().map(|j| self.along.get(*j).copied()).collect::<Option<_>>()?;
        let values = triangle.solve(&along);
        let taken = dot(&values, &along);
        Some(Solved { inverse: triangle.inverse(), rss: (self.square - taken).max(0.0), values })
    }

    /// By how much each column reduces the sum of squares, given a set; zero for members and what is in their span.
    pub fn gains(&self, set: &[usize], solved: &Solved) -> Vec<f64> {
        let rows: Vec<Rc<Vec<f64>>> = set.iter().map(|k| self.row(*k)).collect();
        let one = |j: usize| -> f64 {
            let square = self.product(j, j);
            if set.contains(&j) || !(square > 0.0) {
                return 0.0;
            }
            let with: Vec<f64> = rows.iter().map(|row| row[j]).collect();
            let mut outside = square;
            for (row, a) in solved.inverse.iter().zip(&with) {
                outside -= a * row.iter().zip(&with).map(|(v, b)| v * b).sum::<f64>();
            }
            if !(outside > INDEPENDENT * square) {
                return 0.0;
            }
            let along = self.along[j] - with.iter().zip(&solved.values).map(|(a, x)| a * x).sum::<f64>();
            along * along / outside
        };
        (0..self.along.len()).map(one).collect()
    }

    /// Columns that could replace a member, and how much worse they fit; at most `excess`.
    pub fn rivals(&self, set: &[usize], place: usize, excess: f64) -> Vec<(usize, f64, bool)> {
        let Some(member) = set.get(place) else { return Vec::new() };
        let mut others = set.to_vec();
        others.remove(place);
        let (Some(with), Some(solved)) = (self.solve(set), self.solve(&others)) else { return Vec::new() };
        let gains = self.gains(&others, &solved);
        let rivals = gains.iter().enumerate().filter(|(j, _)| j != member && !set.contains(j));
        let rivals = rivals.map(|(j, gain)| (j, solved.rss - gain - with.rss));
        let near = rivals.filter(|(j, worse)| *worse <= excess && self.product(*j, *j) > 0.0);
        near.map(|(j, worse)| (j, worse, self.product(*member, j).abs() > 1.0 - 1e-6)).collect()
    }

    /// Pairs of these columns that could replace two members of a set together, and how much worse they fit; at most `excess`. Of two columns the
    /// one nearer to the first place's is first. With scores `s` and cosines `g` outside the others,
    /// `drop = (s_a^2 + s_b^2 - 2 g s_a s_b) / (1 - g^2)`.
    pub fn pairs(&self, set: &[usize], places: [usize; 2], excess: f64, among: &[usize]) -> Vec<(usize, usize, f64)> {
        let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| !places.contains(k)).map(|(_, j)| *j).collect();
        let (Some(with), Some(solved)) = (self.solve(set), self.solve(&others)) else { return Vec::new() };
        let [Some(first), Some(second)] = places.map(|place| set.get(place).copied()) else { return Vec::new() };
        // of each column what the others leave, and its score
        let one = |j: &usize| {
            let square = self.product(*j, *j);
            let along: Vec<f64> = others.iter().map(|k| self.product(*k, *j)).collect();
            let taken: Vec<f64> = solved.inverse.iter().map(|row| dot(row, &along)).collect();
            let outside = square - dot(&along, &taken);
            let usable = square > 0.0 && outside > INDEPENDENT * square;
            let score = self.along.get(*j)? - dot(&along, &solved.values);
            usable.then(|| (*j, along, taken, outside.sqrt(), score / outside.sqrt()))
        };
        let usable: Vec<_> = among.iter().filter(|j| !set.contains(j)).filter_map(one).collect();
        let mut pairs = Vec::new();
        for (k, (a, along, _, norm, score)) in usable.iter().enumerate() {
            for (b, _, taken, size, other) in usable.iter().skip(k + 1) {
                let cosine = (self.product(*a, *b) - dot(along, taken)) / (norm * size);
                let sine = 1.0 - cosine * cosine;
                if !(sine > INDEPENDENT) {
                    continue;
                }
                let drop = (score * score + other * other - 2.0 * cosine * score * other) / sine;
                let worse = solved.rss - drop - with.rss;
                if worse <= excess {
                    let near = |j: usize, member: usize| self.product(member, j).abs();
                    let straight = near(*a, first) * near(*b, second) >= near(*b, first) * near(*a, second);
                    pairs.push(if straight { (*a, *b, worse) } else { (*b, *a, worse) });
                }
            }
        }
        pairs
    }
}

/// `z^2` beyond which the best of so many columns is significant: `2 (1 - Phi(z)) count = significance`.
pub(super) fn penalty(significance: f64, count: usize) -> f64 {
    let tail = 0.5 * significance / count.max(1) as f64;
    // at a significance of zero, beyond all numbers
    normal_quantile(tail).map_or(f64::INFINITY, |z| z * z)
}

/// Family-wise probability of so large a t by chance in so many tests.
pub(super) fn chance(t: f64, tests: usize) -> f64 {
    // t beyond all numbers: certain
    (2.0 * normal_survival(t.abs()).unwrap_or_default() * tests as f64).min(1.0)
}
