//! Variance components: readings that share an offset, and groups whose scatter is unknown, in one generalised least squares.
//!
//! ```text
//! y = A x + e + offsets,   V = sum theta_h V_h,   V_h = diag(u^2) over a group's rows, or 1 1' over rows that share an offset
//! ```
//!
//! The rows are whitened by the Cholesky factors of V's blocks and adjusted by QR. Components come from Helmert's equations
//! `sum_h tr(P V_g P V_h) theta_h = y' P V_g P y`, iterated: at the fixed point REML (K.-R. Koch 1999, 3.6; H. D. Patterson, R. Thompson
//! 1971). The variance of an offset may come out negative as long as V stays positive definite: cutting it at zero would make the intervals
//! of what offsets dominate too long and those of the rest too short. The covariance of the solution carries the small-sample correction of M. G. Kenward and
//! J. H. Roger, "Small sample inference for fixed effects from restricted maximum likelihood", Biometrics 53 (1997).

use super::{Elimination, Estimate, Group, Settings, System, adjust, adjust_on};
use crate::error::Result;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// One variance component.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Rows, each with the standard deviation that a component of 1 gives it.
    pub rows: Vec<(usize, f64)>,
    /// The shared offset that each of `rows` has a part in; empty where errors are independent.
    pub offset: Vec<usize>,
    /// The variance if it is known.
    pub known: Option<f64>,
}

/// A system adjusted with its variance components.
#[derive(Debug, Clone)]
pub struct Components {
    /// Variance of each component.
    pub variance: Vec<f64>,
    /// Covariance of the estimated variances (rows and columns of all components; zero for known ones).
    pub spread: Mat<f64>,
    /// What the small-sample correction adds to the covariance of the unknowns, `n x n`.
    pub correction: Mat<f64>,
    /// The adjustment of the whitened rows: residuals, leverages and redundancies are those of whitened rows.
    pub estimate: Estimate,
    /// `d x / d y`, `n x m`, for the readings as they are.
    pub sensitivities: Mat<f64>,
    /// For each row of the system, a unit error of it in the whitened rows (row and value).
    pub indicators: Vec<Vec<(usize, f64)>>,
    /// Steps that the components took; whether they settled.
    pub iterations: usize,
    /// Did they settle?
    pub converged: bool,
}

/// Steps to the components at most.
const STEPS: usize = 200;
/// Steps that keep every variance positive, before those that converge quickly.
const SAFE_STEPS: usize = 4;
/// Relative change of the variances that no longer matters.
const SETTLED: f64 = 1e-11;

/// Adjust `system` (its `u` and `group` are not used) with the components' covariance, estimating those that are not known.
///
/// Every row must be in an independent component, so that V can be inverted. Errors: those of [`adjust`].
pub fn adjust_components(
    system: &System,
    components: &[Component],
    elimination: Option<&Elimination>,
    settings: &Settings,
) -> Result<Components> {
    let m = system.observed.len();
    let start = start(system, components, elimination, settings)?;
    let mut variance: Vec<f64> = components.iter().map(|c| c.known.unwrap_or(start)).collect();
    let estimated: Vec<usize> = (0..components.len()).filter(|k| components[*k].known.is_none()).collect();
    let blocks = blocks(m, components);
    let (mut iterations, mut converged) = (0, estimated.is_empty());
    loop {
        let whitening = Whitening::new(&blocks, components, &variance);
        let whitened = whitening.system(system);
        let estimate = solve(&whitened, elimination, settings)?;
        let normal = Normal::new(&whitening, components, &estimate);
        if converged || iterations == STEPS {
            let spread = normal.spread(&estimated);
            let correction = normal.correction(&estimate, &spread);
            let mut sensitivities = estimate.factor.sensitivities();
            whitening.transform_columns(&mut sensitivities);
            return Ok(Components {
                variance,
                spread,
                correction,
                estimate,
                sensitivities,
                indicators: whitening.indicators(),
                iterations,
                converged,
            });
        }
        // the first steps stay positive; then Fisher's, shortened until V is positive definite
        let mut next = normal.safe_step(&estimated, &variance);
        if iterations >= SAFE_STEPS {
            let full = normal.step(&estimated, &variance);
            let mut share = 1.0;
            while share > 1e-3 {
                let trial: Vec<f64> = variance.iter().zip(&full).map(|(v, f)| v + share * (f - v)).collect();
                let independent = |k: &usize| !components[*k].offset.is_empty() || trial[*k] > 1e-3 * variance[*k];
                if estimated.iter().all(independent) && Whitening::new(&blocks, components, &trial).is_definite() {
                    next = trial;
                    break;
                }
                share *= 0.5;
            }
        }
        let size = next.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        converged = next.iter().zip(&variance).all(|(a, b)| (a - b).abs() <= SETTLED * (size * 1e-3 + b.abs()));
        variance = next;
        iterations += 1;
    }
}

