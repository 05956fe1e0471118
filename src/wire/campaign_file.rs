//! The campaign file (`*.campaign.json`): what was measured on a bench, and what is asked.

use super::bounds_file::{self, ConstraintFile, LimitFile};
use super::readings_file::{ReadingFile, read_rows};
use super::shapes::shaped;
use super::{
    BenchFile, DerivedFile, Fetch, Folder, Named, SamplesFile, SiteFile, Source, WRONG_FORM, read_bench, read_readings,
};
use crate::algebra::Expression;
use crate::bench::{self, Bench};
use crate::campaign::{
    self, Asked, Campaign, Condition, Decision, Given, Identity, Instrument, Readings, Role, ScatterRequest,
    UnitUnderTest,
};
use crate::error::{Fault, Malformed, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A campaign: a bench, what is known, what is asked, and the readings. Without sensor values it is a schedule.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CampaignFile {
    /// A built-in bench id, the path of a bench file, or the bench itself.
    pub bench: BenchRef,
    /// The site of the bench; keys given here replace those of the bench.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub site: Option<SiteFile>,
    /// Relative standard uncertainties of the rates of turning joints in ppm; they replace the bench's.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub rate_u_ppm: Named<f64>,
    /// Known parameters with their Type B standard uncertainties.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub known: Named<KnownEntry>,
    /// Correlation coefficients of pairs of known parameters, `["kI", "V0", 0.6]`; pairs that are not named are independent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<(String, String, f64)>,
    /// Parameters to estimate.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub estimate: Named<Asked>,
    /// What must hold between estimated parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub constraints: Vec<ConstraintFile>,
    /// Quantities computed from parameters, each a line of algebra, or `{ "line", "unit" }`.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub derived: Named<DerivedFile>,
    /// Limits of estimated parameters and derived quantities: `[lower, upper]`, or `{ "between": [lower, upper], "unit": ... }`.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub limits: Named<LimitFile>,
    /// How conformity with the limits is decided: `simple` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<Decision>,
    /// The unit under test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<UnitUnderTest>,
    /// Date of the measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Place of the measurement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Who measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// Instruments and their traceability.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instruments: Vec<Instrument>,
    /// The procedure that was followed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub procedure: Option<String>,
    /// Conditions, for example `"temperature_c": 23.1`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub environment: BTreeMap<String, Condition>,
    /// A remark.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// What scatters beyond the readings' own noise, one line each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scatter: Vec<ScatterRequest>,
    /// The column of the readings that identifies the device: one fit for each of its values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// Columns of a table of readings or of samples that have other titles, by their key: `"theta_deg": "Winkel (deg)"`. A unit in
    /// brackets is converted to the key's.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub columns: Named<String>,
    /// The readings; or the path of a table with the same keys as columns (CSV, Parquet, Excel, MATLAB, HDF5); or samples that are reduced to readings.
    pub readings: ReadingsRef,
}

/// A bench by name, by path, or in full.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum BenchRef {
    /// Built-in id or path.
    Named(String),
    /// The bench itself.
    Inline(Box<BenchFile>),
}

/// Readings in this file or in a CSV file in the same folder.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum ReadingsRef {
    /// Path of a table.
    Path(String),
    /// One object for each reading.
    Inline(Vec<ReadingFile>),
    /// A record of samples and how it is reduced.
    Samples(Box<SamplesFile>),
}

impl Default for BenchRef {
    fn default() -> Self {
        BenchRef::Named(String::new())
    }
}

impl Default for ReadingsRef {
    fn default() -> Self {
        ReadingsRef::Inline(Vec::new())
    }
}

shaped!(
    BenchRef,
    "a built-in bench id, the path of a bench file, or a bench object",
    text: BenchRef::Named,
    object: |bench: BenchFile| BenchRef::Inline(Box::new(bench))
);

shaped!(
    ReadingsRef,
    "a list of readings, the path of a table, or { \"samples\": the path of a record, ... }",
    text: ReadingsRef::Path,
    list: ReadingsRef::Inline,
    object: |samples: SamplesFile| ReadingsRef::Samples(Box::new(samples))
);

