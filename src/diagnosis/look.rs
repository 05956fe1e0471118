//! One pass: every candidate at one point of the model, and what the search finds among them.

use super::arena::Arena;
use super::candidates::build;
use super::noise::{self, Weighted};
use super::screen::{self, Chosen, Scanned, Screen};
use super::search::{self, Found, IMPLAUSIBLE, Levels};
use super::support::Support;
use super::{Candidate, Effect, Step, assumptions};
use crate::campaign::Campaign;
use crate::design::{self, DesignMatrix, Model};
use crate::error::Result;
use crate::fit::Fit;

/// Candidates that are mostly in the model already are the less plausible the less of them is left.
const MOSTLY_ABSORBED: f64 = 1e-2;

/// Looks at a long campaign before what has no column is left alone.
const SCREENED: usize = 4;

/// What the passes of a diagnosis share, and where the next one stands.
pub(super) struct Pass<'a> {
    campaign: &'a Campaign,
    /// For each equation, the constraint that was asked for.
    asked: &'a [usize],
    catalogue: &'a [Effect],
    levels: Levels,
    model: Model,
    point: Vec<f64>,
    scales: Option<Vec<Option<f64>>>,
    /// Candidates whose repair did not do what their column promised.
    banned: Vec<(String, Option<usize>)>,
    /// In a long campaign, the bad readings, positions and steps that have a column.
    chosen: Chosen,
    /// How many of them have none.
    pub without_column: usize,
    /// The last pass's record.
    pub steps: Vec<Step>,
}

/// Where a pass stands: its point, and the scales of the noise if a finished model told them.
pub(super) type Stand = (Vec<f64>, Option<Vec<Option<f64>>>);

/// What one pass saw and found.
pub(super) struct Look {
    pub candidates: Vec<Candidate>,
    pub arena: Arena,
    pub weighted: Weighted,
    pub design: DesignMatrix,
    pub found: Found,
}

impl<'a> Pass<'a> {
    pub fn new(
        campaign: &'a Campaign,
        asked: &'a [usize],
        catalogue: &'a [Effect],
        levels: Levels,
        point: Vec<f64>,
    ) -> Result<Self> {
        let model = Model::new(campaign)?;
        Ok(Pass {
            campaign,
            asked,
            catalogue,
            levels,
            model,
            point,
            scales: None,
            banned: Vec::new(),
            chosen: screen::chosen(campaign),
            without_column: 0,
            steps: Vec::new(),
        })
    }

    /// Stand where a repaired model stands, with its noise: columns that depend on the tilts follow.
    pub fn stand_at(&mut self, repaired: &Campaign, after: &Fit) {
        for (value, parameter) in self.point.iter_mut().zip(self.campaign.estimated()) {
            if let Some(found) = repaired.parameter_index(&parameter.id).and_then(|k| after.point.get(k)) {
                *value = *found;
            }
        }
        self.scales = Some(after.estimate.group_scale.clone());
    }

    /// Where it stands.
    pub fn stand(&self) -> Stand {
        (self.point.clone(), self.scales.clone())
    }

    /// Stand there again.
    pub fn go_back(&mut self, stand: Stand) {
        (self.point, self.scales) = stand;
    }

    /// Does the exact fit with a set take off at least half of what its columns promised? If not, the set is banned.
    ///
    /// A column that exists only because of wrong tilts promises what no coefficient keeps: once the tilts are right, it is gone.
    pub fn keeps_its_promise(&mut self, look: &Look, set: &[usize], after: &Fit) -> bool {
        let left: f64 = after.estimate.residuals.iter().zip(&look.weighted.weight).map(|(v, w)| v * w * v * w).sum();
        let promised = look.arena.rss - look.arena.rss_of(set);
        if look.arena.rss - left >= 0.5 * promised {
            return true;
        }
        // of a set the least visible is the one that fails
        let least = set
            .iter()
            .filter_map(|j| look.candidates.get(*j))
            .min_by(|a, b| (a.visible * a.size).total_cmp(&(b.visible * b.size)));
        self.banned.extend(least.map(|c| (c.regressor.clone(), c.sensor)));
        false
    }

    fn arena(&mut self) -> Result<(DesignMatrix, Weighted, Vec<Candidate>, Arena)> {
        let design = design::assemble(self.campaign, &self.model, &self.point)?;
        let weighted = noise::weigh(self.campaign, &design, self.scales.as_deref())?;
        let screen = Screen::new(self.campaign, &design, &weighted, &self.chosen, &[]);
        self.chosen.add(screen.strongest(&self.chosen).into_iter().map(|(member, _)| member));
        let rows = weighted.weight.len();
        let mut candidates = build(self.campaign, self.catalogue, &self.model, &design, rows, &self.chosen)?;
        candidates.extend(assumptions::candidates(self.campaign, self.asked, &design)?);
        candidates.retain(|c| !self.banned.iter().any(|(name, sensor)| *name == c.regressor && *sensor == c.sensor));
        let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
        let mut arena = Arena::new(&weighted, &columns);
        self.without_column = screen.without_column(&self.chosen);
        arena.tests += self.without_column;
        for (candidate, visible) in candidates.iter_mut().zip(arena.pool.visible()) {
            candidate.visible = *visible;
            candidate.vanishing |= *visible < MOSTLY_ABSORBED;
        }
        Ok((design, weighted, candidates, arena))
    }

