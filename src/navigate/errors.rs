//! Errors of an inertial measurement unit and of the navigator's start, and their names.
//!
//! Each triad reads `measured = (1 + K) true + b + k2 true^2 + noise` (gyros `+ D f`, their acceleration-sensitive drift) in the body frame: the diagonal of `K` holds the
//! scale factor errors, the other elements the installation errors (`xy`: what of the y input the x sensor sees), `b` the bias,
//! `k2` the second-order coefficient of each sensor on its input, noise a white one (random walk of its integral).

use crate::elements::Elements;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// Which of the two triads, or the start.
    Instrument {
        /// Angular rate, rad/s.
        Gyro = "gyro",
        /// Specific force, m/s^2.
        Accelerometer = "accelerometer",
        /// What the navigator believes when it starts: its alignment, velocity and position.
        Start = "start",
    }
}

/// Errors of one triad, in SI units (rad/s or m/s^2) and body axes x right, y forward, z up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TriadErrors {
    /// Bias, rad/s or m/s^2.
    pub bias: [f64; 3],
    /// Row: the sensor; column: the input. Diagonal: scale factor error; off it: installation error, rad.
    pub matrix: [[f64; 3]; 3],
    /// Second-order coefficient of each sensor on its input, s/rad or s^2/m.
    pub square: [f64; 3],
    /// Random walk of the integrated reading, rad/sqrt(s) or (m/s)/sqrt(s); the square root of the noise density.
    pub random_walk: f64,
}

/// The errors of a navigator, when it starts and later, or standard uncertainties of them.
///
/// Attitude is the *phi* angle: the navigator's level frame is the true one turned by the small rotation `phi`, so that
/// its attitude is `C' = (I - phi x) C`. Velocity and position are computed minus true.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NavigationError {
    /// `phi` about east, north, up, rad.
    pub attitude: [f64; 3],
    /// East, north, m/s.
    pub velocity: [f64; 2],
    /// East, north, m on the ground.
    pub position: [f64; 2],
}

/// Errors of the whole unit, and of the navigator's start.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ImuErrors {
    /// Gyros.
    pub gyro: TriadErrors,
    /// Acceleration-sensitive drift of the gyros, rad/s for each m/s^2. Row: the gyro; column: the specific force.
    pub drift: [[f64; 3]; 3],
    /// Accelerometers.
    pub accelerometer: TriadErrors,
    /// The start.
    pub start: NavigationError,
}

vocabulary! {
    /// The kind of a deterministic error source.
    Kind {
        /// Constant offset.
        Bias = "bias",
        /// Scale factor error.
        ScaleFactor = "scale_factor",
        /// Installation error: a sensor's input axis leans towards another body axis.
        Installation = "installation",
        /// Second-order coefficient.
        SecondOrder = "second_order",
        /// Acceleration-sensitive drift of a gyro (IEEE 528), by the axis of the specific force.
        AccelerationSensitive = "acceleration_sensitive",
        /// Attitude at the start (tilts and azimuth).
        Attitude = "attitude",
        /// Velocity at the start.
        Velocity = "velocity",
        /// Position at the start.
        Position = "position",
    }
}

/// One number of [`ImuErrors`]: an error source with a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ErrorSource {
    /// The triad.
    pub instrument: Instrument,
    /// The kind.
    pub kind: Kind,
    /// The sensor's axis, 0 to 2; at the start east, north, up.
    pub axis: usize,
    /// The input's axis, 0 to 2; equal to `axis` unless the kind is an installation error or an acceleration-sensitive drift.
    pub input: usize,
}

/// Names of the axes of the body, and of those at the start.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
pub(super) const DIRECTIONS: [&str; 3] = ["east", "north", "up"];

impl ErrorSource {
    /// The deterministic sources: 24 of bias, scale factor and installation, then 6 second-order ones, then 9 acceleration-sensitive drifts.
    pub fn all() -> Vec<ErrorSource> {
        let mut sources = ErrorSource::first_order();
        for instrument in [Instrument::Gyro, Instrument::Accelerometer] {
            sources.extend((0..3).map(|axis| ErrorSource { instrument, kind: Kind::SecondOrder, axis, input: axis }));
        }
        for axis in 0..3 {
            let (instrument, kind) = (Instrument::Gyro, Kind::AccelerationSensitive);
            sources.extend((0..3).map(|input| ErrorSource { instrument, kind, axis, input }));
        }
        sources
    }