fn solve(whitened: &System, elimination: Option<&Elimination>, settings: &Settings) -> Result<Estimate> {
    match elimination {
        Some(elimination) => adjust_on(whitened, elimination, settings),
        None => adjust(whitened, settings),
    }
}

/// A variance to begin with: that of the ordinary residuals.
fn start(
    system: &System,
    components: &[Component],
    elimination: Option<&Elimination>,
    settings: &Settings,
) -> Result<f64> {
    if components.iter().all(|c| c.known.is_some()) {
        return Ok(1.0);
    }
    let mut plain = System { group: vec![Group::Estimated(0); system.observed.len()], ..system.clone() };
    for component in components.iter().filter(|c| c.offset.is_empty()) {
        for (row, u) in &component.rows {
            plain.u[*row] = *u * component.known.unwrap_or(1.0).sqrt();
        }
    }
    let sd = solve(&plain, elimination, settings)?.residual_sd().unwrap_or(1.0);
    Ok(if sd > 0.0 { 0.5 * sd * sd } else { 1.0 })
}

/// Rows that are correlated with each other, directly or through others.
fn blocks(m: usize, components: &[Component]) -> Vec<Vec<usize>> {
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
struct Whitening<'a> {
    blocks: &'a [Vec<usize>],
    /// Lower triangles, each as a dense matrix.
    lower: Vec<Mat<f64>>,
    /// Block and place in it of each row.
    place: Vec<(usize, usize)>,
}

