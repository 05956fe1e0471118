//! The same search among columns that belong to no campaign: rows that are whitened already, nothing in the model but the columns themselves, and
//! groupings of the rows that what is left may follow. Measured navigation errors ask it.

use super::criteria::{Question, without};
use super::evidence::Evidence;
use super::noise::NoiseFrom;
use super::posterior;
use super::remainder::{Felt, Remainders};
use super::settings::Settings;
use super::stepwise;
use faer::Mat;

/// Columns against a residual, and what each costs in plausibility.
pub(crate) struct Plain {
    evidence: Evidence,
    plausibility_penalty: Vec<f64>,
}

/// An effect that stands beside the others.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stands {
    /// Student's t against the noise and what is left.
    pub t: f64,
    /// Family-wise probability of a `t` as large by chance.
    pub p: f64,
    /// That the effect, or one that cannot be told from it, is present.
    pub probability: f64,
}

impl Plain {
    /// `columns` and `residual` are whitened by what is known of the rows, by the noise alone where that is stated (`from`); `tests` of the columns are
    /// distinct. A column of zeros is never an effect.
    pub fn new(
        columns: &[Vec<f64>],
        residual: Vec<f64>,
        tests: usize,
        from: NoiseFrom,
        groupings: Vec<Felt>,
        plausibility_penalty: Vec<f64>,
    ) -> Plain {
        let rows = residual.len();
        let matrix = Mat::from_fn(rows, columns.len(), |i, j| {
            columns.get(j).and_then(|column| column.get(i)).copied().unwrap_or_default() // a short column ends in zeros
        });
        let remainders = Remainders::plain(rows, from == NoiseFrom::Stated, groupings);
        Plain { evidence: Evidence::plain(matrix, residual, tests, from, remainders), plausibility_penalty }
    }

    fn question<'a>(&'a self, settings: &'a Settings) -> Question<'a> {
        // what is doubtful is a course of time that fits better: it stands in the way of what is plain
        Question {
            settings,
            plausibility_penalty: &self.plausibility_penalty,
            doubtful_yields: false,
            is_pattern: &|_| false,
        }
    }

    /// The effects that stand one after another, each beyond doubt against the noise and what is still unexplained; `is_pattern` says which sets can
    /// build any pattern. From `start`, where all of that stands: of five large effects none stands without the others.
    pub fn one_after_another(
        &self,
        start: &[usize],
        settings: &Settings,
        is_pattern: &dyn Fn(&[usize]) -> bool,
    ) -> Vec<usize> {
        let question = Question { is_pattern, ..self.question(settings) };
        stepwise::build(&self.evidence, start, &question)
    }

    /// How a member of a set stands beside the others; `whole` where the rest is noise. `None` where the members are dependent.
    pub fn stands(&self, set: &[usize], place: usize, whole: bool, settings: &Settings) -> Option<Stands> {
        let (others, member) = (without(set, place), *set.get(place)?);
        let standing = self.evidence.standing(&others, member)?;
        let posterior = posterior::of(&self.evidence, &others, member, whole, &self.question(settings));
        let p = self.evidence.family_wise(standing.t, standing.dof, member);
        Some(Stands { t: standing.t, p, probability: posterior.probability })
    }

    /// The few columns that would take off most beside a set.
    pub fn nearest(&self, set: &[usize], count: usize) -> Vec<usize> {
        let mut longer = set.to_vec();
        while longer.len() < set.len() + count {
            match stepwise::extended(&self.evidence, &longer) {
                Some(next) => longer = next,
                None => break,
            }
        }
        longer.split_off(set.len())
    }

    /// Sum of squares that a set leaves.
    pub fn rss_of(&self, set: &[usize]) -> f64 {
        self.evidence.rss_of(set)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line under a wave of five times its noise: the line is named, its t counts the wave, and no candidate is named for the wave.
    #[test]
    fn an_effect_stands_beside_what_nothing_explains() {
        let rows = 240;
        let time = |i: usize| i as f64 / rows as f64;
        let unit = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let column: Vec<f64> = (0..rows).map(|i| f(time(i))).collect();
            let norm = column.iter().map(|v| v * v).sum::<f64>().sqrt();
            column.into_iter().map(|v| v / norm).collect()
        };
        let mut columns = vec![unit(&|t| t)];
        columns.extend((1..20).map(|k| unit(&|t| (13.7 * f64::from(k) * t + 0.3).cos())));
        // noise of unit variance that repeats itself nowhere
        let noise = |i: usize| 2f64.sqrt() * (1e4 * (i as f64 + 1.0).powi(2)).sin();
        let wave = |t: f64| 5.0 * (47.0 * t).sin();
        let residual =
            |line: f64| -> Vec<f64> { (0..rows).map(|i| line * time(i) + wave(time(i)) + noise(i)).collect() };
        let felt = |k: usize| Felt {
            name: format!("stretches of {k}"),
            group: (0..rows).map(|i| Some(i / k)).collect(),
            size: vec![1.0; rows],
        };
        let question = |line: f64| {
            let groupings = [3, 6, 12, 24].map(felt).into();
            Plain::new(&columns, residual(line), columns.len(), NoiseFrom::Stated, groupings, vec![0.0; columns.len()])
        };
        let settings = Settings::default();
        let plain = question(60.0);
        assert_eq!(plain.one_after_another(&[], &settings, &|_| false), [0]);
        let stands = plain.stands(&[0], 0, false, &settings).expect("one column");
        // against the noise alone t would be 60 |t| = 60 (240 / 3)^(1/2) = 537
        assert!(stands.t > 10.0 && stands.t < 300.0 && stands.probability > 0.99, "{stands:?}");
        assert_eq!(question(0.0).one_after_another(&[], &settings, &|_| false), [0_usize; 0]);
    }
}
