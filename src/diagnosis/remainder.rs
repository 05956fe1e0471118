//! What no effect explains, as a component of variance: an effect must win against it with the few degrees of freedom that it has.
//!
//! ```text
//! V = s^2 (I + t Z Z'),   Z_ig = w_i / rms(w) for the rows i of group g           t = (sd of the remainder / sd of the noise)^2
//! deviance(t) = ln|V| + ln|X'V^-1 X| + r'V^-1 r - r'V^-1 X (X'V^-1 X)^-1 X'V^-1 r    REML: Patterson, Thompson, Biometrika 58 (1971)
//! V^-1 = (I - sum_g k_g z_g z_g') / s^2,    k_g = t / (1 + t |z_g|^2)
//! ```
//!
//! Rows that share a group share one deviation: repeats of a setting do not make it look small. Which grouping it follows (a setting of all
//! joints, of one, a position, a stretch of time, or each reading by itself) is decided by the deviance; its size is estimated from what is
//! left with the effect in the model. `X` is orthonormal and `r` orthogonal to it, so that only sums over groups are needed.

use super::noise::{NoiseFrom, Weighted};
use crate::campaign::{Campaign, JointState};
use crate::design::DesignMatrix;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use std::collections::HashMap;

/// Stretches of so many consecutive readings may share what time does to them.
const STRETCHES: [usize; 3] = [3, 6, 12];
/// Fewest groups that can be a component of variance.
const FEWEST_GROUPS: usize = 4;
/// Ratio of successive sizes `t` that are tried.
const GRID: f64 = 2.0;
/// Most groups that are made orthogonal where rows are not independent.
const MOST_TURNED: usize = 250;
/// Smallest `t |z_g|^2` that is tried besides zero.
const SMALLEST: f64 = 0.1;

/// A grouping of the rows.
#[derive(Debug, Clone)]
pub(super) struct Grouping {
    /// What the groups share, in words.
    pub name: String,
    group: Vec<Option<usize>>,
    z: Vec<f64>,
    /// `|z_g|^2` of each group.
    size: Vec<f64>,
    /// `Z'Q`, groups x rank.
    basis: Mat<f64>,
    /// Where rows are not independent: orthogonal combinations of the groups' whitened columns, `m x groups`, in the place of `Z`.
    turned: Option<Mat<f64>>,
}

/// The remainder of one model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Remainder {
    /// Index of its grouping; `None` where each reading has its own, or there is none.
    pub grouping: Option<usize>,
    /// Its variance over that of the noise, `t`.
    pub ratio: f64,
    /// Variance of unit weight: 1 where the noise is stated.
    pub variance: f64,
    /// `-2 ln` of the restricted likelihood, but for a constant.
    pub deviance: f64,
    /// Degrees of freedom from which its size was estimated.
    pub dof: f64,
}

/// The evidence for one direction against noise and remainder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Standing {
    pub t: f64,
    pub dof: f64,
    pub remainder: Remainder,
}

/// Everything against which remainders are estimated.
#[derive(Debug, Clone)]
pub(super) struct Remainders {
    groupings: Vec<Grouping>,
    basis: Mat<f64>,
    known: bool,
    rows: usize,
    rank: usize,
}

impl Remainders {
    /// The groupings of a campaign's rows; `rows` counts those of priors too.
    pub fn new(campaign: &Campaign, design: &DesignMatrix, weighted: &Weighted) -> Self {
        let rows = weighted.weight.len();
        let q = weighted.estimate.factor.thin_q().to_owned();
        let mut remainders = Remainders {
            groupings: Vec::new(),
            known: weighted.from == NoiseFrom::Stated,
            rows,
            rank: q.ncols(),
            basis: q,
        };
        let z = relative_weights(campaign, design, &weighted.own_weight);
        for (name, in_time, group) in groupings(campaign, design) {
            remainders.add(name, in_time, group, (&z, weighted));
        }
        remainders
    }

