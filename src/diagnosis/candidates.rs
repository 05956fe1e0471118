//! Candidates: every member of the catalogue as a column of the system, at the point of linearisation; and how large each is here against
//! what its inputs could make of it: what is left of small tilts alone is small, and rounding is none.

use super::catalogue::{Effect, Filling, breaks, clock, fill, has, order};
use super::common::Settings;
use super::screen::{Chosen, Scanned};
use crate::algebra::{Scratch, Tape};
use crate::campaign::{Campaign, Kind, Role};
use crate::design::{DesignMatrix, Model};
use crate::error::{Fault, Malformed, Result};
use crate::simulate::{Regressor, Table, indicator, largest_inputs};

/// One effect that might be missing.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The appended term without its coefficient, as reports write it.
    pub regressor: String,
    /// Name in the field's words.
    pub name: String,
    /// Name of the coefficient in the repaired model line; for a tilt or a known parameter its own.
    pub coefficient: String,
    /// What the column is made from.
    pub kind: Regressor,
    /// The sensor that has it; `None` for what is common to all.
    pub sensor: Option<usize>,
    /// The catalogue's term with its placeholders.
    pub family: String,
    /// Order of a harmonic; 0 for what is none.
    pub harmonic: usize,
    /// Order among confounded effects, 0 first.
    pub rank: u8,
    /// Of how many members of its family in this sensor it is one, where they have the odds of one effect together; 1 otherwise.
    pub one_of: usize,
    /// Its coefficient, where only one is possible: what two exchanged values differ by.
    pub fixed: Option<f64>,
    /// Why it happens.
    pub why: String,
    /// How to confirm it.
    pub confirm: String,
    /// A coefficient that the model line has already, assumed zero.
    pub existing: Option<usize>,
    /// Is it small at every reading against what its inputs could make of it, so that only small tilts leave anything of it?
    pub vanishing: bool,
    /// Share of its column's weighted norm that the model leaves; 1 until an evidence has looked.
    pub visible: f64,
    /// Its largest value here over what its inputs could make of it; 1 for what is no term.
    pub size: f64,
    /// Its value at each row, `m`, zero at the rows of priors.
    pub column: Vec<f64>,
}