/// An entry of that section.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum KnownEntry {
    /// `"from"`: the path of the JSON report of a fit, whose parameters are known with their u and covariance.
    From(String),
    /// A known parameter.
    Known(Given),
}

/// What is expected of it.
const KNOWN: &str = "an object { \"value\": ..., \"unit\": ..., \"u\": ... }";

shaped!(KnownEntry, KNOWN, text: KnownEntry::From, object: KnownEntry::Known);

/// What is taken from the report of an earlier fit.
#[derive(Deserialize)]
struct EarlierFit {
    parameters: Vec<EarlierParameter>,
    covariance: CovarianceFile,
}

#[derive(Deserialize)]
struct EarlierParameter {
    id: String,
    unit: String,
    value: Option<f64>,
    u: Option<f64>,
    #[serde(default)]
    dof: Option<f64>,
}

/// A covariance matrix.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "CovarianceReport")]
pub struct CovarianceFile {
    /// Names of the rows and columns.
    pub order: Vec<String>,
    /// The matrix, row by row, in products of the parameters' units (tilts in rad; correlations are pure numbers); null for what is not estimable.
    pub matrix: Vec<Vec<Option<f64>>>,
}

impl CampaignFile {
    /// Turn the file into a checked campaign, with the bench, the readings or the samples that it refers to.
    pub fn into_campaign(mut self, folder: &mut dyn Folder) -> Result<Campaign> {
        let bench = self.resolved_bench(&mut |name| folder.text(name))?;
        self.with_earlier(&mut |name| folder.text(name))?;
        let readings = match std::mem::replace(&mut self.readings, ReadingsRef::Inline(Vec::new())) {
            ReadingsRef::Inline(_) if !self.columns.is_empty() => {
                return Err(Malformed::new(
                    Fault::Value,
                    "\"columns\" names columns of a file, but the readings are in the campaign itself",
                )
                .expected("the path of a table as \"readings\", or no \"columns\"")
                .at_path("columns"));
            }
            ReadingsRef::Inline(rows) => read_rows(&bench, rows)?,
            ReadingsRef::Path(path) => {
                let table = folder.table(&path).map_err(|e| e.at_path("readings"))?;
                read_readings(&bench, table, &self.columns, &self.scatter)?
            }
            ReadingsRef::Samples(samples) => self.reduced(&bench, *samples, folder)?,
        };
        self.with(bench, readings)
    }

    /// Are the readings the rows of a record, which is streamed?
    pub fn has_rows(&self) -> bool {
        matches!(&self.readings, ReadingsRef::Samples(samples) if samples.is_rows())
    }

    /// The bench and the record of a campaign whose readings are the rows of it.
    ///
    /// Errors: a campaign of other readings, or of many devices.
    pub(super) fn rows(&self, folder: &mut dyn Folder) -> Result<(Bench, &SamplesFile)> {
        let samples = match &self.readings {
            ReadingsRef::Samples(samples) if samples.is_rows() => samples,
            _ => {
                return Err(Malformed::new(Fault::Value, "the readings are no samples as rows")
                    .expected("\"readings\": { \"samples\": the path of a record, \"as\": \"rows\" }")
                    .at_path("readings"));
            }
        };
        self.one_device()?;
        if !samples.columns.is_empty() && !self.columns.is_empty() {
            return Err(Malformed::new(Fault::Value, "\"columns\" occurs twice")
                .expected("\"columns\" of the campaign, or of its \"readings\"")
                .at_path("readings.columns"));
        }
        Ok((self.resolved_bench(&mut |name| folder.text(name))?, samples))
    }

    pub(super) fn one_device(&self) -> Result<()> {
        match self.by {
            None => Ok(()),
            Some(_) => {
                Err(Malformed::new(Fault::Value, "\"by\" separates devices, and a record of samples is of one device")
                    .expected("a table of readings for \"by\" (tumble reduce makes one of each record)")
                    .at_path("by"))
            }
        }
    }

