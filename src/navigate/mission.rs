//! What is flown: the site, the step, the duration, the motion and the unit's errors, in SI units.

use super::errors::ImuErrors;
pub use super::motion::Site;
use super::motion::{Motion, Path};
use crate::error::{Fault, Malformed, Result};
use crate::number;

/// The fastest rotation that one step may hold, rad: beyond it the series of the attitude update lose digits.
const FASTEST_STEP: f64 = 0.05;
/// The local-level frame has no east or north at a pole; missions keep this far from one, rad.
const POLE_MARGIN: f64 = 1.0 * std::f64::consts::PI / 180.0;

/// A mission that has passed all checks.
#[derive(Debug, Clone, PartialEq)]
pub struct Mission {
    /// A person's name for it.
    pub title: String,
    /// Where it starts.
    pub site: Site,
    /// Time between two samples of the unit, s.
    pub step_s: f64,
    /// Number of steps.
    pub steps: u64,
    /// Steps between two rows of output.
    pub steps_per_row: u64,
    /// The motion.
    pub motion: Motion,
    /// Motions to compare with `motion`, in the mission's order.
    pub beside: Vec<Motion>,
    /// The unit's errors.
    pub errors: ImuErrors,
    /// Seed of the noise.
    pub seed: u64,
}

impl Mission {
    /// Check a mission: a regular latitude, a step, a duration, and motions that fit into both.
    ///
    /// `duration` and `row_interval` in s; both are rounded to an even number of steps, as the navigator takes samples in
    /// pairs. Errors: [`Malformed`] with the path of the
    /// key in a mission file.
    pub fn new(site: Site, step: f64, duration: f64, row_interval: f64, motion: Motion) -> Result<Mission> {
        let wrong = |what: &str, path: &str, expected: &str, found: f64| {
            Malformed::new(Fault::Value, what).at_path(path).expected(expected).found(format!("{found}"))
        };
        let limit = std::f64::consts::FRAC_PI_2 - POLE_MARGIN;
        if !(site.latitude_rad.abs() <= limit) {
            let found = site.latitude_rad.to_degrees();
            let what = "east and north are not defined at a pole";
            return Err(wrong(what, "site.latitude_deg", "a latitude from -89 to 89 degrees", found));
        }
        if !(site.longitude_rad.abs() <= 2.0 * std::f64::consts::PI) {
            let found = site.longitude_rad.to_degrees();
            return Err(wrong("not a longitude", "site.longitude_deg", "-360 to 360 degrees", found));
        }
        if !(-12e3..=100e3).contains(&site.altitude_m) {
            return Err(wrong("not an altitude", "site.altitude_m", "-12000 to 100000 m", site.altitude_m));
        }
        if !(1e-5..=10.0).contains(&step) {
            return Err(wrong("the step is not usable", "step_s", "0.00001 to 10 s", step));
        }
        if !(duration >= 2.0 * step && duration.is_finite()) {
            return Err(wrong("the mission has no duration", "duration_h", "at least two steps", duration / 3600.0));
        }
        if !(duration / step <= 1e13) {
            let expected = "at most 1e13 steps";
            return Err(wrong("the mission has too many steps", "duration_h", expected, duration / 3600.0));
        }
        if !(row_interval > 0.0 && row_interval.is_finite()) {
            return Err(wrong("rows need a time between them", "output_every_s", "more than 0 s", row_interval));
        }
        let pairs = |time: f64| 2 * number::count_u64((0.5 * time / step).round().max(1.0));
        let steps = pairs(duration);
        let steps_per_row = pairs(row_interval.min(duration));
        let mission = Mission {
            title: String::new(),
            site,
            step_s: step,
            steps,
            steps_per_row,
            motion: Motion::default(),
            beside: Vec::new(),
            errors: ImuErrors::default(),
            seed: 1,
        };
        mission.check_motion(&motion).map_err(|e| e.under("motion"))?;
        Ok(Mission { motion, ..mission })
    }

    /// The same mission with one motion more to compare with.
    pub(crate) fn beside(mut self, motion: Motion) -> Result<Mission> {
        let index = self.beside.len();
        self.check_motion(&motion).map_err(|e| e.under(&format!("beside[{index}]")))?;
        self.beside.push(motion);
        Ok(self)
    }

    /// Duration, s.
    pub(crate) fn duration(&self) -> f64 {
        self.steps as f64 * self.step_s
    }

    fn check_motion(&self, motion: &Motion) -> Result<()> {
        if !(motion.fastest_rate() * self.step_s <= FASTEST_STEP) {
            let what = "the step is too long for so fast a motion";
            return Err(Malformed::new(Fault::Value, what)
                .expected(format!("at most {FASTEST_STEP} rad of rotation in a step"))
                .found(format!("{:.3} rad", motion.fastest_rate() * self.step_s)));
        }
        if motion.shortest_period() < self.step_s / 100.0 {
            let what = "the motion is too fast for the step";
            return Err(Malformed::new(Fault::Value, what)
                .expected("periods of at least a hundredth of a step")
                .found(format!("{} s at a step of {} s", motion.shortest_period(), self.step_s)));
        }
        if let Path::Legs(legs) = &motion.path {
            return legs.check(self.site, self.step_s, self.duration());
        }
        Ok(())
    }
}
