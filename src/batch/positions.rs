//! Rows of the design by position: benches with joints, whose devices share positions though not schedules.
//!
//! A position is worked out when it is met first, by the ordinary rows of a reading; where devices hardly share any, each is fitted by itself.

use super::device::bits;
use super::{Device, Layout};
use crate::campaign::Campaign;
use crate::design::{self, Model};
use crate::elements::{OrNan, Parts};
use crate::error::Result;
use crate::fit;
use crate::mix::Mix;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Positions that are kept.
const MOST: usize = 1 << 15;
/// After so many readings at least half of them must have been at positions that were known.
const TRIED: usize = 3000;

type Map<T> = HashMap<Vec<u64>, T, BuildHasherDefault<Mix>>;

/// Positions that were met.
#[derive(Debug)]
pub(super) struct Positions {
    model: Model,
    /// Cells of a row that make a position.
    cells: Vec<usize>,
    /// Derivatives by the unknowns, and the prediction.
    width: usize,
    /// Place of each position's first sensor; `None` for what no fit takes.
    places: Map<Option<u32>>,
    /// One place after the other.
    rows: Vec<f64>,
    /// For each place, the cell that replicates share.
    cell: Vec<u32>,
    keys: Map<u32>,
    key: Vec<u64>,
    asked: usize,
    met: usize,
}

impl Positions {
    /// No position yet; `weights` are the cells that say nothing of a position. `None` where the lines cannot be bound.
    pub(super) fn new(campaign: &Campaign, width: usize, weights: &[usize]) -> Option<Self> {
        Some(Positions {
            model: Model::new(campaign).ok()?,
            cells: (0..width).filter(|k| !weights.contains(k)).collect(),
            width: campaign.unknowns() + 1,
            places: Map::default(),
            rows: Vec::new(),
            cell: Vec::new(),
            keys: Map::default(),
            key: Vec::new(),
            asked: 0,
            met: 0,
        })
    }

    /// The place of each row of a device's system; `None` for a device that its own fit has to answer.
    pub(super) fn of(
        &mut self,
        width: usize,
        device: &Device,
        layout: &Layout,
        question: &(dyn Fn(&Device) -> Result<Campaign> + Sync),
    ) -> Option<Vec<u32>> {
        if self.asked > TRIED && 2 * self.met < self.asked {
            return None;
        }
        let of_layout: Vec<usize> = layout.sensors().collect();
        let sensors = of_layout.len();
        let mut firsts = Vec::with_capacity(device.rows);
        for row in 0..device.rows {
            let inputs = device.input(row, width);
            self.key.clear();
            self.key.extend(self.cells.iter().map(|k| bits(inputs.or_nan(*k))));
            self.asked += 1;
            let first = match self.places.get(self.key.as_slice()) {
                Some(known) => {
                    self.met += 1;
                    *known
                }
                None if self.places.len() >= MOST => return None,
                None => {
                    let found = self.work_out(inputs, &of_layout, question);
                    self.places.insert(self.key.clone(), found);
                    found
                }
            };
            firsts.push(first?);
        }
        let read = |slot: usize, row: usize| device.value(row, sensors).get(slot).is_some_and(|y| !y.is_nan());
        let of_slot = |slot: usize| {
            firsts
                .iter()
                .enumerate()
                .filter(move |(row, _)| read(slot, *row))
                // a bench has fewer sensors than the fallback stands for
                .map(move |(_, first)| first + u32::try_from(slot).unwrap_or(0))
        };
        Some((0..sensors).flat_map(of_slot).collect())
    }

    /// The rows of a position, one for each sensor.
    fn work_out(
        &mut self,
        inputs: &[f64],
        sensors: &[usize],
        question: &(dyn Fn(&Device) -> Result<Campaign> + Sync),
    ) -> Option<u32> {
        let mut single = Device {
            inputs: vec![f64::NAN; inputs.len()],
            values: vec![0.0; sensors.len()],
            rows: 1,
            ..Device::default()
        };
        for k in &self.cells {
            *single.inputs.get_mut(*k)? = *inputs.get(*k)?;
        }
        let campaign = question(&single).ok()?;
        let design = design::assemble(&campaign, &self.model, &campaign.reference_point()).ok()?;
        fit::check_ranges(&campaign).ok()?;
        fit::check_rows(&campaign, &self.model, &design).ok()?;
        let first = u32::try_from(self.cell.len()).ok()?;
        for sensor in sensors {
            let (i, origin) = design.rows.iter().enumerate().find(|(_, row)| row.sensor == *sensor)?;
            let (n, predicted) = (self.width - 1, *design.predicted.get(i)?);
            self.rows.extend((0..n).map(|j| design.jacobian[(i, j)]));
            self.rows.push(predicted);
            let next = u32::try_from(self.keys.len()).ok()?;
            self.cell.push(*self.keys.entry(design::cell_key(&campaign, origin)).or_insert(next));
        }
        Some(first)
    }

    /// Derivatives by the unknowns and the prediction at a place.
    pub(super) fn row(&self, place: u32) -> &[f64] {
        let start = place as usize * self.width;
        self.rows.part(start..start + self.width)
    }

    /// The cell that replicates of a place share.
    pub(super) fn cell(&self, place: u32) -> u32 {
        // beyond what was worked out: a cell of its own, which nothing repeats
        self.cell.get(place as usize).copied().unwrap_or(u32::MAX)
    }
}
