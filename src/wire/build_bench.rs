//! A bench in code: the same keys as in its file, one call each.

use super::{BenchFile, DerivedFile, DirectionFile, LinkFile, SensorFile, SiteFile};
use crate::bench::{Axis, Bench, ForceUnit, RateUnit, Units};
use crate::error::Result;

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
