//! Single wrong values: far from what a state predicts and from their neighbours in time.

use super::measured::CHANNELS;
use super::refine::{Search, State};
use crate::diagnosis::NoiseFrom;
use crate::elements::Elements;
use crate::number;
use crate::uncertainty::quantiles::normal_quantile;

impl Search<'_> {
    /// Single values far from what the state predicts and from their neighbours in time; none where they are more than a few.
    ///
    /// While something is still missing a value is compared with the values of its channel before and after it, in units of how they usually
    /// differ; where noise alone remains, with its standard uncertainty.
    pub(super) fn single(&self, state: &State) -> Vec<usize> {
        if self.case.from != NoiseFrom::Stated {
            return Vec::new();
        }
        let settings = &self.case.settings;
        let white = self.case.whitened(self.case.residual(&state.flown.predicted), self.u, &[]);
        let most = self.most();
        let level = settings.single_share * settings.common.significance / white.len().max(1) as f64;
        // a level of zero asks for more than any number
        let far = normal_quantile(1.0 - 0.5 * level).unwrap_or(6.0);
        let beyond: Vec<usize> = white.iter().enumerate().filter(|(_, v)| v.abs() > far).map(|(i, _)| i).collect();
        if beyond.len() <= most {
            return beyond;
        }
        self.outstanding(&white, most, true)
    }

    /// Single values that stand out from their neighbours in time, whatever else is unexplained; none where they are more than a few.
    pub(super) fn standing_out(&self, state: &State) -> Vec<usize> {
        let white = self.case.whitened(self.case.residual(&state.flown.predicted), self.u, &[]);
        self.outstanding(&white, self.most(), false)
    }

    /// Single wrong values at most: more of them may be the course of a channel, which has one value in a row.
    fn most(&self) -> usize {
        let rows: usize = self.case.measured.runs.iter().map(|run| run.rows.len()).sum();
        number::count(self.case.settings.singles * rows as f64).max(1)
    }

    /// The same among weighted values; at most so many. The first and the last of a channel have neighbours on one side only: what is there may be a jump.
    fn outstanding(&self, white: &[f64], most: usize, ends: bool) -> Vec<usize> {
        let settings = &self.case.settings;
        let mut outliers: Vec<(usize, f64)> = Vec::new();
        for (run, _) in self.case.measured.runs.iter().enumerate() {
            for channel in 0..CHANNELS {
                let cells = self.case.measured.cells().enumerate();
                let places: Vec<usize> =
                    cells.filter(|(_, c)| c.run == run && c.channel == channel).map(|(i, _)| i).collect();
                if places.len() < 8 {
                    continue;
                }
                // `places` has at least eight places of `white`
                let at = |k: usize| places.get(k).and_then(|i| white.get(*i)).copied().unwrap_or_default();
                let bend = |k: usize| match k {
                    0 => at(0) - 2.0 * at(1) + at(2),
                    k if k + 1 == places.len() => at(k) - 2.0 * at(k - 1) + at(k - 2),
                    k => at(k) - 0.5 * (at(k - 1) + at(k + 1)),
                };
                let bends: Vec<f64> = (0..places.len()).map(bend).collect();
                let mut sizes: Vec<f64> = bends.iter().map(|b| b.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                // 1.4826 median is the standard deviation of normal values; that of a bend of noise alone is 1.22
                let median = sizes.at(sizes.len() / 2);
                let scale = (1.4826 * median).max(1.5_f64.sqrt());
                for (k, (cell, bend)) in places.iter().zip(&bends).enumerate() {
                    let around = bends.iter().take(k + 2).skip(k.saturating_sub(1));
                    let largest = around.fold(0.0_f64, |most, b| most.max(b.abs()));
                    // at a jump one neighbour bends as much the other way and the other hardly; at a single value both bend half as much
                    let [before, after] =
                        [k.checked_sub(1), Some(k + 1)].map(|j| j.and_then(|j| bends.get(j)).copied());
                    let is_jump = before.zip(after).is_some_and(|(before, after)| {
                        let [one, other] = [before / bend, after / bend];
                        (one < -0.75 && other.abs() < 0.3) || (other < -0.75 && one.abs() < 0.3)
                    });
                    let edge = if k == 0 || k + 1 == places.len() { 2.0 } else { 1.0 };
                    if bend.abs() > settings.stands_out * scale * edge
                        && bend.abs() >= largest
                        && !is_jump
                        && (ends || edge == 1.0)
                    {
                        outliers.push((*cell, bend.abs()));
                    }
                }
            }
        }
        if outliers.len() > most {
            return Vec::new();
        }
        let mut out: Vec<usize> = outliers.into_iter().map(|(i, _)| i).collect();
        out.sort_unstable();
        out
    }
}
