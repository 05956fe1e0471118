//! `"readings": { "samples": "log.csv", ... }`: samples that are reduced to readings as the campaign is read, and the recipe, which is that of
//! `tumble reduce` as well.

use super::{Folder, Named, ReadingFile};
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::number;
use crate::record::{self, As, Block, ClockFrom, Record};
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A record of samples, and how it becomes readings: the options of `tumble reduce`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SamplesFile {
    /// The record: CSV in any dialect (also gzip), Parquet, an Excel workbook, a MATLAB or HDF5 file, an MCAP log; FILE#NAME is one of its tables.
    pub samples: String,
    /// What becomes of the samples: their means, unless given.
    #[serde(default, rename = "as", skip_serializing_if = "Option::is_none")]
    pub taken_as: Option<SamplesAs>,
    /// The positions that were taken, as readings without sensor values; one row applies to all segments. Without it: one empty row. As rows: what is the
    /// same in every row of a position.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub positions: Vec<ReadingFile>,
    /// Segments are runs of equal labels in this column of the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// Segments by their times: a list, or the path of a table with the columns start_s, end_s and, if there is one, position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<TimesFile>,
    /// Window of the static detector, s; 0.5 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window_s: Option<f64>,
    /// Largest variance of a still window, in variances of the still sensor; 4 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Left out at both ends of a segment, s; 0.5 for static segments, else 0, unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard_s: Option<f64>,
    /// Segments shorter than this are not used, s; 1 for static segments, else 0, unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_s: Option<f64>,
    /// Columns of the record by the name that the bench has for them: `{ "V": "Ausgang (mV)" }`. Without it: those that the bench reads.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub columns: Named<String>,
    /// The column of times; time_s, time, t or timestamp unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Samples a second, where there is no column of times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// The column of an encoder: turning segments are cut to whole turns by its angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoder: Option<String>,
    /// What the encoder reads more after a turn; 360 unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counts_per_turn: Option<f64>,
}

vocabulary! {
    /// What becomes of samples.
    SamplesAs {
        /// A mean of each segment is a reading, with the uncertainty that its samples show.
        Means = "means",
        /// Each sample is a reading; the record is streamed and may have any length. For `tumble fit`.
        Rows = "rows",
    }
}

/// Times of segments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a list of { \"start_s\", \"end_s\", \"position\" }, or the path of a table with these columns"
)]
pub enum TimesFile {
    /// Path of a table.
    Path(String),
    /// One line for each segment.
    List(Vec<TimesLine>),
}

/// A segment by its times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimesLine {
    /// Its position.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<String>,
    /// Its start, s since the first sample.
    pub start_s: f64,
    /// Its end.
    pub end_s: f64,
}

impl SamplesFile {
    /// Is every sample a reading?
    pub(crate) fn is_rows(&self) -> bool {
        self.taken_as == Some(SamplesAs::Rows)
    }

    /// Which rows are used, for samples as rows; all of them where neither labels nor times say it.
    ///
    /// Errors: keys of means; numbers that are not positive; a table of times that cannot be read.
    pub(super) fn segments_of_rows(&self, folder: &mut dyn Folder) -> Result<SegmentsBy> {
        let of_means = [
            ("window_s", self.window_s.is_some()),
            ("threshold", self.threshold.is_some()),
            ("guard_s", self.guard_s.is_some()),
            ("least_s", self.least_s.is_some()),
            ("encoder", self.encoder.is_some()),
            ("counts_per_turn", self.counts_per_turn.is_some()),
        ];
        if let Some((key, _)) = of_means.iter().find(|(_, given)| *given) {
            return Err(Malformed::new(
                Fault::Value,
                format!("\"{key}\" is of means, and the samples are taken as rows"),
            )
            .expected("\"by\" or \"times\" for the rows that are used, or samples without \"as\": \"rows\"")
            .at_path(*key));
        }
        Ok(self.recipe(&Named(Vec::new()), folder)?.segments)
    }

