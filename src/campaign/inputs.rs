//! Inputs of the bench that are known with an uncertainty: gravity, latitude, the rates of turning joints. Each is a known parameter
//! with a separate budget line; its value is that of the bench, so predictions include it already.

use super::{Campaign, Distribution, JointState, Kind, Known, Parameter, Role};
use crate::bench::Bench;

/// The name of gravity as an input.
pub(crate) const GRAVITY: &str = "site.gravity";
/// The name of the latitude as an input.
pub(crate) const LATITUDE: &str = "site.latitude";
/// Prefix of a joint's name for the relative error of its rate.
pub const RATE: &str = "rate.";

impl Parameter {
    /// The inputs of a bench that have an uncertainty and that a model line sees.
    pub(super) fn inputs(bench: &Bench) -> Vec<Parameter> {
        let sees = |kind: &str| {
            bench
                .sensors
                .iter()
                .any(|s| s.model.names().iter().any(|name| name.starts_with(kind) && super::is_axis_input(bench, name)))
        };
        let (rate, force) = (sees("w_"), sees("a_"));
        let input = |id: String, value: f64, u: f64, unit: &str, meaning: String| {
            let known = Known { value, u, dof: f64::INFINITY, distribution: Distribution::Normal };
            Parameter { id, kind: Kind::Input, unit: unit.into(), meaning, role: Role::Known(known) }
        };
        let mut inputs = Vec::new();
        if let Some(site) = bench.site {
            let per_g = bench.units.force.per_g();
            if site.gravity_u_g > 0.0 && force {
                let (value, u) = (site.gravity_g * per_g, site.gravity_u_g * per_g);
                inputs.push(input(GRAVITY.into(), value, u, bench.units.force.name(), "local gravity".into()));
            }
            if site.latitude_u_deg > 0.0 && site.earth_rate_deg_h > 0.0 && rate {
                let (value, u) = (site.latitude_deg.to_radians(), site.latitude_u_deg.to_radians());
                inputs.push(input(LATITUDE.into(), value, u, "rad", "geodetic latitude".into()));
            }
        }
        for (joint, u) in bench.rate_u.iter().filter(|(_, u)| *u > 0.0 && rate) {
            inputs.push(input(
                format!("{RATE}{joint}"),
                0.0,
                *u,
                "1",
                format!("relative error of the rate of {joint}"),
            ));
        }
        inputs
    }
}

impl Campaign {
    /// Move an input of the bench, as [`Kind::Input`] parameters name them, by an amount in its parameter's unit.
    pub(crate) fn shift_input(&mut self, id: &str, amount: f64) {
        let per_g = self.bench.units.force.per_g();
        if let Some(joint) = id.strip_prefix(RATE) {
            let joint = self.bench.joints().position(|other| other == joint);
            let states = self.readings.rows.iter_mut().filter_map(|row| row.joints.get_mut(joint?));
            let faster = |state: &JointState| state.at_rate(state.rate_deg_s() * (1.0 + amount)).unwrap_or(*state);
            states.for_each(|state| *state = faster(state));
        } else if let Some(site) = self.bench.site.as_mut() {
            match id {
                GRAVITY => site.gravity_g += amount / per_g,
                LATITUDE => site.latitude_deg += amount.to_degrees(),
                _ => {}
            }
        }
    }
}
