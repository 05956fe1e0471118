//! The diagnosis of a search that has ended: its findings, what fits as well in the place of each (alone, or together with a second cause in the place of another
//! finding), and the gap as it shrinks, each set refined anew on the full simulation.

use super::cause::{Cause, Change};
use super::diagnose::{Alias, Finding, GapStep, NavigationDiagnosis, Suspect, Unexplained};
use super::judged::Linear;
use super::measured::CHANNEL_NAMES;
use super::mission::Mission;
use super::partly::Partly;
use super::products::{INDEPENDENT, Products, chance};
use super::refine::{Search, State, UnstatedWalk, stated};
use super::remainder::Remainder;
use super::{separate, study};
use crate::diagnosis::{Gap, NoiseFrom, Verdict};
use crate::elements::Elements;
use crate::error::Result;
use crate::linear::{dot, norm, orthonormal, project};
use std::mem::discriminant;

/// With more causes than this only the first and the last gap are reported.
const STEPS: usize = 12;
/// Any wave.
const WAVE: Change = Change::Wave { period: 1.0, phase: 0.0 };
/// Pairs of members are compared with other pairs in sets of no more than so many.
const PAIRED: usize = 8;

impl Search<'_> {
    /// The diagnosis of a state; where that is not complete, of the causes that are significant against what is unexplained.
    pub fn conclude(mut self, state: &State, gap: &[f64]) -> Result<NavigationDiagnosis> {
        self.part = (0.9, 1.0);
        let complete = self.is_complete(state);
        let (partly, suspected) = if complete { (None, state.suspected.clone()) } else { self.partly(state) };
        let nearest_rss = if complete { 0.0 } else { state.rss };
        let state = partly.as_ref().map_or(state, |partly| &partly.state);
        let linear = self.linear_at(state);
        let (case, u) = (&self.case, self.u);
        let residual = case.residual(&state.flown.predicted);
        let before = case.gap(gap, u, &[], 0);
        let after = self.gap_of(state);
        let nothing = state.set.is_empty() && state.out.is_empty() && self.unstated.is_empty();
        let verdict = match (complete, nothing) {
            _ if case.measured.count() < 3 => Verdict::NotDiagnosable,
            (true, true) if suspected.is_empty() => Verdict::NothingMissing,
            (true, true) => Verdict::Unexplained,
            (true, false) => Verdict::EffectsFound,
            (false, _) if partly.is_some() => Verdict::PartlyExplained,
            (false, _) => Verdict::Unexplained,
        };
        let has_findings = matches!(verdict, Verdict::EffectsFound | Verdict::PartlyExplained);
        let mut findings = Vec::new();
        let errors = stated(&case.with(&state.set, &state.values), &self.unstated);
        let walking = Mission { errors: stated(&case.mission.errors, &self.unstated), ..case.mission.clone() };
        if has_findings {
            findings = self.findings(state, &linear, gap, partly.as_ref());
            let present = |cause: &Cause| {
                let member = state.set.iter().position(|other| other == cause);
                let derivative = member.and_then(|k| state.flown.jacobian.get(k)).cloned();
                case.whitened(derivative.unwrap_or_else(|| case.raw_of(cause)), u, &state.out)
            };
            separate::separate(&walking, case.measured, u, &present, &state.set, case.settings.tells, &mut findings)?;
            findings.sort_by(|a, b| b.t.abs().total_cmp(&a.t.abs()));
        }
        let mut explained = residual.clone();
        state.out.iter().for_each(|at| explained.get_mut(*at).into_iter().for_each(|slot| *slot = 0.0));
        let shown = if has_findings { &explained[..] } else { gap };
        let remainder = Remainder { mission: case.mission, measured: case.measured, u, before: gap, after: shown };
        let suspects = if has_findings { self.suspects(state, &residual) } else { Vec::new() };
        let unexplained = matches!(verdict, Verdict::Unexplained | Verdict::PartlyExplained).then(|| {
            let (cells, pattern) = remainder.pattern();
            let share = if before.chi_square > 0.0 { 1.0 - nearest_rss / before.chi_square } else { 0.0 };
            let (nearest, share) = match &partly {
                Some(partly) => (partly.nearest.clone(), partly.nearest_share),
                None if complete => {
                    let causes: Vec<Cause> = suspected.iter().map(|(cause, _)| *cause).collect();
                    let share = linear.share_of(&linear.places(&state.set), &linear.places(&causes));
                    (causes, share)
                }
                None if state.set.len() <= 8 => (state.set.clone(), share),
                None => (Vec::new(), share),
            };
            let nearest = nearest.iter().map(Cause::id).collect();
            Unexplained { pattern, cells, nearest, nearest_explains: share.max(0.0) }
        });
        let constants = case.causes.iter().filter(|cause| cause.is_constant());
        let invisible = constants.filter(|cause| !case.is_visible(cause, u)).filter_map(Cause::constant);
        let invisible = invisible.collect();
        let gap_steps = if findings.is_empty() { Vec::new() } else { self.gap_steps(state, gap) };
        let case = &self.case;
        Ok(NavigationDiagnosis {
            verdict,
            before: case.mission.errors,
            after: if has_findings { errors } else { case.mission.errors },
            noise: case.from,
            gap: if has_findings { [before, after] } else { [before.clone(), before] },
            gap_steps,
            channels: remainder.channels(),
            gaps_over_time: remainder.gaps_over_time(),
            unexplained,
            suspects,
            suspected,
            steps: self.steps,
            candidates: (case.causes.len(), self.distinct),
            invisible,
            refits: (self.flights, state.settled),
            findings,
        })
    }

    /// Standard uncertainties of a state's values, with those of times, periods and phases, which are fitted too: one over the norm of what the others leave
    /// of each column.
    fn with_times(&self, state: &State) -> Vec<f64> {
        let moves = self.moves(&state.set, &self.case.columns);
        if moves.is_empty() {
            return state.u.clone();
        }
        let mut columns: Vec<Vec<f64>> = state.flown.jacobian.iter().cloned().chain(moves).collect();
        self.case.weigh(self.u, &state.out, &mut columns);
        let one = |place: usize| {
            let others = columns.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, column)| column.clone());
            let mut column = columns.get(place).cloned().unwrap_or_default();
            project(&mut column, &orthonormal(others, INDEPENDENT));
            1.0 / norm(&column)
        };
        (0..state.set.len()).map(one).collect()
    }

    fn suspects(&self, state: &State, residual: &[f64]) -> Vec<Suspect> {
        let white = self.case.whitened(residual.to_vec(), self.u, &[]);
        let cells: Vec<_> = self.case.measured.cells().collect();
        let motions = study::motions(self.case.mission);
        let one = |at: &usize| {
            let cell = cells.get(*at)?;
            // runs are numbered by the motions of this mission
            let motion = motions.get(self.case.measured.runs.get(cell.run)?.motion)?.0.clone();
            let column = CHANNEL_NAMES.at(cell.channel).into();
            Some(Suspect { motion, column, time_s: cell.time, z: *white.get(*at)? })
        };
        let mut suspects: Vec<Suspect> = state.out.iter().filter_map(one).collect();
        suspects.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        suspects
    }

    /// The linear model with the columns of all causes, not of the state's alone, at the errors of the state: what could stand in the place of a large error is
    /// compared with it there.
    fn linear_at(&mut self, state: &State) -> Linear {
        let waves = self.alike(state);
        let errors = self.case.with(&state.set, &state.values);
        // where nothing can be computed around them, around the mission's
        let moved = (errors != self.case.around).then(|| self.case.around(&errors, self.u)).flatten();
        let before = moved.map(|moved| std::mem::replace(&mut self.case, moved));
        let linear = self.linear(state, &waves);
        self.case = before.unwrap_or_else(|| self.case.clone());
        linear
    }

    /// A state that is not `partly` explained has the probabilities of its causes.
    fn findings(&self, state: &State, linear: &Linear, gap: &[f64], partly: Option<&Partly>) -> Vec<Finding> {
        let case = &self.case;
        let set = linear.places(&state.set);
        let white = case.whitened(gap.to_vec(), self.u, &state.out);
        let whole = dot(&white, &white).max(f64::MIN_POSITIVE);
        let rss = state.rss;
        // in the rows of the search
        let least = linear.products.solve(&set).map_or(rss, |solved| solved.rss);
        // noise that is estimated from the residuals has their size
        let dof = case.measured.count().saturating_sub(set.len() + state.out.len()).max(1) as f64;
        let scale = match partly {
            _ if case.from == NoiseFrom::Residuals => (rss / dof).sqrt(),
            Some(_) => (rss / dof).sqrt().max(1.0),
            None => 1.0,
        };
        let finding = |source: Cause, [value, u, t]: [f64; 3], tests: usize, explains: f64| Finding {
            source,
            value,
            u: Some(u).filter(|u| u.is_finite()),
            t,
            p: chance(t, tests),
            probability: None,
            explains: explains.clamp(0.0, 1.0),
            aliases: Vec::new(),
            separate_by: Vec::new(),
        };
        let walk = |(source, density, excess): &(Cause, f64, f64)| Alias {
            source: *source,
            value: Some(*density),
            exact: false,
            excess: *excess,
            absurd: false,
            together_with: None,
        };
        let mut findings = Vec::new();
        let known = self.with_times(state);
        for (place, cause) in state.set.iter().enumerate() {
            let (Some(value), Some(u)) = (state.values.get(place).copied(), known.get(place)) else { continue };
            let member = partly.and_then(|partly| partly.members.get(place));
            // where something is unexplained, the uncertainty contains it
            let u = member.map_or(scale * u, |member| member.u);
            let mut others = set.clone();
            others.remove(place);
            let without = linear.products.solve(&others).map_or(least, |solved| solved.rss);
            let t = if u > 0.0 { value / u } else { f64::INFINITY.copysign(value) };
            let mut aliases = self.aliases(linear, &set, place, scale);
            aliases.extend(self.walks_instead(state, place).iter().map(walk));
            findings.push(Finding {
                probability: member.map(|member| member.probability).or(state.each.get(place).copied()),
                aliases,
                ..finding(*cause, [value, u, t], self.distinct, (without - least) / whole)
            });
        }
        let cells: Vec<_> = case.measured.cells().collect();
        let residual = case.residual(&state.flown.predicted);
        for unstated in &self.unstated {
            // against the innovations of the other walks alone
            let others: Vec<UnstatedWalk> =
                self.unstated.iter().filter(|other| other.cause != unstated.cause).cloned().collect();
            let others = self.with_walks(&self.case, &self.stated, &others);
            let square = |values: &[f64]| {
                let white = others.whitened(values.to_vec(), self.u, &[]);
                dot(&white, &white)
            };
            let t = unstated.gain.max(0.0).sqrt();
            let explains = (square(&residual) - rss) / square(gap).max(f64::MIN_POSITIVE);
            findings.push(Finding {
                aliases: unstated.others.iter().map(walk).collect(),
                ..finding(unstated.cause, [unstated.density, unstated.u, t], self.distinct, explains)
            });
        }
        for at in &state.out {
            let (Some(cell), Some(value)) = (cells.get(*at), residual.get(*at)) else { continue };
            let u = self.u.at(*at);
            let before: usize = case.measured.runs.iter().take(cell.run).map(|run| run.rows.len()).sum();
            let source = Cause::Reading { row: before + cell.row + 1, channel: cell.channel, at: *at };
            let explains = gap.get(*at).map_or(0.0, |gap| (gap / u).powi(2)) / whole;
            findings.push(finding(source, [*value, u, value / u], case.measured.count(), explains));
        }
        findings
    }

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

    /// The gap before, after each of the causes of a state, and after all of them with single values left out; `whole` is the gap before.
    pub fn gap_steps(&mut self, state: &State, whole: &[f64]) -> Vec<GapStep> {
        let (u, out) = (self.u, &state.out);
        // random walks are no members of the set: with them, all gaps are innovations
        let walks: Vec<String> = self.unstated.iter().map(|walk| walk.cause.id()).collect();
        let step = |set: &[Cause], left_out: usize, gap: Gap| GapStep {
            with: walks.iter().cloned().chain(set.iter().map(Cause::id)).collect(),
            left_out,
            gap,
        };
        let mut steps = vec![step(&[], 0, self.case.gap(whole, u, &[], 0))];
        let order = if state.set.len() > STEPS { Vec::new() } else { self.order(state) };
        let causes =
            |places: &[usize]| places.iter().filter_map(|k| state.set.get(*k)).copied().collect::<Vec<Cause>>();
        for count in 1..order.len() {
            let (set, start): (Vec<Cause>, Vec<f64>) =
                order.iter().take(count).filter_map(|k| Some((*state.set.get(*k)?, *state.values.get(*k)?))).unzip();
            // a set that cannot be flown is left out
            let Some(fitted) = self.refine(&set, &start, out) else { continue };
            steps.push(step(&set, 0, self.case.gap(&self.case.residual(&fitted.flown.predicted), u, &[], set.len())));
        }
        let set = if order.is_empty() { state.set.clone() } else { causes(&order) };
        let residual = self.case.residual(&state.flown.predicted);
        if !set.is_empty() {
            steps.push(step(&set, 0, self.case.gap(&residual, u, &[], set.len())));
        }
        if !out.is_empty() {
            steps.push(step(&set, out.len(), self.case.gap(&residual, u, out, set.len())));
        }
        steps
    }

    /// Members of a state's set in the order in which they reduce the gap most, given those before them.
    fn order(&self, state: &State) -> Vec<usize> {
        let mut columns = state.flown.jacobian.clone();
        columns.push(self.case.observed(&state.flown, &state.values));
        self.case.weigh(self.u, &state.out, &mut columns);
        let Some(residual) = columns.pop() else { return Vec::new() };
        let count = columns.len();
        let (products, _) = Products::normalised(columns, &residual);
        let mut order: Vec<usize> = Vec::with_capacity(count);
        while order.len() < count {
            let Some(solved) = products.solve(&order) else { return Vec::new() };
            let gains = products.gains(&order, &solved);
            let remaining = (0..count).filter(|k| !order.contains(k));
            match remaining.max_by(|a, b| gains.at(*a).total_cmp(&gains.at(*b)).then(b.cmp(a))) {
                Some(next) => order.push(next),
                None => break,
            }
        }
        order
    }
}
