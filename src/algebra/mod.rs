//! Model lines: one line of algebra, as the papers print it, read once and evaluated many times.
//!
//! ```text
//! text --parse--> Expression --Tape::compile--> value and exact gradient at (inputs; coefficients)
//!                     \--> names, linear_in, trig_degree, is_smooth_in, angle_degree; Display, canonical
//! ```
//!
//! An [`Expression`] is a tree kept in postfix order, so that nothing here recurses into it and no line, however long or
//! deep, can exhaust the stack. Which names are inputs and which are coefficients is not known here: callers say so.
//!
//! Grammar: names `[A-Za-z_][A-Za-z0-9_]*`, numbers (`1`, `1.5`, `.5`, `1e-3`), `pi`, `+ - * /` from the left, `^` from the
//! right and tighter than the minus sign (`-x^2` is `-(x^2)`), parentheses, the functions below
//! and `atan2(y, x)`. Deliberately absent: implicit multiplication, comparison, other functions of two arguments, simplification.

mod analysis;
mod canonical;
mod expression;
mod function;
mod homogeneity;
mod language;
mod parse;
mod tape;

pub(crate) use analysis::{NameDegree, Term};
pub use expression::Expression;
pub(crate) use function::Function;
pub(crate) use homogeneity::{Powers, Reason};
pub(crate) use language::Language;
pub(crate) use tape::{Lane, lanes};
pub use tape::{Scratch, Tape};
