//! Readings: one position of the bench, and the values of its sensors.

use super::shared::{Label, Shared};
use crate::error::{Fault, Malformed, Result};
use std::sync::Arc;

/// Most turns of one reading: a mean over part turns is taken panel by panel.
const MOST_TURNS: f64 = 10_000.0;

/// All readings of a campaign, in the file's order.
#[derive(Debug, Clone, Default)]
pub struct Readings {
    /// Names of the numeric columns that a model line may use, for example `time_s`.
    pub columns: Vec<String>,
    /// One entry for each reading.
    pub rows: Vec<Reading>,
}

/// One reading: the state of every joint, and the values read.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Label; readings that share it were taken without remounting. Empty if the file gives none.
    pub position: Label,
    /// State of each joint, in chain order.
    pub joints: Shared<JointState>,
    /// Values of the numeric columns, in the order of [`Readings::columns`]; `None` where the file has none.
    pub columns: Shared<Option<f64>>,
    /// What was read, in the bench's sensor order.
    pub observations: Shared<Observation>,
    /// Samples averaged into each value that is read here, or is to be; 1 unless stated.
    pub samples: f64,
    /// Standard uncertainties that a schedule states for values still to be read: sensor and `u`, in the bench's sensor order.
    pub planned_u: Shared<(usize, f64)>,
    /// Texts that are no inputs (operator, remark), carried along.
    pub remarks: Shared<(String, String)>,
    /// Where the file has this reading, for messages.
    pub place: Place,
}

/// Where a file has a reading, as messages begin with it.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Place {
    /// In no file.
    #[default]
    Nowhere,
    /// Number, from 0, in the `readings` of a campaign file.
    Entry(usize),
    /// A row of a table of this name: its line in a file of text, else its number, from 1.
    Row {
        /// Is the number that of a line?
        is_text: bool,
        /// Line or number.
        number: u64,
        /// Name of the file.
        file: Arc<str>,
    },
    /// Elsewhere, as a path.
    Path(Arc<str>),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Place::Nowhere => Ok(()),
            Place::Entry(k) => write!(f, "readings[{k}]"),
            // a column's name may follow
            Place::Row { is_text: true, number, file } => write!(f, "line {number} of {file}|"),
            Place::Row { is_text: false, number, file } => write!(f, "row {number} of {file}|"),
            Place::Path(path) => f.write_str(path),
        }
    }
}

impl From<Place> for String {
    fn from(place: Place) -> String {
        place.to_string()
    }
}

impl From<&Place> for String {
    fn from(place: &Place) -> String {
        place.to_string()
    }
}

/// One sensor's value at one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Index of the sensor in the bench.
    pub sensor: usize,
    /// The value, in the sensor's unit.
    pub value: f64,
    /// Its standard uncertainty, if stated.
    pub u: Option<f64>,
    /// Samples averaged into the value; 1 unless stated.
    pub samples: f64,
}

/// State of one joint during a reading. Angles in degrees (exact at quarter turns), rates in degrees per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointState {
    /// At rest.
    Held {
        /// Joint angle.
        angle_deg: f64,
    },
    /// It turned; the reading is the mean of the model line over whole turns.
    WholeTurns {
        /// Joint rate.
        rate_deg_s: f64,
    },
    /// It turned; the reading is the mean of the model line over `turns` turns from `start_deg`.
    PartTurns {
        /// Angle at the start.
        start_deg: f64,
        /// Joint rate; its sign is the sense.
        rate_deg_s: f64,
        /// How many turns, positive, not necessarily whole.
        turns: f64,
    },
    /// It turned; the reading is one sample as the joint passed this angle.
    Passing {
        /// Joint angle at the sample.
        angle_deg: f64,
        /// Joint rate.
        rate_deg_s: f64,
    },
}

/// A reading that says nothing.
impl Default for Reading {
    fn default() -> Self {
        Reading {
            position: Label::default(),
            joints: Shared::default(),
            columns: Shared::default(),
            observations: Shared::default(),
            samples: 1.0,
            planned_u: Shared::default(),
            remarks: Shared::default(),
            place: Place::Nowhere,
        }
    }
}

