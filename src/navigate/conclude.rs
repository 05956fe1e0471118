//! From a search that has settled to a diagnosis.

use super::case::{Case, Look, rank};
use super::diagnose::{Alias, Finding, NavigationDiagnosis, Suspect, Unexplained};
use super::errors::Source;
use super::measured::CHANNEL_NAMES;
use super::remainder::Remainder;
use super::separate;
use super::whiten::whiten;
use crate::diagnosis::plain;
use crate::diagnosis::{NoiseFrom, Step, Verdict};
use crate::error::Result;
use crate::uncertainty::quantiles::normal_survival;

impl Case<'_> {
    pub fn conclude(
        &self,
        look: Look,
        gap: &[f64],
        predicted: &[f64],
        change: &[f64],
        u: &[f64],
        refits: (usize, bool),
    ) -> Result<NavigationDiagnosis> {
        let left: Vec<f64> = self.values.iter().zip(predicted).map(|(y, p)| y - p).collect();
        let name = |j: &usize| self.sources.get(*j).map_or(String::new(), Source::id);
        let steps: Vec<Step> = look
            .answer
            .steps
            .iter()
            .map(|step| Step {
                with: step.with.iter().map(name).collect(),
                strongest: step.strongest.map(|(j, t, p)| (name(&j), t, p)),
                global_p: step.global,
            })
            .collect();
        let set = look.set();
        let before = self.gap(gap, u, 0);
        let after = self.gap(&left, u, set.len());
        // what the linear model accepts must hold in the full simulation
        let holds = after.p.is_none_or(|p| p > 0.2 * self.settings.significance) && refits.1;
        let fit = look.fit(&set).filter(|fit| self.is_possible(&set, fit) && holds);
        let (verdict, findings) = match (&look.answer.verdict, &fit) {
            _ if self.values.len() < 3 => (Verdict::NotDiagnosable, Vec::new()),
            (plain::Verdict::Nothing, _) => (Verdict::NothingMissing, Vec::new()),
            (plain::Verdict::Found(members), Some(fit)) => {
                let mut findings = self.findings(&look, members, fit);
                separate::separate(self.mission, self.measured, u, &look, &set, &mut findings)?;
                findings.sort_by(|a, b| b.t.abs().total_cmp(&a.t.abs()));
                (Verdict::EffectsFound, findings)
            }
            _ => (Verdict::Unexplained, Vec::new()),
        };
        let found = verdict == Verdict::EffectsFound;
        let (change, left, after) = if found { (change.to_vec(), &left[..], after) } else { (Vec::new(), gap, before) };
        let suspects = if verdict == Verdict::Unexplained { Vec::new() } else { self.suspects(left, u) };
        // what no name explains is not nothing
        let verdict = match verdict {
            Verdict::NothingMissing if !suspects.is_empty() => Verdict::Unexplained,
            other => other,
        };
        let rest = Remainder { mission: self.mission, measured: self.measured, u, before: gap, after: left };
        let unexplained = (verdict == Verdict::Unexplained).then(|| {
            let share = match &look.answer.verdict {
                plain::Verdict::Unexplained(_, share) | plain::Verdict::Partly(_, _, share) => *share,
                plain::Verdict::Found(_) => look.answer.explained,
                plain::Verdict::Nothing => 0.0,
            };
            let (cells, mut pattern) = rest.pattern();
            if let Some(worst) = suspects.first() {
                let name = CHANNEL_NAMES.get(worst.cell.channel).copied().unwrap_or_default();
                let more = suspects.len() - 1;
                let more = if more > 0 { format!(" (and {more} more)") } else { String::new() };
                pattern = format!(
                    "the gap is noise but for single values: {name} at {} s is {:.1} u off{more}",
                    worst.cell.time, worst.z
                );
            }
            let nearest = set.iter().filter_map(|j| self.sources.get(*j).copied()).collect();
            Unexplained { pattern, cells, nearest, nearest_explains: share }
        });
        Ok(NavigationDiagnosis {
            verdict,
            findings,
            before: self.mission.errors,
            after: self.with(&change),
            noise: self.from,
            gap: [before, after],
            channels: rest.channels(),
            courses: rest.courses(),
            unexplained,
            suspects,
            steps,
            candidates: (self.sources.len(), look.answer.tests),
            invisible: look.invisible,
            refits,
        })
    }

    /// Single values further off than noise goes among so many, with what the significance leaves for them.
    fn suspects(&self, left: &[f64], u: &[f64]) -> Vec<Suspect> {
        if self.from != NoiseFrom::Stated {
            return Vec::new();
        }
        let mut columns = [left.to_vec()];
        whiten(self.measured, &self.system.walks, u, &mut columns);
        let [white] = columns;
        let level = 0.1 * self.settings.significance / white.len().max(1) as f64;
        let far = |z: f64| normal_survival(z.abs()).is_some_and(|p| 2.0 * p < level);
        let pairs = self.measured.cells().zip(white).filter(|(_, z)| far(*z));
        let mut suspects: Vec<Suspect> = pairs.map(|(cell, z)| Suspect { cell, z }).collect();
        suspects.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        suspects
    }

    fn findings(&self, look: &Look, members: &[plain::Member], fit: &[(f64, f64)]) -> Vec<Finding> {
        let set: Vec<usize> = members.iter().map(|member| member.index).collect();
        let source = |j: usize| self.sources.get(j).copied();
        let finding = |place: usize, member: &plain::Member, (value, u): (f64, f64)| -> Option<Finding> {
            let alias = |own: &plain::Alias| -> Option<Alias> {
                let mut other = set.clone();
                other.iter_mut().enumerate().for_each(|(k, slot)| match own.together {
                    _ if k == place => *slot = own.index,
                    Some(second) => *slot = second,
                    None => {}
                });
                let value = look.fit(&other).and_then(|fit| fit.get(place).map(|(value, _)| *value));
                Some(Alias {
                    source: source(own.index)?,
                    value,
                    exact: own.exact,
                    excess: own.excess,
                    absurd: value.is_some_and(|value| self.is_absurd(own.index, value)),
                    together_with: own.together.and_then(source),
                })
            };
            let mut aliases: Vec<Alias> = member.aliases.iter().filter_map(alias).collect();
            let order = |a: &Alias| (a.absurd, !a.exact, a.together_with.is_some(), rank(&a.source) as u8);
            aliases.sort_by(|a, b| order(a).cmp(&order(b)).then(a.excess.total_cmp(&b.excess)));
            Some(Finding {
                source: source(member.index)?,
                value,
                u: Some(u).filter(|u| u.is_finite()),
                t: member.t,
                p: member.p,
                explains: member.explains,
                aliases,
                separate_by: Vec::new(),
            })
        };
        members.iter().zip(fit).enumerate().filter_map(|(k, (member, fit))| finding(k, member, *fit)).collect()
    }
}
