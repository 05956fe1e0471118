//! Candidates: every member of the catalogue as a column of the system, at the point where the model stands.

use super::candidate::Candidate;
use super::catalogue::{Effect, Filling, breaks, fill};
use super::screen::{Chosen, Scanned};
use super::settings::Settings;
use super::sizes::sizes;
use crate::campaign::{Campaign, Kind, Role};
use crate::design::{DesignMatrix, Model};
use crate::error::{Fault, Malformed, Result};
use crate::simulate::{Regressor, Table, indicator};

/// Everything that the catalogue has for this campaign. `rows` is the length of the system, priors included.
///
/// Errors: a term of a user's catalogue that uses a name which this campaign does not have.
///
/// `kept` holds the columns of terms that no tilt moves, from one point to the next.
pub(super) fn build(
    campaign: &Campaign,
    catalogue: &[Effect],
    model: &Model,
    design: &DesignMatrix,
    rows: usize,
    chosen: &Chosen,
    kept: &mut Kept,
) -> Result<Vec<Candidate>> {
    let tilts = model.tilts_of(&design.point);
    let mut maker = Maker {
        kept,
        campaign,
        design,
        rows,
        chosen,
        table: Table::new(campaign, &tilts, &design.point),
        found: Vec::new(),
        seen: std::collections::HashSet::new(),
        named: std::collections::HashSet::new(),
    };
    for effect in catalogue {
        if effect.needs.iter().any(|column| !campaign.readings.columns.contains(column)) {
            continue;
        }
        maker.effect(effect)?;
    }
    let mut found = maker.found;
    let settings = Settings::default();
    let rounding = settings.roundings * f64::EPSILON;
    let bounds = sizes(campaign, design, &mut found, rounding);
    let mut bounds = bounds.into_iter();
    // a column of rounding is no column
    found.retain(|candidate| bounds.next().is_none_or(|bound| candidate.size > bound));
    for candidate in &mut found {
        candidate.vanishing = candidate.size < settings.vanishing;
    }
    Ok(found)
}

/// Columns of terms that no tilt moves, by regressor and sensor.
pub(super) type Kept = std::collections::HashMap<(String, usize), Vec<f64>>;

struct Maker<'a> {
    kept: &'a mut Kept,
    campaign: &'a Campaign,
    design: &'a DesignMatrix,
    rows: usize,
    /// Which bad readings, positions and steps get a column.
    chosen: &'a Chosen,
    table: Table<'a>,
    found: Vec<Candidate>,
    seen: std::collections::HashSet<(String, Option<usize>)>,
    /// Names of coefficients that candidates have: two that are found together must not share one.
    named: std::collections::HashSet<String>,
}

