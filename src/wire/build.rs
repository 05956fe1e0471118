//! Benches, campaigns and schedules in code: the same keys as in their files, one call each.

use super::folder::Texts;
use super::{
    BenchFile, BenchRef, CampaignFile, Cell, ConstraintFile, DerivedFile, DirectionFile, KnownEntry, LinkFile,
    ReadingFile, ReadingsRef, SensorFile, SiteFile, bench_file,
};
use crate::bench::{Axis, Bench, ForceUnit, RateUnit, Units};
use crate::campaign::{Asked, Campaign, Decision, Given, NumberOrEstimate, OneOrSeveral, ScatterRequest};
use crate::error::{Fault, Malformed, Result};

/// A bench in the making; see [`Bench::builder`].
#[derive(Debug, Clone)]
pub struct BenchBuilder {
    file: BenchFile,
}

/// A sensor in the making, for [`BenchBuilder::sensor`]: its unit, its model line, its axes.
#[derive(Debug, Clone)]
pub struct SensorBuilder {
    file: SensorFile,
}

impl Bench {
    /// A bench link by link, from the ground to the sensor; what a bench file says, in code.
    ///
    /// ```
    /// use tumble::bench::Axis;
    /// use tumble::wire::SensorBuilder;
    /// let bench = tumble::Bench::builder("rate-table")
    ///     .site_latitude(45.75)
    ///     .joint("gamma", Axis::Z)
    ///     .tilt("dtheta_x", Axis::X, "spin axis against the vertical, about x")
    ///     .sensor("V", SensorBuilder::new("V", "V0 + kI*w_I").axis("I", Axis::Z))
    ///     .build()?;
    /// assert_eq!((bench.joints().count(), bench.tilts().count()), (1, 1));
    /// # Ok::<(), tumble::Malformed>(())
    /// ```
    pub fn builder(id: impl Into<String>) -> BenchBuilder {
        BenchBuilder { file: BenchFile { id: id.into(), ..BenchFile::default() } }
    }
}

impl BenchBuilder {
    /// One line for a person.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.file.title = title.into();
        self
    }

    /// Geodetic latitude in degrees, north positive: with it the Earth turns (15.041067 deg/h), and gravity is 1 g.
    pub fn site_latitude(mut self, latitude_deg: f64) -> Self {
        self.file.site = Some(SiteFile { latitude_deg: Some(latitude_deg), ..self.file.site.unwrap_or_default() });
        self
    }

    /// Latitude, Earth rate and gravity, as a file states them.
    pub fn site(mut self, site: SiteFile) -> Self {
        self.file.site = Some(site);
        self
    }

    /// Units of `w_*` and `a_*` in the model lines; degrees per second and g unless said.
    pub fn units(mut self, rate: RateUnit, force: ForceUnit) -> Self {
        self.file.units = Units { rate, force };
        self
    }

    /// A commanded joint, the next rotation of the chain.
    pub fn joint(self, name: impl Into<String>, about: Axis) -> Self {
        self.link(Some(name.into()), None, about, String::new(), None)
    }

    /// An unknown small rotation, the next of the chain: a parameter in radians.
    pub fn tilt(self, name: impl Into<String>, about: Axis, meaning: impl Into<String>) -> Self {
        self.link(None, Some(name.into()), about, meaning.into(), None)
    }

    /// A tilt that follows the joints' angles: the rotation is the parameter times this line of algebra.
    pub fn tilt_times(self, name: impl Into<String>, about: Axis, line: impl Into<String>) -> Self {
        self.link(None, Some(name.into()), about, String::new(), Some(line.into()))
    }

    /// A sensor, by the key of its readings.
    pub fn sensor(mut self, id: impl Into<String>, sensor: SensorBuilder) -> Self {
        self.file.sensors.0.push((id.into(), sensor.file));
        self
    }

    /// Relative standard uncertainty of a turning joint's rate, ppm: one error of the table, common to all readings.
    pub fn rate_u_ppm(mut self, joint: impl Into<String>, ppm: f64) -> Self {
        self.file.rate_u_ppm.0.push((joint.into(), ppm));
        self
    }

    /// A quantity that every campaign derives where it can: a line of algebra in the parameters.
    pub fn derived(mut self, id: impl Into<String>, line: impl Into<String>) -> Self {
        self.file.derived.0.push((id.into(), DerivedFile::Line(line.into())));
        self
    }

    /// What a column of the readings is when the unit is in use, as a line of algebra in `w_*` and `a_*`.
    pub fn in_use(mut self, column: impl Into<String>, line: impl Into<String>) -> Self {
        self.file.in_use.0.push((column.into(), line.into()));
        self
    }

    /// The bench. Errors: what is wrong with it, with its place among the links and sensors.
    pub fn build(self) -> Result<Bench> {
        self.file.into_bench()
    }

    fn link(
        mut self,
        joint: Option<String>,
        tilt: Option<String>,
        about: Axis,
        is: String,
        times: Option<String>,
    ) -> Self {
        self.file.chain.push(LinkFile { joint, tilt, about, is, times });
        self
    }
}

