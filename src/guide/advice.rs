//! What a guide says after each reading, and while samples come and a position is held.

use crate::campaign::JointState;
use crate::language::Sentence;
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

vocabulary! {
    /// What may have gone wrong at the bench.
    MistakeKind {
        /// A joint stood 180 degrees from where it was asked for.
        Turned = "turned-180",
        /// Another position of the schedule was set.
        OtherPosition = "another-position",
        /// A joint turned in the other sense.
        WrongSense = "wrong-sense",
        /// The settings of two joints were exchanged: turned about the wrong axis.
        ExchangedAxes = "exchanged-axes",
        /// The values of two sensors were exchanged.
        ExchangedSensors = "exchanged-sensors",
        /// A tilt moved, and stayed where it is, from a reading on.
        SlippedMounting = "slipped-mounting",
        /// One value, or all of one reading, are wrong by any amount.
        BadReading = "bad-reading",
        /// No mistake: the model lacks an effect.
        MissingEffect = "missing-effect",
    }
}

vocabulary! {
    /// Whether a reading agrees with the others.
    Agreement {
        /// The others predict it.
        Agrees = "agrees",
        /// It is further from what the others predict than chance allows.
        Disagrees = "disagrees",
        /// The others do not predict it yet.
        NotPredicted = "not-predicted",
    }
}

vocabulary! {
    /// Why a position comes next.
    Why {
        /// It tells most, for its cost: about the unknowns until all are determined, then about the goals and about what the model may lack.
        Information = "information",
        /// It tells explanations of the residuals apart.
        Discriminates = "tells-apart",
        /// The last reading does not agree: the same position again.
        Again = "again",
    }
}

vocabulary! {
    /// Why a guide ended.
    Ending {
        /// The goals are met, and nothing is missing or all of it is named.
        Reached = "reached",
        /// The readings that may still be taken at these positions cannot tell enough of what is still wanted.
        NothingToGain = "nothing-to-gain",
        /// The most readings were taken.
        MostReadings = "most-readings",
    }
}

/// What a guide says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Advice {
    /// Readings that stand.
    pub readings: usize,
    /// What their work cost, in the unit of the costs that were given.
    pub cost: f64,
    /// The newest reading, against the others.
    pub newest: Option<Newest>,
    /// Every estimated parameter.
    pub parameters: Vec<Estimated>,
    /// Every goal.
    pub goals: Vec<Progress>,
    /// What could have gone wrong, while a reading does not agree.
    pub mistake: Option<Mistake>,
    /// What the model lacks.
    pub diagnosis: Option<Lacks>,
    /// What the model in use leaves of every value.
    pub residuals: Vec<Residual>,
    /// What else the model may lack, the most probable first.
    pub suspected: Vec<Suspected>,
    /// Probability that nothing is missing, or that all of it is named.
    pub nothing_missing_or_named: f64,
    /// Effects of the catalogue that these readings could not have shown.
    pub unseen_effects: usize,
    /// The position to set next; none at the end.
    pub next: Option<Next>,
    /// Why no more is asked for.
    pub ended: Option<Ending>,
    /// Goals that no number of readings at these positions reaches.
    pub unreachable: Vec<String>,
}

/// The newest reading, against what the others predict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Newest {
    /// Number of the reading, from 1.
    pub reading: usize,
    /// Its position's label.
    pub position: String,
    /// Its setting.
    pub setting: String,
    /// Does it agree?
    pub agreement: Agreement,
    /// How far it is from what the others predict, all its values together, in standard deviations: the normal deviate that chance exceeds with
    /// probability `p`, which decides; negative where the value that is furthest off is below.
    pub deviation: Option<f64>,
    /// Probability of a difference as large by chance.
    pub p: Option<f64>,
    /// The probability below which it does not agree: their sum over all readings is the family-wise level.
    pub level: f64,
    /// What is odd about its other columns.
    pub remarks: Vec<Sentence>,
}

/// An estimated parameter so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimated {
    /// Its name.
    pub id: String,
    /// Its value, in `unit`; none while it is not estimable.
    pub value: Option<f64>,
    /// Its standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// Unit of both.
    pub unit: String,
}