impl Maker<'_> {
    fn effect(&mut self, effect: &Effect) -> Result<()> {
        let campaign = self.campaign;
        for (k, sensor) in campaign.bench.sensors.iter().enumerate() {
            if !effect.applies.to(sensor) {
                continue;
            }
            let mut common = false;
            for filling in effect.fillings(campaign, sensor) {
                for (filling, row) in self.scanned(effect, filling, k) {
                    let text = fill(&effect.term, &filling);
                    common = self
                        .member(effect, &filling, &text, k, row)
                        .map_err(|e| e.at_path(format!("{}.term", effect.place)))?;
                }
            }
            if common {
                break;
            }
        }
        Ok(())
    }

    /// The placeholders that stand for readings, with the threshold of a step where it is one.
    fn scanned(&self, effect: &Effect, filling: Filling, sensor: usize) -> Vec<(Filling, Option<f64>)> {
        let with = |placeholder: &'static str, value: String| {
            let mut next = filling.clone();
            next.push((placeholder, value));
            next
        };
        let read = |k: usize| {
            self.campaign.readings.rows.get(k).is_some_and(|r| r.observations.iter().any(|o| o.sensor == sensor))
        };
        if effect.term.contains("{break}") {
            let breaks = breaks(self.campaign).into_iter();
            let chosen = breaks.filter(|(_, at)| self.chosen.has(&Scanned::Break(sensor, at.to_bits())));
            return chosen.map(|(text, at)| (with("{break}", text), Some(at))).collect();
        }
        if effect.term.contains("{other}") {
            let pairs = self.chosen.pairs(sensor).into_iter();
            let both = |(a, b): (usize, usize)| {
                let mut next = with("{reading}", (a + 1).to_string());
                next.push(("{other}", (b + 1).to_string()));
                (next, None)
            };
            return pairs.map(both).collect();
        }
        if effect.term.contains("{reading}") {
            let indices = (0..self.campaign.readings.rows.len())
                .filter(|k| read(*k) && self.chosen.has(&Scanned::Reading(sensor, *k)));
            return indices.map(|k| (with("{reading}", (k + 1).to_string()), None)).collect();
        }
        if effect.term.contains("{position}") {
            let labels = positions(self.campaign).into_iter();
            let chosen = labels.filter(|own| self.chosen.has(&Scanned::Position(sensor, own.clone())));
            return chosen.map(|label| (with("{position}", label), None)).collect();
        }
        vec![(filling, None)]
    }

    /// Makes the candidate; tells whether it is common to all sensors.
    fn member(
        &mut self,
        effect: &Effect,
        filling: &Filling,
        text: &str,
        sensor: usize,
        step: Option<f64>,
    ) -> Result<bool> {
        let campaign = self.campaign;
        let kind = Regressor::parse(campaign, Some(sensor), text)?;
        let (regressor, owner) = match &kind {
            // named as they were scanned: a canonical form would multiply the numbers out
            Regressor::Term(_) if effect.term.contains("{tau}") || effect.term.contains("{break}") => {
                (text.to_string(), Some(sensor))
            }
            Regressor::Term(line) => (line.canonical(), Some(sensor)),
            Regressor::Tilt(_) | Regressor::Known(_) => (text.to_string(), None),
            _ => (text.to_string(), Some(sensor)),
        };
        if !self.seen.insert((regressor.clone(), owner)) {
            return Ok(owner.is_none());
        }
        let mut column = match (&kind, step) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => self.jacobian(*k),
            (Regressor::Term(_), Some(at)) => self.step(at, sensor),
            (Regressor::Term(line), None) => {
                if line.names().is_empty() {
                    return Err(Malformed::new(Fault::Value, format!("the effect '{text}' is a constant"))
                        .expected("a term with an input, a joint or a column"));
                }
                let key = (regressor.clone(), sensor);
                match self.kept.get(&key) {
                    Some(column) => column.clone(),
                    None => match self.table.term(sensor, line, &self.design.rows)? {
                        Some(column) => {
                            let moves = |name: &&str| crate::campaign::is_axis_input(&campaign.bench, name);
                            if !line.names().iter().any(moves) {
                                self.kept.insert(key, column.clone());
                            }
                            column
                        }
                        None => return Ok(owner.is_none()),
                    },
                }
            }
            (other, _) => indicator(campaign, &self.design.rows, other, sensor),
        };
        if column.iter().any(|value| !value.is_finite()) || column.iter().all(|value| *value == 0.0) {
            return Ok(owner.is_none());
        }
        column.resize(self.rows, 0.0);
        let existing = existing_coefficient(campaign, sensor, &kind);
        let own_name = |k: usize| campaign.parameters.get(k).map_or(String::new(), |p| p.id.clone());
        let coefficient = match (&kind, existing) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => own_name(*k),
            (_, Some(k)) => own_name(k),
            _ => self.coefficient(&fill(&effect.coefficient, filling), &regressor, sensor),
        };
        self.found.push(Candidate {
            regressor,
            name: fill(&effect.name, filling),
            coefficient,
            kind,
            sensor: owner,
            family: effect.term.clone(),
            // a term without {k} is no harmonic
            harmonic: filling.iter().find(|(key, _)| *key == "{k}").and_then(|(_, k)| k.parse().ok()).unwrap_or(0),
            rank: effect.rank,
            one_of_many: effect.one_of_many,
            why: fill(&effect.why, filling),
            confirm: fill(&effect.confirm, filling),
            existing,
            vanishing: false,
            visible: 1.0,
            size: 1.0,
            column,
        });
        Ok(owner.is_none())
    }

    fn jacobian(&self, parameter: usize) -> Vec<f64> {
        if parameter >= self.design.jacobian.ncols() {
            return vec![0.0; self.design.rows.len()];
        }
        self.design.jacobian.col_as_slice(parameter).to_vec()
    }

    fn step(&self, at: f64, sensor: usize) -> Vec<f64> {
        let column = self.campaign.readings.columns.iter().position(|c| c == "time_s");
        let time = |k: usize| {
            let row = self.campaign.readings.rows.get(k)?;
            row.columns.get(column?).copied().flatten()
        };
        let after = |k: usize| f64::from(time(k).is_some_and(|t| t >= at));
        self.design.rows.iter().map(|o| if o.sensor == sensor { after(o.reading) } else { 0.0 }).collect()
    }

    /// A coefficient's name that nothing else has.
    fn coefficient(&mut self, wanted: &str, regressor: &str, sensor: usize) -> String {
        let mut name: String = if wanted.is_empty() { format!("c_{regressor}") } else { wanted.to_string() }
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
            .collect();
        while name.contains("__") {
            name = name.replace("__", "_");
        }
        let mut name = name.trim_end_matches('_').to_string();
        if crate::bench::identifier(&name).is_err() {
            name = format!("c_{name}");
        }
        let taken = |name: &str| {
            let bench = &self.campaign.bench;
            self.named.contains(name)
                || self.campaign.parameter_index(name).is_some()
                || self.campaign.readings.columns.iter().any(|column| column == name)
                || bench.chain.iter().any(|link| link.name() == name)
                || bench.sensors.iter().any(|sensor| sensor.id == name)
        };
        if taken(&name)
            && let [_, _, ..] = self.campaign.bench.sensors.as_slice()
            && let Some(own) = self.campaign.bench.sensors.get(sensor)
        {
            name = format!("{name}_{}", own.id);
        }
        while taken(&name) {
            name.push_str("_1");
        }
        self.named.insert(name.clone());
        name
    }
}