    fn add(&mut self, name: String, in_time: bool, labels: Vec<Option<usize>>, (z, weighted): (&[f64], &Weighted)) {
        let count = labels.iter().flatten().max().map_or(0, |g| g + 1);
        let grouped = labels.iter().flatten().count();
        if count < FEWEST_GROUPS || (count == grouped && in_time) || (count == grouped && !self.known) {
            return;
        }
        let mut group = labels;
        group.resize(self.rows, None);
        if self.groupings.iter().any(|own| same(&own.group, &group)) {
            return;
        }
        let mut z = z.to_vec();
        z.resize(self.rows, 0.0);
        if weighted.floor.is_some() {
            let shared: Vec<f64> = z.iter().zip(&weighted.own_weight).map(|(z, w)| z / w).collect();
            if count <= MOST_TURNED
                && let Some((turned, size)) = turned(weighted, &group, &shared, count)
            {
                let basis = turned.transpose() * &self.basis;
                self.groupings.push(Grouping { name, group, z, size, basis, turned: Some(turned) });
            }
            return;
        }
        self.push(name, group, z);
    }

    /// A grouping of independent rows.
    fn push(&mut self, name: String, group: Vec<Option<usize>>, z: Vec<f64>) {
        let count = group.iter().flatten().max().map_or(0, |g| g + 1);
        let mut size = vec![0.0; count];
        let mut basis = Mat::zeros(count, self.rank);
        for (i, (g, z)) in group.iter().zip(&z).enumerate() {
            let Some(g) = g else { continue };
            if let Some(size) = size.get_mut(*g) {
                *size += z * z;
            }
            for k in 0..self.rank {
                basis[(*g, k)] += z * self.basis[(i, k)];
            }
        }
        self.groupings.push(Grouping { name, group, z, size, basis, turned: None });
    }

    /// The grouping of a remainder.
    pub fn grouping(&self, remainder: &Remainder) -> Option<&Grouping> {
        self.groupings.get(remainder.grouping?)
    }

    /// The remainder that is left with these orthonormal directions in the model; `residual` is orthogonal to all of them.
    pub fn left(&self, directions: &[Vec<f64>], residual: &[f64], rss: f64) -> Remainder {
        let mut best = self.by_reading(directions.len(), rss);
        for index in 0..self.groupings.len() {
            if let Some(own) = self.fit(index, directions, residual, rss).filter(|own| own.deviance < best.deviance) {
                best = own;
            }
        }
        best
    }

    /// Evidence for the last of the directions, whose score is `score`, against what is left.
    pub fn evidence(&self, remainder: Remainder, directions: &[Vec<f64>], residual: &[f64], score: f64) -> Standing {
        let sd = remainder.variance.sqrt();
        let alone = if self.known && remainder.variance <= 1.0 { f64::INFINITY } else { remainder.dof };
        let plain = Standing { t: score / sd, dof: alone, remainder };
        let (Some(grouping), Some(last)) = (self.grouping(&remainder), directions.last()) else { return plain };
        if remainder.ratio <= 0.0 {
            return plain;
        }
        let p = self.rank + directions.len();
        let sums = grouping.sums(directions, residual);
        let Some(System { factor, right, .. }) = grouping.system(&sums, remainder.ratio, p) else { return plain };
        let mut unit = Mat::zeros(p, 1);
        unit[(p - 1, 0)] = 1.0;
        let solved = factor.solve(&unit);
        let solution = factor.solve(&right);
        let cofactor = solved[(p - 1, 0)];
        if !(cofactor > 0.0) {
            return plain;
        }
        let t = (score + solution[(p - 1, 0)]) / (cofactor * remainder.variance).sqrt();
        // share of its information that rests on differences between groups
        let along = grouping.sum(last);
        let (mut between, mut lost) = (0.0, 0.0);
        for (a, size) in along.iter().zip(&grouping.size).filter(|(_, size)| **size > 0.0) {
            between += a * a / size / (1.0 + remainder.ratio * size);
            lost += a * a / size;
        }
        let share = (between / (1.0 - lost + between).max(1e-12)).clamp(0.0, 1.0);
        let noise = if self.known { f64::INFINITY } else { (self.rows - p) as f64 - remainder.dof };
        let inverse = share * share / remainder.dof + (1.0 - share) * (1.0 - share) / noise.max(1.0);
        Standing { t, dof: 1.0 / inverse, remainder }
    }

