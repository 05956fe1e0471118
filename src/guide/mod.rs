//! A calibration that tells the laboratory what to do next: readings come one by one, and after each there is an [`Advice`].
//!
//! ```text
//! reading -> agrees with the others? -> fit -> what is missing -> the position that tells most, for its cost -> reading
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `advice.rs` | what is said, after a reading and while a position is held |
//! | `evidence.rs` | what is believed of the unknowns, and how probable readings are |
//! | `mistakes.rs` | which mistake at the bench explains a reading |
//! | `seen.rs` | what the readings would have shown, and what a position is worth |
//!
//! A [`Guide`] is a function of its events: the same readings, undone ones among them, give the same advice. It needs the readings' noise: stated,
//! or given. Deliberately absent: files and clocks (`cli`), constraints in predictions (they are in the fit).

mod advice;
mod evidence;
mod mistakes;
mod seen;

pub use advice::{Advice, Explanation, Held, Named};
pub(crate) use advice::{
    Agreement, Ending, Estimated, HeldMean, Holding, Lacks, Mistake, MistakeKind, Newest, Next, Progress, Residual, Why,
};

use crate::campaign::{Campaign, Observation, Reading, Readings, Shared, joint_keys};
use crate::design::RowOrigin;
use crate::diagnosis::{self, Diagnosis, Effect, Verdict};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{self, Fit};
use crate::language::{Sentence, sentence};
use crate::plan::{self, Costs, Goal, Noise, Offer, Term};
use crate::simulate::Regressor;
use crate::uncertainty::quantiles::{chi_square_survival, normal_quantile};
use evidence::{Beliefs, Judge, Solved};
#[cfg(feature = "cli")]
pub(crate) use mistakes::setting;
use seen::{Seen, Table, Wanted, Worth, cost_from, same_position};
use std::sync::Arc;

/// What a guide is asked.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The uncertainties that are wanted (radians for angles). Without any it ends when every parameter is determined and nothing is missing, or all
    /// of it named.
    pub goals: Vec<Goal>,
    /// Standard deviations of one sample, by sensor, where readings state none.
    pub noise: Vec<(String, f64)>,
    /// Standard deviation, in radians, that is supposed of an estimated tilt without a prior or limits before any reading.
    pub tilts: f64,
    /// What work costs.
    pub costs: Costs,
    /// Probability that any reading of a calibration without fault is said to disagree.
    pub false_alarms: f64,
    /// Probability that nothing is missing, or all of it named, from which the goals are enough.
    pub probability: f64,
    /// The most readings.
    pub most: usize,
    /// Settings of the diagnosis.
    pub diagnosis: diagnosis::Settings,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            goals: Vec::new(),
            noise: Vec::new(),
            // three degrees: a mounting that looks askew
            tilts: 0.05,
            costs: Costs::default(),
            false_alarms: 0.01,
            probability: 0.95,
            most: 200,
            diagnosis: diagnosis::Settings::default(),
        }
    }
}

/// A calibration under way.
#[derive(Debug, Clone)]
pub struct Guide {
    campaign: Campaign,
    catalogue: Vec<Effect>,
    settings: Settings,
    noise: Noise,
    candidates: Vec<Reading>,
    taken: Vec<Reading>,
    /// The last reading that did not agree, by index, until it is undone or explained.
    disagrees: Option<usize>,
    /// The labels of the positions of the readings that stand, as they were given.
    labels: Vec<String>,
    /// The campaign with the effects that are named.
    model: Campaign,
    /// What is believed of the model's unknowns before any reading.
    beliefs: Beliefs,
    table: Option<Table>,
    /// Did the last diagnosis leave something unexplained?
    unexplained: bool,
    /// What the last advice was made from, where goals are open: what positions are held for.
    open: Option<Arc<Open>>,
}

/// What the readings tell under the model in use.
struct Weighed {
    table: Table,
    seen: Option<Seen>,
    residuals: Vec<Residual>,
    /// What could have gone wrong, where a reading does not agree.
    mistake: Option<Mistake>,
}