/// The labels of positions, in order of first appearance; none where every reading has the same.
fn positions(campaign: &Campaign) -> Vec<String> {
    let mut seen = std::collections::HashSet::new();
    let labels = campaign.readings.rows.iter().map(|reading| reading.position.as_str());
    let labels: Vec<String> =
        labels.filter(|label| !label.is_empty() && seen.insert(*label)).map(str::to_string).collect();
    if labels.len() < 2 { Vec::new() } else { labels }
}

/// The coefficient, assumed zero, whose term the model line has already.
fn existing_coefficient(campaign: &Campaign, sensor: usize, kind: &Regressor) -> Option<usize> {
    coefficient(campaign, sensor, kind, |role| *role == Role::AssumedZero)
}

/// The coefficient in such a role whose term the model line has already.
pub(super) fn coefficient(
    campaign: &Campaign,
    sensor: usize,
    kind: &Regressor,
    is_in: impl Fn(&Role) -> bool,
) -> Option<usize> {
    let Regressor::Term(line) = kind else { return None };
    if line.text().contains('(') {
        return None;
    }
    let sorted = |powers: &[(String, f64)], without: &str| {
        let mut rest: Vec<(String, f64)> = powers.iter().filter(|(name, _)| name != without).cloned().collect();
        rest.sort_by(|a, b| a.0.cmp(&b.0));
        rest
    };
    let own = line.terms()?;
    let wanted = match own.as_slice() {
        [one] => sorted(&one.powers, ""),
        _ => return None,
    };
    let terms = campaign.bench.sensors.get(sensor)?.model.terms()?;
    campaign.parameters.iter().enumerate().find_map(|(k, parameter)| {
        let asked = is_in(&parameter.role) && parameter.kind == Kind::Coefficient;
        let has = |term: &crate::algebra::Term| {
            term.powers.iter().any(|(name, power)| *name == parameter.id && *power == 1.0)
                && sorted(&term.powers, &parameter.id) == wanted
        };
        (asked && terms.iter().any(has)).then_some(k)
    })
}
