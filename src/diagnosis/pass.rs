//! One pass: every candidate at one point of the model, and what the search finds among them.

use super::candidates::{Kept, build};
use super::criteria::Question;
use super::criteria::without;
use super::evidence::Evidence;
use super::noise::{self, Finished, Weighted};
use super::remainder::Remainders;
use super::screen::{self, Chosen, Scanned, Screen};
use super::search::{self, Found};
use super::settings::Settings;
use super::support::Support;
use super::{Candidate, Effect, assumptions, families};
use crate::campaign::{Campaign, Role};
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::estimate::Variances;
use crate::fit::{self, Fit};
use crate::simulate::Regressor;
use std::collections::HashSet;

/// Passes over a long campaign before what has no column is left alone.
const SCREENED: usize = 4;

/// What the passes of a diagnosis share, and where the next one stands.
pub(super) struct Pass<'a> {
    campaign: &'a Campaign,
    /// For each equation, the constraint that was asked for.
    asked: &'a [usize],
    catalogue: &'a [Effect],
    settings: Settings,
    model: Model,
    point: Vec<f64>,
    finished: Option<Finished>,
    /// Candidates whose repair did not do what their column promised.
    banned: Vec<(String, Option<usize>)>,
    /// Candidates that exist only through small tilts where the model stands as given.
    through_tilts: Option<HashSet<(String, Option<usize>)>>,
    /// In a long campaign, the bad readings, positions and steps that have a column.
    chosen: Chosen,
    /// How many of them have none.
    pub without_column: usize,
    kept: Kept,
}

/// Where a pass stands: its point, and the scales of the noise if a finished model told them.
pub(super) type Stand = (Vec<f64>, Option<Finished>);

/// What one pass saw and found.
pub(super) struct Seen {
    pub candidates: Vec<Candidate>,
    pub evidence: Evidence,
    pub weighted: Weighted,
    pub design: DesignMatrix,
    /// Of each candidate, in noise variances.
    pub plausibility_penalty: Vec<f64>,
    pub found: Found,
    /// Of each named candidate, that it or one of its aliases is there.
    pub probabilities: Vec<(usize, f64)>,
}

impl<'a> Pass<'a> {
    pub fn new(
        campaign: &'a Campaign,
        asked: &'a [usize],
        catalogue: &'a [Effect],
        settings: Settings,
        point: Vec<f64>,
    ) -> Result<Self> {
        let model = Model::new(campaign)?;
        Ok(Pass {
            campaign,
            asked,
            catalogue,
            settings,
            model,
            point,
            finished: None,
            banned: Vec::new(),
            through_tilts: None,
            chosen: screen::chosen(campaign),
            without_column: 0,
            kept: Kept::new(),
        })
    }

    /// Stand where a repaired model stands, with its noise: columns that depend on the tilts follow, on those too that were assumed zero.
    pub fn stand_at(&mut self, repaired: &Campaign, effects: &[&Candidate], after: &Fit) {
        for (value, parameter) in self.point.iter_mut().zip(&self.campaign.parameters) {
            if let Some(found) = repaired.parameter_index(&parameter.id).and_then(|k| after.point.get(k)) {
                *value = *found;
            }
        }
        let variances = match repaired.scatter.is_empty() {
            true => None,
            false => fit::scattered(repaired, &after.design).ok().map(|found| Variances::from(&found)),
        };
        let with = effects.iter().map(|c| (c.regressor.clone(), c.sensor)).collect();
        self.finished = Some(Finished { scales: after.estimate.group_scale.clone(), variances, with });
    }

    /// Where it stands.
    pub fn stand(&self) -> Stand {
        (self.point.clone(), self.finished.clone())
    }

