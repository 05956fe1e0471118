//! Rows that others stand for (`condense.rs`): what they say is that they are there.

/// What rows of zeros say.
#[derive(Debug, Clone, Default)]
pub(super) struct LeftOut {
    /// How many belong to each component; none where the list ends.
    pub rows: Vec<f64>,
    /// `log det` of their covariance at variances of one.
    pub log_determinant: f64,
}

impl LeftOut {
    /// How many rows of a component were left out.
    pub fn of(&self, component: usize) -> f64 {
        self.rows.get(component).copied().unwrap_or(0.0)
    }

    /// `log det` of their covariance.
    pub fn log_determinant_at(&self, theta: &[f64]) -> f64 {
        let own = self.rows.iter().zip(theta).filter(|(count, _)| **count > 0.0);
        self.log_determinant + own.map(|(count, theta)| count * theta.ln()).sum::<f64>()
    }
}
