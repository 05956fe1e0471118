//! What `tumble plan` is asked.

use crate::cli::one_of;
use crate::cli::pages::Pages;
use crate::plan::{Method, Order, Unit};
use clap::{ArgGroup, Args};
use std::path::PathBuf;

const UNITS: [(&str, Unit); 3] = [("reading", Unit::Reading), ("pair", Unit::Pair), ("mounting", Unit::Mounting)];
const METHODS: [(&str, Method); 2] = [("fedorov", Method::Fedorov), ("coordinate", Method::Coordinate)];
const ORDERS: [(&str, Order); 3] = [("given", Order::AsGiven), ("abba", Order::Abba), ("random", Order::Random)];

/// What to judge, what to look for and what to write.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("searched").multiple(true)), group(ArgGroup::new("refinable").multiple(true)))]
pub(in crate::cli) struct Arguments {
    /// The schedule; or a campaign, whose values are used for the noise only.
    pub(super) schedule: PathBuf,
    /// Standard deviation of one sample of a sensor, in its unit: V=9e-4 (divided by the root of n for a reading with n samples); or of a line of the
    /// schedule's scatter, in the line's unit: "beta per position=5". Repeat for each sensor or line.
    #[arg(long, value_name = "NAME=SD")]
    pub(super) noise: Vec<String>,
    /// A tilt with a random change at every remounting, and its standard deviation in arcsec: dtheta_y2=0.5.
    #[arg(long, value_name = "TILT=ARCSEC")]
    pub(super) remount: Vec<String>,
    /// Expected size of the tilts in arcsec: the uncertainty of known scale factors acts through them.
    #[arg(long, value_name = "ARCSEC", allow_negative_numbers = true)]
    pub(super) tilts: Option<f64>,
    /// Evaluate at this value of an estimated parameter (arcsec for a tilt): K=1.3. By default its fitted value, start, prior, or zero.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(super) at: Vec<String>,
    /// A catalogue of further effects to try with the built-in ones (`tumble schema effects` has its form).
    #[arg(long, value_name = "FILE")]
    pub(super) effects: Option<PathBuf>,
    /// Find the best schedule of N readings (not positions: a position read at four rates is four readings) at no more than the cost of the given
    /// schedule, in proportion if N is larger than its number of readings (--budget: another limit).
    #[arg(long, value_name = "N", group = "refinable", conflicts_with_all = ["add", "goal", "budget"])]
    pub(super) choose: Option<usize>,
    /// With --choose: no limit on the cost.
    #[arg(long, requires = "choose", conflicts_with = "budget")]
    pub(super) any_cost: bool,
    /// Keep the schedule and find the best N readings (not positions) to add.
    #[arg(long, value_name = "N", group = "refinable", conflicts_with = "goal")]
    pub(super) add: Option<usize>,
    /// Keep the schedule and find the positions to add (2, or --add N) that discriminate two effects: a_S a_S^2, or tilt:dtheta_z1 a_S.
    #[arg(long, num_args = 2, value_names = ["EFFECT", "EFFECT"], conflicts_with_all = ["choose", "goal", "budget"])]
    pub(super) separate: Vec<String>,
    /// The sensor that may have the effects of --separate, --find and --beside, where the bench has several.
    #[arg(long, value_name = "SENSOR")]
    pub(super) sensor: Option<String>,
    /// Find the fewest readings for a standard uncertainty: 1 (arcsec, every estimated angle), dtheta_y2=0.5 or gamma=1 for a derived angle
    /// (arcsec; its unit for a coefficient).
    #[arg(long, value_name = "[NAME=]U", groups = ["searched", "refinable"], conflicts_with = "budget")]
    pub(super) goal: Vec<String>,
    /// Find the fewest readings that detect an effect of this size with the probability of --power: a_S=1e-3, or tilt:dtheta_z2=20 (arcsec). It becomes
    /// one more unknown, with a limit on its uncertainty; can be combined with --goal.
    #[arg(long, value_name = "EFFECT=SIZE", groups = ["searched", "refinable"], conflicts_with_all = ["choose", "add", "separate", "budget"])]
    pub(super) find: Vec<String>,
    /// With --find: probability that an effect of that size is detected.
    #[arg(long, value_name = "P", default_value_t = 0.8, requires = "find")]
    pub(super) power: f64,
    /// Evaluate and search with this effect as one more unknown, so that the schedule is good with it and without it. Repeat for several.
    #[arg(long, value_name = "EFFECT")]
    pub(super) beside: Vec<String>,
    /// Find the best schedule that costs no more than COST, by the costs of --cost.
    #[arg(long, value_name = "COST", groups = ["searched", "refinable"], conflicts_with = "add", allow_negative_numbers = true)]
    pub(super) budget: Option<f64>,
    /// With --goal, --find or --budget: keep the schedule and add to it.
    #[arg(long, requires = "searched")]
    pub(super) keep: bool,
    /// With --goal or --find: find the cheapest schedule instead of the fewest readings.
    #[arg(long, requires = "searched", conflicts_with = "budget")]
    pub(super) cheapest: bool,
    /// With --goal or --find: largest number of readings that may be chosen.
    #[arg(long, value_name = "N", default_value_t = 600)]
    pub(super) most: usize,
    /// D (volume of the confidence ellipsoid), A (sum of the angles' variances), G (largest variance of a predicted reading), I (mean
    /// variance of the predicted readings), E (worst determined combination of the angles), or a quantity: dtheta_z2, gamma.
    #[arg(long, value_name = "D|A|G|I|E|NAME", default_value = "D")]
    pub(super) criterion: String,
    /// Then move the chosen angles between the candidates, in multiples of DEG, as long as the schedule improves (with --goal or --find this may
    /// save a reading).
    #[arg(long, value_name = "DEG", requires = "refinable", conflicts_with = "separate")]
    pub(super) refine: Option<f64>,
    /// Portions in which readings are chosen: single readings, both senses of a rate, all rates of a mounting.
    #[arg(long, default_value = "reading", value_parser = one_of(UNITS))]
    pub(super) unit: Unit,
    /// A schedule whose positions are the candidates (its lists sweep joints and rates); a sweep of the bench unless given.
    #[arg(long, value_name = "FILE")]
    pub(super) candidates: Option<PathBuf>,
    /// Step of the sweep over joints at rest.
    #[arg(long, value_name = "DEG", default_value_t = 45.0, allow_negative_numbers = true)]
    pub(super) step: f64,
    /// Further rates for the sweep, in deg/s, for every joint that the schedule turns: 5,-5,60,-60.
    #[arg(
        long,
        value_name = "RATES",
        value_delimiter = ',',
        allow_hyphen_values = true,
        conflicts_with = "candidates"
    )]
    pub(super) rates: Vec<f64>,
    /// A zone that no candidate may be in: alpha_deg=100:170 or alpha_deg=100:170,beta_deg=0:90 (both at once).
    #[arg(long, value_name = "ZONE")]
    pub(super) forbid: Vec<String>,
    /// How often one portion (see --unit) may be chosen.
    #[arg(long, value_name = "N")]
    pub(super) repeats: Option<usize>,
    /// Fedorov exchange, or coordinate exchange for very many candidates.
    #[arg(long, default_value = "fedorov", value_parser = one_of(METHODS))]
    pub(super) method: Method,
    /// Costs: mounting=10, rate=1, reading=1; soak=30 for the wait after each mounting; degree=0.02 for each degree, from one mounting to the
    /// next, of the joint that moves furthest.
    #[arg(long, value_name = "WHAT=COST")]
    pub(super) cost: Vec<String>,
    /// Number of starts of the exchange.
    #[arg(long, value_name = "N", default_value_t = 100)]
    pub(super) starts: usize,
    /// Seed; the same seed gives the same schedule.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    /// Order of the schedule found.
    #[arg(long, default_value = "abba", value_parser = one_of(ORDERS))]
    pub(super) order: Order,
    /// Write the schedule found (or, without a search, the given one in that order) as a campaign file.
    #[arg(short, long, value_name = "FILE")]
    pub(super) write: Option<PathBuf>,
    /// Write a run sheet of the same schedule: the mountings in order, each with a drawing, and empty cells for the values. The name ends in .html,
    /// .xlsx or .csv; the completed CSV is read as the readings (`fit CAMPAIGN --readings FILE`).
    #[arg(long, value_name = "FILE")]
    pub(super) sheet: Option<PathBuf>,
    #[command(flatten)]
    pub(super) pages: Pages,
    /// Also list every value with its leverage and minimal detectable bias.
    #[arg(long)]
    pub(super) readings: bool,
}