    /// The 24 sources of bias, scale factor and installation error.
    pub fn first_order() -> Vec<ErrorSource> {
        let mut sources = Vec::new();
        for instrument in [Instrument::Gyro, Instrument::Accelerometer] {
            for kind in [Kind::Bias, Kind::ScaleFactor] {
                sources.extend((0..3).map(|axis| ErrorSource { instrument, kind, axis, input: axis }));
            }
            for axis in 0..3 {
                let inputs = (0..3).filter(|&input| input != axis);
                sources.extend(inputs.map(|input| ErrorSource { instrument, kind: Kind::Installation, axis, input }));
            }
        }
        sources
    }

    /// The biases of the three gyros and the three accelerometers.
    pub(super) fn biases() -> Vec<ErrorSource> {
        ErrorSource::first_order().into_iter().filter(|source| source.kind == Kind::Bias).collect()
    }

    /// Their indices in the catalogue.
    pub(super) fn bias_indices() -> Vec<usize> {
        let is_bias = |(_, source): &(usize, ErrorSource)| source.kind == Kind::Bias;
        ErrorSource::catalogue().into_iter().enumerate().filter(is_bias).map(|(j, _)| j).collect()
    }

    /// The errors of the start: attitude, velocity and position, 7 sources.
    pub fn start() -> Vec<ErrorSource> {
        let source = |kind, axis| ErrorSource { instrument: Instrument::Start, kind, axis, input: axis };
        let kinds = [(Kind::Attitude, 3), (Kind::Velocity, 2), (Kind::Position, 2)];
        kinds.into_iter().flat_map(|(kind, axes)| (0..axes).map(move |axis| source(kind, axis))).collect()
    }

    /// All errors of a mission: the 39 sources of the unit, then the 7 of the start.
    pub fn catalogue() -> Vec<ErrorSource> {
        ErrorSource::all().into_iter().chain(ErrorSource::start()).collect()
    }

    /// The source of a name, if there is one.
    pub fn named(id: &str) -> Option<ErrorSource> {
        ErrorSource::catalogue().into_iter().find(|source| source.id() == id)
    }

    /// The group that the source belongs to, for example `gyro_scale_factor`.
    pub(crate) fn group(&self) -> String {
        format!("{}_{}", self.instrument, self.kind)
    }

    /// The source's name, for example `gyro_bias_x` or `accelerometer_installation_xy`.
    pub fn id(&self) -> String {
        let names = if self.instrument == Instrument::Start { DIRECTIONS } else { AXES };
        // an axis is 0, 1 or 2
        let axis = |i: usize| names.at(i);
        match self.kind {
            Kind::Installation | Kind::AccelerationSensitive => {
                format!("{}_{}{}", self.group(), axis(self.axis), axis(self.input))
            }
            _ => format!("{}_{}", self.group(), axis(self.axis)),
        }
    }