impl<'a> Whitening<'a> {
    fn new(blocks: &'a [Vec<usize>], components: &[Component], variance: &[f64]) -> Self {
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
    fn is_definite(&self) -> bool {
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

    fn system(&self, system: &System) -> System {
        let (m, n) = system.shape();
        let mut rows = Mat::zeros(m, n);
        for j in 0..n {
            rows.col_as_slice_mut(j).copy_from_slice(&self.apply(system.rows.col_as_slice(j)));
        }
        System { rows, observed: self.apply(&system.observed), u: vec![1.0; m], group: vec![Group::Known; m] }
    }

    /// The columns of `L^-1`, without zeros.
    fn indicators(&self) -> Vec<Vec<(usize, f64)>> {
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
    fn transform_columns(&self, sensitivities: &mut Mat<f64>) {
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
    fn whiten(&self, component: &Component) -> Vec<Mat<f64>> {
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

/// Helmert's normal equations at the present components.
struct Normal {
    /// `tr(P V_g P V_h)`.
    s: Mat<f64>,
    /// `y' P V_g P y`.
    q: Vec<f64>,
    /// `tr(P V_g)`.
    trace: Vec<f64>,
    /// `V~_h Q`, `m x rank`.
    seen: Vec<Mat<f64>>,
    /// `Q' V~_h Q`.
    inner: Vec<Mat<f64>>,
}

impl Normal {
    fn new(whitening: &Whitening<'_>, components: &[Component], estimate: &Estimate) -> Self {
        let q = estimate.factor.thin_q();
        let (m, rank) = (q.nrows(), q.ncols());
        let parts: Vec<Vec<Mat<f64>>> = components.iter().map(|c| whitening.whiten(c)).collect();
        let times = |parts: &[Mat<f64>], column: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut out = vec![0.0; m];
            for (block, part) in whitening.blocks.iter().zip(parts) {
                for (i, row) in block.iter().enumerate() {
                    out[*row] = block.iter().enumerate().map(|(j, other)| part[(i, j)] * column(*other)).sum();
                }
            }
            out
        };
        let mut seen = Vec::with_capacity(parts.len());
        let mut squares = Vec::with_capacity(parts.len());
        for parts in &parts {
            let mut all = Mat::zeros(m, rank);
            for k in 0..rank {
                all.col_as_slice_mut(k).copy_from_slice(&times(parts, &|i| q[(i, k)]));
            }
            seen.push(all);
            let moved = times(parts, &|i| estimate.residuals[i]);
            squares.push(moved.iter().zip(&estimate.residuals).map(|(a, b)| a * b).sum());
        }
        let inner: Vec<Mat<f64>> = seen.iter().map(|seen| q.transpose() * seen).collect();
        let dot = |a: &Mat<f64>, b: &Mat<f64>| -> f64 {
            (0..a.ncols()).flat_map(|k| a.col_as_slice(k).iter().zip(b.col_as_slice(k))).map(|(a, b)| a * b).sum()
        };
        let s = Mat::from_fn(parts.len(), parts.len(), |g, h| {
            let whole: f64 = parts[g].iter().zip(&parts[h]).map(|(a, b)| dot(a, b)).sum();
            whole - 2.0 * dot(&seen[g], &seen[h]) + dot(&inner[g], &inner[h])
        });
        let diagonal = |a: &Mat<f64>| -> f64 { (0..a.nrows()).map(|i| a[(i, i)]).sum() };
        let trace = parts
            .iter()
            .zip(&inner)
            .map(|(parts, inner)| parts.iter().map(diagonal).sum::<f64>() - diagonal(inner))
            .collect();
        Normal { s, q: squares, trace, seen, inner }
    }

    /// Fisher's step, `S theta = q` over the variances to estimate.
    fn step(&self, estimated: &[usize], now: &[f64]) -> Vec<f64> {
        let s = Mat::from_fn(estimated.len(), estimated.len(), |a, b| self.s[(estimated[a], estimated[b])]);
        let fixed = |g: usize| -> f64 {
            (0..now.len()).filter(|h| !estimated.contains(h)).map(|h| self.s[(g, h)] * now[h]).sum()
        };
        let q = Mat::from_fn(estimated.len(), 1, |a, _| self.q[estimated[a]] - fixed(estimated[a]));
        let found = s.col_piv_qr().solve(&q);
        let mut next = now.to_vec();
        for (a, k) in estimated.iter().enumerate() {
            next[*k] = found[(a, 0)];
        }
        next
    }

    /// A step that keeps every variance positive and never lowers the likelihood: `theta *= sqrt(y'P V_h P y / tr P V_h)`
    /// (H. Zhou, L. Hu, J. Zhou, K. Lange, "MM algorithms for variance components models", J. Comp. Graph. Stat. 28 (2019)).
    fn safe_step(&self, estimated: &[usize], now: &[f64]) -> Vec<f64> {
        let mut next = now.to_vec();
        for k in estimated {
            let ratio = self.q[*k] / self.trace[*k];
            if ratio > 0.0 && ratio.is_finite() {
                next[*k] *= ratio.sqrt();
            }
        }
        next
    }

    /// Covariance of the estimated variances, `2 S^-1`.
    fn spread(&self, estimated: &[usize]) -> Mat<f64> {
        let count = self.q.len();
        let mut spread = Mat::zeros(count, count);
        if estimated.is_empty() {
            return spread;
        }
        let s = Mat::from_fn(estimated.len(), estimated.len(), |a, b| self.s[(estimated[a], estimated[b])]);
        let inverse = s.col_piv_qr().solve(Mat::<f64>::identity(estimated.len(), estimated.len()));
        for (a, g) in estimated.iter().enumerate() {
            for (b, h) in estimated.iter().enumerate() {
                spread[(*g, *h)] = 2.0 * inverse[(a, b)];
            }
        }
        spread
    }

    /// Kenward and Roger's correction `2 T {sum W_ij (W_i'W_j - A_i A_j)} T'`.
    fn correction(&self, estimate: &Estimate, spread: &Mat<f64>) -> Mat<f64> {
        let rank = estimate.factor.rank();
        let mut middle = Mat::<f64>::zeros(rank, rank);
        for i in 0..self.q.len() {
            for j in 0..self.q.len() {
                if spread[(i, j)] == 0.0 || !spread[(i, j)].is_finite() {
                    continue;
                }
                let part = self.seen[i].transpose() * &self.seen[j] - &self.inner[i] * &self.inner[j];
                middle += part * faer::Scale(2.0 * spread[(i, j)]);
            }
        }
        let directions = estimate.factor.whitened_directions();
        &directions * middle * directions.transpose()
    }
}
