//! Random effects beyond the noise of the readings: lines of sensors, joints, tilts and coefficients that deviate anew at each level of a factor.

use super::{Campaign, Kind, Reading, Readings, Role};
use crate::error::{Fault, Malformed, Result};
use crate::mix::Mix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// One random effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// What deviates.
    pub of: Deviating,
    /// How often it takes a new value.
    pub per: Per,
    /// How large its deviations are.
    pub size: Size,
    /// How deviations are correlated in time, if they are.
    pub over: Option<Over>,
    /// Factor from radians (or the parameter's or sensor's unit) to `unit`.
    pub shown: f64,
    /// Unit in which a person gave or wants the standard deviation.
    pub unit: String,
    /// Where the file has this line, for messages.
    pub place: String,
}

/// What deviates.
#[derive(Debug, Clone, PartialEq)]
pub enum Deviating {
    /// A sensor: an offset of its readings.
    Sensor(usize),
    /// A joint: its angle.
    Joint(usize),
    /// A tilt or coefficient, by parameter index: estimated, known or assumed zero.
    Parameter(usize),
    /// The noise of several sensors' values in one reading, correlated by this factor.
    Correlated(Vec<usize>, f64),
}

/// How often a deviation takes a new value.
#[derive(Debug, Clone, PartialEq)]
pub enum Per {
    /// At each reading.
    Reading,
    /// At each position; a reading without a label is a separate position.
    Position,
    /// Never: one deviation for the whole campaign.
    Campaign,
    /// At each value of this column of the readings, numbers or texts.
    Column(String),
}

/// How large deviations are.
#[derive(Debug, Clone, PartialEq)]
pub enum Size {
    /// Standard deviation, in radians or the parameter's or sensor's unit, and its degrees of freedom.
    Stated {
        /// Standard deviation.
        sd: f64,
        /// Degrees of freedom; infinite unless stated.
        dof: f64,
    },
    /// Estimated from the readings.
    Estimated,
    /// In this column of each reading, in degrees (`<joint>_u`).
    Column(String),
}

/// Correlation in time, `exp(-|dt|/tau)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Over {
    /// Column of the readings that holds the time.
    pub column: String,
    /// Correlation time in the column's unit; `None` where it is to be estimated.
    pub tau: Option<f64>,
}

/// What scatters beyond the readings' own noise: `of` something, `per` something, or correlated `over` a time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ScatterFile")]
pub struct ScatterRequest {
    /// A sensor, joint, tilt or coefficient; or several, each with deviations of its own.
    pub of: OneOrSeveral,
    /// `reading`, `position`, `campaign` or a column of the readings: how often it takes a new value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per: Option<String>,
    /// Standard deviation in `unit`, or `estimate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<NumberOrEstimate>,
    /// Degrees of freedom of a stated `u`; infinite unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<f64>,
    /// Unit of `u`; an angle needs one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The column that holds the time, where deviations are correlated as `exp(-|dt|/tau)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Correlation time in the unit of that column, or `estimate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau: Option<NumberOrEstimate>,
    /// Correlation between the sensors of one reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<f64>,
}

/// One name or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a name, or a list of names")]
pub enum OneOrSeveral {
    /// One.
    One(String),
    /// Several.
    Several(Vec<String>),
}

impl Default for OneOrSeveral {
    fn default() -> Self {
        OneOrSeveral::Several(Vec::new())
    }
}

/// A number, or the word `estimate`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number, or \"estimate\"")]
pub enum NumberOrEstimate {
    /// Stated.
    Number(f64),
    /// To be estimated from the readings.
    Estimate(EstimateWord),
}

/// The word `estimate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EstimateWord {
    /// From the readings.
    Estimate,
}

impl OneOrSeveral {
    fn names(&self) -> &[String] {
        match self {
            OneOrSeveral::One(name) => std::slice::from_ref(name),
            OneOrSeveral::Several(names) => names,
        }
    }
}

impl NumberOrEstimate {
    fn number(self) -> Option<f64> {
        if let NumberOrEstimate::Number(value) = self { Some(value) } else { None }
    }
}