impl Readings {
    /// A further position with these joint states: no values, other columns as in `like`, and the columns of the joints
    /// (`<joint>_deg`, `<joint>_deg_s`, `<joint>_turns`) following the states.
    pub fn position(&self, joint_names: &[&str], like: &Reading, joints: impl Into<Shared<JointState>>) -> Reading {
        let joints = joints.into();
        let mut columns = like.columns.clone();
        for (name, state) in joint_names.iter().zip(&joints) {
            let (deg, _, turns) = state.keys();
            for (suffix, value) in [("_deg", deg), ("_deg_s", Some(state.rate_deg_s())), ("_turns", turns)] {
                let column = self.columns.iter().position(|c| c.strip_prefix(name) == Some(suffix));
                if let Some(slot) = column.and_then(|k| columns.get_mut(k)) {
                    *slot = value;
                }
            }
        }
        Reading { joints, columns, samples: like.samples, planned_u: like.unread().planned_u, ..Reading::default() }
    }
}

/// Joint states as the keys that a reading would have.
pub(crate) fn joint_keys<'a>(
    joints: impl Iterator<Item = &'a str>,
    states: &'a [JointState],
) -> impl Iterator<Item = (String, f64)> {
    let of = |(joint, state): (&'a str, &JointState)| {
        state.given().map(move |(suffix, value)| (format!("{joint}{suffix}"), value))
    };
    joints.zip(states).flat_map(of)
}

impl JointState {
    /// The same turning at another rate; `None` for a joint at rest.
    pub(crate) fn at_rate(&self, rate_deg_s: f64) -> Option<JointState> {
        match *self {
            JointState::Held { .. } => None,
            JointState::WholeTurns { .. } => Some(JointState::WholeTurns { rate_deg_s }),
            JointState::PartTurns { start_deg, turns, .. } => {
                Some(JointState::PartTurns { start_deg, rate_deg_s, turns })
            }
            JointState::Passing { angle_deg, .. } => Some(JointState::Passing { angle_deg, rate_deg_s }),
        }
    }

    /// The values of `<joint>_deg`, `<joint>_deg_s` and `<joint>_turns` in this state.
    pub fn keys(&self) -> (Option<f64>, Option<f64>, Option<f64>) {
        match *self {
            JointState::Held { angle_deg } => (Some(angle_deg), None, None),
            JointState::WholeTurns { rate_deg_s } => (None, Some(rate_deg_s), None),
            JointState::PartTurns { start_deg, rate_deg_s, turns } => (Some(start_deg), Some(rate_deg_s), Some(turns)),
            JointState::Passing { angle_deg, rate_deg_s } => (Some(angle_deg), Some(rate_deg_s), None),
        }
    }

    /// The angle at which it is held; `None` for one that turns.
    pub(crate) fn held_deg(&self) -> Option<f64> {
        match *self {
            JointState::Held { angle_deg } => Some(angle_deg),
            _ => None,
        }
    }

    /// What is given of these, with what a key has behind the joint's name.
    pub(crate) fn given(&self) -> impl Iterator<Item = (&'static str, f64)> + use<> {
        let (deg, deg_s, turns) = self.keys();
        let all = [("_deg", deg), ("_deg_s", deg_s), ("_turns", turns)];
        all.into_iter().filter_map(|(suffix, value)| Some((suffix, value?)))
    }

    /// Its identity, bit by bit; a negative zero is a zero.
    pub(crate) fn bits(&self) -> [u64; 3] {
        let (deg, deg_s, turns) = self.keys();
        [deg, deg_s, turns].map(|key| key.map_or(u64::MAX, |value| (value + 0.0).to_bits()))
    }

