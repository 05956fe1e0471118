//! The gap by channel and in time: its size, its course in time, and its pattern where nothing explains it.

use super::measured::{CHANNEL_NAMES, CHANNELS, Cell as Value, Measured, si_per_unit};
use super::mission::Mission;
use super::study;
use crate::diagnosis::NoiseFrom;
use crate::elements::Elements;

/// The gap in one channel of one run.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "ChannelReport")]
pub struct ChannelGap {
    /// Name of the motion.
    pub motion: String,
    /// The column; its name has the unit of all numbers here.
    pub column: String,
    /// Values measured.
    pub values: usize,
    /// Root mean square before, in the column's unit.
    pub rms_before: f64,
    /// Largest by size before, in the column's unit.
    pub max_before: f64,
    /// Root mean square after, in the column's unit.
    pub rms_after: f64,
    /// Largest by size after, in the column's unit.
    pub max_after: f64,
    /// Standard uncertainty of a value, in the column's unit.
    pub u: f64,
    /// `stated` or `residuals` (then it can only come from what is left).
    pub u_from: NoiseFrom,
}

/// The gap in one channel of one run against time, SI units, thinned for a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct GapOverTime {
    /// Name of the motion.
    pub motion: String,
    /// The channel.
    pub channel: usize,
    /// Time (s), gap before, gap after.
    pub points: Vec<(f64, f64, f64)>,
}

/// Mean gap in a part of a run.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[schemars(rename = "NavigationCellReport")]
#[non_exhaustive]
pub struct Cell {
    /// Name of the motion.
    pub motion: String,
    /// The column.
    pub column: String,
    /// Start of the part, h.
    pub from_h: f64,
    /// End of the part, h.
    pub to_h: f64,
    /// Values there.
    pub values: usize,
    /// Mean gap, in the column's unit.
    pub mean: f64,
    /// Its size in standard deviations.
    pub z: f64,
}

/// Points of a channel's gap over time at most.
const DRAWN: usize = 300;
/// Parts of a run.
const PARTS: usize = 4;

/// The gap before and after, value by value.
pub(super) struct Remainder<'a> {
    pub mission: &'a Mission,
    pub measured: &'a Measured,
    pub u: &'a [f64],
    pub before: &'a [f64],
    pub after: &'a [f64],
}

/// A value: its cell, its standard uncertainty, its gap before and after.
type Entry = (Value, f64, f64, f64);

