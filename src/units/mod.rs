//! Units of measurement: the field's names, products, quotients and powers of them, their dimensions, conversion.
//!
//! ```text
//! "mV/(deg/s)" --parse--> Unit (factor to SI, dimension) --conversion--> Conversion (numerator, denominator)
//! ```
//!
//! A plane angle is a base quantity, so that `V/(deg/s)` is not `V/Hz`; only an angle, or a power of one, and a
//! pure number convert to each other, the radian being 1 (`ppm` and `urad` of a misalignment). A value in `K` where `degC` is wanted is shifted by
//! 273.15. Deliberately absent: logarithmic units, numbers inside a unit.

mod dimension;
mod parse;
mod table;
mod unit;

pub use dimension::{Conversion, STANDARD_GRAVITY_M_S2};
#[cfg(feature = "dcc")]
pub(crate) use table::plain;
pub(crate) use table::{names, of_column};
pub use unit::Unit;

/// One radian in arcseconds.
pub const ARCSEC: f64 = 180.0 * 3600.0 / std::f64::consts::PI;
