//! A campaign or a schedule in code: the same keys as in its file, one call each.

use super::front::Texts;
use super::{
    BenchRef, CampaignFile, Cell, ConstraintFile, DerivedFile, KnownEntry, ReadingFile, ReadingsRef, bench_file,
};
use crate::bench::Bench;
use crate::campaign::{Asked, Campaign, Decision, Given, NumberOrEstimate, OneOrSeveral, ScatterRequest};
use crate::error::{Fault, Malformed, Result};

/// A campaign in the making; see [`Campaign::builder`].
#[derive(Debug, Clone)]
pub struct CampaignBuilder {
    file: CampaignFile,
}

/// A reading in the making, for [`CampaignBuilder::reading`]: the state of the joints, what was read, further columns.
#[derive(Debug, Clone, Default)]
pub struct ReadingBuilder {
    cells: ReadingFile,
}

impl Campaign {
    /// A campaign on this bench, parameter by parameter and reading by reading; without values read it is a schedule.
    ///
    /// ```
    /// use tumble::{Bench, Campaign, fit};
    /// use tumble::wire::{ReadingBuilder, SensorBuilder};
    /// let bench = Bench::builder("line").sensor("y", SensorBuilder::new("", "a + b*x")).build()?;
    /// let at = |x: f64, y: f64| ReadingBuilder::new().column("x", x).value("y", y);
    /// let campaign = Campaign::builder(&bench)
    ///     .estimate("a")
    ///     .estimate("b")
    ///     .reading(at(0.0, 1.0))
    ///     .reading(at(1.0, 3.0))
    ///     .reading(at(2.0, 4.0))
    ///     .build()?;
    /// assert!((fit(&campaign, &Default::default())?.parameter("b")?.value.unwrap() - 1.5).abs() < 1e-15);
    /// # Ok::<(), tumble::Malformed>(())
    /// ```
    pub fn builder(bench: &Bench) -> CampaignBuilder {
        let bench = BenchRef::Inline(Box::new(bench_file(bench)));
        CampaignBuilder { file: CampaignFile { bench, ..CampaignFile::default() } }
    }
}

impl CampaignBuilder {
    /// A parameter to estimate.
    pub fn estimate(self, id: impl Into<String>) -> Self {
        self.estimate_with(id, Asked::default())
    }

    /// A parameter to estimate, with a start or a prior.
    pub fn estimate_with(mut self, id: impl Into<String>, asked: Asked) -> Self {
        self.file.estimate.0.push((id.into(), asked));
        self
    }

    /// A known parameter with its Type B standard uncertainty, both in the unit that follows from the model line (a tilt in radians).
    pub fn known(self, id: impl Into<String>, value: f64, u: f64) -> Self {
        self.known_with(id, Given { value, u: Some(u), ..Given::default() })
    }

    /// A known parameter with its unit, degrees of freedom or distribution.
    pub fn known_with(mut self, id: impl Into<String>, known: Given) -> Self {
        self.file.known.0.push((id.into(), KnownEntry::Known(known)));
        self
    }

    /// A quantity computed from parameters, a line of algebra; in the unit that follows from theirs.
    pub fn derived(mut self, id: impl Into<String>, line: impl Into<String>) -> Self {
        self.file.derived.0.push((id.into(), DerivedFile::of(line.into(), None)));
        self
    }

    /// The same in a unit of its own.
    pub fn derived_in(mut self, id: impl Into<String>, line: impl Into<String>, unit: impl Into<String>) -> Self {
        self.file.derived.0.push((id.into(), DerivedFile::of(line.into(), Some(unit.into()))));
        self
    }

    /// Something that must hold between estimated parameters.
    pub fn constraint(mut self, constraint: ConstraintFile) -> Self {
        self.file.constraints.push(constraint);
        self
    }

    /// Limits of an estimated parameter or derived quantity, in its own unit (a tilt in radians); `None` for no limit.
    pub fn limits(mut self, id: impl Into<String>, lower: Option<f64>, upper: Option<f64>) -> Self {
        self.file.limits.0.push((id.into(), super::LimitFile::Bare([lower, upper])));
        self
    }

    /// How conformity with the limits is decided; simple acceptance unless said.
    pub fn decision(mut self, decision: Decision) -> Self {
        self.file.decision = Some(decision);
        self
    }

    /// What scatters beyond the readings' own noise: standard deviation `u` in `unit`, a new value per `reading`, `position`, `campaign` or column.
    pub fn scatter(self, of: impl Into<String>, per: impl Into<String>, u: f64, unit: impl Into<String>) -> Self {
        self.scatter_with(ScatterRequest {
            of: OneOrSeveral::One(of.into()),
            per: Some(per.into()),
            u: Some(NumberOrEstimate::Number(u)),
            unit: Some(unit.into()),
            ..ScatterRequest::default()
        })
    }

    /// The same with all that a file can say: several at once, estimated, correlated in time.
    pub fn scatter_with(mut self, line: ScatterRequest) -> Self {
        self.file.scatter.push(line);
        self
    }

    /// One reading, or one position of a schedule.
    pub fn reading(mut self, reading: ReadingBuilder) -> Self {
        if let ReadingsRef::Inline(rows) = &mut self.file.readings {
            rows.push(reading.cells);
        }
        self
    }

    /// Several.
    pub fn readings(self, readings: impl IntoIterator<Item = ReadingBuilder>) -> Self {
        readings.into_iter().fold(self, CampaignBuilder::reading)
    }

    /// The campaign. Errors: what is wrong with it, with its place (`readings[3].V`).
    pub fn build(self) -> Result<Campaign> {
        self.file.into_campaign(&mut Texts(&mut |name| {
            Err(Malformed::new(Fault::File, format!("'{name}' is a file, and a campaign in code refers to none")))
        }))
    }
}

impl ReadingBuilder {
    /// A reading of which nothing is said.
    pub fn new() -> Self {
        Self::default()
    }

    /// The label of its position; readings that share one were taken without remounting.
    pub fn position(self, label: impl Into<String>) -> Self {
        self.cell("position", Cell::Text(label.into()))
    }

    /// A joint that stands at an angle, degrees.
    pub fn at(self, joint: &str, angle_deg: f64) -> Self {
        self.cell(format!("{joint}_deg"), Cell::Number(angle_deg))
    }

    /// A joint that turns at a rate, degrees per second; what is read is the mean over whole turns.
    pub fn turning(self, joint: &str, rate_deg_s: f64) -> Self {
        self.cell(format!("{joint}_deg_s"), Cell::Number(rate_deg_s))
    }

    /// What a sensor read, in its unit.
    pub fn value(self, sensor: &str, value: f64) -> Self {
        self.cell(sensor, Cell::Number(value))
    }

    /// What a sensor read, with its standard uncertainty.
    pub fn value_u(self, sensor: &str, value: f64, u: f64) -> Self {
        self.value(sensor, value).cell(format!("{sensor}_u"), Cell::Number(u))
    }

    /// How many samples were averaged.
    pub fn samples(self, n: f64) -> Self {
        self.cell("n", Cell::Number(n))
    }

    /// A further column (`time_s`, `temperature_c`, a run's number), which a model line may use.
    pub fn column(self, name: &str, value: f64) -> Self {
        self.cell(name, Cell::Number(value))
    }

    fn cell(mut self, key: impl Into<String>, cell: Cell) -> Self {
        self.cells.0.push((key.into(), cell));
        self
    }
}