impl SensorBuilder {
    /// A sensor whose reading, in this unit, is this line of algebra.
    pub fn new(unit: impl Into<String>, model: impl Into<String>) -> Self {
        let (unit, model) = (unit.into(), model.into());
        SensorBuilder { file: SensorFile { unit, model, ..SensorFile::default() } }
    }

    /// A named axis along one of the last frame; `w_<name>` and `a_<name>` are its inputs.
    pub fn axis(mut self, name: impl Into<String>, along: Axis) -> Self {
        self.file.axes.0.push((name.into(), DirectionFile::Axis(along)));
        self
    }

    /// A named axis by its direction cosines in the last frame.
    pub fn direction(mut self, name: impl Into<String>, cosines: [f64; 3]) -> Self {
        self.file.axes.0.push((name.into(), DirectionFile::Cosines(cosines)));
        self
    }

    /// The axis whose rate the sensor measures: where readings step it, a fit reports the errors of the scale factor.
    pub fn input_axis(mut self, axis: impl Into<String>) -> Self {
        self.file.input_axis = Some(axis.into());
        self
    }

    /// For the reading of a closed circle: its full turn, in the sensor's unit.
    pub fn turn(mut self, turn: f64) -> Self {
        self.file.turn = Some(turn);
        self
    }
}

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
    /// use tumble::campaign::{Asked, Given};
    /// use tumble::wire::{ReadingBuilder, SensorBuilder};
    /// use tumble::{Bench, Campaign, fit};
    /// let bench = Bench::builder("line").sensor("y", SensorBuilder::new("V", "a + b*x + c")).build()?;
    /// let at = |x: f64, y: f64| ReadingBuilder::new().column("x", x).value("y", y);
    /// let campaign = Campaign::builder(&bench)
    ///     .estimate("b")
    ///     .estimate_with("a", Asked { start: Some(1.0), ..Asked::default() })
    ///     .known_with("c", Given { value: 500.0, unit: Some("mV".into()), ..Given::default() })
    ///     .reading(at(0.0, 1.5))
    ///     .reading(at(1.0, 3.5))
    ///     .reading(at(2.0, 4.5))
    ///     .build()?;
    /// let line = fit(&campaign, &Default::default())?;
    /// let value = |id: &str| line.parameter(id).map(|own| own.value.unwrap());
    /// assert!((value("b")? - 1.5).abs() < 1e-14 && (value("a")? - 7.0 / 6.0).abs() < 1e-14);
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
    pub fn scatter(mut self, of: impl Into<String>, per: impl Into<String>, u: f64, unit: impl Into<String>) -> Self {
        self.file.scatter.push(ScatterRequest {
            of: OneOrSeveral::One(of.into()),
            per: Some(per.into()),
            u: Some(NumberOrEstimate::Number(u)),
            unit: Some(unit.into()),
            ..ScatterRequest::default()
        });
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