impl Scatter {
    /// Is it a joint that deviates?
    pub(crate) fn is_of_a_joint(&self) -> bool {
        matches!(self.of, Deviating::Joint(_))
    }

    /// What deviates, by name.
    pub(crate) fn of_name(&self, campaign: &Campaign) -> String {
        let sensor = |k: &usize| campaign.sensor_id(*k).to_string();
        match &self.of {
            Deviating::Sensor(k) => sensor(k),
            // the line was resolved among these joints
            Deviating::Joint(k) => campaign.bench.joints().nth(*k).unwrap_or_default().to_string(),
            Deviating::Parameter(k) => campaign.parameter_id(*k).to_string(),
            Deviating::Correlated(list, _) => list.iter().map(sensor).collect::<Vec<_>>().join(", "),
        }
    }

    /// Name of the line in budgets: `beta per position`, `V over time_s`.
    pub(crate) fn name(&self, campaign: &Campaign) -> String {
        let of = self.of_name(campaign);
        match (&self.over, &self.of) {
            (Some(over), _) if self.per == Per::Campaign => format!("{of} over {}", over.column),
            (Some(over), _) => format!("{of} over {} per {}", over.column, self.per.name()),
            (None, Deviating::Correlated(..)) => format!("correlation of {of}"),
            (None, _) => format!("{of} per {}", self.per.name()),
        }
    }

    /// The line as a file states it; `None` for one from a column of the readings.
    pub(crate) fn request(&self, campaign: &Campaign) -> Option<ScatterRequest> {
        let estimate = NumberOrEstimate::Estimate(EstimateWord::Estimate);
        let per = Some(self.per.name().to_string());
        if let Deviating::Correlated(sensors, correlation) = &self.of {
            let of = OneOrSeveral::Several(sensors.iter().map(|k| campaign.sensor_id(*k).to_string()).collect());
            return Some(ScatterRequest { of, per, correlation: Some(*correlation), ..ScatterRequest::default() });
        }
        let (u, dof) = match self.size {
            Size::Stated { sd, dof } => (NumberOrEstimate::Number(sd * self.shown), dof.is_finite().then_some(dof)),
            Size::Estimated => (estimate, None),
            Size::Column(_) => return None,
        };
        Some(ScatterRequest {
            of: OneOrSeveral::One(self.of_name(campaign)),
            per: per.filter(|_| self.over.is_none() || self.per != Per::Campaign),
            u: Some(u),
            dof,
            unit: (!self.unit.is_empty()).then(|| self.unit.clone()),
            over: self.over.as_ref().map(|over| over.column.clone()),
            tau: self.over.as_ref().map(|over| over.tau.map_or(estimate, NumberOrEstimate::Number)),
            correlation: None,
        })
    }
}

impl Per {
    /// As files write it.
    pub(crate) fn name(&self) -> &str {
        match self {
            Per::Reading => "reading",
            Per::Position => "position",
            Per::Campaign => "campaign",
            Per::Column(column) => column,
        }
    }

    /// The level of each reading, counted from 0, and how many there are. `None` for a reading that lacks the column.
    pub fn levels(&self, campaign: &Campaign) -> (Vec<Option<usize>>, usize) {
        let rows = &campaign.readings.rows;
        let mut seen: HashMap<Cow<'_, str>, usize, BuildHasherDefault<Mix>> = HashMap::default();
        let mut next = 0;
        let mut fresh = || {
            next += 1;
            next - 1
        };
        let levels = match self {
            Per::Reading => rows.iter().map(|_| Some(fresh())).collect(),
            Per::Campaign => rows.iter().map(|_| Some(*seen.entry("".into()).or_insert_with(&mut fresh))).collect(),
            Per::Position => rows
                .iter()
                .map(|r| {
                    Some(match r.position.as_str() {
                        "" => fresh(),
                        label => *seen.entry(label.into()).or_insert_with(&mut fresh),
                    })
                })
                .collect(),
            Per::Column(name) => {
                let number = campaign.readings.columns.iter().position(|c| c == name);
                let named = |r| value(number, name, r).map(|text| *seen.entry(text).or_insert_with(&mut fresh));
                rows.iter().map(named).collect()
            }
        };
        (levels, next)
    }