/// Goals that are open, and what the readings so far tell of them.
#[derive(Debug)]
struct Open {
    seen: Seen,
    goals: Vec<(Goal, Option<f64>)>,
    effects: bool,
    /// The setting that is to be as it was read last.
    again: Option<Reading>,
}

impl Guide {
    /// Begin with a schedule: the campaign, its readings (if it has any) being the first, and the positions that may be asked for.
    ///
    /// Errors: nothing to estimate, no candidates, noise that is not known, a goal that is no quantity of the campaign.
    pub fn new(campaign: &Campaign, candidates: &Readings, catalogue: &[Effect], settings: Settings) -> Result<Self> {
        if campaign.unknowns() == 0 {
            return Err(Malformed::new(Fault::Missing, "nothing is to be estimated")
                .expected("at least one parameter in \"estimate\", for example { \"V0\": {} }")
                .at_path("estimate"));
        }
        settings.costs.check()?;
        let positive = |value: f64, fault: String| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(Malformed::new(Fault::Value, fault).expected("a positive number").found(value.to_string())),
        };
        for goal in &settings.goals {
            let known = campaign.estimated().iter().map(|q| &q.id).chain(campaign.derived.iter().map(|q| &q.id));
            if !known.clone().any(|id| *id == goal.id) {
                let what = format!("the goal names '{}', which is not estimated", goal.id);
                return Err(Malformed::unknown(what, &goal.id, known));
            }
            positive(goal.u, format!("the goal for {} is not an uncertainty", goal.id))?;
        }
        positive(settings.tilts, "the assumed size of the tilts is not a standard deviation".into())?;
        let noise = Noise::new(campaign, &settings.noise, &[])?;
        let mut distinct: Vec<Reading> = Vec::new();
        for row in &candidates.rows {
            if !distinct.iter().any(|earlier| same_position(earlier, row)) {
                distinct.push(row.unread());
            }
        }
        if distinct.is_empty() {
            return Err(Malformed::new(Fault::Missing, "there are no positions to choose from")
                .expected("a schedule with at least one position")
                .at_path("readings"));
        }
        let beliefs = Beliefs::new(campaign, &distinct, &noise, settings.tilts)?;
        let mut guide = Guide {
            campaign: campaign.clone(),
            catalogue: catalogue.to_vec(),
            settings,
            noise,
            candidates: distinct,
            taken: Vec::new(),
            disagrees: None,
            labels: Vec::new(),
            model: campaign.clone(),
            beliefs,
            table: None,
            unexplained: false,
            open: None,
        };
        for row in campaign.readings.rows.iter().filter(|row| !row.observations.is_empty()) {
            guide.accept(row.clone())?;
        }
        Ok(guide)
    }

    /// The positions that may be asked for.
    pub fn candidates(&self) -> &[Reading] {
        &self.candidates
    }

    /// The readings that stand.
    pub fn taken(&self) -> &[Reading] {
        &self.taken
    }

    /// The ordinary campaign of the readings that stand.
    pub fn campaign(&self) -> Campaign {
        let columns = self.campaign.readings.columns.clone();
        self.campaign.with_readings(Readings { columns, rows: self.taken.clone() })
    }

    /// The next reading. A position that is set again after another one is a mounting of its own, and gets a label of its own; a value without
    /// an uncertainty has that of the noise.
    ///
    /// Errors: a reading without a value, or with one that is not finite.
    pub fn accept(&mut self, reading: Reading) -> Result<()> {
        let finite = reading.observations.iter().all(|observation| observation.value.is_finite());
        if reading.observations.is_empty() || !finite {
            let sensors: Vec<&str> = self.campaign.bench.sensors.iter().map(|sensor| sensor.id.as_str()).collect();
            return Err(Malformed::new(Fault::Missing, "the reading has no value")
                .expected(format!("a number for {}", sensors.join(" or ")))
                .at_path(&reading.place));
        }
        let mut next = reading;
        let u = |seen: &Observation| next.stated_u(seen.sensor).unwrap_or_else(|| self.noise.u(&next, seen.sensor));
        let all: Vec<f64> = next.observations.iter().map(u).collect();
        next.observations.iter_mut().zip(all).for_each(|(slot, u)| slot.u = Some(u));
        next.planned_u = Shared::default();
        let asked = next.position.clone();
        next.position = self.label(&next).into();
        self.labels.push(asked.to_string());
        self.taken.push(next);
        Ok(())
    }

    /// The label of a mounting: as given, with a number where that label was left and is set again.
    pub(crate) fn label(&self, reading: &Reading) -> String {
        let wanted = reading.position.as_str();
        let used = |label: &str| self.taken.iter().any(|earlier| earlier.position == label);
        match (self.taken.last(), self.labels.last()) {
            (Some(last), Some(label)) if label == wanted && plan::mounting(last) == plan::mounting(reading) => {
                last.position.to_string()
            }
            _ if wanted.is_empty() || !used(wanted) => wanted.to_string(),
            _ => {
                let anew = |k: usize| format!("{wanted} again {k}");
                (2..).map(anew).find(|label| !used(label)).unwrap_or_default()
            }
        }
    }

    /// Take a reading back, by its number from 1. Errors: there is none.
    pub fn undo(&mut self, number: usize) -> Result<()> {
        let Some(k) = number.checked_sub(1).filter(|k| *k < self.taken.len()) else {
            return Err(Malformed::new(Fault::Value, format!("there is no reading {number} to undo"))
                .expected(match self.taken.len() {
                    0 => "a reading first".to_string(),
                    count => format!("1 to {count}"),
                })
                .found(number.to_string()));
        };
        self.taken.remove(k);
        self.labels.remove(k);
        self.disagrees = match self.disagrees {
            Some(place) if place == k => None,
            Some(place) if place > k => Some(place - 1),
            place => place,
        };
        Ok(())
    }

    /// What to say now. `fresh`: is the last reading new, so that it is to be judged?
    ///
    /// Errors: those of a fit and a diagnosis.
    pub fn advise(&mut self, fresh: bool) -> Result<Advice> {
        let newest = if fresh { self.newest()? } else { None };
        if newest.as_ref().is_some_and(|newest| newest.agreement == Agreement::Disagrees) {
            self.disagrees = self.taken.len().checked_sub(1);
        }
        let campaign = self.campaign();
        let fit = if self.taken.is_empty() { None } else { Some(fit::fit(&campaign, &fit::Settings::default())?) };
        let has_redundancy = fit.as_ref().is_some_and(|fit| fit.estimate.dof > 0);
        let diagnosis = match has_redundancy {
            true => Some(diagnosis::diagnose(&campaign, &self.catalogue, &self.settings.diagnosis)?),
            false => None,
        };
        // a reading is weighed by the model that it disagrees with: readings with a named mistake among them are no evidence of an effect
        let weighed = self.disagrees.map(|_| self.weighed(fresh)).transpose()?;
        let weighed = match weighed {
            Some(weighed) if weighed.mistake.as_ref().is_some_and(Mistake::is_named) => weighed,
            Some(weighed) if !self.follow(diagnosis.as_ref())? => weighed,
            Some(_) => self.weighed(fresh)?,
            None => {
                self.follow(diagnosis.as_ref())?;
                self.weighed(fresh)?
            }
        };
        let Weighed { table, seen, residuals, mistake } = weighed;
        self.disagrees = self.disagrees.filter(|_| mistake.is_some());
        let goals = self.progress(fit.as_ref(), diagnosis.as_ref());
        let probability = probability(diagnosis.as_ref(), seen.as_ref());
        let mut advice = Advice {
            readings: self.taken.len(),
            cost: self.settings.costs.work(&self.taken).cost,
            newest,
            parameters: fit.as_ref().map_or(Vec::new(), estimated),
            residuals,
            suspected: seen.as_ref().map_or(Vec::new(), Seen::suspected),
            nothing_missing_or_named: probability,
            unseen_effects: seen.as_ref().map_or(0, Seen::unseen),
            diagnosis: diagnosis.as_ref().map(lacks),
            mistake,
            goals,
            next: None,
            ended: None,
            unreachable: Vec::new(),
        };
        // at a point that no reading has told, slopes say nothing of what can be reached
        if let Some(seen) = seen.as_ref().filter(|seen| !seen.is_open(&self.model)) {
            advice.unreachable = seen.unreachable(&self.model, &self.settings.goals)?;
        }
        (advice.next, advice.ended) = self.decide(&advice, (&table, seen.as_ref()), diagnosis.as_ref())?;
        self.unexplained = unexplained(diagnosis.as_ref());
        self.table = Some(table);
        let (goals, effects) = (self.open_goals(&advice), !self.is_certain(&advice));
        let again = advice.next.as_ref().filter(|next| next.why == Why::Again).and(self.taken.last().cloned());
        self.open = seen.filter(|_| !goals.is_empty()).map(|seen| Arc::new(Open { seen, goals, effects, again }));
        Ok(advice)
    }

    /// What the readings tell under the model in use.
    fn weighed(&mut self, fresh: bool) -> Result<Weighed> {
        let table = self.table()?;
        let solved = self.judge(&[]).solved(&self.taken)?;
        let point = solved.as_ref().map_or(Vec::new(), |solved| solved.point.clone());
        let seen =
            solved.as_ref().map(|solved| Seen::new(&table, self.judge(&point), &self.taken, solved)).transpose()?;
        let residuals = solved.as_ref().map_or(Vec::new(), |solved| self.residuals(solved));
        let mistake = match self.disagrees {
            None => None,
            Some(at) => Some(mistakes::mistake(self.judge(&point), &self.taken, &self.candidates, at, seen.as_ref())?),
        };
        // what the model explains by now, what agrees since another was taken back, and what lies far back, is no open question
        let last = self.taken.len();
        let open = |mistake: &Mistake| {
            (fresh && mistake.reading == last) || (mistake.chance < 0.5 && mistake.reading + mistakes::BACK > last)
        };
        Ok(Weighed { table, seen, residuals, mistake: mistake.filter(open) })
    }

    fn residuals(&self, solved: &Solved) -> Vec<Residual> {
        let rows = &solved.rows;
        let one = |((origin, residual), sd): ((&RowOrigin, &f64), &f64)| {
            let sensor = self.campaign.bench.sensors.get(origin.sensor)?;
            Some(Residual {
                reading: origin.reading + 1,
                sensor: sensor.id.clone(),
                residual: *residual,
                unit: sensor.unit.clone(),
                in_sd: residual / sd,
            })
        };
        rows.design.rows.iter().zip(&rows.residual).zip(&rows.sd).filter_map(one).collect()
    }

    /// The model in use, about a point of its parameters (empty: what is believed).
    fn judge<'a>(&'a self, point: &'a [f64]) -> Judge<'a> {
        Judge { model: &self.model, beliefs: &self.beliefs, noise: &self.noise, point }
    }

    /// Take the model with the named effects, where they can be terms of its lines. Is it another than before?
    fn follow(&mut self, diagnosis: Option<&Diagnosis>) -> Result<bool> {
        let joins_model = |finding: &diagnosis::Finding| {
            matches!(finding.effect.kind, Regressor::Term(_) | Regressor::Tilt(_) | Regressor::Known(_))
        };
        let repaired = diagnosis
            .filter(|d| d.verdict == Verdict::EffectsFound && d.effects.iter().all(joins_model))
            .and_then(|d| d.repaired.as_ref())
            .filter(|d| d.readings.columns == self.campaign.readings.columns);
        let model = repaired.unwrap_or(&self.campaign);
        let lines = |campaign: &Campaign| -> Vec<String> {
            let models = campaign.bench.sensors.iter().map(|sensor| sensor.model.to_string());
            models.chain(campaign.estimated().iter().map(|p| p.id.clone())).collect()
        };
        let is_another = lines(model) != lines(&self.model);
        if is_another {
            self.table = None;
            self.beliefs = Beliefs::new(model, &self.candidates, &self.noise, self.settings.tilts)?;
        }
        self.model = model.without_readings(&self.campaign.readings.columns);
        Ok(is_another)
    }

    fn table(&mut self) -> Result<Table> {
        let mut positions = self.candidates.clone();
        for reading in &self.taken {
            if !positions.iter().any(|other| same_position(other, reading)) {
                positions.push(reading.unread());
            }
        }
        match self.table.take().filter(|table| table.positions.len() == positions.len()) {
            Some(table) => Ok(table),
            None => Table::new(&self.model, &positions, &self.catalogue, &self.noise),
        }
    }

    fn newest(&self) -> Result<Option<Newest>> {
        self.taken.split_last().map(|(newest, others)| self.judged(others, newest)).transpose()
    }

    /// A reading against others that were taken before it.
    fn judged(&self, others: &[Reading], newest: &Reading) -> Result<Newest> {
        let compared = mistakes::agreement(self.judge(&[]), others, newest)?.filter(|a| a.predicted > 0);
        let reading = others.len() + 1;
        // 1/2 + 1/6 + 1/12 + ... = 1
        let level = self.settings.false_alarms / (reading as f64 * (reading as f64 + 1.0));
        let p = compared.as_ref().and_then(|a| chi_square_survival(a.square.max(0.0), a.predicted as f64));
        let agreement = match p {
            None => Agreement::NotPredicted,
            Some(p) if p < level => Agreement::Disagrees,
            // within what is supposed of the tilts, which is no evidence
            Some(_) if compared.as_ref().is_none_or(|a| a.told == 0) => Agreement::NotPredicted,
            Some(_) => Agreement::Agrees,
        };
        let deviation = compared.zip(p).map(|(agreement, p)| {
            // as a value of one normal variable; of a probability below what a number can hold, the root of the sum itself, which is a little more
            let far = match normal_quantile(0.5 * p) {
                Some(z) if p > f64::MIN_POSITIVE => z.abs(),
                _ => agreement.square.max(0.0).sqrt(),
            };
            if agreement.is_below { -far } else { far }
        });
        let (position, setting) = (newest.position.to_string(), mistakes::setting(&self.campaign, &newest.joints));
        let remarks = self.clock(others.last(), newest);
        Ok(Newest { reading, position, setting, agreement, deviation, p, level, remarks })
    }

    /// Would this reading agree with those that stand, or be within what is supposed of the tilts?
    ///
    /// Errors: a setting at which the model has no value.
    pub(crate) fn would_agree(&self, reading: &Reading) -> Result<Agreement> {
        let judged = self.judged(&self.taken, reading)?;
        let agrees = judged.p.is_some() && judged.agreement == Agreement::NotPredicted;
        Ok(if agrees { Agreement::Agrees } else { judged.agreement })
    }

    /// The standard uncertainties of the sensors' values that a position is to be held for: as planned, by the schedule or of the noise; where goals alone
    /// are still open, and this reading meets them with a larger one, that one. White noise is supposed to take a quarter of the time for twice as much.
    ///
    /// Errors: those of a goal's quantity.
    pub fn wanted_u(&self, position: &Reading) -> Result<Vec<f64>> {
        let planned = (0..self.campaign.bench.sensors.len()).map(|sensor| self.noise.u(position, sensor));
        let share = match (&self.open, &self.table) {
            (Some(open), Some(table)) if !open.again.as_ref().is_some_and(|again| same_position(again, position)) => {
                let (goals, last) = (open.goals.as_slice(), self.taken.last());
                let wanted = Wanted { goals, effects: open.effects, last, costs: &self.settings.costs };
                open.seen.worth_holding(table, &self.model, &wanted, position)?
            }
            _ => 1.0,
        };
        Ok(planned.map(|u| u / share.sqrt()).collect())
    }

    /// A time that runs backwards.
    fn clock(&self, before: Option<&Reading>, reading: &Reading) -> Vec<Sentence> {
        let column = self.campaign.readings.columns.iter().position(|name| name == "time_s");
        let time = |reading: &Reading| reading.columns.get(column?).copied().flatten();
        let back = before.and_then(time).zip(time(reading)).filter(|(before, now)| now < before);
        let said = |(before, now): (f64, f64)| {
            sentence!("guide-time-goes-back", before = before.to_string(), now = now.to_string())
        };
        back.map(said).into_iter().collect()
    }

    fn progress(&self, fit: Option<&Fit>, diagnosis: Option<&Diagnosis>) -> Vec<Progress> {
        let after = diagnosis.and_then(|diagnosis| diagnosis.after.as_ref());
        let best = after.or(fit);
        let one = |goal: &Goal| {
            let parameter = best.and_then(|fit| fit.parameters.iter().find(|q| q.id == goal.id));
            let derived = best.and_then(|fit| fit.derived.iter().find(|q| q.id == goal.id));
            // with what is not known of aliases and of the remainder
            let change = diagnosis.and_then(|d| d.changes.iter().find(|q| q.id == goal.id));
            let in_all = change.filter(|_| after.is_some()).and_then(diagnosis::Change::u_in_all);
            let value = parameter.map_or(derived.and_then(|q| q.value), |q| q.value);
            let uncertainty =
                parameter.map_or(derived.and_then(|q| q.uncertainty.as_ref()), |q| q.uncertainty.as_ref());
            let u = value.and(in_all.or(uncertainty.map(|uncertainty| uncertainty.u)));
            let unit = match plan::is_angle(&self.campaign, &goal.id) {
                true => "rad".to_string(),
                false => parameter.map_or(String::new(), |q| q.unit.clone()),
            };
            let met = u.is_some_and(|u| u <= goal.u);
            Progress { id: goal.id.clone(), value, u, goal: goal.u, unit, met }
        };
        self.settings.goals.iter().map(one).collect()
    }

    fn is_certain(&self, advice: &Advice) -> bool {
        advice.nothing_missing_or_named >= self.settings.probability
    }

    /// The goals that these positions reach, each with its u now.
    fn open_goals(&self, advice: &Advice) -> Vec<(Goal, Option<f64>)> {
        let all = self.settings.goals.iter().zip(&advice.goals);
        let reachable = all.filter(|(goal, _)| !advice.unreachable.contains(&goal.id));
        reachable.map(|(goal, progress)| (goal.clone(), progress.u)).collect()
    }

    /// What comes next, or why nothing does.
    fn decide(
        &self,
        advice: &Advice,
        (table, seen): (&Table, Option<&Seen>),
        diagnosis: Option<&Diagnosis>,
    ) -> Result<(Option<Next>, Option<Ending>)> {
        if self.taken.len() >= self.settings.most {
            return Ok((None, Some(Ending::MostReadings)));
        }
        if let Some(again) = self.again(advice) {
            return Ok((Some(again), None));
        }
        let Some(seen) = seen else { return Ok((None, None)) };
        let determined = !seen.is_open(&self.model);
        let diagnosis = diagnosis.filter(|_| !advice.mistake.as_ref().is_some_and(Mistake::is_named));
        if let (true, Some(diagnosis)) = (determined, diagnosis)
            && let Some(next) = self.discriminating(diagnosis)?
        {
            return Ok((Some(next), None));
        }
        let certain = self.is_certain(advice);
        let goals_met = match advice.goals.as_slice() {
            [] => determined,
            goals => goals.iter().all(|goal| goal.met),
        };
        if goals_met && certain && advice.mistake.is_none() {
            return Ok((None, Some(Ending::Reached)));
        }
        let reachable = |id: &String| !advice.unreachable.contains(id);
        let goals = self.open_goals(advice);
        let reachable_met = determined && advice.goals.iter().all(|goal| goal.met || !reachable(&goal.id));
        // what no candidate's effect explains is not explained by more of the same
        let exhausted = self.candidates.iter().all(|c| self.taken.iter().any(|r| same_position(r, c)));
        let wanted = Wanted { goals: &goals, effects: !certain, last: self.taken.last(), costs: &self.settings.costs };
        let worth = seen.worth(table, &self.model, &wanted)?;
        let left = self.settings.most - self.taken.len();
        let lacking = binary_entropy(advice.nothing_missing_or_named) - binary_entropy(self.settings.probability);
        // even if every position were read in each of the readings that are left
        let too_little =
            || Ok::<_, Malformed>(seen.together(&self.model, &wanted, left)?.is_some_and(|all| all < lacking));
        let hopeless = reachable_met && (certain || (exhausted && unexplained(diagnosis)) || too_little()?);
        let known = |worth: Worth| Some((self.candidates.get(worth.position)?, worth));
        if let Some((reading, worth)) = worth.into_iter().find_map(known).filter(|_| !hopeless) {
            let next = self.next(reading, Why::Information, Vec::new(), Some(worth.nats), worth.cost);
            return Ok((Some(next), None));
        }
        // a reading that disagrees is confirmed, undone or explained before anything ends
        let open = self.disagrees.filter(|_| advice.mistake.is_some()).and_then(|at| self.taken.get(at));
        let next = open.map(|reading| self.same_again(reading, Vec::new()));
        Ok((next, open.is_none().then_some(Ending::NothingToGain)))
    }

    fn next(&self, reading: &Reading, why: Why, between: Vec<String>, information: Option<f64>, cost: f64) -> Next {
        let keys = joint_keys(self.campaign.bench.joints(), &reading.joints);
        let columns = self.campaign.readings.columns.iter().zip(&reading.columns);
        let columns = columns.filter_map(|(name, value)| value.map(|value| (name.clone(), value)));
        Next {
            position: reading.position.to_string(),
            setting: mistakes::setting(&self.campaign, &reading.joints),
            set: keys.chain(columns.filter(|_| reading.joints.is_empty())).collect(),
            why,
            between,
            information,
            cost,
        }
    }

    fn cost_of(&self, reading: &Reading) -> f64 {
        cost_from(self.taken.last(), reading, &self.settings.costs)
    }

    /// The position of a reading that does not agree, once more, unless a missing effect explains it.
    fn again(&self, advice: &Advice) -> Option<Next> {
        let mistake = advice.mistake.as_ref()?;
        let at = self.disagrees.filter(|at| at + 1 == self.taken.len())?;
        let missing = mistake.explanations.iter().filter(|explanation| explanation.kind == MistakeKind::MissingEffect);
        if missing.map(|explanation| explanation.probability).sum::<f64>() > 0.5 {
            return None;
        }
        let reading = self.taken.get(at)?;
        // of a model that is known to lack something nobody expects agreement
        if self.unexplained {
            return None;
        }
        // what once more did not tell, a third time will not
        if at.checked_sub(1).and_then(|k| self.taken.get(k)).is_some_and(|before| same_position(before, reading)) {
            return None;
        }
        let between = mistake.explanations.iter().map(|e| format!("{}: {}", e.kind, e.what)).collect();
        Some(self.same_again(reading, between))
    }

    fn same_again(&self, reading: &Reading, between: Vec<String>) -> Next {
        let asked = self.candidates.iter().find(|candidate| same_position(candidate, reading)).unwrap_or(reading);
        self.next(asked, Why::Again, between, None, self.cost_of(asked))
    }

    /// A position that tells a finding from what else it could be.
    fn discriminating(&self, diagnosis: &Diagnosis) -> Result<Option<Next>> {
        for finding in &diagnosis.effects {
            let is_rival = |alias: &&diagnosis::Alias| {
                alias.together_with.is_none() && !alias.vanishing && alias.probability > 1.0 - self.settings.probability
            };
            let rivals: Vec<&diagnosis::Alias> = finding.aliases.iter().filter(is_rival).collect();
            let term = |regressor: Regressor| {
                let common = matches!(regressor, Regressor::Tilt(_) | Regressor::Known(_));
                (common || matches!(regressor, Regressor::Term(_)))
                    .then(|| Term { sensor: finding.effect.sensor.filter(|_| !common), regressor })
            };
            // what no position changes (the order of the readings) is none of them
            let parsed = |text: &str| Regressor::parse(&self.campaign, finding.effect.sensor, text).ok().and_then(term);
            let others: Vec<Term> = rivals.iter().filter_map(|alias| parsed(&alias.regressor)).collect();
            let Some(named_term) = parsed(&finding.effect.regressor).filter(|_| !others.is_empty()) else { continue };
            let columns = self.campaign.readings.columns.clone();
            let offer = Offer {
                kept: Readings { columns: columns.clone(), rows: self.taken.clone() },
                candidates: Readings { columns, rows: self.candidates.clone() },
                noise: self.noise.clone(),
                costs: self.settings.costs,
            };
            let is_new = |position: &Reading| !self.taken.iter().any(|reading| same_position(reading, position));
            let discriminating = plan::discriminating_positions(&self.campaign(), &offer, &named_term, &others)?;
            let fresh = discriminating.into_iter().find(|best| !best.told.is_empty() && is_new(&best.position));
            if let Some(best) = fresh {
                let position = self.candidates.iter().find(|candidate| same_position(candidate, &best.position));
                let position = position.unwrap_or(&best.position);
                let names = [&finding.effect.regressor].into_iter().chain(rivals.iter().map(|alias| &alias.regressor));
                let (names, cost) = (names.cloned().collect(), self.cost_of(position));
                return Ok(Some(self.next(position, Why::Discriminates, names, None, cost)));
            }
        }
        Ok(None)
    }
}

