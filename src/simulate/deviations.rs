//! Deviations drawn for a campaign's lines of scatter, felt by the readings through the model's derivatives.

use super::Truth;
use crate::campaign::{Campaign, Size};
use crate::design::DesignMatrix;
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::fit;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// Size of a line's deviations in truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueScatter {
    /// Index of the line in the campaign.
    pub line: usize,
    /// Standard deviation, in radians or the parameter's or sensor's unit.
    pub sd: f64,
    /// Correlation time, where the line has one.
    pub tau: Option<f64>,
}

/// What deviations add to each row, and the standard deviation of the remaining noise of the row. `sd` is that of the whole noise of each row.
///
/// Errors: a line whose size or correlation time neither the campaign nor the truth states.
pub(super) fn deviations(
    campaign: &Campaign,
    design: &DesignMatrix,
    truth: &Truth,
    sd: &[f64],
    seed: u64,
) -> Result<(Vec<f64>, Vec<f64>)> {
    let mut added = vec![0.0; design.rows.len()];
    // a separate stream: the same seed gives the same noise with and without scatter
    let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x5ca7_7e25_0000_0001);
    let stated = fit::stated_variances(campaign);
    for (k, (line, asked)) in fit::scatter_lines(campaign, design, sd).iter().zip(&campaign.scatter).enumerate() {
        let in_truth = truth.scatter.iter().find(|entry| entry.line == k);
        let missing = |what: &str| {
            Malformed::new(
                Fault::Missing,
                format!("{what} of {} is to be estimated, and nothing says what it is in truth", asked.name(campaign)),
            )
            .expected(format!(
                "in the truth file, \"scatter\": {{ \"{}\": {{ \"sd\": a number }} }}",
                asked.name(campaign)
            ))
            .at_path(asked.place.clone())
        };
        let size = match (in_truth, &asked.size) {
            (Some(entry), _) => entry.sd,
            (None, Size::Estimated) => return Err(missing("the standard deviation")),
            (None, _) => stated.at(k).sqrt(),
        };
        let mut drawn: Vec<f64> = (0..line.levels()).map(|_| StandardNormal.sample(&mut random)).collect();
        if let Some(memory) = &line.memory {
            let tau =
                in_truth.and_then(|entry| entry.tau).or(memory.tau).ok_or_else(|| missing("the correlation time"))?;
            // in the order of time within each run; a level has one time and one run
            let levels = drawn.iter_mut().zip(memory.run.iter().zip(&memory.time));
            let mut order: Vec<(&mut f64, (&usize, &f64))> = levels.collect();
            order.sort_by(|(_, (run, time)), (_, (other, at))| run.cmp(other).then(time.total_cmp(at)));
            let mut before: Option<(usize, f64, f64)> = None;
            for (deviation, (run, time)) in order {
                if let Some((_, at, from)) = before.filter(|(before, ..)| before == run) {
                    let retained = (-(time - at).abs() / tau).exp();
                    *deviation = retained * from + (1.0 - retained * retained).sqrt() * *deviation;
                }
                before = Some((*run, *time, *deviation));
            }
        }
        for felt in &line.felt {
            if let (Some(slot), Some(z)) = (added.get_mut(felt.row), drawn.get(felt.level)) {
                *slot += felt.by * size * z;
            }
        }
    }
    Ok((added, fit::own_noise(campaign, design, sd)))
}
