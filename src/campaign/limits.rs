//! Limits that a quantity must keep, and the rule by which it is judged.

use super::Campaign;
use crate::bench::Sensor;
use crate::vocabulary::vocabulary;

vocabulary! {
    /// How conformity is decided (JCGM 106:2012, ISO/IEC 17025 7.8.6).
    #[derive(Default)]
    Decision {
        /// Simple acceptance: the value inside the limits, whatever its uncertainty (JCGM 106, 8.2).
        #[default]
        Simple = "simple",
        /// Guard band w = U: pass where the value is inside by U, fail where it is outside by U (JCGM 106, 8.3).
        GuardU = "guard-u",
        /// Specific risk: pass where the probability of conformity is at least the level, fail where it is at most one minus it (JCGM 106, 7).
        Risk = "risk",
    }
}

vocabulary! {
    /// An error of a scale factor, from steps of rate (IEEE Std 528, IEEE Std 1431).
    ScaleFactor {
        /// Largest deviation from the straight line, over the full-scale output.
        Nonlinearity = "nonlinearity",
        /// Slopes of either sense, their difference over their mean.
        Asymmetry = "asymmetry",
        /// Largest difference of readings from below and from above, over the full-scale output.
        Hysteresis = "hysteresis",
        /// Standard deviation of the slopes of runs, over their mean.
        Repeatability = "repeatability",
    }
}

/// A quantity that limits apply to, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limited {
    /// An estimated parameter.
    Parameter(usize),
    /// A derived quantity.
    Derived(usize),
    /// An error of a scale factor, of those in `Campaign::scale_factor_errors`.
    ScaleFactor(usize),
}

impl Campaign {
    /// Names of the errors of scale factors that a fit may report: of each sensor with an input axis, by each joint.
    pub fn scale_factor_errors(&self) -> Vec<String> {
        let sensors = self.bench.sensors.iter().filter(|sensor| sensor.input_axis.is_some());
        let by_joint = |sensor: &Sensor, joint: &str| {
            let column = format!("{joint}_deg_s");
            ScaleFactor::ALL.map(|error| error.of(&sensor.id, &column))
        };
        sensors.flat_map(|sensor| self.bench.joints().flat_map(move |joint| by_joint(sensor, joint))).collect()
    }

    /// Those with limits, in the order of the limits: a device's row has them after the derived quantities.
    pub fn limited_errors(&self) -> Vec<String> {
        let of = |limit: &Limit| if let Limited::ScaleFactor(k) = limit.of { Some(k) } else { None };
        let limited: Vec<usize> = self.limits.iter().filter_map(of).collect();
        let names = if limited.is_empty() { Vec::new() } else { self.scale_factor_errors() };
        limited.into_iter().filter_map(|k| names.get(k).cloned()).collect()
    }
}

impl ScaleFactor {
    /// Its name among the results: `V_nonlinearity_gamma_deg_s`.
    pub fn of(self, sensor: &str, column: &str) -> String {
        format!("{sensor}_{self}_{column}")
    }
}

/// Limits of one quantity, in its internal unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The quantity.
    pub of: Limited,
    /// Lower limit, may be minus infinity.
    pub lower: f64,
    /// Upper limit, may be infinity.
    pub upper: f64,
}
