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
