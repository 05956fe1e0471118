//! Single wrong values: far from what a state predicts and from their neighbours in time.

use super::case::Case;
use super::measured::CHANNELS;
use super::refine::{Search, State};
use crate::diagnosis::NoiseFrom;
use crate::number;
use crate::uncertainty::quantiles::{normal_quantile, student_t_quantile};

/// Bends from which the noise is estimated: the relative standard deviation of a variance from n of them is `sqrt(35 / (9 n))`, a half, and that of the noise a
/// quarter.
const FEWEST: f64 = 16.0;

/// A value of a series in time.
#[derive(Clone, Copy)]
struct Point {
    place: usize,
    run: usize,
    time: f64,
    value: f64,
    /// A jump before it, or a kink at it, is taken for part of the course.
    jump: bool,
    kink: bool,
}

/// The deviation of the middle one of three values from the line between its neighbours, in units in which that of white noise has its standard deviation.
fn bend(three: &[Point]) -> Option<f64> {
    let [a, b, c] = three else { return None };
    let share = (b.time - a.time) / (c.time - a.time);
    let off = b.value - (1.0 - share) * a.value - share * c.value;
    let one = a.run == b.run && b.run == c.run && c.time > a.time && !b.jump && !c.jump && !b.kink;
    one.then(|| off / (1.0 + share * share + (1.0 - share) * (1.0 - share)).sqrt())
}

/// Sum of the squares of all bends, and how many there are.
fn bends(points: &[Point]) -> (f64, f64) {
    points.windows(3).filter_map(bend).fold((0.0, 0.0), |(sum, count), b| (sum + b * b, count + 1.0))
}

impl Case<'_> {
    /// Single wrong values at most: more of them may be the course of a channel, which has one value in a row.
    fn most_singles(&self) -> usize {
        let rows: usize = self.measured.runs.iter().map(|run| run.rows.len()).sum();
        number::count(self.settings.singles * rows as f64).max(1)
    }

    /// Standard deviation of the noise of each channel, and single wrong values, from residuals together: neither is known without the other.
    ///
    /// The mean square of the residuals, corrected for the degrees of freedom of a fit, is the variance of the noise, or that of their bends, the differences from the line between their neighbours in time, where
    /// it is less, as a slow course is no noise (J. von Neumann, Ann. Math. Stat. 12 (1941), 367, with second differences). The variance from `n` bends has
    /// the relative variance 35/(9n), thus as one of 18n/35 degrees of freedom; so a bend is Student's with these in units of all others. The farthest
    /// is a wrong value, a jump, or a kink of the course, which one explains all bends best: `-n/2 ln S - k/2 ln n`, where it frees `k` bends.
    pub(super) fn noise(&self, residual: &[f64], fitted: usize) -> ([f64; CHANNELS], Vec<usize>) {
        let mut series: [Vec<Point>; CHANNELS] = Default::default();
        for (place, (cell, value)) in self.measured.cells().zip(residual).enumerate() {
            let point = Point { place, run: cell.run, time: cell.time, value: *value, jump: false, kink: false };
            series.get_mut(cell.channel).into_iter().for_each(|points| points.push(point));
        }
        let level = self.settings.single_share * self.settings.common.significance / residual.len().max(1) as f64;
        let kept = 1.0 - (fitted as f64 / residual.len().max(1) as f64).min(0.9);
        // of innovations in units of stated noise
        let least = if self.from == NoiseFrom::Stated { 1.0 } else { 0.0 };
        let mut singles = Vec::new();
        let sizes = series.map(|mut points| {
            let all = points.clone();
            let mut out = Vec::new();
            // more of them are a course
            for found in 0..=self.most_singles() {
                let Some((changed, single)) = without_farthest(&points, level, least) else { break };
                if found == self.most_singles() {
                    (points, out) = (all, Vec::new());
                    break;
                }
                points = changed;
                out.extend(single);
            }
            let whole = points.iter().map(|p| p.value * p.value).sum::<f64>() / (kept * points.len().max(1) as f64);
            let (sum, count) = bends(&points);
            singles.append(&mut out);
            let square = if count < FEWEST { whole } else { whole.min(sum / count) };
            if square > 0.0 { square.sqrt() } else { 1.0 }
        });
        singles.sort_unstable();
        (sizes, singles)
    }
}

/// A series without the feature that makes its farthest bend, and the place of the value if it is a single one; `None` where noise, which is no less than known,
/// makes such bends.
fn without_farthest(points: &[Point], level: f64, least: f64) -> Option<(Vec<Point>, Option<usize>)> {
    let (sum, count) = bends(points);
    let all = points.windows(3).enumerate().filter_map(|(k, three)| Some((k + 1, bend(three)?)));
    let (middle, far) = all.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let omitting = |k: usize| {
        let point = points.get(k)?;
        let rest = points.iter().filter(|other| other.place != point.place);
        Some((rest.copied().collect::<Vec<Point>>(), Some(point.place)))
    };
    let marked = |k: usize, mark: &dyn Fn(&mut Point)| {
        let mut course = points.to_vec();
        mark(course.get_mut(k)?);
        Some((course, None))
    };
    let jump = |point: &mut Point| point.jump = true;
    let features = [
        omitting(middle),
        omitting(middle - 1),
        omitting(middle + 1),
        marked(middle, &|point| point.kink = true),
        marked(middle, &jump),
        marked(middle + 1, &jump),
    ];
    let cost = |(sum, left): (f64, f64)| count * sum.max(f64::MIN_POSITIVE).ln() + (count - left) * count.ln();
    let weighed = features.into_iter().flatten().map(|feature| (bends(&feature.0), feature));
    let (left, feature) = weighed.min_by(|a, b| cost(a.0).total_cmp(&cost(b.0)))?;
    let dof = left.1 * 18.0 / 35.0;
    let farthest = -student_t_quantile(0.5 * level, dof)?;
    let is_far = left.1 >= FEWEST && sum > left.0 && far.abs() > farthest * (left.0 / left.1).sqrt().max(least);
    is_far.then_some(feature)
}

impl Search<'_> {
    /// Single values far from what the state predicts and from their neighbours in time; none where they are more than a few.
    ///
    /// Where noise alone remains, a value is compared with its standard uncertainty; else it has to stand out.
    pub(super) fn single(&self, state: &State) -> Vec<usize> {
        let settings = &self.case.settings;
        if self.case.from == NoiseFrom::Stated {
            let white = self.case.whitened(self.case.residual(&state.flown.predicted), self.u, &[]);
            let level = settings.single_share * settings.common.significance / white.len().max(1) as f64;
            // a level of zero asks for more than any number; a tail below rounding of one is a probability of its own
            let far = normal_quantile(0.5 * level).map_or(f64::INFINITY, |z| -z);
            let beyond: Vec<usize> = white.iter().enumerate().filter(|(_, v)| v.abs() > far).map(|(i, _)| i).collect();
            if beyond.len() <= self.case.most_singles() {
                return beyond;
            }
        }
        self.standing_out(state)
    }

    /// Single values that stand out from their neighbours in time, whatever else is unexplained; none where they are more than a few.
    pub(super) fn standing_out(&self, state: &State) -> Vec<usize> {
        let mut residual = self.case.residual(&state.flown.predicted);
        if self.case.from == NoiseFrom::Stated {
            residual = self.case.whitened(residual, self.u, &[]);
        }
        self.case.noise(&residual, state.set.len()).1
    }
}