    /// The state with these `<joint>_deg`, `<joint>_deg_s` and `<joint>_turns`.
    ///
    /// Errors: `Missing` where neither angle nor rate is given, `Value` for a rate of zero without an angle, or turns that are not positive.
    pub(crate) fn from_keys(joint: &str, deg: Option<f64>, deg_s: Option<f64>, turns: Option<f64>) -> Result<Self> {
        if let Some(turns) = turns {
            if !(turns > 0.0) {
                return Err(Malformed::new(Fault::Value, format!("{joint}_turns must be positive"))
                    .expected("a positive number of turns; the sign of the rate is the sense")
                    .found(turns.to_string())
                    .at_path(format!("{joint}_turns")));
            }
            if turns > MOST_TURNS {
                return Err(Malformed::new(Fault::Value, format!("{joint}_turns is too large"))
                    .expected(format!(
                        "at most {MOST_TURNS} turns in one reading; a mean over so many is one over whole turns"
                    ))
                    .found(turns.to_string())
                    .at_path(format!("{joint}_turns")));
            }
            if deg_s.is_none_or(|rate| rate == 0.0) {
                return Err(Malformed::new(Fault::Missing, format!("{joint}_turns needs a rate"))
                    .expected(format!("{joint}_deg_s other than zero with {joint}_turns"))
                    .at_path(format!("{joint}_turns")));
            }
        }
        match (deg, deg_s, turns) {
            (None, None, _) => Err(Malformed::new(Fault::Missing, format!("the joint '{joint}' has no state"))
                .expected(format!("{joint}_deg (its angle) or {joint}_deg_s (its rate)"))
                .found("neither")),
            (Some(angle_deg), None | Some(0.0), None) => Ok(JointState::Held { angle_deg }),
            (None, Some(0.0), _) => {
                Err(Malformed::new(Fault::Missing, format!("the joint '{joint}' is at rest, but its angle is missing"))
                    .expected(format!(
                        "{joint}_deg with {joint}_deg_s = 0: a column that is empty where the joint turns (any angle, if no reading depends on it)"
                    ))
                    .found("a rate of zero and no angle")
                    .at_path(format!("{joint}_deg_s")))
            }
            (None, Some(rate_deg_s), None) => Ok(JointState::WholeTurns { rate_deg_s }),
            (_, Some(rate_deg_s), Some(turns)) if turns.fract() == 0.0 => Ok(JointState::WholeTurns { rate_deg_s }),
            (None, Some(_), Some(_)) => {
                Err(Malformed::new(Fault::Missing, format!("a part of a turn of '{joint}' needs its start"))
                    .expected(format!("{joint}_deg, the angle at the start"))
                    .at_path(format!("{joint}_turns")))
            }
            (Some(start_deg), Some(rate_deg_s), Some(turns)) => {
                Ok(JointState::PartTurns { start_deg, rate_deg_s, turns })
            }
            (Some(angle_deg), Some(rate_deg_s), None) => Ok(JointState::Passing { angle_deg, rate_deg_s }),
            (Some(angle_deg), None, Some(_)) => Ok(JointState::Held { angle_deg }),
        }
    }

    /// The joint's rate in degrees per second; zero at rest.
    pub fn rate_deg_s(&self) -> f64 {
        match *self {
            JointState::Held { .. } => 0.0,
            JointState::WholeTurns { rate_deg_s }
            | JointState::PartTurns { rate_deg_s, .. }
            | JointState::Passing { rate_deg_s, .. } => rate_deg_s,
        }
    }

    /// The same with the joint turning the other way; unchanged at rest.
    pub(crate) fn reversed(self) -> Self {
        self.at_rate(-self.rate_deg_s()).unwrap_or(self)
    }

    /// Is the reading a mean over this joint's turning?
    pub(crate) fn is_averaged(&self) -> bool {
        matches!(self, JointState::WholeTurns { .. } | JointState::PartTurns { .. })
    }
}

impl Reading {
    /// The same position without values; their stated uncertainties stay, as those of values to be read.
    pub(crate) fn unread(&self) -> Reading {
        let stated = self.observations.iter().filter_map(|o| Some((o.sensor, o.u?)));
        let planned_u = self.planned_u.iter().copied().chain(stated).collect();
        Reading { observations: Shared::default(), planned_u, ..self.clone() }
    }

    /// The standard uncertainty that is stated for a sensor's value here, read or still to be read.
    pub(crate) fn stated_u(&self, sensor: usize) -> Option<f64> {
        let read = self.observations.iter().find(|o| o.sensor == sensor);
        match read {
            Some(observation) => observation.u,
            None => self.planned_u.iter().find(|(k, _)| *k == sensor).map(|(_, u)| *u),
        }
    }

    /// Check that the means are well defined: at most one joint is averaged over, and none other turns meanwhile.
    pub(crate) fn check_turning(states: &[JointState], joints: &[&str]) -> Result<()> {
        if !states.iter().any(JointState::is_averaged) {
            return Ok(());
        }
        let turning = joints.iter().zip(states).filter(|(_, state)| state.rate_deg_s() != 0.0);
        let turning: Vec<&str> = turning.map(|(name, _)| *name).collect();
        if turning.len() > 1 {
            return Err(Malformed::new(Fault::Value, format!("two joints turn in one mean: {}", turning.join(" and ")))
                .expected("one turning joint for each averaged reading; give every turning joint its angle too for an instantaneous sample")
                .found(turning.iter().map(|name| format!("{name}_deg_s")).collect::<Vec<_>>().join(", ")));
        }
        Ok(())
    }
}