    /// The recipe; `columns` are the campaign's own.
    ///
    /// Errors: keys that exclude each other, numbers that are not positive, a table of times that cannot be read.
    pub(super) fn recipe(&self, columns: &Named<String>, folder: &mut dyn Folder) -> Result<Recipe> {
        let both = |a: &str, b: &str| {
            Malformed::new(Fault::Value, format!("\"{a}\" and \"{b}\" exclude each other"))
                .expected("one of them")
                .at_path(a.to_string())
        };
        let still = self.window_s.map(|_| "window_s").or(self.threshold.map(|_| "threshold"));
        let segments = match (&self.by, &self.times, still) {
            (Some(_), Some(_), _) => return Err(both("times", "by")),
            (Some(_), _, Some(key)) => return Err(both(key, "by")),
            (_, Some(_), Some(key)) => return Err(both(key, "times")),
            (Some(column), ..) => SegmentsBy::Column(column.clone()),
            (_, Some(TimesFile::Path(path)), _) => {
                let list = times(&mut folder.record(path).map_err(|e| e.at_path("times"))?)?;
                SegmentsBy::Times { list, from: format!("the times in '{path}'") }
            }
            (_, Some(TimesFile::List(lines)), _) => {
                let mut list = Vec::with_capacity(lines.len());
                for (k, line) in lines.iter().enumerate() {
                    if !(line.end_s > line.start_s) {
                        return Err(Malformed::new(Fault::Value, "a segment does not end after it starts")
                            .expected("end_s above start_s")
                            .found(format!("{} and {}", line.start_s, line.end_s))
                            .at_path(format!("times[{k}]")));
                    }
                    list.push((line.position.clone().unwrap_or_default(), line.start_s, line.end_s));
                }
                SegmentsBy::Times { list, from: "the times in the campaign".into() }
            }
            _ => SegmentsBy::Still { window: self.window_s.unwrap_or(0.5), threshold: self.threshold.unwrap_or(4.0) },
        };
        let positive = [
            ("window_s", self.window_s),
            ("threshold", self.threshold),
            ("rate_hz", self.rate_hz),
            ("counts_per_turn", self.counts_per_turn),
        ];
        let not_negative = [("guard_s", self.guard_s), ("least_s", self.least_s)];
        let bad = positive.iter().find(|(_, v)| v.is_some_and(|v| !(v > 0.0) || !v.is_finite()));
        let bad = bad.or_else(|| not_negative.iter().find(|(_, v)| v.is_some_and(|v| !(v >= 0.0) || !v.is_finite())));
        if let Some((key, value)) = bad {
            return Err(Malformed::new(Fault::Value, format!("{key} cannot be this"))
                .expected(if key.ends_with("d_s") || key.starts_with("least") {
                    "zero or a positive number"
                } else {
                    "a positive number"
                })
                .found(value.unwrap_or_default().to_string())
                .at_path(*key));
        }
        if self.time.is_some() && self.rate_hz.is_some() {
            return Err(both("rate_hz", "time"));
        }
        if self.counts_per_turn.is_some() && self.encoder.is_none() {
            return Err(Malformed::new(Fault::Missing, "\"counts_per_turn\" is of an encoder")
                .expected("\"encoder\": the column of its angle")
                .at_path("counts_per_turn"));
        }
        if !self.columns.is_empty() && !columns.is_empty() {
            return Err(Malformed::new(Fault::Value, "\"columns\" occurs twice")
                .expected("\"columns\" of the campaign, or of its \"readings\"")
                .at_path("columns"));
        }
        let columns = if self.columns.is_empty() { columns } else { &self.columns };
        Ok(Recipe {
            segments,
            guard: self.guard_s,
            least: self.least_s,
            columns: columns.0.clone(),
            clock: ClockFrom { time: self.time.clone(), rate: self.rate_hz },
            encoder: self.encoder.clone().map(|column| Encoder { column, turn: self.counts_per_turn }),
        })
    }
}

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
    /// What it reads more after a turn; `None`: a turn in the unit of its title, else 360.
    pub turn: Option<f64>,
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
                format!("static detection (variance in {window} s below {threshold} times that of the sensor at rest)")
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
