//! What is asked of a plan.

use super::candidates::{Unit, Zone};
use super::criterion::Criterion;
use super::order::Order;
use crate::error::{Fault, Malformed, Result};
use std::sync::Arc;

/// How exchanges look for replacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// All candidates (Fedorov).
    #[default]
    Fedorov,
    /// Candidates that differ in the state of one joint (coordinate exchange): for very many candidates.
    Coordinate,
}

/// The request for a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Readings to choose; with a budget the most that may be chosen, and 0 for as many as it buys.
    pub readings: usize,
    /// What may be spent on what is chosen.
    pub budget: Option<f64>,
    /// May it cost more where nothing within the budget determines the unknowns?
    pub may_cost_more: bool,
    /// Best in what.
    pub criterion: Criterion,
    /// In what portions.
    pub unit: Unit,
    /// Which exchange.
    pub method: Method,
    /// How often one portion may be chosen.
    pub most_repeats: usize,
    /// Starts of the exchange.
    pub starts: usize,
    /// Seed of starts and random orders.
    pub seed: u64,
    /// Are angles moved between the candidates after the choice?
    pub refine: Option<Refinement>,
    /// Order of the result.
    pub order: Order,
    /// Called with the progress of the search.
    pub progress: Progress,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            readings: 0,
            budget: None,
            may_cost_more: false,
            criterion: Criterion::D,
            unit: Unit::Reading,
            method: Method::Fedorov,
            most_repeats: usize::MAX,
            starts: 100,
            seed: 1,
            refine: None,
            order: Order::Abba,
            progress: Progress::default(),
        }
    }
}

/// How finely angles are moved after the choice.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Angles move in multiples of this, in degrees.
    pub resolution_deg: f64,
    /// Where no position may lie.
    pub zones: Vec<Zone>,
}

impl Refinement {
    /// Errors: a resolution that is no positive angle.
    pub(super) fn check(&self) -> Result<()> {
        if self.resolution_deg > 0.0 && self.resolution_deg <= 90.0 {
            return Ok(());
        }
        Err(Malformed::new(Fault::Value, "the resolution of the angles is not valid")
            .expected("degrees, above 0 and at most 90")
            .found(self.resolution_deg.to_string())
            .argument("refine", "0.1"))
    }
}

/// Progress of a search: what is done, and of how much.
#[derive(Clone, Default)]
#[allow(clippy::type_complexity, reason = "the type of a callback, in one place")]
pub struct Progress(Option<Arc<dyn Fn(&str, usize, usize) + Send + Sync>>);

impl Progress {
    /// Call this after every batch of starts.
    pub(crate) fn new(tell: impl Fn(&str, usize, usize) + Send + Sync + 'static) -> Self {
        Progress(Some(Arc::new(tell)))
    }

    pub(super) fn tell(&self, what: &str, done: usize, of: usize) {
        if let Some(tell) = &self.0 {
            tell(what, done, of);
        }
    }
}

impl std::fmt::Debug for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.0.is_some() { "Progress(reported)" } else { "Progress(silent)" })
    }
}

/// The callback is not part of a question.
impl PartialEq for Progress {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
