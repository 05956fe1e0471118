//! Causes that fit as well in the place of a finding: alone, or together with a second one in the place of another finding.

use super::candidates::Linear;
use super::cause::{Cause, Change};
use super::diagnose::Alias;
use super::refine::Search;
use std::mem::discriminant;

/// Any wave.
const WAVE: Change = Change::Wave { period: 1.0, phase: 0.0 };
/// Pairs of members are compared with other pairs in sets of no more than so many.
const PAIRED: usize = 8;

impl Search<'_> {
    pub(super) fn aliases(&self, linear: &Linear, set: &[usize], place: usize, scale: f64) -> Vec<Alias> {
        let member = set.get(place).and_then(|j| linear.causes.get(*j));
        let rivals = linear.products.rivals(set, place, self.case.settings.indistinguishable * scale * scale);
        let alone: Vec<usize> = rivals.iter().map(|(j, ..)| *j).collect();
        let one = |(j, excess, exact): (usize, f64, bool)| -> Option<Alias> {
            let source = *linear.causes.get(j)?;
            let mut other = set.to_vec();
            *other.get_mut(place)? = j;
            let value =
                linear.products.solve(&other).and_then(|solved| Some(solved.values.get(place)? / linear.norms.get(j)?));
            let absurd = value.is_some_and(|value| self.case.is_absurd(&source, value));
            let excess = (excess / (scale * scale).max(f64::MIN_POSITIVE)).max(0.0);
            Some(Alias { source, value, exact, excess, absurd, together_with: None })
        };
        let mut aliases: Vec<Alias> = rivals.into_iter().filter_map(one).collect();
        aliases.extend(self.together(linear, set, place, &alone, scale));
        // identical columns fit equally well but for rounding: those stay in the order of the catalogue
        let excess = |alias: &Alias| if alias.exact { 0.0 } else { alias.excess };
        aliases.sort_by(|a, b| excess(a).total_cmp(&excess(b)));
        // of causes that differ only in the time of a change the best is kept, and none that differs so from the member but waves of another period
        let own = member.map(Cause::family).filter(|(_, change)| *change != Some(discriminant(&WAVE)));
        let mut seen: Vec<_> = own.into_iter().collect();
        aliases.retain(|alias| {
            let family = alias.source.family();
            let is_kept = alias.together_with.is_some() || !seen.contains(&family);
            seen.extend(alias.together_with.is_none().then_some(family));
            is_kept
        });
        let order = |a: &Alias| (a.absurd, a.together_with.is_some(), !a.exact, crate::number::whole(a.source.rank()));
        aliases.sort_by(|a, b| order(a).cmp(&order(b)).then(excess(a).total_cmp(&excess(b))));
        aliases
    }

    /// Constant errors that fit as well in the place of a member if another error replaces a second member; those in `alone` do so by themselves.
    fn together(&self, linear: &Linear, set: &[usize], place: usize, alone: &[usize], scale: f64) -> Vec<Alias> {
        let mut aliases: Vec<Alias> = Vec::new();
        if set.len() > PAIRED {
            return aliases;
        }
        let excess = self.case.settings.indistinguishable * scale * scale;
        let is_constant = |j: &usize| linear.causes.get(*j).is_some_and(Cause::is_constant);
        let constants: Vec<usize> = (0..linear.causes.len()).filter(is_constant).collect();
        for other in (0..set.len()).filter(|other| *other != place) {
            let (Some(second), true) = (set.get(other), set.get(place).is_some_and(is_constant)) else {
                continue;
            };
            if !is_constant(second) {
                continue;
            }
            for (first, second, worse) in linear.products.pairs(set, [place, other], excess, &constants) {
                let (Some(source), Some(with)) = (linear.causes.get(first), linear.causes.get(second)) else {
                    continue;
                };
                let known = aliases.iter().position(|alias| alias.source == *source);
                if alone.contains(&first)
                    || known.and_then(|k| aliases.get(k)).is_some_and(|alias| alias.excess <= worse)
                {
                    continue;
                }
                let mut instead = set.to_vec();
                for (at, j) in [(place, first), (other, second)] {
                    instead.get_mut(at).into_iter().for_each(|slot| *slot = j);
                }
                let solved = linear.products.solve(&instead);
                let of = |at: usize, j: usize| Some(solved.as_ref()?.values.get(at)? / linear.norms.get(j)?);
                let value = of(place, first);
                let absurd = |cause: &Cause, value: Option<f64>| value.is_some_and(|v| self.case.is_absurd(cause, v));
                let absurd = absurd(source, value) || absurd(with, of(other, second));
                let worse = (worse / (scale * scale).max(f64::MIN_POSITIVE)).max(0.0);
                if let Some(k) = known {
                    aliases.remove(k);
                }
                let (source, together_with) = (*source, Some(*with));
                aliases.push(Alias { source, value, exact: false, excess: worse, absurd, together_with });
            }
        }
        aliases
    }
}
