//! What a program asks a fit for: parameters by name, angles in arcseconds.

use super::{Fit, ParameterResult};
use crate::campaign::Kind;
use crate::error::{Fault, Malformed, Result};
use crate::units::ARCSEC;

/// An estimated angle: a tilt, or a derived angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    value: Option<f64>,
    u: Option<f64>,
    expanded: Option<f64>,
}

impl Angle {
    /// The estimate in arcseconds; `None` where it is not estimable.
    pub fn arcsec(&self) -> Option<f64> {
        self.value.map(|value| value * ARCSEC)
    }

    /// Its standard uncertainty in arcseconds; `None` where it cannot be known.
    pub fn u_arcsec(&self) -> Option<f64> {
        self.u.map(|u| u * ARCSEC)
    }

    /// Its expanded uncertainty at the level of the fit, in arcseconds.
    pub fn expanded_arcsec(&self) -> Option<f64> {
        self.expanded.map(|u| u * ARCSEC)
    }
}

impl Fit {
    /// The result of an estimated parameter. Errors: a name that is not estimated.
    pub fn parameter(&self, id: &str) -> Result<&ParameterResult> {
        self.parameters.iter().find(|own| own.id == id).ok_or_else(|| self.unknown(id, "parameter"))
    }

    /// An estimated tilt or a derived angle.
    ///
    /// ```
    /// let text = include_str!("../../data/campaigns/li2012-table1.campaign.json");
    /// let fit = tumble::fit(&tumble::Campaign::from_json(text)?, &Default::default())?;
    /// // Li, Ren, Zhao 2012, table 1: -162.2, -162.2 and -162.0 arcsec at the three rates
    /// assert!((fit.angle("dtheta_y2")?.arcsec().unwrap() + 162.1).abs() < 0.15);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    ///
    /// Errors: a name that is no estimated angle.
    pub fn angle(&self, id: &str) -> Result<Angle> {
        let tilt = self.parameters.iter().find(|own| own.id == id && own.kind == Kind::Tilt);
        let derived = || self.derived.iter().find(|own| own.id == id && own.is_angle);
        let (value, uncertainty) = tilt
            .map(|own| (own.value, own.uncertainty))
            .or_else(|| derived().map(|own| (own.value, own.uncertainty)))
            .ok_or_else(|| self.unknown(id, "angle"))?;
        Ok(Angle { value, u: uncertainty.map(|own| own.u), expanded: uncertainty.map(|own| own.expanded) })
    }

    fn unknown(&self, id: &str, what: &str) -> Malformed {
        let names: Vec<&str> = self.parameters.iter().map(|own| own.id.as_str()).collect();
        Malformed::new(Fault::UnknownName, format!("no estimated {what} is called '{id}'")).expected(names.join(", "))
    }
}