    /// The level of a reading by name, where the factor links positions: empty for the whole campaign, the column's value else. `None` for a
    /// reading that lacks the column, and for factors that link none.
    pub(crate) fn level_name<'a>(&self, readings: &Readings, reading: &'a Reading) -> Option<Cow<'a, str>> {
        match self {
            Per::Campaign => Some("".into()),
            Per::Column(name) => value(readings.columns.iter().position(|c| c == name), name, reading),
            Per::Reading | Per::Position => None,
        }
    }
}

/// A column's value at a reading, a number or a text.
fn value<'a>(number: Option<usize>, name: &str, reading: &'a Reading) -> Option<Cow<'a, str>> {
    let numeric = number.and_then(|k| reading.columns.get(k).copied().flatten());
    let text = || reading.remarks.iter().find(|(key, _)| key == name).map(|(_, text)| text.as_str().into());
    numeric.map(|v| Cow::Owned((v + 0.0).to_string())).or_else(text)
}

impl Campaign {
    /// Add lines of scatter: one for each name that a request lists, and one for each column `<joint>_u`.
    ///
    /// Errors: names that the bench does not have, columns that the readings lack or that are constant, lines with the same effect, sizes that are
    /// not positive; each with its place.
    pub(crate) fn with_scatter(mut self, requests: Vec<ScatterRequest>) -> Result<Self> {
        for (k, request) in requests.into_iter().enumerate() {
            let place = format!("scatter[{k}]");
            for line in request.into_lines(&self, &place).map_err(|error| error.under(&place))? {
                self.add_scatter(line)?;
            }
        }
        let joints: Vec<String> = self.bench.joints().map(str::to_string).collect();
        for (joint, name) in joints.iter().enumerate() {
            let column = format!("{name}_u");
            let Some(k) = self.readings.columns.iter().position(|c| *c == column) else { continue };
            let bad = |r: &&super::Reading| r.columns.get(k).copied().flatten().is_some_and(|u| !(u >= 0.0));
            if let Some(reading) = self.readings.rows.iter().find(bad) {
                return Err(Malformed::new(Fault::Value, format!("{column} cannot be a standard uncertainty"))
                    .expected(format!("the standard uncertainty of {name}_deg in degrees, zero or positive"))
                    .at_path(format!("{}.{column}", reading.place)));
            }
            self.add_scatter(Scatter {
                of: Deviating::Joint(joint),
                per: Per::Position,
                size: Size::Column(column.clone()),
                over: None,
                shown: 180.0 / std::f64::consts::PI,
                unit: "deg".into(),
                place: format!("readings: {column}"),
            })?;
        }
        Ok(self)
    }

    /// Add one line; two with the same effect cannot be distinguished.
    pub(crate) fn add_scatter(&mut self, line: Scatter) -> Result<()> {
        let same = |other: &&Scatter| {
            let (a, b) = (&other.of, &line.of);
            let of = match (a, b) {
                (Deviating::Correlated(a, _), Deviating::Correlated(b, _)) => a.iter().any(|k| b.contains(k)),
                _ => a == b,
            };
            let over = other.over.as_ref().map(|o| &o.column) == line.over.as_ref().map(|o| &o.column);
            of && other.per == line.per && over
        };
        if let Some(other) = self.scatter.iter().find(same) {
            return Err(Malformed::new(Fault::Value, format!("{} scatters twice", line.name(self)))
                .expected("one line for each; two variances of the same deviations add up")
                .found(format!("the same at {}", other.place))
                .at_path(line.place.clone()));
        }
        if let (Deviating::Parameter(k), Per::Campaign, None) = (&line.of, &line.per, &line.over)
            && is_known_with_uncertainty(self, *k)
        {
            return Err(Malformed::new(
                Fault::Value,
                format!("{} is known with an uncertainty already", line.of_name(self)),
            )
            .expected("its u in \"known\", or a scatter line per campaign, not both")
            .at_path(line.place.clone()));
        }
        self.scatter.push(line);
        Ok(())
    }
}