    /// The unit in which mission files and reports give the source.
    pub fn unit(&self) -> &'static str {
        match (self.instrument, self.kind) {
            (Instrument::Gyro, Kind::Bias) => "deg/h",
            (_, Kind::Bias) => "g",
            (_, Kind::ScaleFactor) => "1",
            (_, Kind::Installation | Kind::Attitude) => "arcsec",
            (Instrument::Gyro, Kind::SecondOrder) => "(deg/h)/(deg/s)^2",
            (_, Kind::SecondOrder) => "g/g^2",
            (_, Kind::AccelerationSensitive) => "(deg/h)/g",
            (_, Kind::Velocity) => "m/s",
            (_, Kind::Position) => "m",
        }
    }

    /// SI value (rad/s, m/s^2, 1, rad, s/rad, s^2/m, rad s/m, m/s, m) of one of [`ErrorSource::unit`].
    pub fn si_per_unit(&self) -> f64 {
        let degree = 1f64.to_radians();
        match (self.instrument, self.kind) {
            (Instrument::Gyro, Kind::Bias) => degree / 3600.0,
            (_, Kind::Bias) => super::earth::STANDARD_GRAVITY,
            (_, Kind::ScaleFactor | Kind::Velocity | Kind::Position) => 1.0,
            (_, Kind::Installation | Kind::Attitude) => degree / 3600.0,
            (Instrument::Gyro, Kind::SecondOrder) => 1.0 / (3600.0 * degree),
            (_, Kind::SecondOrder) => 1.0 / super::earth::STANDARD_GRAVITY,
            (_, Kind::AccelerationSensitive) => degree / 3600.0 / super::earth::STANDARD_GRAVITY,
        }
    }

    /// The largest size, SI, that a navigator's unit and start can have at all: no mission holds more.
    pub fn limit(&self) -> f64 {
        match (self.instrument, self.kind) {
            (Instrument::Accelerometer, Kind::Bias) => 10.0,
            (_, Kind::Velocity) => 100.0,
            (_, Kind::Position) => 1e5,
            (_, Kind::AccelerationSensitive) => 1e-2,
            _ => 0.1,
        }
    }

    /// The source's value in `errors`, SI.
    pub fn of(&self, errors: &ImuErrors) -> f64 {
        let mut copy = *errors;
        self.slot(&mut copy).map_or(0.0, |slot| *slot)
    }

    /// Set the source's value, SI.
    pub fn set(&self, errors: &mut ImuErrors, value: f64) {
        if let Some(slot) = self.slot(errors) {
            *slot = value;
        }
    }

    fn slot<'a>(&self, errors: &'a mut ImuErrors) -> Option<&'a mut f64> {
        if self.kind == Kind::AccelerationSensitive {
            return errors.drift.get_mut(self.axis).and_then(|row| row.get_mut(self.input));
        }
        let triad = match self.instrument {
            Instrument::Gyro => &mut errors.gyro,
            Instrument::Accelerometer => &mut errors.accelerometer,
            Instrument::Start => {
                return match self.kind {
                    Kind::Attitude => errors.start.attitude.get_mut(self.axis),
                    Kind::Velocity => errors.start.velocity.get_mut(self.axis),
                    Kind::Position => errors.start.position.get_mut(self.axis),
                    _ => None,
                };
            }
        };
        match self.kind {
            Kind::Bias => triad.bias.get_mut(self.axis),
            Kind::SecondOrder => triad.square.get_mut(self.axis),
            Kind::ScaleFactor | Kind::Installation => {
                triad.matrix.get_mut(self.axis).and_then(|row| row.get_mut(self.input))
            }
            Kind::Attitude | Kind::Velocity | Kind::Position | Kind::AccelerationSensitive => None,
        }
    }
}

impl ImuErrors {
    /// Only the sources that `keep` accepts; no noise.
    pub(crate) fn only(&self, keep: impl Fn(&ErrorSource) -> bool) -> ImuErrors {
        let mut kept = ImuErrors::default();
        for source in ErrorSource::catalogue().into_iter().filter(|source| keep(source)) {
            source.set(&mut kept, source.of(self));
        }
        kept
    }

    /// One source of the given SI value and nothing else.
    pub(crate) fn single(source: ErrorSource, value: f64) -> ImuErrors {
        let mut errors = ImuErrors::default();
        source.set(&mut errors, value);
        errors
    }

    /// The sources that are not zero.
    pub(crate) fn present(&self) -> Vec<ErrorSource> {
        ErrorSource::catalogue().into_iter().filter(|source| source.of(self) != 0.0).collect()
    }

    /// The same without random walks.
    pub(crate) fn noiseless(&self) -> ImuErrors {
        let mut errors = *self;
        errors.gyro.random_walk = 0.0;
        errors.accelerometer.random_walk = 0.0;
        errors
    }

    /// The same with a random walk of a triad in addition.
    pub(super) fn walking(mut self, instrument: Instrument, density: f64) -> ImuErrors {
        let triad = if instrument == Instrument::Gyro { &mut self.gyro } else { &mut self.accelerometer };
        triad.random_walk = triad.random_walk.hypot(density);
        self
    }

    /// Whether there is noise, which needs random numbers at every step.
    pub(crate) fn is_noisy(&self) -> bool {
        self.gyro.random_walk > 0.0 || self.accelerometer.random_walk > 0.0
    }
}