    /// Noise larger than stated, each reading by itself; or the noise itself where nothing states it.
    fn by_reading(&self, directions: usize, rss: f64) -> Remainder {
        let dof = self.rows.saturating_sub(self.rank + directions).max(1) as f64;
        let variance = rss / dof;
        let variance = if self.known { variance.max(1.0) } else { variance.max(f64::MIN_POSITIVE) };
        let deviance = dof * variance.ln() + rss / variance;
        Remainder { grouping: None, ratio: 0.0, variance, deviance, dof }
    }

    fn fit(&self, index: usize, directions: &[Vec<f64>], residual: &[f64], rss: f64) -> Option<Remainder> {
        let grouping = self.groupings.get(index)?;
        let p = self.rank + directions.len();
        let free = self.rows.checked_sub(p).filter(|free| *free > 0)? as f64;
        let sums = grouping.sums(directions, residual);
        let mean = grouping.size.iter().sum::<f64>() / grouping.size.len() as f64;
        let inside: f64 = sums.basis.squared_norm_l2();
        let dof = (grouping.size.len() as f64 - inside / mean).max(1.0);
        // beyond this size the rest would be larger than all that is left
        let most = 8.0 * (rss / free).max(1.0) * mean.max(1.0) * if self.known { 1.0 } else { free };
        let mut best: Option<Remainder> = None;
        let mut ratio = SMALLEST / mean;
        let mut misses = 0;
        while ratio * mean <= most.max(1.0) && misses < 6 {
            let own = grouping.system(&sums, ratio, p).map(|system| {
                let squares = (rss - system.lost).max(f64::MIN_POSITIVE);
                let variance = if self.known { 1.0 } else { squares / free };
                let deviance = free * variance.ln() + squares / variance + system.determinant;
                Remainder { grouping: Some(index), ratio, variance, deviance, dof }
            });
            match own.filter(|own| best.is_none_or(|before| own.deviance < before.deviance)) {
                Some(own) => (best, misses) = (Some(own), 0),
                None => misses += 1,
            }
            ratio *= GRID;
        }
        best
    }
}

/// Sums over groups: of the basis and the directions, and of the residual.
struct Sums {
    basis: Mat<f64>,
    residual: Vec<f64>,
}

/// `X'V^-1 X` factored, `X'V^-1 r`, and what the groups take off the sum of squares, for unit variance.
struct System {
    factor: Llt<f64>,
    right: Mat<f64>,
    lost: f64,
    determinant: f64,
}

impl Grouping {
    fn sum(&self, column: &[f64]) -> Vec<f64> {
        if let Some(turned) = &self.turned {
            let own = |k: usize| turned.col_as_slice(k).iter().zip(column).map(|(z, c)| z * c).sum();
            return (0..turned.ncols()).map(own).collect();
        }
        let mut sums = vec![0.0; self.size.len()];
        for ((g, z), c) in self.group.iter().zip(&self.z).zip(column) {
            if let Some(slot) = g.and_then(|g| sums.get_mut(g)) {
                *slot += z * c;
            }
        }
        sums
    }