/// What the model in use leaves of a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Residual {
    /// Number of the reading, from 1.
    pub reading: usize,
    /// The sensor.
    pub sensor: String,
    /// Value less prediction, in `unit`.
    pub residual: f64,
    /// Unit of the sensor.
    pub unit: String,
    /// The residual in standard deviations of the value.
    pub in_sd: f64,
}

/// An effect that the model may lack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Suspected {
    /// The term, as `diagnose` writes it.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// Its probability.
    pub probability: f64,
}

/// A goal and how far it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Progress {
    /// The parameter or derived quantity.
    pub id: String,
    /// Its value, in `unit`; none while it is not estimable.
    pub value: Option<f64>,
    /// Its standard uncertainty, in `unit`.
    pub u: Option<f64>,
    /// The standard uncertainty that is wanted, in `unit`.
    pub goal: f64,
    /// Unit of these.
    pub unit: String,
    /// Is it met?
    pub met: bool,
}

/// What may have gone wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Mistake {
    /// Number of the reading that does not agree, from 1.
    pub reading: usize,
    /// The kind of mistake, where it has a probability of at least 0.95.
    pub named: Option<MistakeKind>,
    /// Number of the reading at which it was made, where that has a probability of at least 0.95.
    pub at: Option<usize>,
    /// Probability that it is chance.
    pub chance: f64,
    /// Explanations, the most probable first: as many as have a probability of 0.95 together.
    pub explanations: Vec<Explanation>,
}

impl Mistake {
    /// Is a mistake at the bench named, and not an effect that the model lacks?
    pub(crate) fn is_named(&self) -> bool {
        self.named.is_some_and(|kind| kind != MistakeKind::MissingEffect)
    }

    /// The reading that is most probably wrong itself, with the probability that it is, where that is more than one half; without it the others may agree.
    pub fn culprit(&self) -> Option<(usize, f64)> {
        let wrong = |explanation: &&Explanation| {
            !matches!(explanation.kind, MistakeKind::SlippedMounting | MistakeKind::MissingEffect)
        };
        let share = |reading: usize| -> f64 {
            self.explanations
                .iter()
                .filter(wrong)
                .filter(|explanation| explanation.reading == reading)
                .map(|explanation| explanation.probability)
                .sum()
        };
        let readings =
            self.explanations.iter().filter(wrong).map(|explanation| (explanation.reading, share(explanation.reading)));
        readings.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, probability)| *probability > 0.5)
    }
}

/// One explanation of a reading that does not agree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Explanation {
    /// The kind of mistake.
    pub kind: MistakeKind,
    /// Number of the reading at which it was made, from 1.
    pub reading: usize,
    /// The setting, sensors, tilt or effect.
    pub what: String,
    /// Its probability.
    pub probability: f64,
    /// The setting as a value.
    #[serde(skip)]
    #[schemars(skip)]
    pub joints: Option<Vec<JointState>>,
}

/// What the model lacks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Lacks {
    /// The verdict, as `diagnose` says it.
    pub verdict: crate::diagnosis::Verdict,
    /// Sum of squares of the residuals over its degrees of freedom, the model as given: a ratio of variances, near 1 where nothing is missing.
    pub gap_before: Option<f64>,
    /// The same ratio of variances with the effects that are named.
    pub gap_after: Option<f64>,
    /// Effects that are named.
    pub effects: Vec<Named>,
}

/// An effect that is named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Named {
    /// The term, as `diagnose` writes it.
    pub regressor: String,
    /// Its name.
    pub name: String,
    /// Its coefficient, in `unit`.
    pub value: Option<f64>,
    /// Standard uncertainty of the coefficient, in `unit`.
    pub u: Option<f64>,
    /// Unit of both.
    pub unit: String,
    /// Probability that it, or one of its aliases, is there.
    pub probability: f64,
    /// What else it could be.
    pub aliases: Vec<String>,
}

/// The position to set next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Next {
    /// Label of the position.
    pub position: String,
    /// The setting, for a person.
    pub setting: String,
    /// The setting as keys of a reading, in the units that the keys name.
    pub set: std::collections::BTreeMap<String, f64>,
    /// Why this one.
    pub why: Why,
    /// Explanations that it tells apart.
    pub between: Vec<String>,
    /// What it is expected to tell, in nats (a pure number).
    pub information: Option<f64>,
    /// What setting and reading it costs, from where the bench stands, in the unit of the costs that were given.
    pub cost: f64,
}

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
