//! What a guide says while samples come and a position is held.

use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

vocabulary! {
    /// What the samples say of the bench.
    Holding {
        /// It moves.
        Moving = "moving",
        /// It stands, or turns at a constant rate, and is not read yet.
        Held = "held",
        /// It stands where it was read last: the next position may be set.
        Read = "read",
        /// It was read, and several positions agree with what was read: which one it is, is asked for.
        Which = "which",
        /// It was left before the uncertainty that is wanted was reached, and is not read.
        Left = "left",
    }
}

/// A position while samples come.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Held {
    /// What the bench does.
    pub state: Holding,
    /// Label of the position that it is taken for.
    pub position: String,
    /// Its setting.
    pub setting: String,
    /// How long it has been held, without guard times, s.
    pub held_s: f64,
    /// Time of the newest sample that this is of, s since the first row.
    #[serde(default)]
    pub until_s: f64,
    /// How much longer it is to be held, s; none where that is not known yet, or holding it does not reach what is wanted.
    pub wait_s: Option<f64>,
    /// Each sensor's mean so far.
    pub means: Vec<HeldMean>,
    /// Settings that agree, where it is asked for which one it is.
    pub candidates: Vec<String>,
}

/// The mean of a sensor so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldMean {
    /// The sensor.
    pub sensor: String,
    /// The mean, in `unit`.
    pub mean: f64,
    /// Its standard uncertainty, in `unit`.
    pub u: f64,
    /// The standard uncertainty that is wanted, in `unit`.
    pub wanted: f64,
    /// Unit of these.
    pub unit: String,
}

impl Held {
    /// A state alone.
    pub fn nothing(state: Holding) -> Self {
        let (position, setting) = Default::default();
        Held {
            state,
            position,
            setting,
            held_s: 0.0,
            until_s: 0.0,
            wait_s: None,
            means: Vec::new(),
            candidates: Vec::new(),
        }
    }
}
