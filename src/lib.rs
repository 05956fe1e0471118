//! **tumble** calibrates inertial sensors from multi-position tests.
//!
//! ```text
//! reading = f(inputs at this position; coefficients) + noise
//! inputs  = rate w_* and specific force a_* along the sensor's axes, from the bench's chain of rotations
//! row     = d reading / d unknowns at the stated reference point       (unknowns: coefficients and small tilts)
//! x       = argmin sum ((reading - f) / u)^2                           (column-pivoted QR, never normal equations)
//! ```
//!
//! ```
//! // 30 readings of a gyro on a rate table, six unknowns (Li, Ren, Zhao 2012, table 1: -54.0, -53.7 and -53.8 arcsec at its rates)
//! let campaign = tumble::Campaign::from_json(include_str!("../data/campaigns/li2012-table1.campaign.json"))?;
//! let fit = tumble::fit(&campaign, &Default::default())?;
//! let angle = fit.angle("dtheta_y1")?;
//! assert!((angle.arcsec().unwrap() + 53.8).abs() < 0.1 && (angle.u_arcsec().unwrap() - 0.60).abs() < 0.01);
//! # Ok::<(), tumble::Malformed>(())
//! ```
//!
//! A question that is malformed is an [`Malformed`] with its place, what was expected and what was found. What readings say (a rank defect, a failed
//! test, no convergence) is part of the answer. Answers and their reports ([`report`]) print as the program prints them: `println!("{fit}")`.
//!
//! Data flows one way, [`bench`](mod@bench) → [`campaign`] → [`design`] → [`estimate`] → [`fit`](mod@fit) → [`diagnosis`], [`plan`] → [`guide`], [`report`]; files are read by [`wire`], and
//! [`theory`] has the equations with their sources. Ground: x east, y north, z up; rotations are active. Tilts are in radians, the rest is in the
//! bench's units. Nothing panics; only [`cli`] reads, writes and prints.
//!
//! Features, all on by default: `cli` (the program, with all others), `html` (pages, Markdown), `dcc` (certificates), `navigate` (missions), `parquet`,
//! `excel`, `hdf5`, `mcap` (formats). `default-features = false` leaves the engine.

#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports, reason = "some items only the program asks for"))]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable,
    clippy::todo,
    clippy::unimplemented,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

pub mod algebra;
pub mod batch;
pub mod bench;
pub mod campaign;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compare;
pub mod correction;
pub mod design;
pub mod diagnosis;
pub mod document;
mod elements;
pub mod error;
pub mod estimate;
pub mod fit;
pub mod guide;
pub mod language;
mod linear;
mod mix;
#[cfg(feature = "navigate")]
pub mod navigate;
pub mod noise;
mod number;
pub mod plan;
pub mod quality;
pub mod record;
pub(crate) mod reduce;
pub mod report;
pub mod simulate;
pub mod stop;
pub mod theory;
pub mod uncertainty;
pub mod units;
mod vocabulary;
pub mod wire;

pub use bench::Bench;
pub use campaign::Campaign;
pub use compare::compare;
pub use diagnosis::{Diagnosis, diagnose};
pub use error::{Fault, Malformed, Result};
pub use fit::{Fit, fit};
pub use simulate::simulate;
