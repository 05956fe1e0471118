//! Deviations that link positions: one for the whole campaign, or for each day, operator, instrument.
//!
//! Positions that share a deviation are no longer independent, so their information does not add up. With the deviation as one more unknown that is
//! known beforehand to be `0` with its standard deviation, it does:
//!
//! ```text
//! [A Z; 0 1/s] in the unknowns (x, d):     (M^-1)_xx = (A' (R + s^2 Z Z')^-1 A)^-1       (C. R. Henderson, Biometrics 31 (1975) 423)
//! ```
//!
//! The deviations themselves are not what a plan is after: criteria speak of the parameters alone.

use super::effort::Noise;
use crate::campaign::{Campaign, Per, Reading, Readings};
use crate::design::DesignMatrix;
use crate::estimate::ScatterLine;

/// One deviation.
#[derive(Debug, Clone, PartialEq)]
struct Deviation {
    /// The campaign's line, by index.
    line: usize,
    /// Its level.
    level: String,
    /// Standard deviation.
    sd: f64,
}

/// The deviations that the readings of a plan share.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Deviations {
    list: Vec<Deviation>,
}

/// Does a line give positions one deviation together?
pub(super) fn links(campaign: &Campaign, line: usize) -> bool {
    campaign.scatter.get(line).is_some_and(|line| !matches!(line.per, Per::Reading | Per::Position))
}

/// The levels of a reading in the columns by which positions share deviations: another day is another mounting. Empty without such columns.
pub(super) fn level_of(campaign: &Campaign, readings: &Readings, reading: &Reading) -> String {
    let by_column = campaign.scatter.iter().filter(|line| matches!(line.per, Per::Column(_)));
    let names: Vec<String> = by_column
        .map(|line| line.per.level_name(readings, reading).map_or(String::new(), |name| name.into_owned()))
        .collect();
    names.join("\n")
}

impl Deviations {
    /// Those of all these readings, in the order in which they come. A line that scatters by nothing has none.
    pub fn of(campaign: &Campaign, noise: &Noise, sets: &[&Readings]) -> Self {
        let mut list: Vec<Deviation> = Vec::new();
        for (k, own) in campaign.scatter.iter().enumerate().filter(|(k, _)| links(campaign, *k)) {
            let Some(sd) = noise.lines.get(k).map(|variance| variance.sqrt()).filter(|sd| *sd > 0.0) else { continue };
            let mut seen: std::collections::HashSet<String> = std::collections::HashSet::new();
            for set in sets {
                for level in set.rows.iter().filter_map(|row| own.per.level_name(set, row)) {
                    if seen.insert(level.to_string()) {
                        list.push(Deviation { line: k, level: level.into_owned(), sd });
                    }
                }
            }
        }
        Deviations { list }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Their standard deviations.
    pub fn sd(&self) -> impl Iterator<Item = f64> {
        self.list.iter().map(|own| own.sd)
    }

    /// What each row of a design feels of each of them; `lines` are the campaign's at that design.
    pub fn columns(&self, campaign: &Campaign, design: &DesignMatrix, lines: &[ScatterLine]) -> Vec<Vec<f64>> {
        let readings = &campaign.readings;
        let mut columns = vec![vec![0.0; design.rows.len()]; self.list.len()];
        let place: std::collections::HashMap<(usize, &str), usize> =
            self.list.iter().enumerate().map(|(at, own)| ((own.line, own.level.as_str()), at)).collect();
        for (k, (own, line)) in campaign.scatter.iter().zip(lines).enumerate().filter(|(k, _)| links(campaign, *k)) {
            for felt in &line.felt {
                let reading = design.rows.get(felt.row).and_then(|origin| readings.rows.get(origin.reading));
                let level = reading.and_then(|reading| own.per.level_name(readings, reading));
                let column = level.and_then(|level| place.get(&(k, &*level)).copied());
                if let Some(slot) = column.and_then(|at| columns.get_mut(at)?.get_mut(felt.row)) {
                    *slot += felt.by;
                }
            }
        }
        columns
    }
}
