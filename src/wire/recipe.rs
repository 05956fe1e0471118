//! How a record becomes readings: the same recipe for `tumble reduce` and for samples in a campaign.

use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{self, As, Block, Record};

pub use crate::record::ClockFrom;

/// How a record becomes readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// How segments are found.
    pub segments: SegmentsBy,
    /// Left out at both ends of a segment, s; by default 0.5 of static segments, else 0.
    pub guard: Option<f64>,
    /// Least length of a segment, s; by default 1 of static segments, else 0.
    pub least: Option<f64>,
    /// Names and the columns of the record that they stand for; empty for those that the schedule's bench reads, or all numeric ones.
    pub columns: Vec<(String, String)>,
    /// Where times come from.
    pub clock: ClockFrom,
    /// What whole turns are told by.
    pub encoder: Option<Encoder>,
}

/// The column of an encoder.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoder {
    /// The column.
    pub column: String,
    /// What it reads more after a turn.
    pub turn: f64,
}

/// How segments are found.
#[derive(Debug, Clone, PartialEq)]
pub enum SegmentsBy {
    /// Runs of equal labels in a column.
    Column(String),
    /// Label, start and end in seconds since the first sample.
    Times {
        /// The segments.
        list: Vec<(String, f64, f64)>,
        /// Where they come from, in words.
        from: String,
    },
    /// Where the record stands still.
    Still {
        /// Window of the detector, s.
        window: f64,
        /// Largest variance of a still window, in variances of the still sensor.
        threshold: f64,
    },
}

impl SegmentsBy {
    pub(super) fn words(&self) -> String {
        match self {
            SegmentsBy::Column(column) => format!("the column '{column}'"),
            SegmentsBy::Times { from, .. } => from.clone(),
            SegmentsBy::Still { window, threshold } => {
                format!("stillness (variance in {window} s below {threshold} of the still sensor's)")
            }
        }
    }
}

/// Segments from a table with the columns start_s, end_s and, if there is one, position.
///
/// Errors: columns that are not there, a segment that does not end after it starts.
pub fn times(table: &mut Record) -> Result<Vec<(String, f64, f64)>> {
    let (start, end) = (table.find("start_s")?, table.find("end_s")?);
    let position = record::find(table.columns(), "position");
    let mut selected = vec![(start, As::Number), (end, As::Number)];
    selected.extend(position.map(|k| (k, As::Label)));
    table.select(&selected);
    let (mut list, mut block) = (Vec::new(), Block::default());
    while table.next(&mut block)? {
        for k in 0..block.rows() {
            let number = |column: usize| block.columns.at(column).at(k);
            if !(number(1) > number(0)) {
                return Err(Malformed::new(Fault::Value, "a segment does not end after it starts")
                    .expected("end_s above start_s")
                    .found(format!("{} and {} in row {}", number(0), number(1), list.len() + 1))
                    .in_file(table.name()));
            }
            let labelled = position.map(|_| number(2)).filter(|n| n.is_finite());
            // a label column holds numbers of labels; without the column there is none
            let label = labelled.and_then(|n| table.labels().get(number::count(n))).cloned().unwrap_or_default();
            list.push((label, number(0), number(1)));
        }
    }
    Ok(list)
}