    /// The exact fit of a repaired campaign: from its own start, and, where an effect has a kink or exists only through tilts, from where this
    /// pass stands: there its column did what it promised.
    pub fn fit(&self, repaired: &Campaign, seen: &Seen, set: &[usize]) -> Result<Fit> {
        let delicate = |c: &Candidate| match &c.kind {
            Regressor::Term(line) => c.vanishing || line.text().contains("sign(") || line.text().contains("abs("),
            _ => false,
        };
        if !set.iter().filter_map(|j| seen.candidates.get(*j)).any(delicate) {
            return super::fit_exactly(repaired);
        }
        let mut beside = repaired.clone();
        for (parameter, value) in self.campaign.parameters.iter().zip(&self.point) {
            let own = repaired.parameter_index(&parameter.id).and_then(|k| beside.parameters.get_mut(k));
            if let Some(Role::Estimated { start, .. }) = own.map(|p| &mut p.role) {
                *start = Some(*value);
            }
        }
        let mut here = super::fit_exactly(&beside)?;
        here.campaign.parameters = repaired.parameters.clone();
        if self.is_confirmed(seen, set, &here) {
            return Ok(here);
        }
        let home = super::fit_exactly(repaired)?;
        let squares = |fit: &Fit| -> f64 {
            fit.estimate.residuals.iter().zip(&fit.system.u).map(|(v, u)| (v / u) * (v / u)).sum()
        };
        Ok(if squares(&here) < squares(&home) { here } else { home })
    }

    /// Stand there again.
    pub fn go_back(&mut self, stand: Stand) {
        (self.point, self.finished) = stand;
    }

    /// The thresholds.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Does the exact fit with a set take off what its columns promised, but for less than half of what its least member adds?
    pub fn is_confirmed(&self, seen: &Seen, set: &[usize], after: &Fit) -> bool {
        let left = seen.weighted.squares(&after.estimate.residuals);
        let promised = seen.evidence.rss_of(set);
        let least = (0..set.len()).map(|place| seen.evidence.rss_of(&without(set, place)) - promised);
        left - promised <= 0.5 * least.fold(f64::INFINITY, f64::min)
    }

    /// Does the exact fit with a set take off at least half of what its columns promised? If not, the set is banned.
    ///
    /// A column that exists only because of wrong tilts promises what no coefficient keeps: once the tilts are right, it is gone.
    pub fn keeps_its_promise(&mut self, seen: &Seen, set: &[usize], after: &Fit) -> bool {
        let left = seen.weighted.squares(&after.estimate.residuals);
        let promised = seen.evidence.rss - seen.evidence.rss_of(set);
        if seen.evidence.rss - left >= self.settings.kept_promise * promised {
            return true;
        }
        // of a set the least visible is the one that fails
        let least = set
            .iter()
            .filter_map(|j| seen.candidates.get(*j))
            .min_by(|a, b| (a.visible * a.size).total_cmp(&(b.visible * b.size)));
        self.banned.extend(least.map(|c| (c.regressor.clone(), c.sensor)));
        false
    }

    fn evidence(&mut self) -> Result<(DesignMatrix, Weighted, Vec<Candidate>, Evidence)> {
        let mut design = design::assemble(self.campaign, &self.model, &self.point)?;
        self.put_back(&mut design);
        let weighted = noise::weigh(self.campaign, &design, self.finished.as_ref())?;
        let screen = Screen::new(self.campaign, &design, &weighted, &self.chosen, &[]);
        self.chosen.add(screen.strongest(&self.chosen).into_iter().map(|(member, _)| member));
        self.chosen.add(screen::exchanged(self.campaign, &design, &weighted, &self.settings));
        let rows = weighted.weight.len();
        let mut candidates =
            build(self.campaign, self.catalogue, &self.model, &design, rows, &self.chosen, &mut self.kept)?;
        candidates.extend(assumptions::candidates(self.campaign, self.asked, &design)?);
        candidates.retain(|c| !self.banned.iter().any(|(name, sensor)| *name == c.regressor && *sensor == c.sensor));
        let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
        let remainders = Remainders::new(self.campaign, &design, &weighted);
        let mut evidence = Evidence::new(&weighted, &columns, remainders);
        if let Some(finished) = &self.finished {
            let place = |(name, sensor): &(String, Option<usize>)| {
                candidates.iter().position(|c| c.regressor == *name && c.sensor == *sensor)
            };
            let with: Vec<usize> = finished.with.iter().filter_map(place).collect();
            evidence.found_with(&with);
        }
        self.without_column = screen.without_column(&self.chosen);
        evidence.tests += self.without_column;
        evidence.multiplicity = families::multiplicity(self.campaign, &candidates, &evidence);
        for (candidate, visible) in candidates.iter_mut().zip(evidence.pool.visible()) {
            candidate.visible = *visible;
            candidate.vanishing |= *visible < self.settings.absorbed;
        }
        self.keep_doubts(&mut candidates);
        Ok((design, weighted, candidates, evidence))
    }

