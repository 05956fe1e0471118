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
//! # The pipeline, and the map of the modules
//!
//! Data flows one way; a module knows only the modules that stand before it. The edge, [`wire`], is beside the line: it knows the types of every
//! module that has files; built-in data, reports and the program use it.
//!
//! | module | what is in it |
//! |---|---|
//! | [`error`] | the question is malformed: where, what was expected, what was found |
//! | [`language`] | the sentences and terms of the reports in English and Chinese |
//! | [`units`] | the field's units: parsed, converted, their dimensions |
//! | [`algebra`] | a model line: parsed, printed, differentiated |
//! | [`mod@bench`] | the chain of rotations, the site, the sensors; the built-in benches |
//! | [`record`] | tables of samples: CSV in its dialects, gzip, Parquet, in blocks |
//! | [`reduce`] | segments of a record, their means, the uncertainty of means of correlated samples |
//! | [`noise`] | Allan deviations of a record, and the coefficients of IEEE Std 952 |
//! | [`campaign`] | parameters, readings, constraints; a schedule is a campaign without values |
//! | [`design`] | inputs at each instant, means over turns, rows from exact derivatives |
//! | [`estimate`] | weighted, scaled, pivoted QR; rank; covariance; rows in blocks; what scatters |
//! | [`uncertainty`] | quantiles, budgets, degrees of freedom |
//! | [`quality`] | residuals, redundancy numbers, detectable faults, the global test |
//! | [`mod@fit`] | the pipeline in one call: campaign in, every parameter with its uncertainty out |
//! | [`batch`] | many devices through one schedule: what they share done once, one row for each |
//! | [`mod@compare`] | the published closed forms beside least squares; misprints; calibrations of one unit |
//! | [`correction`] | readings of a calibrated unit turned back into rates and forces; the same as source code |
//! | [`mod@simulate`] | readings from a truth, with noise and hidden effects |
//! | [`plan`] | a schedule judged before anyone measures; the best positions |
//! | [`diagnosis`] | the gap, the effects catalogue, the search, the repair, the verdict |
//! | [`navigate`] | what calibration errors do to a strapdown navigator over hours, and which explain measured ones |
//! | [`wire`] | bench, campaign, mission, truth and CSV files in and out, their JSON Schemas; the same in code |
//! | [`report`] | results as stable JSON and as tables |
//! | [`stop`] | work that may be stopped while it runs |
//! | [`theory`] | the equations with their sources, page by page, each with a number worked by hand |
//! | [`cli`] | the program: the only module that reads files, writes files and prints |
//!
//! # Features
//!
//! All are on unless `default-features = false`, which leaves the engine: benches, campaigns, fits, diagnoses, plans, simulations, records, reports as
//! JSON and as tables.
//!
//! | feature | what it adds |
//! |---|---|
//! | `cli` | the program (and all other features) |
//! | `html` | reports as pages and Markdown, their pictures |
//! | `dcc` | the digital calibration certificate |
//! | `navigate` | missions, and diagnoses of navigation errors |
//! | `parquet` | records and series as Parquet |
//! | `excel` | records and readings in workbooks (`.xlsx`, `.xls`, `.xlsb`, `.ods`) |
//! | `hdf5` | records and readings in HDF5 and MATLAB 7.3 |
//! | `mcap` | records in MCAP logs of ROS 1 and 2 |
//!
//! # Invariants
//!
//! * Frames: ground x east, y north, z up; rotations are active and take sensor components to the ground.
//! * Inside, tilts are in radians and everything else is in the bench's declared units; a bare number's name carries its unit.
//! * No small angles: rows are exact derivatives at the reference point. The papers' rows fall out at zero tilts.
//! * No normal equations, no hidden prior, damping, clipping or repair. A prior is a row; what is assumed zero is listed.
//! * Outcomes (rank defect, failed test, no convergence) are values. [`error::Malformed`] means that the question is malformed.
//! * Nothing panics, whatever the input; the library neither prints nor reads files.

#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented,
        clippy::indexing_slicing,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss
    )
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
mod elements;
pub mod error;
pub mod estimate;
pub mod fit;
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
pub mod reduce;
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
