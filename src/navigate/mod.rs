//! What calibration errors do to a strapdown navigator over hours.
//!
//! ```text
//! motion (exact truth) -> increments (exact integrals) -> unit with errors -> mechanisation -> believed - true
//! ```
//!
//! | file | what |
//! |---|---|
//! | `mission`, `motion`, `errors` | the question: site, step, motion, what is wrong with the unit |
//! | `earth`, `quadrature`, `trajectory` | the truth: WGS-84, exact increments, where the vehicle really is |
//! | `mechanise`, `vector`, `simd_batch` | the navigator: one step in all lanes of a register, groups of eight scenarios |
//! | `linear` | the linear error equations, one signature for each error source |
//! | `measured`, `signatures`, `whiten` | measured navigation errors, their design matrix, random walks taken out |
//! | `cause`, `changing` | possible causes of a gap, and their columns |
//! | `judged`, `bank` | the posterior of sets of causes and of what none of them explains, by the score of campaigns |
//! | `products`, `refine` (`single`, `periodic`), `search` | least squares of a few of many columns; sets of causes refined on the full simulation; judged and refined in turn |
//! | `partly` | causes that are significant although something is unexplained |
//! | `settings` | every threshold, with its reason |
//! | `unstated_walk` | random walks that the mission does not state |
//! | `shortened` | long records in fewer rows, in which all of these look |
//! | `diagnose` (`case`, `conclude`), `separate`, `remainder` | the diagnosis, how the gap shrinks, motions that would discriminate aliases, the remainder |
//! | `run` | a mission flown: rows to a sink, memory independent of the duration |
//!
//! East-north-up, body axes x right, y forward, z up, SI units and rad inside. Deliberately absent: a vertical
//! channel (held at the site's altitude), alignment, aiding, a Kalman filter.

mod bank;
mod case;
pub(crate) mod cause;
mod changing;
mod conclude;
pub(crate) mod diagnose;
pub(crate) mod earth;
pub(crate) mod errors;
mod finding;
mod judged;
pub(crate) mod linear;
pub(crate) mod measured;
mod mechanise;
pub(crate) mod mission;
pub(crate) mod motion;
mod partly;
mod periodic;
mod products;
pub(crate) mod propagation;
pub(crate) mod quadrature;
mod refine;
pub(crate) mod remainder;
pub(crate) mod run;
mod search;
pub(crate) mod separate;
pub(crate) mod settings;
mod shortened;
pub(crate) mod signatures;
mod simd_batch;
mod single;
pub(crate) mod study;
pub(crate) mod trajectory;
mod unstated_walk;
mod vector;
mod weighed;
mod whiten;

pub use diagnose::{NavigationDiagnosis, diagnose};
pub use errors::ImuErrors;
pub use measured::{Measured, MeasuredRow};
pub use mission::{Mission, Site};
pub use motion::{Attitude, Motion, Oscillation};
pub use propagation::{SourceCovariance, combine};
pub use run::{Continue, Scenario};
pub use settings::Settings;
pub use study::{Flown, FlownTogether, PropagatedCalibration, fly, propagate_calibration, scenarios};