    /// What exists only through small tilts at the model as given does so still where an effect has moved the tilts far, as long as no tilt has been
    /// found: there it would explain what it has itself brought about.
    fn keep_doubts(&mut self, candidates: &mut [Candidate]) {
        let key = |c: &Candidate| (c.regressor.clone(), c.sensor);
        let Some(given) = &self.through_tilts else {
            self.through_tilts = Some(candidates.iter().filter(|c| c.vanishing).map(key).collect());
            return;
        };
        let is_tilt = |name: &str| name.starts_with("tilt:");
        if !self.finished.iter().flat_map(|own| &own.with).any(|(name, _)| is_tilt(name)) {
            candidates.iter_mut().for_each(|c| c.vanishing |= given.contains(&key(c)));
        }
    }

    /// How many directions are tested together, and for how many tests the probability of each candidate accounts.
    pub fn tests(&mut self) -> Result<(usize, Vec<(String, Option<usize>, f64)>)> {
        let (_, _, candidates, evidence) = self.evidence()?;
        let own = candidates.into_iter().zip(&evidence.multiplicity);
        Ok((evidence.tests, own.map(|(c, tests)| (c.regressor, c.sensor, *tests)).collect()))
    }

    /// What the point has beyond the model as given (a tilt that was found) belongs to the gap: it is taken out of the predictions linearly, so
    /// that columns are those of the point and the gap is that of the model as given.
    fn put_back(&self, design: &mut DesignMatrix) {
        let given = self.campaign.reference_point();
        for k in self.campaign.unknowns()..self.campaign.parameters.len().min(design.jacobian.ncols()) {
            let moved = self.point.get(k).zip(given.get(k)).map_or(0.0, |(point, given)| point - given);
            if moved != 0.0 {
                let column = design.jacobian.col_as_slice(k);
                design.predicted.iter_mut().zip(column).for_each(|(predicted, slope)| *predicted -= slope * moved);
            }
        }
    }

    /// Search; in a long campaign again, as long as a bad reading, a position or a step without a column is significant beside what was found.
    pub fn see(&mut self) -> Result<Seen> {
        let mut seen = self.once()?;
        for _ in 0..SCREENED {
            if !self.has_overlooked(&seen) {
                break;
            }
            seen = self.once()?;
        }
        Ok(seen)
    }

    /// Members without a column that are significant given what was found, or the strongest candidate by itself, get one.
    fn has_overlooked(&mut self, seen: &Seen) -> bool {
        let nothing = seen.evidence.given(&[]);
        let leader = nothing.and_then(|given| seen.evidence.strongest(&given)).map(|strongest| vec![strongest.index]);
        let found = match &seen.found {
            Found::Nothing => return false,
            Found::Set { set, .. } => set.clone(),
            Found::Unexplained { nearest, .. } => nearest.clone(),
        };
        let mut added = 0;
        for set in leader.into_iter().chain([found]) {
            let columns: Vec<&Vec<f64>> =
                set.iter().filter_map(|j| seen.candidates.get(*j)).map(|c| &c.column).collect();
            let Some(given) = seen.evidence.given(&set) else { continue };
            let sd = seen.evidence.variance(&given).sqrt();
            let screen = Screen::new(self.campaign, &seen.design, &seen.weighted, &self.chosen, &columns);
            let strongest = screen.strongest(&self.chosen).into_iter();
            let significant = |score: f64| {
                let tests = seen.evidence.tests as f64;
                // a score that is not a number is not significant
                let alone = 2.0 * crate::uncertainty::quantiles::normal_survival((score / sd).abs()).unwrap_or(0.5);
                tests * alone <= self.settings.names()
            };
            let overlooked: Vec<Scanned> =
                strongest.filter(|(_, score)| significant(*score)).map(|(member, _)| member).collect();
            added += self.chosen.add(overlooked);
        }
        added > 0
    }

