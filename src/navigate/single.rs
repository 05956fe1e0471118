//! Single wrong values: far from what a state predicts and from their neighbours in time.

use super::measured::CHANNELS;
use super::refine::{State, Walk};
use crate::diagnosis::NoiseFrom;
use crate::elements::Elements;
use crate::number;
use crate::uncertainty::quantiles::normal_quantile;

impl Walk<'_> {
    /// Single values far from what the state predicts and from their neighbours in time; none where they are more than a few.
    ///
    /// While something is still missing a value is compared with the values of its channel before and after it, in units of how they usually
    /// differ; where noise alone is left, with its own standard uncertainty.
    pub(super) fn single(&self, state: &State) -> Vec<usize> {
        if self.case.from != NoiseFrom::Stated {
            return Vec::new();
        }
        let settings = &self.case.settings;
        let mut white = [self.case.left(&state.flown.predicted)];
        self.case.weigh(self.u, &[], &mut white);
        let [white] = white;
        let rows: usize = self.case.measured.runs.iter().map(|run| run.rows.len()).sum();
        let most = number::count(settings.singles * rows as f64).max(1);
        let level = settings.single_share * settings.common.significance / white.len().max(1) as f64;
        // a level of zero asks for more than any number
        let far = normal_quantile(1.0 - 0.5 * level).unwrap_or(6.0);
        let beyond: Vec<usize> = white.iter().enumerate().filter(|(_, v)| v.abs() > far).map(|(i, _)| i).collect();
        if beyond.len() <= most {
            return beyond;
        }
        let mut found: Vec<(usize, f64)> = Vec::new();
        for (run, _) in self.case.measured.runs.iter().enumerate() {
            for channel in 0..CHANNELS {
                let cells = self.case.measured.cells().enumerate();
                let own: Vec<usize> =
                    cells.filter(|(_, c)| c.run == run && c.channel == channel).map(|(i, _)| i).collect();
                if own.len() < 8 {
                    continue;
                }
                // `own` has at least eight places of `white`
                let at = |k: usize| own.get(k).and_then(|i| white.get(*i)).copied().unwrap_or_default();
                let bend = |k: usize| match k {
                    0 => at(0) - 2.0 * at(1) + at(2),
                    k if k + 1 == own.len() => at(k) - 2.0 * at(k - 1) + at(k - 2),
                    k => at(k) - 0.5 * (at(k - 1) + at(k + 1)),
                };
                let bends: Vec<f64> = (0..own.len()).map(bend).collect();
                let mut sizes: Vec<f64> = bends.iter().map(|b| b.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                // 1.4826 median is the standard deviation of normal values; that of a bend of noise alone is 1.22
                let median = sizes.at(sizes.len() / 2);
                let scale = (1.4826 * median).max(1.5_f64.sqrt());
                for (k, (cell, bend)) in own.iter().zip(&bends).enumerate() {
                    let around = bends.iter().take(k + 2).skip(k.saturating_sub(1));
                    let largest = around.fold(0.0_f64, |most, b| most.max(b.abs()));
                    let edge = if k == 0 || k + 1 == own.len() { 2.0 } else { 1.0 };
                    if bend.abs() > settings.stands_out * scale * edge && bend.abs() >= largest {
                        found.push((*cell, bend.abs()));
                    }
                }
            }
        }
        if found.len() > most {
            return Vec::new();
        }
        let mut out: Vec<usize> = found.into_iter().map(|(i, _)| i).collect();
        out.sort_unstable();
        out
    }
}
