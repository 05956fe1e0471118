//! The correction: readings of a calibrated unit turned back into the rates and specific forces that caused them.
//!
//! ```text
//! s = f(q; p)              the model lines of all sensors of the unit, q the inputs that they determine, p the calibrated parameters
//! q0 = M (s - b)           first order: b = f(0), M = (df/dq)^-1 at q = 0 (least squares where there are more sensors than inputs)
//! q <- q + M (s - f(q))    to the fixed point, which is the solution of the exact lines; where it does not contract,
//! q <- q + (M df/dq)^-1 M (s - f(q))   Newton's steps to the same
//! u(q)^2 = c C c',  c = dq/dp = -(df/dq)^-1 df/dp,  C the covariance of p (GUM 5.2.2)
//! R q                      on the mounting face, R of the tilts t behind the last joint: c = (R dq/dp, dR/dt q), C the covariance of p and t together
//! ```
//!
//! A [`Calibration`] is a value that stands on its own: a program reads it from the `correction` of a fit report and needs neither bench nor
//! campaign. All sensors of a unit are solved together. Three gyros (or accelerometers) of independent directions give a whole vector along x, y, z
//! of the last frame; fewer give the component along each sensor's own axis, the others being given with the readings or taken as zero, which
//! [`Calibration::inputs`] says. A unit held by hand has no chain: its bench says which columns are rates and forces in use
//! ([`Bench::in_use`](crate::Bench::in_use)), or its line is the norm of a vector that is affine in the readings, whose inverse is the lines of
//! these (`triad.rs`). Deliberately absent: files and formats (`wire`, `report`), dynamics of the sensors, noise of single samples.

mod bound;
mod calibrated;
mod calibration;
mod choose;
pub mod export;
mod mount;
mod solve;
mod triad;
mod validity;

pub(crate) use calibration::{CalibratedLine, LineInput, Mounting, Parameters, Span};
pub use calibration::{Calibration, Quantity};
pub use mount::ToMount;
pub use solve::Corrector;
pub(crate) use validity::{Linearity, linearity};