    /// What resembles a tilt at the point where that tilt stands: all columns there are those of the tilt, which has the first claim.
    fn resembling_tilts(&self, candidates: &[Candidate], evidence: &Evidence) -> Vec<f64> {
        let mut penalty = vec![0.0; candidates.len()];
        let with = self.finished.iter().flat_map(|finished| &finished.with);
        let stands = |c: &Candidate| {
            matches!(c.kind, Regressor::Tilt(_))
                && with.clone().any(|(name, sensor)| *name == c.regressor && *sensor == c.sensor)
        };
        for (tilt, _) in candidates.iter().enumerate().filter(|(_, c)| stands(c)) {
            let cosines = evidence.cosines(tilt);
            let resembling = penalty.iter_mut().zip(cosines.iter()).enumerate();
            resembling
                .filter(|(j, (_, g))| *j != tilt && g.abs() > self.settings.resembles_tilt)
                .for_each(|(_, (own, _))| *own = self.settings.beside_tilt);
        }
        penalty
    }

    fn once(&mut self) -> Result<Seen> {
        let (design, weighted, candidates, evidence) = self.evidence()?;
        let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
        let beside_tilts = self.resembling_tilts(&candidates, &evidence);
        let plausibility_penalty: Vec<f64> = candidates
            .iter()
            .zip(beside_tilts)
            .map(|(candidate, beside)| {
                let small = if candidate.vanishing { self.settings.small_handicap() } else { 0.0 };
                // what was only asserted is the first to be doubted
                let asserted = if assumptions::is_assumption(candidate) { self.settings.asserted } else { 0.0 };
                self.settings.rank_penalty * f64::from(candidate.rank) + small - asserted + beside
            })
            .collect();
        let found = if weighted.estimate.dof == 0 {
            Found::Nothing
        } else {
            let positions = noise::positions(self.campaign, &design, weighted.weight.len());
            let basis = weighted.basis(&design, self.campaign.unknowns());
            let basis = basis.as_ref().map_or(weighted.estimate.factor.thin_q(), |own| own.as_ref());
            let support = Support {
                weighted: &weighted,
                basis,
                columns: &columns,
                positions: &positions,
                hangs: self.settings.hangs,
            };
            let is_pattern = |set: &[usize]| families::is_pattern(self.campaign, &candidates, set, &self.settings);
            let needs_all = |j: usize| candidates.get(j).is_some_and(|c| families::needs_all(c, &self.settings));
            let other_phase = |j: usize| families::other_phase(&candidates, j, &self.settings);
            let harmonics_of = |j: usize| families::harmonics_of(&candidates, j);
            let question = Question {
                settings: &self.settings,
                plausibility_penalty: &plausibility_penalty,
                doubtful_yields: true,
                support: Some(&support),
                is_pattern: &is_pattern,
                needs_all: &needs_all,
                other_phase: &other_phase,
                harmonics_of: &harmonics_of,
            };
            search::search(&evidence, &question)
        };
        Ok(Seen { candidates, evidence, weighted, design, plausibility_penalty, found, probabilities: Vec::new() })
    }
}

/// Every candidate for this campaign at its fitted model, with the standard uncertainty that its coefficient would have in it.
///
/// What a schedule can see: an effect of less than five of these hides in the noise. Infinite where the model absorbs it.
/// Errors: as [`super::diagnose`].
pub fn candidates(campaign: &Campaign, catalogue: &[Effect]) -> Result<Vec<(Candidate, f64)>> {
    let assumed = assumptions::hold(campaign)?;
    let campaign = &assumed.campaign;
    let fit = super::fit_exactly(campaign)?;
    let mut point = fit.point.clone();
    point.truncate(fit.design.point.len());
    let (_, weighted, candidates, _) =
        Pass::new(campaign, &assumed.asked, catalogue, Settings::default(), point)?.evidence()?;
    let with_u = |candidate: Candidate| {
        let u = 1.0 / (weighted.norm(&candidate.column) * candidate.visible);
        (candidate, u)
    };
    Ok(candidates.into_iter().map(with_u).collect())
}

/// What a pass saw, and the repaired campaign with its exact fit if effects were found.
pub(super) type Outcome = (Seen, Option<(Campaign, Fit)>);
