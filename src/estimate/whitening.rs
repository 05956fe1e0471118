//! Covariance of the readings as a sum of components, block by block: Cholesky factors, and rows made independent by them.

use super::components::Component;
use super::{Group, System};
use faer::Mat;

/// Rows that are correlated with each other, directly or through others.
pub(super) fn blocks(m: usize, components: &[Component]) -> Vec<Vec<usize>> {
    let mut label: Vec<usize> = (0..m).collect();
    fn root(label: &mut [usize], mut i: usize) -> usize {
        while label[i] != i {
            label[i] = label[label[i]];
            i = label[i];
        }
        i
    }
    for component in components.iter().filter(|c| !c.offset.is_empty()) {
        let mut first: std::collections::HashMap<usize, usize> = std::collections::HashMap::new();
        for ((row, _), offset) in component.rows.iter().zip(&component.offset) {
            let other = *first.entry(*offset).or_insert(*row);
            let (a, b) = (root(&mut label, *row), root(&mut label, other));
            label[a] = b;
        }
    }
    let mut number = vec![usize::MAX; m];
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    for i in 0..m {
        let root = root(&mut label, i);
        if number[root] == usize::MAX {
            number[root] = blocks.len();
            blocks.push(Vec::new());
        }
        blocks[number[root]].push(i);
    }
    blocks
}

/// Cholesky factors of V, block by block.
pub(super) struct Whitening<'a> {
    pub(super) blocks: &'a [Vec<usize>],
    /// Lower triangles, each as a dense matrix.
    lower: Vec<Mat<f64>>,
    /// Block and place in it of each row.
    place: Vec<(usize, usize)>,
}

impl<'a> Whitening<'a> {
    pub(super) fn new(blocks: &'a [Vec<usize>], components: &[Component], variance: &[f64]) -> Self {
        let m = blocks.iter().map(Vec::len).sum();
        let mut place = vec![(0, 0); m];
        for (b, block) in blocks.iter().enumerate() {
            for (at, row) in block.iter().enumerate() {
                place[*row] = (b, at);
            }
        }
        let mut whole: Vec<Mat<f64>> = blocks.iter().map(|b| Mat::zeros(b.len(), b.len())).collect();
        for (component, variance) in components.iter().zip(variance) {
            for_pairs(component, &place, |block, i, j, product| whole[block][(i, j)] += variance * product);
        }
        let lower = whole.iter().map(cholesky).collect();
        Whitening { blocks, lower, place }
    }

    /// Is V positive definite, with room for rounding?
    pub(super) fn is_definite(&self) -> bool {
        self.lower.iter().all(|lower| (0..lower.nrows()).all(|i| lower[(i, i)] > 1e-4 * lower[(0, 0)]))
    }

    /// `L^-1 y`.
    fn apply(&self, values: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; values.len()];
        for (block, lower) in self.blocks.iter().zip(&self.lower) {
            for (at, row) in block.iter().enumerate() {
                let before: f64 = (0..at).map(|k| lower[(at, k)] * out[block[k]]).sum();
                out[*row] = (values[*row] - before) / lower[(at, at)];
            }
        }
        out
    }

    pub(super) fn system(&self, system: &System) -> System {
        let (m, n) = system.shape();
        let mut rows = Mat::zeros(m, n);
        for j in 0..n {
            rows.col_as_slice_mut(j).copy_from_slice(&self.apply(system.rows.col_as_slice(j)));
        }
        System { rows, observed: self.apply(&system.observed), u: vec![1.0; m], group: vec![Group::Known; m] }
    }

    /// The columns of `L^-1`, without zeros.
    pub(super) fn indicators(&self) -> Vec<Vec<(usize, f64)>> {
        let mut columns = vec![Vec::new(); self.place.len()];
        for (block, lower) in self.blocks.iter().zip(&self.lower) {
            for at in 0..block.len() {
                let mut column = vec![0.0; block.len()];
                for i in at..block.len() {
                    let before: f64 = (at..i).map(|k| lower[(i, k)] * column[k]).sum();
                    column[i] = (if i == at { 1.0 } else { 0.0 } - before) / lower[(i, i)];
                }
                columns[block[at]] = (at..block.len()).map(|i| (block[i], column[i])).collect();
            }
        }
        columns
    }

    /// `S <- S L^-1`.
    pub(super) fn transform_columns(&self, sensitivities: &mut Mat<f64>) {
        for (block, lower) in self.blocks.iter().zip(&self.lower) {
            for i in 0..sensitivities.nrows() {
                for at in (0..block.len()).rev() {
                    let after: f64 = (at + 1..block.len()).map(|k| sensitivities[(i, block[k])] * lower[(k, at)]).sum();
                    sensitivities[(i, block[at])] = (sensitivities[(i, block[at])] - after) / lower[(at, at)];
                }
            }
        }
    }

    /// `L^-1 V_h L^-T`, block by block.
    pub(super) fn whiten(&self, component: &Component) -> Vec<Mat<f64>> {
        let mut parts: Vec<Mat<f64>> = self.blocks.iter().map(|b| Mat::zeros(b.len(), b.len())).collect();
        for_pairs(component, &self.place, |block, i, j, product| parts[block][(i, j)] += product);
        for (part, lower) in parts.iter_mut().zip(&self.lower) {
            for _ in 0..2 {
                // L^-1 from the left, then the same on the transpose
                for j in 0..part.ncols() {
                    for i in 0..part.nrows() {
                        let before: f64 = (0..i).map(|k| lower[(i, k)] * part[(k, j)]).sum();
                        part[(i, j)] = (part[(i, j)] - before) / lower[(i, i)];
                    }
                }
                *part = part.transpose().to_owned();
            }
        }
        parts
    }
}

/// Visit the elements of V_h that are not zero.
fn for_pairs(component: &Component, place: &[(usize, usize)], mut visit: impl FnMut(usize, usize, usize, f64)) {
    if component.offset.is_empty() {
        for (row, u) in &component.rows {
            let (block, at) = place[*row];
            visit(block, at, at, u * u);
        }
        return;
    }
    let mut shared: std::collections::BTreeMap<usize, Vec<(usize, f64)>> = std::collections::BTreeMap::new();
    for ((row, u), offset) in component.rows.iter().zip(&component.offset) {
        shared.entry(*offset).or_default().push((*row, *u));
    }
    for rows in shared.values() {
        for (a, u) in rows {
            for (b, w) in rows {
                let ((block, i), (_, j)) = (place[*a], place[*b]);
                visit(block, i, j, u * w);
            }
        }
    }
}

fn cholesky(whole: &Mat<f64>) -> Mat<f64> {
    let n = whole.nrows();
    let mut lower = Mat::zeros(n, n);
    for j in 0..n {
        let rest = whole[(j, j)] - (0..j).map(|k| lower[(j, k)] * lower[(j, k)]).sum::<f64>();
        // what is not positive definite comes out with a tiny pivot, see `is_definite`
        let pivot = rest.max(whole[(j, j)] * f64::EPSILON).max(f64::MIN_POSITIVE).sqrt();
        lower[(j, j)] = pivot;
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| lower[(i, k)] * lower[(j, k)]).sum();
            lower[(i, j)] = (whole[(i, j)] - sum) / pivot;
        }
    }
    lower
}