/// Entropy of a probability and its complement, nats: what must be told to bring one probability to another is the difference, or more
/// (T. M. Cover, J. A. Thomas, Elements of Information Theory, 2006, 2.4).
fn binary_entropy(probability: f64) -> f64 {
    let part = |p: f64| if p > 0.0 { -p * p.ln() } else { 0.0 };
    part(probability) + part(1.0 - probability)
}

fn unexplained(diagnosis: Option<&Diagnosis>) -> bool {
    diagnosis.is_some_and(|diagnosis| matches!(diagnosis.verdict, Verdict::Unexplained | Verdict::PartlyExplained))
}

/// Probability that nothing is missing or that all of it is named.
fn probability(diagnosis: Option<&Diagnosis>, seen: Option<&Seen>) -> f64 {
    let nothing_missing = seen.map_or(0.0, Seen::nothing_missing);
    match diagnosis.map(|diagnosis| diagnosis.verdict) {
        None | Some(Verdict::NothingMissing | Verdict::NotDiagnosable) => nothing_missing,
        Some(Verdict::EffectsFound) => {
            diagnosis.into_iter().flat_map(|d| &d.effects).map(|f| f.probability).product::<f64>() * nothing_missing
        }
        Some(_) => 0.0,
    }
}

fn estimated(fit: &Fit) -> Vec<Estimated> {
    let one = |parameter: &fit::ParameterResult| Estimated {
        id: parameter.id.clone(),
        value: parameter.value,
        u: parameter.value.and(parameter.uncertainty.as_ref().map(|uncertainty| uncertainty.u)),
        unit: parameter.unit.clone(),
    };
    fit.parameters.iter().map(one).collect()
}

fn lacks(diagnosis: &Diagnosis) -> Lacks {
    let named = |finding: &diagnosis::Finding| Named {
        regressor: finding.effect.regressor.clone(),
        name: finding.effect.name.clone(),
        value: finding.value,
        u: finding.u,
        unit: finding.unit.clone(),
        probability: finding.probability,
        aliases: finding.aliases.iter().map(|alias| alias.regressor.clone()).collect(),
    };
    let gap = |gap: &diagnosis::Gap| (gap.dof > 0).then(|| gap.chi_square / gap.dof as f64).filter(|v| v.is_finite());
    Lacks {
        verdict: diagnosis.verdict,
        gap_before: gap(&diagnosis.gap_before),
        gap_after: gap(&diagnosis.gap_after),
        effects: diagnosis.effects.iter().map(named).collect(),
    }
}
