//! A tilt that grows with a joint's angle: a linear positioning error, a harmonic of a scale, the wobble of an axis.

use crate::algebra::{Expression, Scratch, Tape};
use crate::error::{Fault, Malformed, Result};

/// The factor of a tilt: a line of algebra in the joints' angles (rad). The rotation is `tilt * factor`.
#[derive(Debug, Clone)]
pub struct Modulation {
    line: Expression,
    tape: Tape,
}

impl PartialEq for Modulation {
    fn eq(&self, other: &Self) -> bool {
        self.line == other.line
    }
}

impl Modulation {
    /// Bind a line to the joints of a chain, given in chain order.
    ///
    /// Errors: `UnknownName` for a name that is no joint.
    pub(crate) fn new(line: Expression, joints: &[&str]) -> Result<Self> {
        if let Some(name) = line.names().into_iter().find(|name| !joints.contains(name)) {
            let error =
                Malformed::new(Fault::UnknownName, format!("a tilt's factor uses '{name}', which is not a joint"))
                    .expected(format!("joints of this chain: {}", joints.join(", ")))
                    .found(format!("'{name}'"));
            return Err(match line.span_of(name) {
                Some((start, len)) => error.at_span(start, len),
                None => error,
            });
        }
        let tape = Tape::compile(&line, joints)?;
        Ok(Modulation { line, tape })
    }

    /// The line of algebra.
    pub(crate) fn line(&self) -> &Expression {
        &self.line
    }

    /// The factor where the joints stand at these angles (rad), in chain order.
    pub fn factor(&self, angles: &[f64], scratch: &mut Scratch) -> f64 {
        self.tape.value(angles, scratch)
    }

    /// The factor's derivatives by the joints' angles, in chain order.
    pub(crate) fn slopes(&self, angles: &[f64], scratch: &mut Scratch) -> Vec<f64> {
        let mut slopes = vec![0.0; angles.len()];
        self.tape.gradient(angles, scratch, &mut slopes);
        slopes
    }
}
