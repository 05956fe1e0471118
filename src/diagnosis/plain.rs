//! The same search on plain columns: for a linear model that comes from elsewhere than a campaign (the signatures of a navigator's errors).
//!
//! Columns and residuals are weighted already and nothing is estimated beside the candidates. An orthogonal transformation of both changes
//! nothing (all that counts are inner products), so that many rows may come as the triangle of their QR; `rows` says how many there were.

use super::evidence::Evidence;
use super::noise::{NoiseFrom, Weighted};
use super::remainder::Remainders;
use super::search::{self, Found};
use super::sets::Rival;
use super::settings::Settings;
use super::support::Support;
use crate::error::Result;
use crate::estimate::{self, Group, System};
use faer::Mat;

/// Which columns explain a residual?
pub(crate) struct Question<'a> {
    /// Candidates, weighted.
    pub columns: &'a [Vec<f64>],
    /// What is to be explained, weighted.
    pub residual: &'a [f64],
    /// Rows of the data, at least those of the columns.
    pub rows: usize,
    /// Where the weights come from: stated or residuals.
    pub from: NoiseFrom,
    /// What decides among candidates that fit alike, in variances of the noise.
    pub handicap: &'a [f64],
    /// Probability of naming anything when nothing is missing.
    pub significance: f64,
}

/// What the search says.
pub(crate) struct Answer {
    pub verdict: Verdict,
    /// Share of the sum of squares that the members take off together; 0 where there are none.
    pub explained: f64,
    /// Distinct candidates: how many tests every probability accounts for.
    pub tests: usize,
    /// The evidence step by step: members, the strongest further candidate with its t and p, the global test.
    pub steps: Vec<Step>,
}

pub(crate) struct Step {
    pub with: Vec<usize>,
    pub strongest: Option<(usize, f64, f64)>,
    pub global: Option<f64>,
}

pub(crate) enum Verdict {
    Nothing,
    Found(Vec<Member>),
    /// Members that stand beside something unexplained; the nearest further ones, and the share of the rest that they would take off.
    Partly(Vec<Member>, Vec<usize>, f64),
    /// The nearest set, which was not accepted, and the share of the sum of squares that it would take off.
    Unexplained(Vec<usize>, f64),
}

/// A column that is missing.
pub(crate) struct Member {
    pub index: usize,
    /// Given the other members; normal where the noise is stated.
    pub t: f64,
    /// Family-wise.
    pub p: f64,
    /// Share of the sum of squares, the other members given.
    pub explains: f64,
    pub aliases: Vec<Alias>,
}

/// Another column that could stand in a member's place.
pub(crate) struct Alias {
    pub index: usize,
    /// The same column, but for rounding.
    pub exact: bool,
    /// How much worse it fits, in variances of the noise.
    pub excess: f64,
    /// A column that must then stand in the place of the other member.
    pub together: Option<usize>,
}

/// Errors: numbers that are not finite.
pub(crate) fn search(question: &Question<'_>) -> Result<Answer> {
    let m = question.residual.len();
    let bare = System {
        rows: Mat::zeros(m, 0),
        observed: question.residual.to_vec(),
        u: vec![1.0; m],
        group: vec![Group::Known; m],
    };
    let mut estimate = estimate::adjust(&bare, &estimate::Settings::default())?;
    estimate.dof = question.rows.max(m);
    let residual = question.residual.to_vec();
    let rss = residual.iter().map(|v| v * v).sum();
    let weighted = Weighted { estimate, weight: vec![1.0; m], residual, rss, from: question.from, replicates: None };
    let columns: Vec<&Vec<f64>> = question.columns.iter().collect();
    let remainders = Remainders::white(&weighted, question.rows.max(m));
    let evidence = Evidence::new(&weighted, &columns, remainders);
    let support = Support { weighted: &weighted, columns: &columns, positions: &[] };
    let settings = Settings::at(question.significance);
    let found = search::search(
        &evidence,
        &search::Question {
            settings: &settings,
            handicap: question.handicap,
            support: &support,
            is_pattern: &|_| false,
            needs_all: &|_| false,
            other_phase: &|_| None,
        },
    );
    let explained = match &found {
        Found::Set { set, .. } if evidence.rss > 0.0 => (1.0 - evidence.rss_of(set) / evidence.rss).max(0.0),
        _ => 0.0,
    };
    let verdict = match found {
        Found::Nothing => Verdict::Nothing,
        Found::Unexplained { nearest, .. } => {
            let left = if evidence.rss > 0.0 { evidence.rss_of(&nearest) / evidence.rss } else { 1.0 };
            Verdict::Unexplained(nearest, (1.0 - left).max(0.0))
        }
        Found::Set { set, rivals, complete, nearest, .. } => {
            let members = (0..set.len()).filter_map(|place| member(&evidence, &set, place, &rivals)).collect();
            let all: Vec<usize> = set.iter().chain(&nearest).copied().collect();
            let rest = evidence.rss_of(&set);
            let share = if rest > 0.0 { (1.0 - evidence.rss_of(&all) / rest).max(0.0) } else { 0.0 };
            if complete { Verdict::Found(members) } else { Verdict::Partly(members, nearest, share) }
        }
    };
    let steps = steps(&evidence, &verdict);
    Ok(Answer { verdict, explained, tests: evidence.tests, steps })
}