    fn sums(&self, directions: &[Vec<f64>], residual: &[f64]) -> Sums {
        let rank = self.basis.ncols();
        let mut basis = Mat::zeros(self.size.len(), rank + directions.len());
        basis.as_mut().subcols_mut(0, rank).copy_from(&self.basis);
        for (k, direction) in directions.iter().enumerate() {
            basis.col_as_slice_mut(rank + k).copy_from_slice(&self.sum(direction));
        }
        Sums { basis, residual: self.sum(residual) }
    }

    fn system(&self, sums: &Sums, ratio: f64, p: usize) -> Option<System> {
        let shrink: Vec<f64> = self.size.iter().map(|size| ratio / (1.0 + ratio * size)).collect();
        let mut normal = Mat::<f64>::identity(p, p);
        let mut right = Mat::zeros(p, 1);
        for a in 0..p {
            let column = sums.basis.col_as_slice(a);
            let scaled: Vec<f64> = column.iter().zip(&shrink).map(|(v, k)| v * k).collect();
            for b in a..p {
                let product: f64 = scaled.iter().zip(sums.basis.col_as_slice(b)).map(|(x, y)| x * y).sum();
                normal[(b, a)] -= product;
            }
            right[(a, 0)] = -scaled.iter().zip(&sums.residual).map(|(x, y)| x * y).sum::<f64>();
        }
        let factor = Llt::new(normal.as_ref(), Side::Lower).ok()?;
        let solution = factor.solve(&right);
        let explained: f64 = solution.col_as_slice(0).iter().zip(right.col_as_slice(0)).map(|(x, y)| x * y).sum();
        let shared: f64 = sums.residual.iter().zip(&shrink).map(|(s, k)| s * s * k).sum();
        let of_model: f64 = (0..p).map(|k| factor.L()[(k, k)].abs().ln()).sum::<f64>() * 2.0;
        let of_groups: f64 = self.size.iter().map(|size| (1.0 + ratio * size).ln()).sum();
        Some(System { factor, right, lost: shared + explained, determinant: of_model + of_groups })
    }
}

/// The groups' columns as independent values, and turned so that they are orthogonal; with their squared norms.
fn turned(weighted: &Weighted, group: &[Option<usize>], z: &[f64], count: usize) -> Option<(Mat<f64>, Vec<f64>)> {
    let mut columns = Mat::zeros(weighted.weight.len(), count);
    for (i, (g, z)) in group.iter().zip(z).enumerate() {
        if let Some(g) = g {
            columns[(i, *g)] = *z;
        }
    }
    for g in 0..count {
        let white = weighted.whiten(columns.col_as_slice(g));
        columns.col_as_slice_mut(g).copy_from_slice(&white);
    }
    let gram = columns.transpose() * &columns;
    let eigen = gram.self_adjoint_eigen(Side::Lower).ok()?;
    let mut turned = &columns * eigen.U();
    let mut size: Vec<f64> = (0..count).map(|g| eigen.S()[g].max(0.0)).collect();
    let largest = size.iter().fold(0.0_f64, |a, b| a.max(*b));
    for (g, own) in size.iter_mut().enumerate().filter(|(_, own)| **own < 1e-10 * largest) {
        *own = 0.0;
        turned.col_as_slice_mut(g).fill(0.0);
    }
    Some((turned, size))
}

/// Weights over their root mean square for each sensor; zero for rows of priors.
fn relative_weights(campaign: &Campaign, design: &DesignMatrix, weight: &[f64]) -> Vec<f64> {
    let mut squares = vec![(0.0_f64, 0.0_f64); campaign.bench.sensors.len()];
    for (origin, w) in design.rows.iter().zip(weight) {
        if let Some((sum, count)) = squares.get_mut(origin.sensor) {
            *sum += w * w;
            *count += 1.0;
        }
    }
    let rms = |sensor: usize| squares.get(sensor).map_or(1.0, |(sum, count)| (sum / count).sqrt());
    design.rows.iter().zip(weight).map(|(origin, w)| w / rms(origin.sensor)).collect()
}