impl ScatterRequest {
    /// Does one of the lines read a column?
    pub fn use_key(lines: &[ScatterRequest], key: &str) -> bool {
        lines.iter().any(|line| [&line.over, &line.per].into_iter().any(|column| column.as_deref() == Some(key)))
    }

    fn u(&self) -> Option<f64> {
        self.u.and_then(NumberOrEstimate::number)
    }

    fn tau(&self) -> Option<f64> {
        self.tau.and_then(NumberOrEstimate::number)
    }

    /// Is the size to be estimated?
    fn is_estimated(&self) -> bool {
        self.u.is_some() && self.u().is_none()
    }

    fn into_lines(self, campaign: &Campaign, place: &str) -> Result<Vec<Scatter>> {
        if self.of.names().is_empty() || self.of.names().iter().any(|name| name.trim().is_empty()) {
            return Err(Malformed::new(Fault::Missing, "a scatter line of nothing")
                .expected("\"of\": a sensor, joint, tilt or coefficient")
                .at_path("of"));
        }
        if let Some(correlation) = self.correlation {
            return self.correlated(campaign, correlation, place);
        }
        let over = self.over(campaign)?;
        let per = self.per(campaign, over.is_some())?;
        if self.u.is_none() {
            return Err(Malformed::new(Fault::Missing, "the size of the deviations is not stated")
                .expected("\"u\": a standard deviation, or \"estimate\"")
                .at_path("u"));
        }
        if let Some(u) = self.u().filter(|u| !(*u > 0.0 && u.is_finite())) {
            return Err(Malformed::new(Fault::Value, "a scatter line without a positive standard deviation")
                .expected("a positive number, or \"estimate\"; leave the line out where nothing scatters")
                .found(u.to_string())
                .at_path("u"));
        }
        if let Some(dof) = self.dof.filter(|dof| !(*dof > 0.0)) {
            return Err(Malformed::new(Fault::Value, "the degrees of freedom cannot be used")
                .expected("a positive number")
                .found(dof.to_string())
                .at_path("dof"));
        }
        if self.dof.is_some() && self.is_estimated() {
            return Err(Malformed::new(Fault::Value, "degrees of freedom of a standard deviation that is estimated")
                .expected("\"dof\" only with a stated \"u\": for an estimated one the readings determine it")
                .at_path("dof"));
        }
        let mut lines = Vec::new();
        for name in self.of.names() {
            let of = deviating(campaign, name)?;
            let (shown, unit) = self.unit(campaign, &of, name)?;
            let size = match self.u() {
                Some(u) => Size::Stated { sd: u / shown, dof: self.dof.unwrap_or(f64::INFINITY) },
                None => Size::Estimated,
            };
            lines.push(Scatter { of, per: per.clone(), size, over: over.clone(), shown, unit, place: place.into() });
        }
        Ok(lines)
    }