    /// How many directions are tested together, and for how many tests the probability of each candidate accounts.
    pub fn tests(&mut self) -> Result<(usize, Vec<(String, Option<usize>, f64)>)> {
        let (_, _, candidates, arena) = self.arena()?;
        let tests = arena.tests;
        Ok((tests, candidates.into_iter().map(|c| (c.regressor, c.sensor, tests as f64)).collect()))
    }

    /// Look; in a long campaign again, as long as a bad reading, a position or a step without a column is significant beside what was found.
    pub fn look(&mut self) -> Result<Look> {
        let mut look = self.look_here()?;
        for _ in 0..SCREENED {
            if !self.has_overlooked(&look) {
                break;
            }
            look = self.look_here()?;
        }
        Ok(look)
    }

    /// Members without a column that are significant given what was found, or the strongest candidate by itself, get one.
    fn has_overlooked(&mut self, look: &Look) -> bool {
        let nothing = look.arena.given(&[]);
        let leader = nothing.and_then(|given| look.arena.strongest(&given)).map(|strongest| vec![strongest.index]);
        let found = match &look.found {
            Found::Nothing => return false,
            Found::Set { set, .. } => set.clone(),
            Found::Unexplained { nearest, .. } => nearest.clone(),
        };
        let mut added = 0;
        for set in leader.into_iter().chain([found]) {
            let columns: Vec<&Vec<f64>> =
                set.iter().filter_map(|j| look.candidates.get(*j)).map(|c| &c.column).collect();
            let Some(given) = look.arena.given(&set) else { continue };
            let sd = look.arena.variance(&given).sqrt();
            let screen = Screen::new(self.campaign, &look.design, &look.weighted, &self.chosen, &columns);
            let strongest = screen.strongest(&self.chosen).into_iter();
            let significant = |score: f64| look.arena.family_wise(score / sd, f64::INFINITY) <= self.levels.names;
            let overlooked: Vec<Scanned> =
                strongest.filter(|(_, score)| significant(*score)).map(|(member, _)| member).collect();
            added += self.chosen.add(overlooked);
        }
        added > 0
    }

    fn look_here(&mut self) -> Result<Look> {
        let (design, weighted, candidates, mut arena) = self.arena()?;
        let columns: Vec<&Vec<f64>> = candidates.iter().map(|c| &c.column).collect();
        let handicap: Vec<f64> = candidates
            .iter()
            .map(|candidate| {
                let small = if candidate.vanishing { IMPLAUSIBLE } else { 0.0 };
                let rounding = if candidate.rounding { IMPLAUSIBLE } else { 0.0 };
                // what was only asserted is the first to be doubted
                let asserted = if assumptions::is_assumption(candidate) { 0.3 } else { 0.0 };
                0.4 * f64::from(candidate.rank) + small + rounding - asserted
            })
            .collect();
        let mut steps = Vec::new();
        let found = if weighted.estimate.dof == 0 {
            Found::Nothing
        } else {
            let positions = noise::positions(self.campaign, &design, weighted.weight.len());
            let support = Support { weighted: &weighted, columns: &columns, positions: &positions };
            search::search(&mut arena, self.levels, &handicap, &support, &mut steps)
        };
        let name = |j: usize| candidates.get(j).map_or(String::new(), |c: &Candidate| c.regressor.clone());
        self.steps = steps
            .iter()
            .map(|step| Step {
                with: step.set.iter().map(|j| name(*j)).collect(),
                strongest: step.strongest.map(|(j, t, p)| (name(j), t, p)),
                global_p: step.global,
            })
            .collect();
        Ok(Look { candidates, arena, weighted, design, found })
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
        Pass::new(campaign, &assumed.asked, catalogue, Levels::of(0.01), point)?.arena()?;
    let norm = |candidate: &Candidate| {
        let largest = candidate.column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let square = |(v, w): (&f64, &f64)| (v / largest * w) * (v / largest * w);
        candidate.column.iter().zip(&weighted.weight).map(square).sum::<f64>().sqrt() * largest
    };
    let with_u = |candidate: Candidate| {
        let u = 1.0 / (norm(&candidate) * candidate.visible);
        (candidate, u)
    };
    Ok(candidates.into_iter().map(with_u).collect())
}