/// Two groupings that part the rows alike.
fn same(a: &[Option<usize>], b: &[Option<usize>]) -> bool {
    let mut forth: HashMap<usize, usize> = HashMap::new();
    let mut back: HashMap<usize, usize> = HashMap::new();
    a.iter().zip(b).all(|pair| match pair {
        (None, None) => true,
        (Some(x), Some(y)) => *forth.entry(*x).or_insert(*y) == *y && *back.entry(*y).or_insert(*x) == *x,
        _ => false,
    })
}

/// Every way in which the rows of this campaign can share a deviation: name, whether it follows time, group of each row.
fn groupings(campaign: &Campaign, design: &DesignMatrix) -> Vec<(String, bool, Vec<Option<usize>>)> {
    let bits = |state: &JointState| {
        let (deg, deg_s, turns) = state.keys();
        [deg, deg_s, turns].map(|v| v.map_or(u64::MAX, |v| (v + 0.0).to_bits()))
    };
    // rows are of readings of this campaign
    let joints = |reading: usize| campaign.readings.rows.get(reading).map(|r| r.joints.as_slice()).unwrap_or_default();
    let mut all = Vec::new();
    let mut by = |name: String, key: &dyn Fn(usize) -> Vec<[u64; 3]>| {
        let mut seen: HashMap<(usize, Vec<[u64; 3]>), usize> = HashMap::new();
        let label = |origin: &crate::design::RowOrigin| {
            let next = seen.len();
            Some(*seen.entry((origin.sensor, key(origin.reading))).or_insert(next))
        };
        let labels: Vec<Option<usize>> = design.rows.iter().map(label).collect();
        all.push((name, false, labels));
    };
    by("the setting".into(), &|k| joints(k).iter().map(bits).collect());
    let held = |state: &JointState| matches!(state, JointState::Held { .. });
    by("the angles".into(), &|k| joints(k).iter().filter(|s| held(s)).map(bits).collect());
    if campaign.bench.joints().count() > 1 {
        for (place, joint) in campaign.bench.joints().enumerate() {
            by(joint.to_string(), &|k| joints(k).get(place).map(bits).into_iter().collect());
        }
    }
    let mut positions: HashMap<&str, usize> = HashMap::new();
    for reading in &campaign.readings.rows {
        let next = positions.len();
        positions.entry(&reading.position).or_insert(next);
    }
    by("the position".into(), &|k| {
        let label = campaign.readings.rows.get(k).map_or("", |r| r.position.as_str());
        vec![[positions.get(label).map_or(0, |p| *p as u64); 3]]
    });
    for length in STRETCHES {
        let mut labels = vec![None; design.rows.len()];
        let mut next = 0;
        for sensor in 0..campaign.bench.sensors.len() {
            for stretch in in_time(campaign, design, sensor).chunks(length) {
                for row in stretch {
                    if let Some(label) = labels.get_mut(*row) {
                        *label = Some(next);
                    }
                }
                next += 1;
            }
        }
        all.push((format!("stretches of {length} readings"), true, labels));
    }
    all
}

/// The rows of one sensor in the order of time, or of the file where there is no time.
pub(super) fn in_time(campaign: &Campaign, design: &DesignMatrix, sensor: usize) -> Vec<usize> {
    let column = campaign.readings.columns.iter().position(|c| c == "time_s");
    let time = |row: &usize| {
        let reading = design.rows.get(*row).and_then(|o| campaign.readings.rows.get(o.reading))?;
        reading.columns.get(column?).copied().flatten()
    };
    let own = design.rows.iter().enumerate().filter(|(_, origin)| origin.sensor == sensor);
    let mut rows: Vec<usize> = own.map(|(i, _)| i).collect();
    if rows.iter().all(|row| time(row).is_some()) {
        // all have a time, see above
        rows.sort_by(|a, b| time(a).unwrap_or(0.0).total_cmp(&time(b).unwrap_or(0.0)));
    }
    rows
}