    /// The bench where it stands in this campaign, checked.
    pub fn resolved_bench(&self, fetch: Fetch<'_>) -> Result<Bench> {
        let mut bench = match &self.bench {
            BenchRef::Inline(file) => file.clone().into_bench().map_err(|e| e.under("bench"))?,
            BenchRef::Named(name) => named_bench(name, fetch)?,
        };
        if let Some(site) = &self.site {
            bench.site = Some(site.clone().over(bench.site.as_ref()).into_site()?);
        }
        if !self.rate_u_ppm.is_empty() {
            bench.rate_u = self.rate_u_ppm.0.iter().map(|(joint, ppm)| (joint.clone(), ppm * 1e-6)).collect();
        }
        bench.checked()
    }

    /// The path of an earlier fit's report, where the known parameters name one, and those by their own names.
    fn known(&self) -> Result<(Option<&str>, Vec<(String, Given)>)> {
        let (mut from, mut known) = (None, Vec::new());
        for (id, entry) in &self.known.0 {
            let wrong = |found: String, expected: &str| {
                let error = Malformed::new(Fault::Value, WRONG_FORM).expected(expected);
                Err(error.found(found).at_path(format!("known.{id}")))
            };
            match (id.as_str(), entry) {
                ("from", KnownEntry::From(path)) => from = Some(path.as_str()),
                ("from", KnownEntry::Known(_)) => return wrong("an object".into(), "the path of the report of a fit"),
                (_, KnownEntry::From(text)) => return wrong(format!("the text {text:?}"), KNOWN),
                (_, KnownEntry::Known(given)) => known.push((id.clone(), given.clone())),
            }
        }
        Ok((from, known))
    }

    /// Take the known parameters of a fit's report, where the campaign names one.
    fn with_earlier(&mut self, fetch: Fetch<'_>) -> Result<()> {
        let (from, known) = self.known()?;
        let Some(path) = from.map(str::to_string) else { return Ok(()) };
        let source = fetch(&path).map_err(|e| e.at_path("known.from"))?;
        let earlier: EarlierFit = serde_json::from_str(&source.text).map_err(|error| {
            Malformed::new(Fault::Value, format!("'{path}' is not a report of a fit"))
                .expected("what tumble fit --json wrote")
                .found(error.to_string())
                .at_path("known.from")
        })?;
        let taken = |id: &str| known.iter().any(|(other, _)| other == id) || self.estimate.get(id).is_some();
        let entered: Vec<EarlierParameter> =
            earlier.parameters.into_iter().filter(|parameter| !taken(&parameter.id)).collect();
        let names = |k: usize| earlier.covariance.order.get(k).map(String::as_str).unwrap_or_default();
        let of = |id: &str| {
            entered.iter().find(|parameter| parameter.id == id).and_then(|parameter| parameter.u).filter(|u| *u > 0.0)
        };
        for (i, row) in earlier.covariance.matrix.iter().enumerate() {
            for (j, covariance) in row.iter().enumerate().take(i) {
                let (a, b) = (names(j), names(i));
                if let (Some(u_a), Some(u_b), Some(covariance)) = (of(a), of(b), covariance)
                    && *covariance != 0.0
                {
                    // rounding may leave a coefficient beyond one
                    self.correlations.push((a.into(), b.into(), (covariance / (u_a * u_b)).clamp(-1.0, 1.0)));
                }
            }
        }
        self.known.0.retain(|(id, _)| id != "from");
        for parameter in entered {
            let (Some(value), Some(u)) = (parameter.value, parameter.u) else {
                return Err(Malformed::new(
                    Fault::Missing,
                    format!("'{path}' has no value with u of '{}'", parameter.id),
                )
                .expected(format!(
                    "a fit that determines it, or \"{}\" in \"known\" or \"estimate\" here",
                    parameter.id
                ))
                .at_path("known.from"));
            };
            let unit = Some(parameter.unit).filter(|unit| !unit.is_empty());
            let known = Given { value, unit, u: Some(u), dof: parameter.dof, distribution: None };
            self.known.0.push((parameter.id, KnownEntry::Known(known)));
        }
        Ok(())
    }