impl Candidate {
    /// A candidate of which nothing is said yet.
    pub(super) fn new(kind: Regressor, column: Vec<f64>) -> Self {
        Candidate {
            regressor: String::new(),
            name: String::new(),
            coefficient: String::new(),
            kind,
            sensor: None,
            family: String::new(),
            harmonic: 0,
            rank: 0,
            one_of: 1,
            fixed: None,
            why: String::new(),
            confirm: String::new(),
            existing: None,
            vanishing: false,
            visible: 1.0,
            size: 1.0,
            column,
        }
    }
}

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
        candidates: Vec::new(),
        seen: std::collections::HashSet::new(),
        named: std::collections::HashSet::new(),
    };
    for effect in catalogue {
        if effect.needs.iter().any(|column| !campaign.readings.columns.contains(column)) {
            continue;
        }
        maker.effect(effect)?;
    }
    let mut candidates = maker.candidates;
    let settings = Settings::default();
    let rounding = settings.roundings * f64::EPSILON;
    let bounds = sizes(campaign, design, &mut candidates, rounding);
    let mut bounds = bounds.into_iter();
    // a column of rounding is no column
    candidates.retain(|candidate| bounds.next().is_none_or(|bound| candidate.size > bound));
    for candidate in &mut candidates {
        candidate.vanishing = candidate.size < settings.vanishing;
    }
    Ok(candidates)
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
    candidates: Vec<Candidate>,
    seen: std::collections::HashSet<(String, Option<usize>)>,
    /// Names of coefficients that candidates have: two that are named together must not share one.
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
            let fillings = effect.fillings(campaign, sensor);
            let (places, scanned) = self.scanned(effect, k);
            let one_of = if effect.one_of_many { fillings.len() * places.max(1) } else { 1 };
            for filling in fillings {
                for (place, row) in &scanned {
                    let filling = [filling.as_slice(), place].concat();
                    let text = fill(&effect.term, &filling);
                    common = self
                        .member((effect, one_of), &filling, &text, k, *row)
                        .map_err(|e| e.at_path(format!("{}.term", effect.place)))?;
                }
            }
            if common {
                break;
            }
        }
        Ok(())
    }

    fn value(&self, reading: usize, sensor: usize) -> Option<f64> {
        let observations = &self.campaign.readings.rows.get(reading)?.observations;
        observations.iter().find(|o| o.sensor == sensor).map(|o| o.value)
    }

    /// In how many places of a sensor's readings it may be; and the placeholders of those that get a column, with the threshold of a step where it is one.
    fn scanned(&self, effect: &Effect, sensor: usize) -> (usize, Vec<(Filling, Option<f64>)>) {
        let has = |placeholder| effect.term.contains(placeholder);
        let readings: Vec<usize> =
            (0..self.campaign.readings.rows.len()).filter(|k| self.value(*k, sensor).is_some()).collect();
        let number = |k: usize| (k + 1).to_string();
        let is_chosen = |of: Scanned| self.chosen.has(&of);
        if has("{break}") {
            let breaks = breaks(self.campaign);
            let chosen = breaks.iter().filter(|(_, at)| is_chosen(Scanned::Break(sensor, at.to_bits())));
            (breaks.len(), chosen.map(|(text, at)| (vec![("{break}", text.clone())], Some(*at))).collect())
        } else if has("{other}") {
            let both = |(a, b)| (vec![("{reading}", number(a)), ("{other}", number(b))], None);
            let chosen = self.chosen.pairs(sensor).into_iter().map(both).collect();
            (readings.len() * readings.len().saturating_sub(1) / 2, chosen)
        } else if has("{reading}") {
            let chosen = readings.iter().filter(|k| is_chosen(Scanned::Reading(sensor, **k)));
            (readings.len(), chosen.map(|k| (vec![("{reading}", number(*k))], None)).collect())
        } else if has("{position}") {
            let positions = positions(self.campaign);
            let chosen = positions.iter().filter(|label| is_chosen(Scanned::Position(sensor, label.to_string())));
            (positions.len(), chosen.map(|label| (vec![("{position}", label.to_string())], None)).collect())
        } else {
            (1, vec![(Vec::new(), None)])
        }
    }

    /// Makes the candidate; tells whether it is common to all sensors.
    fn member(
        &mut self,
        (effect, one_of): (&Effect, usize),
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
        // a joint that moves in one sense only does not show what the other would do
        let is_one_sided = matches!(kind, Regressor::Approach(_))
            && !(column.iter().any(|value| *value > 0.0) && column.iter().any(|value| *value < 0.0));
        if is_one_sided || column.iter().any(|value| !value.is_finite()) || column.iter().all(|value| *value == 0.0) {
            return Ok(owner.is_none());
        }
        column.resize(self.rows, 0.0);
        let fixed = match kind {
            Regressor::Exchange(a, b) => self.value(a, sensor).zip(self.value(b, sensor)).map(|(a, b)| a - b),
            _ => None,
        };
        let existing = coefficient(campaign, sensor, &kind, |role| *role == Role::AssumedZero);
        let own_name = |k: usize| campaign.parameters.get(k).map_or(String::new(), |p| p.id.clone());
        let coefficient = match (&kind, existing) {
            (Regressor::Tilt(k) | Regressor::Known(k), _) => own_name(*k),
            (_, Some(k)) => own_name(k),
            _ => self.coefficient(&fill(&effect.coefficient, filling), &regressor, sensor),
        };
        self.candidates.push(Candidate {
            regressor,
            name: fill(&effect.name, filling),
            coefficient,
            sensor: owner,
            family: effect.term.clone(),
            // a term without {k} is no harmonic
            harmonic: order(filling).unwrap_or(0),
            rank: effect.rank,
            one_of,
            fixed,
            why: fill(&effect.why, filling),
            confirm: fill(&effect.confirm, filling),
            existing,
            ..Candidate::new(kind, column)
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
        let column = self.campaign.readings.columns.iter().position(|c| c == clock(self.campaign));
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
        let taken = |name: &str| self.named.contains(name) || has(self.campaign, name);
        if taken(&name)
            && let [_, _, ..] = self.campaign.bench.sensors.as_slice()
            && let Some(felt_by) = self.campaign.bench.sensors.get(sensor)
        {
            name = format!("{name}_{}", felt_by.id);
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
        let mut others: Vec<(String, f64)> = powers.iter().filter(|(name, _)| name != without).cloned().collect();
        others.sort_by(|a, b| a.0.cmp(&b.0));
        others
    };
    let terms = line.terms()?;
    let wanted = match terms.as_slice() {
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

/// Each candidate's largest value over what its inputs could make of it: gravity along the axis, the fastest rate, any angle; a tilt's largest
/// derivative over that of all tilts. Gives the size below which each is nothing but the rounding of its inputs.
///
/// A product or sum of few factors errs by few epsilon of the size of its terms; the sine of an angle by an epsilon of the angle in radians,
/// so that `sin(k*joint)` at k half turns is as large as that, and no larger.
fn sizes(campaign: &Campaign, design: &DesignMatrix, candidates: &mut [Candidate], rounding: f64) -> Vec<f64> {
    let largest = |column: &[f64]| column.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let tilts = campaign.parameters.iter().enumerate().filter(|(_, p)| p.kind == Kind::Tilt).map(|(k, _)| k);
    let columns = tilts.filter(|k| *k < design.jacobian.ncols()).map(|k| largest(design.jacobian.col_as_slice(k)));
    let of_tilts = columns.fold(0.0, f64::max);
    let joints = campaign.readings.rows.iter().flat_map(|row| row.joints.iter());
    let angle =
        joints.filter_map(|s| s.keys().0).map(|deg| deg.abs().to_radians()).fold(std::f64::consts::TAU, f64::max);
    let mut scratch = Scratch::default();
    let mut bounds = Vec::with_capacity(candidates.len());
    let natural_of = largest_inputs(campaign);
    for candidate in candidates {
        let here = largest(&candidate.column);
        let natural = match &candidate.kind {
            Regressor::Tilt(_) => of_tilts,
            Regressor::Known(k) => of_known(campaign, design, *k, of_tilts, &natural_of),
            Regressor::Term(line) => {
                let names = line.names();
                let inputs: Vec<f64> = names.iter().map(|name| natural_of(name)).collect();
                // of a harmonic the size is that of its factor
                let compiled = if candidate.harmonic > 0 { None } else { Tape::compile(line, &names).ok() };
                match compiled {
                    Some(tape) => tape.value(&inputs, &mut scratch).abs(),
                    None => names
                        .iter()
                        .zip(&inputs)
                        .filter(|(n, _)| !campaign.bench.joints().any(|j| j == **n))
                        .map(|(_, v)| *v)
                        .product(),
                }
            }
            _ => 0.0,
        };
        candidate.size = if natural > 0.0 { here / natural } else { 1.0 };
        let argument = if candidate.harmonic > 0 { candidate.harmonic as f64 * angle } else { 1.0 };
        bounds.push(rounding * argument.max(1.0));
    }
    bounds
}

/// The derivative of the model lines to a known parameter, with inputs as large as they could be: a scale factor whose input only small tilts
/// leave is as hard to see as a term of that input.
fn of_known(
    campaign: &Campaign,
    design: &DesignMatrix,
    parameter: usize,
    of_tilts: f64,
    natural_of: &dyn Fn(&str) -> f64,
) -> f64 {
    let Some(known) = campaign.parameters.get(parameter) else { return 0.0 };
    if known.kind == Kind::Tilt {
        return of_tilts;
    }
    let (mut scratch, mut natural) = (Scratch::default(), 0.0_f64);
    for sensor in &campaign.bench.sensors {
        let names = sensor.model.names();
        let Some(place) = names.iter().position(|name| *name == known.id) else { continue };
        let value = |name: &str| campaign.parameter_index(name).and_then(|k| design.point.get(k)).copied();
        let inputs: Vec<f64> = names.iter().map(|name| value(name).unwrap_or_else(|| natural_of(name))).collect();
        let Ok(tape) = Tape::compile(&sensor.model, &names) else { continue };
        let mut gradient = vec![0.0; names.len()];
        tape.gradient(&inputs, &mut scratch, &mut gradient);
        natural = natural.max(gradient.get(place).map_or(0.0, |slope| slope.abs()));
    }
    if natural.is_finite() { natural } else { 0.0 }
}
