//! From a walk that has ended to a diagnosis.

use super::cause::Cause;
use super::diagnose::{Alias, Finding, NavigationDiagnosis, Suspect, Unexplained};
use super::measured::CHANNEL_NAMES;
use super::partly::Partly;
use super::refine::{State, Walk};
use super::remainder::Remainder;
use super::{separate, study};
use crate::diagnosis::{NoiseFrom, Step, Verdict};
use crate::elements::Elements;
use crate::error::Result;
use crate::linear::dot;
use crate::uncertainty::quantiles::normal_survival;

impl Walk<'_> {
    /// The diagnosis of a state; or, where it is not complete, of what stands beside an unexplained rest.
    pub fn conclude(mut self, state: &State, gap: &[f64]) -> Result<NavigationDiagnosis> {
        self.part = (0.9, 1.0);
        let complete = self.is_complete(state);
        let partly = if complete { None } else { self.partly(state) };
        let rest = if complete { 0.0 } else { state.rss };
        let state = partly.as_ref().map_or(state, |own| &own.state);
        let mut diagnosis = self.concluded(state, gap, complete.then_some(&state.each), partly.as_ref(), rest)?;
        if !diagnosis.findings.is_empty() {
            diagnosis.gap_steps = self.gap_steps(state, gap);
            diagnosis.refits.0 = self.flights;
        }
        Ok(diagnosis)
    }

    /// A state that is complete has the probability of `each` of its causes; `rest` is the sum of squares that the nearest set leaves where nothing stands.
    fn concluded(
        &self,
        state: &State,
        gap: &[f64],
        each: Option<&[f64]>,
        partly: Option<&Partly>,
        rest: f64,
    ) -> Result<NavigationDiagnosis> {
        let case = &self.case;
        let u = self.u;
        let left = case.left(&state.flown.predicted);
        let before = case.gap(gap, u, &[], 0);
        let after = case.gap(&left, u, &state.out, state.set.len());
        let nothing = state.set.is_empty() && state.out.is_empty() && self.wander.is_none();
        let verdict = match (each.is_some(), nothing) {
            _ if case.values.len() < 3 => Verdict::NotDiagnosable,
            (true, true) => Verdict::NothingMissing,
            (true, false) => Verdict::EffectsFound,
            (false, _) if partly.is_some() => Verdict::PartlyExplained,
            (false, _) => Verdict::Unexplained,
        };
        let found = matches!(verdict, Verdict::EffectsFound | Verdict::PartlyExplained);
        let mut findings = if found { self.findings(state, gap, each.unwrap_or_default(), partly) } else { Vec::new() };
        if found {
            let present = |cause: &Cause| {
                let member = state.set.iter().position(|own| own == cause);
                let own = member.and_then(|k| state.flown.jacobian.get(k)).cloned();
                let mut column = [own.unwrap_or_else(|| case.raw_of(cause))];
                case.weigh(u, &state.out, &mut column);
                let [column] = column;
                column
            };
            separate::separate(
                case.mission,
                case.measured,
                u,
                &present,
                &state.set,
                case.settings.tells,
                &mut findings,
            )?;
            findings.sort_by(|a, b| b.t.abs().total_cmp(&a.t.abs()));
        }
        let mut explained = left.clone();
        state.out.iter().for_each(|at| explained.get_mut(*at).into_iter().for_each(|slot| *slot = 0.0));
        let rest_of = if found { &explained[..] } else { gap };
        let remainder = Remainder { mission: case.mission, measured: case.measured, u, before: gap, after: rest_of };
        let suspects = if found { self.suspects(state, &left) } else { Vec::new() };
        let unexplained = matches!(verdict, Verdict::Unexplained | Verdict::PartlyExplained).then(|| {
            let (cells, pattern) = remainder.pattern();
            let share = if before.chi_square > 0.0 { 1.0 - rest / before.chi_square } else { 0.0 };
            let (nearest, share) = match partly {
                Some(own) => (own.nearest.clone(), own.nearest_share),
                None if state.set.len() <= 8 => (state.set.clone(), share),
                None => (Vec::new(), share),
            };
            let nearest = nearest.iter().map(Cause::id).collect();
            Unexplained { pattern, cells, nearest, nearest_explains: share.max(0.0) }
        });
        let invisible = case.causes.iter().filter_map(Cause::constant).filter(|source| {
            let mut column = [case.raw_of(&Cause::Constant(*source))];
            case.weigh(u, &[], &mut column);
            case.is_invisible(&Cause::Constant(*source), dot(&column[0], &column[0]).sqrt())
        });
        let invisible = invisible.collect();
        // t beyond all numbers: certain
        let family = |t: f64| (2.0 * normal_survival(t.abs()).unwrap_or_default() * self.distinct as f64).min(1.0);
        let steps = self.seen.iter().map(|seen| {
            let strongest = seen.strongest.as_ref().map(|(cause, t)| (cause.id(), *t, family(*t)));
            Step::new(seen.set.iter().map(Cause::id).collect(), strongest, seen.p)
        });
        Ok(NavigationDiagnosis {
            verdict,
            before: case.mission.errors,
            after: if found { case.with(&state.set, &state.values) } else { case.mission.errors },
            noise: case.from,
            gap: if found { [before, after] } else { [before.clone(), before] },
            gap_steps: Vec::new(),
            channels: remainder.channels(),
            gaps_over_time: remainder.gaps_over_time(),
            unexplained,
            suspects,
            steps: steps.collect(),
            candidates: (case.causes.len(), self.distinct),
            invisible,
            refits: (self.flights, state.settled),
            findings,
        })
    }

    fn suspects(&self, state: &State, left: &[f64]) -> Vec<Suspect> {
        let mut white = [left.to_vec()];
        self.case.weigh(self.u, &[], &mut white);
        let cells: Vec<_> = self.case.measured.cells().collect();
        let motions = study::motions(self.case.mission);
        let one = |at: &usize| {
            let cell = cells.get(*at)?;
            // runs are numbered by the motions of this mission
            let motion = motions.get(self.case.measured.runs.get(cell.run)?.motion)?.0.clone();
            let column = CHANNEL_NAMES.at(cell.channel).into();
            Some(Suspect { motion, column, time_s: cell.time, z: *white[0].get(*at)? })
        };
        let mut suspects: Vec<Suspect> = state.out.iter().filter_map(one).collect();
        suspects.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        suspects
    }

    fn findings(&self, state: &State, gap: &[f64], each: &[f64], partly: Option<&Partly>) -> Vec<Finding> {
        let case = &self.case;
        let linear = self.linear(state, &self.alike(state));
        let set = linear.places(&state.set);
        let mut white = [gap.to_vec()];
        case.weigh(self.u, &state.out, &mut white);
        let whole = dot(&white[0], &white[0]).max(f64::MIN_POSITIVE);
        let rss = state.rss;
        // in the rows in which the causes were looked for
        let least = linear.products.solve(&set).map_or(rss, |solved| solved.rss);
        // where the noise is what is left, its own size counts
        let dof = case.values.len().saturating_sub(set.len() + state.out.len()).max(1) as f64;
        let scale = match partly {
            _ if case.from == NoiseFrom::Residuals => (rss / dof).sqrt(),
            Some(_) => (rss / dof).sqrt().max(1.0),
            None => 1.0,
        };
        let tests = self.distinct as f64;
        // t beyond all numbers: certain
        let p_of = |t: f64, tests: f64| (2.0 * normal_survival(t.abs()).unwrap_or_default() * tests).min(1.0);
        let mut findings = Vec::new();
        for (place, cause) in state.set.iter().enumerate() {
            let (Some(value), Some(u)) = (state.values.get(place).copied(), state.u.get(place)) else { continue };
            let stands = partly.and_then(|own| own.stands.get(place));
            // beside an unexplained rest the uncertainty counts it
            let u = stands.map_or(scale * u, |own| own.u);
            let mut others = set.clone();
            others.remove(place);
            let without = linear.products.solve(&others).map_or(least, |solved| solved.rss);
            let t = if u > 0.0 { value / u } else { f64::INFINITY };
            findings.push(Finding {
                source: *cause,
                value,
                u: Some(u).filter(|u| u.is_finite()),
                t,
                p: p_of(t, tests),
                probability: stands.map(|own| own.probability).or(each.get(place).copied()),
                explains: ((without - least) / whole).clamp(0.0, 1.0),
                aliases: self.aliases(&linear, &set, place, scale),
                separate_by: Vec::new(),
            });
        }
        let cells: Vec<_> = case.measured.cells().collect();
        let left = case.left(&state.flown.predicted);
        if let Some(wander) = &self.wander {
            // against the values' own noise, without any walk
            let square = |values: &[f64]| values.iter().zip(self.u).map(|(v, u)| (v / u) * (v / u)).sum::<f64>();
            let t = wander.gain.max(0.0).sqrt();
            let other = |(source, density, excess): &(Cause, f64, f64)| Alias {
                source: *source,
                value: Some(*density),
                exact: false,
                excess: *excess,
                absurd: false,
                together_with: None,
            };
            findings.push(Finding {
                source: wander.cause,
                value: wander.density,
                u: Some(wander.u),
                t,
                p: p_of(t, tests),
                probability: None,
                explains: ((square(&left) - rss) / square(gap).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0),
                aliases: wander.others.iter().map(other).collect(),
                separate_by: Vec::new(),
            });
        }
        for at in &state.out {
            let (Some(cell), Some(value)) = (cells.get(*at), left.get(*at)) else { continue };
            let u = self.u.at(*at);
            let before: usize = case.measured.runs.iter().take(cell.run).map(|run| run.rows.len()).sum();
            findings.push(Finding {
                source: Cause::Reading { row: before + cell.row + 1, channel: cell.channel, at: *at },
                value: *value,
                u: Some(u),
                t: value / u,
                p: p_of(value / u, case.values.len() as f64),
                probability: None,
                explains: (gap.get(*at).map_or(0.0, |gap| (gap / u).powi(2)) / whole).clamp(0.0, 1.0),
                aliases: Vec::new(),
                separate_by: Vec::new(),
            });
        }
        findings
    }
}