    fn correlated(self, campaign: &Campaign, correlation: f64, place: &str) -> Result<Vec<Scatter>> {
        let mut sensors = Vec::new();
        for name in self.of.names() {
            let Some(k) = campaign.bench.sensors.iter().position(|s| s.id == *name) else {
                return Err(unknown_name(campaign, name, "a correlation is between sensors of one reading"));
            };
            if sensors.contains(&k) {
                return Err(Malformed::new(Fault::Value, format!("'{name}' is listed twice")).at_path("of"));
            }
            sensors.push(k);
        }
        let least = if sensors.len() == 2 { -1.0 } else { 0.0 };
        if sensors.len() < 2 || !(correlation > least && correlation < 1.0) || correlation == 0.0 {
            return Err(Malformed::new(Fault::Value, "this is not a correlation of sensors")
                .expected("two sensors or more, and a number between -1 and 1 (between 0 and 1 for more than two)")
                .found(format!("{} of {}", correlation, self.of.names().join(", ")))
                .at_path("correlation"));
        }
        let other = self.per.as_deref().is_some_and(|per| per != "reading");
        if other || self.u.is_some() || self.over.is_some() {
            return Err(Malformed::new(Fault::Value, "only the noise of the readings can be correlated")
                .expected("\"of\", \"per\": \"reading\" and \"correlation\" alone; the sizes are those of the sensors' readings")
                .at_path("correlation"));
        }
        let stated = |k: &usize| {
            let rows = &campaign.readings.rows;
            let mut observations = rows.iter().flat_map(|r| &r.observations).filter(|o| o.sensor == *k);
            observations.all(|o| o.u.is_some())
        };
        if campaign.is_measured() && !sensors.iter().all(stated) {
            return Err(Malformed::new(
                Fault::Missing,
                "a correlation needs the standard uncertainties of the readings",
            )
            .expected(format!(
                "{} in every reading",
                self.of.names().iter().map(|s| format!("{s}_u")).collect::<Vec<_>>().join(", ")
            ))
            .at_path("correlation"));
        }
        Ok(vec![Scatter {
            of: Deviating::Correlated(sensors, correlation),
            per: Per::Reading,
            size: Size::Stated { sd: 1.0, dof: f64::INFINITY },
            over: None,
            shown: 1.0,
            unit: String::new(),
            place: place.into(),
        }])
    }

    fn over(&self, campaign: &Campaign) -> Result<Option<Over>> {
        let Some(column) = &self.over else {
            if self.tau.is_some() {
                return Err(Malformed::new(Fault::Missing, "a correlation time without an order of the readings")
                    .expected("\"over\": the column that holds the time, for example \"time_s\"")
                    .at_path("tau"));
            }
            return Ok(None);
        };
        let Some(k) = campaign.readings.columns.iter().position(|c| c == column) else {
            return Err(Malformed::new(
                Fault::UnknownName,
                format!("the readings have no column '{column}' of numbers"),
            )
            .expected("a column that holds the time of every reading")
            .found(format!("columns: {}", campaign.readings.columns.join(", ")))
            .at_path("over"));
        };
        if let Some(reading) = campaign.readings.rows.iter().find(|r| r.columns.get(k).copied().flatten().is_none()) {
            return Err(Malformed::new(
                Fault::Missing,
                format!("a reading has no {column}, and noise is correlated over it"),
            )
            .expected(format!("{column} in every reading"))
            .at_path(&reading.place));
        }
        if let Some(tau) = self.tau().filter(|tau| !(*tau > 0.0 && tau.is_finite())) {
            return Err(Malformed::new(Fault::Value, "the correlation time is not positive")
                .expected("a positive number in the unit of the column, or \"estimate\"")
                .found(tau.to_string())
                .at_path("tau"));
        }
        if self.tau.is_none() {
            return Err(Malformed::new(Fault::Missing, "the correlation time of the noise is not stated")
                .expected("\"tau\": a time in the unit of the column, or \"estimate\"")
                .at_path("over"));
        }
        Ok(Some(Over { column: column.clone(), tau: self.tau() }))
    }

    fn per(&self, campaign: &Campaign, correlated: bool) -> Result<Per> {
        let per = match self.per.as_deref() {
            None if correlated => return Ok(Per::Campaign),
            None => {
                return Err(Malformed::new(Fault::Missing, "when it takes a new value is not stated")
                    .expected("\"per\": \"reading\", \"position\", \"campaign\" or a column of the readings"));
            }
            Some("reading") => return Ok(Per::Reading),
            Some("position") => return Ok(Per::Position),
            Some("campaign") => return Ok(Per::Campaign),
            Some(column) => Per::Column(column.into()),
        };
        let (levels, count) = per.levels(campaign);
        let name = per.name();
        if campaign.readings.rows.is_empty() {
            return Ok(per);
        }
        if count == 0 {
            return Err(Malformed::new(Fault::UnknownName, format!("the readings have no column '{name}'"))
                .expected("reading, position, campaign, or a column of the readings")
                .found(format!("columns: {}", column_names(campaign)))
                .at_path("per"));
        }
        if let Some(k) = levels.iter().position(Option::is_none) {
            let place = campaign.place_of(k);
            return Err(Malformed::new(
                Fault::Missing,
                format!("a reading has no {name}, and something scatters per {name}"),
            )
            .expected(format!("{name} in every reading"))
            .found(format!("none in {place}"))
            .at_path("per"));
        }
        if count == 1 && levels.len() > 1 {
            return Err(Malformed::new(Fault::Value, format!("{name} is the same in all readings"))
                .expected("\"per\": \"campaign\" for one deviation of the whole campaign, or a column that changes")
                .at_path("per"));
        }
        if count == levels.len() && count > 1 {
            return Err(Malformed::new(Fault::Value, format!("{name} is different in every reading"))
                .expected("\"per\": \"reading\" for a deviation of each reading, or a column that repeats")
                .at_path("per"));
        }
        Ok(per)
    }

