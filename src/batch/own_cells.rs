//! Replicates of one device of a schedule of its own: rows whose lines find the same inputs, by a table of their hashes.

use super::Device;
use super::own_rows::{From, Own, Placed};
use super::positions::Positions;
use crate::mix::Mix;
use crate::number;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// The cell of each row of one device: rows of one cell have the same inputs. How many cells there are comes back.
#[derive(Debug, Default)]
pub(super) struct Cells {
    /// Cell of each row.
    pub(super) of: Vec<usize>,
    /// Row (and sensor) at which each cell was met first.
    firsts: Vec<(usize, usize)>,
    table: Vec<u32>,
    /// The same by the cells of positions.
    known: HashMap<u32, usize, BuildHasherDefault<Mix>>,
}

impl Own {
    /// Part a device's rows, in the order of the system's, by their inputs.
    pub(super) fn cells(
        &self,
        (device, places): Placed<'_>,
        positions: Option<&Positions>,
        cells: &mut Cells,
    ) -> usize {
        let Cells { of, firsts, table, .. } = &mut *cells;
        of.clear();
        firsts.clear();
        let size = (4 * device.rows * self.lines.len()).next_power_of_two();
        table.clear();
        table.resize(size, u32::MAX);
        if let Some(positions) = positions {
            let Cells { of, known, .. } = cells;
            known.clear();
            for place in places {
                let next = known.len();
                of.push(*known.entry(positions.cell(*place)).or_insert(next));
            }
            return known.len();
        }
        let word = |x: f64| (x + 0.0).to_bits();
        for (slot, line) in self.lines.iter().enumerate() {
            let at = |row: usize, k: usize| device.inputs.get(row * self.width() + k).copied().map_or(0, word);
            let used = || line.from.iter().filter_map(|from| if let From::Cell(k) = from { Some(*k) } else { None });
            for row in 0..device.rows {
                if device.values.get(row * self.lines.len() + slot).is_none_or(|value| value.is_nan()) {
                    continue;
                }
                let mut hash = Mix(slot as u64);
                used().for_each(|k| hash.write_u64(at(row, k)));
                let mut place = number::index(hash.finish() & (size as u64 - 1));
                let cell = loop {
                    let Some(entry) = table.get_mut(place) else { break firsts.len() };
                    match firsts.get(*entry as usize) {
                        None => {
                            // beyond u32 it stays an empty place, and the cell has no other row
                            *entry = u32::try_from(firsts.len()).unwrap_or(u32::MAX);
                            firsts.push((row, slot));
                            break firsts.len() - 1;
                        }
                        Some((first, own)) if *own == slot && used().all(|k| at(row, k) == at(*first, k)) => {
                            break *entry as usize;
                        }
                        Some(_) => place = (place + 1) & (size - 1),
                    }
                };
                of.push(cell);
            }
        }
        firsts.len()
    }

    /// The rows of a device's system in the order of its readings: the reading (from 0) and the row.
    pub(super) fn order(&self, device: &Device) -> Vec<(usize, usize)> {
        let sensors = self.lines.len();
        let read = |slot: usize, row: usize| device.values.get(row * sensors + slot).is_some_and(|y| !y.is_nan());
        let rows = (0..sensors).flat_map(|slot| (0..device.rows).filter(move |row| read(slot, *row)));
        let mut order: Vec<(usize, usize)> = rows.enumerate().map(|(row, reading)| (reading, row)).collect();
        order.sort_unstable();
        order
    }
}
