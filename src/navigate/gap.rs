//! Measured minus predicted navigation errors.

/// A gap, in standard uncertainties (of innovations, where the mission has random walks).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Root mean square.
    pub rms: f64,
    /// Largest by size.
    pub max: f64,
    /// Sum of squares.
    pub chi_square: f64,
    /// Values minus errors fitted.
    pub dof: usize,
    /// Probability of a sum of squares as large by chance; `None` where the noise is estimated from residuals.
    pub p: Option<f64>,
}

/// The gap with some of the findings.
#[derive(Debug, Clone, PartialEq)]
pub struct GapStep {
    /// Their names.
    pub with: Vec<String>,
    /// Single values that are left out.
    pub left_out: usize,
    /// The gap with them, fitted anew.
    pub gap: Gap,
}