    /// Factor from internal units to the unit of `u`, and that unit.
    fn unit(&self, campaign: &Campaign, of: &Deviating, name: &str) -> Result<(f64, String)> {
        let internal = match of {
            Deviating::Joint(_) => "rad".to_string(),
            Deviating::Parameter(k) => campaign.parameter_unit(*k).to_string(),
            Deviating::Sensor(k) => campaign.sensor_unit(*k).to_string(),
            Deviating::Correlated(..) => String::new(),
        };
        let is_angle = match of {
            Deviating::Joint(_) => true,
            Deviating::Parameter(k) => campaign.parameters.get(*k).is_some_and(|p| p.kind == Kind::Tilt),
            _ => false,
        };
        let factor = |unit: &str| -> Result<f64> {
            let one = campaign.conversion(unit, &internal, name).map_err(|error| error.at_path("unit"))?.factor();
            Ok(1.0 / one)
        };
        match self.unit.as_deref() {
            Some(unit) => Ok((factor(unit)?, unit.to_string())),
            None if is_angle && self.is_estimated() => Ok((factor("arcsec")?, "arcsec".into())),
            None if is_angle => {
                Err(Malformed::new(Fault::Missing, format!("{name} is an angle, and its u has no unit"))
                    .expected("\"unit\": rad, deg, arcmin, arcsec or another unit of angle")
                    .at_path("u"))
            }
            None => Ok((1.0, internal.clone())),
        }
    }
}

fn column_names(campaign: &Campaign) -> String {
    let mut names: Vec<&str> = campaign.readings.columns.iter().map(String::as_str).collect();
    for (key, _) in campaign.readings.rows.iter().flat_map(|r| &r.remarks) {
        if !names.contains(&key.as_str()) {
            names.push(key);
        }
    }
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

/// What a name is on this bench.
fn deviating(campaign: &Campaign, name: &str) -> Result<Deviating> {
    if let Some(k) = campaign.bench.sensors.iter().position(|s| s.id == name) {
        return Ok(Deviating::Sensor(k));
    }
    if let Some(k) = campaign.bench.joints().position(|joint| joint == name) {
        return Ok(Deviating::Joint(k));
    }
    match campaign.parameter_index(name) {
        Some(k) => Ok(Deviating::Parameter(k)),
        None => Err(unknown_name(campaign, name, "and no other quantity can have a random effect")),
    }
}

fn unknown_name(campaign: &Campaign, name: &str, what: &str) -> Malformed {
    let sensors = campaign.bench.sensors.iter().map(|s| s.id.as_str());
    let parameters = campaign.parameters.iter().map(|p| p.id.as_str());
    let all = sensors.chain(campaign.bench.joints()).chain(parameters);
    Malformed::unknown(format!("'{name}' is not a sensor, joint, tilt or coefficient here ({what})"), name, all)
        .at_path("of")
}

/// Is this parameter known with an uncertainty? Then a line per campaign would count it twice.
fn is_known_with_uncertainty(campaign: &Campaign, k: usize) -> bool {
    campaign.parameters.get(k).is_some_and(|p| matches!(p.role, Role::Known(known) if known.u > 0.0))
}
