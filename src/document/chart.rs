//! What a figure shows: the specification of a chart, drawn by `plot` where a page wants it.

use nalgebra::{Matrix3, Vector3};

/// A value and the half length of its error bar.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Interval {
    /// Name of the row.
    pub label: String,
    /// Value.
    pub value: f64,
    /// Expanded uncertainty.
    pub expanded: f64,
    /// Is the value held by a bound? Then the ends of the interval that the bounds leave, and an upright line at the value.
    pub at_bound: Option<[f64; 2]>,
}

/// A bar made of parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bar {
    /// Name of the row.
    pub label: String,
    /// Its parts, from the left.
    pub parts: Vec<Part>,
}

/// A part of a bar.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Part {
    /// Where it comes from; parts of one source have one colour.
    pub source: String,
    /// Evaluated by other means than the scatter of the readings.
    pub type_b: bool,
    /// Its length.
    pub size: f64,
}

/// A residual.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Residual {
    /// Number of the reading.
    pub number: usize,
    /// Its position label; neighbours that share it stand on one stripe.
    pub group: String,
    /// The residual.
    pub value: f64,
    /// Half width of the band that it should lie in; `None` where there is none.
    pub band: Option<f64>,
    /// Marked as far out.
    pub far: bool,
}

/// A reading's two residuals.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GapPoint {
    /// Group that it belongs to; neighbours of one group stand on one stripe.
    pub group: String,
    /// With the model as given.
    pub before: f64,
    /// With what was found; `None` where nothing was.
    pub after: Option<f64>,
    /// Half width of the noise band; `None` where the noise is unknown.
    pub band: Option<f64>,
}

/// The readings of one sensor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GapPanel {
    /// Title of its axis.
    pub title: String,
    /// Unit.
    pub unit: String,
    /// The readings, those of a group side by side.
    pub points: Vec<GapPoint>,
}

/// A curve.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub label: String,
    /// Points from left to right; those that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// Dashed, as the reference is.
    pub dashed: bool,
}

/// What a chart of one quantity over time shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// Its name.
    pub label: String,
    /// Unit of the values.
    pub unit: String,
    /// Year (2026.5), value and expanded uncertainty of each calibration.
    pub points: Vec<(f64, f64, f64)>,
    /// Two points of the trend, if it is shown.
    pub trend: Option<[(f64, f64); 2]>,
    /// Limits, if there are any.
    pub limits: Option<[f64; 2]>,
}

/// What a control chart shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Control {
    /// Name of the quantity.
    pub label: String,
    /// Unit of the values.
    pub unit: String,
    /// Name, mean and control distance (three standard deviations of a mean) of each lot, in order.
    pub lots: Vec<(String, f64, f64)>,
    /// Mean of all devices.
    pub mean: f64,
}

/// What a histogram shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Distribution {
    /// Name of the quantity.
    pub label: String,
    /// Unit of the values.
    pub unit: String,
    /// The values.
    pub values: Vec<f64>,
    /// Limits; infinite where there is none.
    pub limits: Option<[f64; 2]>,
    /// Mean and standard deviation of a normal curve to compare with: what the uncertainty of the devices' readings alone would leave.
    pub alone: Option<[f64; 2]>,
}

/// A point of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Abscissa, degrees.
    pub x: f64,
    /// Ordinate, degrees.
    pub y: f64,
    /// How many readings are taken there.
    pub readings: usize,
}

/// One averaging time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviationPoint {
    /// Averaging time, s.
    pub tau: f64,
    /// Deviation.
    pub value: f64,
    /// Ends of its interval.
    pub interval: Option<(f64, f64)>,
    /// Deviation of the fitted coefficients.
    pub fitted: Option<f64>,
}

/// A record over time, in steps of a picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordChart {
    /// Title of each channel, and its course: time in seconds, value.
    pub channels: Vec<(String, Vec<(f64, f64)>)>,
    /// Segments: first and last time, s.
    pub segments: Vec<(f64, f64)>,
    /// Time of the last sample, s.
    pub end: f64,
}

/// A joint of a bench in a drawing: a ring about its axis. Directions are east, north and up.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// Its name and state.
    pub label: String,
    /// The axis.
    pub axis: Vector3<f64>,
    /// Direction of its angle zero, square to the axis.
    pub zero: Vector3<f64>,
    /// Its angle; where it turns, that at which it begins.
    pub angle_deg: f64,
    /// Its rate; 0 for a joint at rest.
    pub rate_deg_s: f64,
}

/// A bench in one position.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// Joints, the outermost first.
    pub rings: Vec<Ring>,
    /// The unit's axes x, y, z as columns.
    pub unit: Matrix3<f64>,
    /// Input axes of the sensors, by name, along the unit's axes.
    pub inputs: Vec<(String, Vector3<f64>)>,
    /// Direction of the Earth's rotation; `None` where the bench has no site.
    pub earth_rate: Option<Vector3<f64>>,
}

impl Chart {
    /// Curves over time.
    pub(crate) fn curves(lines: &[Curve], what: &str, unit: &str, along: &str) -> Self {
        Chart::Curves(lines.to_vec(), [what, unit, along].map(String::from))
    }
}

/// A chart by its contents; titles are in the language of the document.
#[derive(Debug, Clone, PartialEq)]
pub enum Chart {
    /// Values with error bars on a common axis.
    Values(Vec<Interval>, String),
    /// Stacked bars: rows, title of the axis, unit, as wide as the page.
    Bars(Vec<Bar>, String, String, bool),
    /// Residuals in order before their bands: rows, title of the axis, unit.
    Residuals(Vec<Residual>, String, String),
    /// Studentized residuals against normal quantiles.
    Normal(Vec<f64>),
    /// A correlation matrix with its names.
    Correlation(Vec<String>, Vec<Vec<Option<f64>>>),
    /// Residuals before and after: panels, and what the readings are grouped by.
    Gap(Vec<GapPanel>, String),
    /// Curves: title and unit of the upright axis, title of the level one.
    Curves(Vec<Curve>, [String; 3]),
    /// A quantity over calendar time.
    History(History),
    /// A quantity over lots with its control limits.
    Control(Control),
    /// A quantity over devices.
    Distribution(Distribution),
    /// Deviations against averaging time, and the title of their axis.
    Deviations(Vec<DeviationPoint>, String),
    /// A record with its segments.
    Record(RecordChart),
    /// Positions over two joint angles: candidates, the given ones, better ones, titles of the axes.
    Positions([Vec<Spot>; 3], [String; 2]),
    /// A bench in one position.
    Scene(Scene),
}