    /// The campaign on its bench with these readings; its own are left aside.
    pub fn with(self, bench: Bench, readings: Readings) -> Result<Campaign> {
        let (from, known) = self.known()?;
        if let Some(path) = from {
            return Err(Malformed::new(
                Fault::Value,
                "\"from\" in \"known\" is for readings of one device: not for many devices, nor for rows of a record",
            )
            .expected("the values themselves in \"known\", each with its \"u\", and \"correlations\" between them")
            .found(format!("'{path}'"))
            .at_path("known.from"));
        }
        let request = campaign::Request { estimate: self.estimate.0, known, correlations: self.correlations };
        let mut campaign = Campaign::new(bench, request, readings)?;
        campaign.titles = self.columns.0.into_iter().collect();
        for (k, constraint) in self.constraints.into_iter().enumerate() {
            let constraint =
                constraint.into_constraint(&campaign).map_err(|e| e.under(&format!("constraints[{k}]")))?;
            campaign.constraints.push(constraint);
        }
        for quantity in campaign.bench.derived.clone() {
            let role =
                |name: &str| campaign.parameter_index(name).and_then(|k| campaign.parameters.get(k)).map(|p| &p.role);
            let given = |name: &str| matches!(role(name), Some(Role::Estimated { .. } | Role::Known(_)));
            let asked = |name: &str| matches!(role(name), Some(Role::Estimated { .. }));
            let names = quantity.line.names();
            let replaced = self.derived.0.iter().any(|(id, _)| *id == quantity.id);
            if !replaced && names.iter().all(|name| given(name)) && names.iter().any(|name| asked(name)) {
                let path = format!("bench.derived.{}", quantity.id);
                let derived = campaign::derived(&campaign, &quantity.id, quantity.line, quantity.unit.as_deref())
                    .map_err(|e| e.under(&path))?;
                campaign.derived.push(derived);
            }
        }
        for (id, line) in self.derived.0 {
            let (text, below, unit) = line.parts();
            let path = format!("derived.{id}{below}");
            let line = Expression::parse(&text).map_err(|e| e.at_path(&path))?;
            let derived = campaign::derived(&campaign, &id, line, unit.as_deref()).map_err(|e| {
                match e.place().path.as_str() {
                    "" => e.at_path(&path),
                    _ => e.under(&format!("derived.{id}")),
                }
            })?;
            campaign.derived.push(derived);
        }
        campaign.limits = bounds_file::limits(&campaign, self.limits)?;
        campaign.decision = self.decision.unwrap_or_default();
        campaign.by = self.by;
        campaign.identity = Identity {
            unit: self.unit,
            date: self.date,
            place: self.place,
            operator: self.operator,
            instruments: self.instruments,
            procedure: self.procedure,
            environment: self.environment,
            note: self.note,
        };
        campaign.with_scatter(self.scatter)
    }
}

/// A built-in bench, or one that `fetch` finds.
pub(super) fn named_bench(name: &str, fetch: Fetch<'_>) -> Result<Bench> {
    if let Some(built_in) = bench::built_in(name) {
        return read_bench(&Source { name: format!("{name} (built in)"), text: built_in.text.into() });
    }
    let looks_like_a_path = name.contains(['/', '\\', '.']);
    let source = fetch(name).map_err(|error| {
        let ids: Vec<&str> = bench::built_ins().iter().map(|b| b.id).collect();
        let what = if looks_like_a_path {
            format!("the bench file '{name}' cannot be read")
        } else {
            format!("no built-in bench is called '{name}', and no file has that name")
        };
        Malformed::new(Fault::File, what)
            .expected(format!("the path of a bench file (relative to this file), or a built-in id: {}", ids.join(", ")))
            .found(error.what().to_string())
            .at_path("bench")
    })?;
    read_bench(&source)
}