impl Remainder<'_> {
    fn entries(&self) -> impl Iterator<Item = Entry> + '_ {
        let gaps = self.u.iter().zip(self.before.iter().zip(self.after));
        self.measured.cells().zip(gaps).map(|(cell, (u, (before, after)))| (cell, *u, *before, *after))
    }

    /// Each run and channel that was measured, with the motion's name.
    fn groups(&self) -> Vec<(String, usize, Vec<Entry>)> {
        let names: Vec<String> = study::motions(self.mission).into_iter().map(|(name, _)| name).collect();
        let mut groups: Vec<Vec<Entry>> = vec![Vec::new(); self.measured.runs.len() * CHANNELS];
        for entry in self.entries() {
            groups.get_mut(entry.0.run * CHANNELS + entry.0.channel).into_iter().for_each(|group| group.push(entry));
        }
        let name = |k: usize| {
            let motion = self.measured.runs.get(k / CHANNELS).map_or(0, |run| run.motion);
            // one motion has no name
            names.get(motion).cloned().unwrap_or_default()
        };
        let groups = groups.into_iter().enumerate().filter(|(_, group)| !group.is_empty());
        groups.map(|(k, group)| (name(k), k % CHANNELS, group)).collect()
    }

    pub fn channels(&self) -> Vec<ChannelGap> {
        let size = |values: &mut dyn Iterator<Item = f64>| {
            let (mut count, mut square, mut max) = (0.0_f64, 0.0, 0.0_f64);
            values.for_each(|v| (count, square, max) = (count + 1.0, square + v * v, max.max(v.abs())));
            ((square / count.max(1.0)).sqrt(), max)
        };
        let stated =
            |channel: usize| self.measured.cells().filter(|cell| cell.channel == channel).all(|cell| cell.u.is_some());
        let one = |(motion, channel, group): (String, usize, Vec<Entry>)| {
            let unit = si_per_unit(channel);
            let (before, after) = (size(&mut group.iter().map(|e| e.2)), size(&mut group.iter().map(|e| e.3)));
            ChannelGap {
                motion,
                column: CHANNEL_NAMES.at(channel).into(),
                values: group.len(),
                rms_before: before.0 / unit,
                max_before: before.1 / unit,
                rms_after: after.0 / unit,
                max_after: after.1 / unit,
                u: size(&mut group.iter().map(|e| e.1)).0 / unit,
                u_from: if stated(channel) { NoiseFrom::Stated } else { NoiseFrom::Residuals },
            }
        };
        self.groups().into_iter().map(one).collect()
    }

    pub fn gaps_over_time(&self) -> Vec<GapOverTime> {
        let one = |(motion, channel, group): (String, usize, Vec<Entry>)| {
            let every = group.len().div_ceil(DRAWN).max(1);
            let points = group.iter().step_by(every).map(|(cell, _, before, after)| (cell.time, *before, *after));
            GapOverTime { motion, channel, points: points.collect() }
        };
        self.groups().into_iter().map(one).collect()
    }

    /// What is left in each channel in parts of each run, on the mean, the most significant first, and one sentence about it.
    pub fn pattern(&self) -> (Vec<Cell>, String) {
        let mut cells = Vec::new();
        let mut channels: Vec<(f64, String, usize, Vec<Entry>)> = Vec::new();
        for (motion, channel, group) in self.groups() {
            for part in group.chunks(group.len().div_ceil(PARTS).max(1)) {
                let (mut weight, mut product, mut sum) = (0.0, 0.0, 0.0);
                for (_, u, _, gap) in part {
                    (weight, product, sum) = (weight + 1.0 / (u * u), product + gap / (u * u), sum + gap);
                }
                let time = |entry: Option<&Entry>| entry.map_or(0.0, |e| e.0.time);
                cells.push(Cell {
                    motion: motion.clone(),
                    column: CHANNEL_NAMES.at(channel).into(),
                    from_h: time(part.first()) / 3600.0,
                    to_h: time(part.last()) / 3600.0,
                    values: part.len(),
                    mean: sum / part.len().max(1) as f64 / si_per_unit(channel),
                    z: product / weight.sqrt(),
                });
            }
            let square = group.iter().map(|(_, u, _, gap)| (gap / u) * (gap / u)).sum::<f64>();
            channels.push((square / group.len().max(1) as f64, motion, channel, group));
        }
        cells.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
        channels.sort_by(|a, b| b.0.total_cmp(&a.0));
        let sentence = channels.first().map_or(String::new(), |(_, motion, channel, group)| {
            let largest = CHANNEL_NAMES.at(*channel);
            format!("the residuals are largest in {largest} ({motion}): {}", course(group))
        });
        (cells, sentence)
    }
}

/// What the gap that is left does in time, in words.
fn course(group: &[Entry]) -> String {
    let white: Vec<f64> = group.iter().map(|(_, u, _, gap)| gap / u).collect();
    let square: f64 = white.iter().map(|v| v * v).sum();
    let rms = (square / white.len().max(1) as f64).sqrt();
    let far = group.iter().zip(&white).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    if let Some(((cell, ..), far)) = far
        && far * far > 0.5 * square
        && white.len() > 4
    {
        return format!("one value, {far:.1} u at {:.1} s, makes most of it", cell.time);
    }
    let follow: f64 =
        // windows of two
        white.windows(2).map(|w| w.first().copied().unwrap_or(0.0) * w.last().copied().unwrap_or(0.0)).sum();
    let follow = if square > 0.0 { follow / square } else { 0.0 };
    let middle = group.iter().map(|(cell, ..)| cell.time).sum::<f64>() / group.len().max(1) as f64;
    let moment = |f: &dyn Fn(f64, f64) -> f64| {
        group.iter().zip(&white).map(|((cell, ..), v)| f(cell.time - middle, *v)).sum::<f64>()
    };
    let (along, spread) = (moment(&|t, v| t * v), moment(&|t, _| t * t));
    let trend = if spread > 0.0 && square > 0.0 { along * along / spread / square } else { 0.0 };
    let shape = if follow < 0.3 {
        "it varies independently from row to row, like noise larger than stated"
    } else if trend > 0.5 {
        "it is correlated from row to row and drifts with time"
    } else {
        "it is correlated from row to row, like errors that change in time or random walks"
    };
    format!("root mean square {rms:.1} u, {shape}")
}
