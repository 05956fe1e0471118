//! # Theory
//!
//! What tumble computes, by which equations, from which sources, under which assumptions, and what it does not do. Each page ends with a
//! number that is worked by hand; `cargo test` checks it against the library.
//!
//! | page | question |
//! |---|---|
//! | [`estimator`] | How do readings become angles and coefficients? |
//! | [`rank`] | What can these positions determine, and how is that decided? |
//! | [`uncertainty`] | What is `u`, what is `U`, and where do the degrees of freedom come from? |
//! | [`scatter`] | What if positions, days or samples share a deviation? |
//! | [`constraints`] | Bounds, equations, cones: what do they do to estimates and intervals? |
//! | [`robust`] | What if a few readings are bad? |
//! | [`agreement`] | Do readings and model agree, and which reading does not? |
//! | [`diagnosis`] | When is a missing effect named, and when is it not? |
//! | [`planning`] | Which positions are best, and how far from the best can a schedule be? |
//! | [`navigation`] | What does a calibration error do to a strapdown navigator? |
//! | [`noise`] | Allan deviation, its intervals, and the uncertainty of a mean of samples |
//! | [`samples`] | Each sample of a long record a reading of its own, with noise correlated in time |
//! | [`conformity`] | Pass or fail near a limit; two calibrations of one unit |
//!
//! Symbols are the same on all pages:
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `y` | readings minus predictions at the point of linearisation, `m` | the sensor's |
//! | `A` | design matrix: derivatives of the readings by the unknowns, `m x n` | sensor by unknown |
//! | `x` | unknowns (tilts in rad, coefficients in the bench's units), `n` | |
//! | `W = diag(1/u)` | weights from the standard uncertainties of the readings | 1/sensor |
//! | `v = y - A x` | residuals | the sensor's |
//! | `C = (A' W^2 A)^-1` | covariance of `x` where every `u` is known | |
//! | `Q`, `R` | factors of the weighted, scaled, pivoted design matrix | |
//!
//! GUM is JCGM 100:2008, GUM-S1 JCGM 101:2008 (Monte Carlo), both free at <https://www.bipm.org/en/committees/jc/jcgm/publications>.
//!
//! The pages are Markdown files under `docs/theory` in the source tree; here each is a module without items.

macro_rules! pages {
    ($($name:ident = $file:literal;)*) => {
        $(#[doc = include_str!(concat!("../docs/theory/", $file))] pub mod $name {})*
    };
}

pages! {
    estimator = "estimator.md";
    rank = "rank.md";
    uncertainty = "uncertainty.md";
    scatter = "scatter.md";
    constraints = "constraints.md";
    robust = "robust.md";
    agreement = "agreement.md";
    diagnosis = "diagnosis.md";
    planning = "planning.md";
    navigation = "navigation.md";
    noise = "noise.md";
    samples = "samples.md";
    conformity = "conformity.md";
}