/// The evidence as given, after the first member, after the second, and so on.
fn steps(evidence: &Evidence, verdict: &Verdict) -> Vec<Step> {
    let set: Vec<usize> = match verdict {
        Verdict::Found(members) | Verdict::Partly(members, ..) => members.iter().map(|m| m.index).collect(),
        _ => Vec::new(),
    };
    let set = super::steps::order(evidence, &set);
    let step = |count: usize| {
        let with = set.get(..count)?.to_vec();
        let given = evidence.given(&with)?;
        let strongest = evidence.strongest(&given).map(|s| (s.index, s.t, s.p));
        Some(Step { with, strongest, global: evidence.global(&given) })
    };
    (0..=set.len()).filter_map(step).collect()
}

fn member(evidence: &Evidence, set: &[usize], place: usize, rivals: &[Rival]) -> Option<Member> {
    let index = *set.get(place)?;
    let others: Vec<usize> = set.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, j)| *j).collect();
    let without = evidence.given(&others)?;
    let (t, dof) = evidence.t(&without, index);
    let own = evidence.cosines(index);
    let aliases = rivals.iter().filter(|rival| rival.place == place).map(|rival| Alias {
        index: rival.candidate,
        exact: own.get(rival.candidate).is_some_and(|cosine| 1.0 - cosine.abs() < 1e-6),
        excess: rival.excess.max(0.0),
        together: rival.together,
    });
    Some(Member {
        index,
        t,
        p: evidence.family_wise(t, dof, index),
        explains: if evidence.rss > 0.0 { (without.rss - evidence.rss_of(set)) / evidence.rss } else { 0.0 },
        aliases: aliases.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_named_and_its_double_is_an_alias() {
        let line = |f: &dyn Fn(f64) -> f64| (0..60).map(|i| f(f64::from(i) / 60.0)).collect::<Vec<f64>>();
        let columns = [line(&|x| x), line(&|x| 2.0 * x), line(&|x| (9.0 * x).sin()), line(&|_| 0.0)];
        let noise = line(&|x| (1e4 * x * (1.0 + x)).sin());
        let residual: Vec<f64> = columns[0].iter().zip(&noise).map(|(c, n)| 30.0 * c + n).collect();
        let ask = |residual: &[f64]| {
            let handicap = [0.0, 1.0, 0.0, 0.0];
            let question = Question {
                columns: &columns,
                residual,
                rows: 60,
                from: NoiseFrom::Stated,
                handicap: &handicap,
                significance: 0.01,
            };
            search(&question).unwrap()
        };
        let Verdict::Found(members) = ask(&residual).verdict else { panic!("nothing found") };
        assert_eq!((members.len(), members[0].index), (1, 0));
        assert!(members[0].aliases.len() == 1 && members[0].aliases[0].index == 1 && members[0].aliases[0].exact);
        assert!(matches!(ask(&noise).verdict, Verdict::Nothing));
        assert_eq!(ask(&noise).tests, 2);
    }
}
