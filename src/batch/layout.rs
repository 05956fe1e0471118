//! Which columns of a table matter to a campaign.

use crate::bench::Bench;
use crate::record::{As, Block, Column};
use crate::units::Conversion;

/// What a column of a table of many devices is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// A sensor's values, by its index in the bench.
    Value(usize),
    /// A number that the model or the weights depend on.
    Input,
    /// A text or a number that only the ordinary fit knows what to do with.
    Other,
}

/// The columns of a table that are read, in the table's order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// Name of each, as a reading's key.
    pub keys: Vec<String>,
    /// Place of each in the table.
    pub columns: Vec<usize>,
    /// What each is.
    pub uses: Vec<Use>,
    /// From each column's unit to the key's.
    pub conversions: Vec<Option<Conversion>>,
    /// The column of the positions' labels, where it only says which rows belong together.
    pub position: Option<usize>,
}

impl Layout {
    /// The columns that a bench needs, under their titles; `others` are further ones that are carried along, or all.
    pub fn of(bench: &Bench, columns: &[Column], by: Option<usize>, others: impl Fn(&str) -> bool) -> Self {
        let keys: Vec<_> = columns.iter().map(|column| (column.title.clone(), None)).collect();
        Layout::keyed(bench, &keys, by, others)
    }

    /// The same with the keys that the columns stand for, and conversions of their units.
    pub(crate) fn keyed(
        bench: &Bench,
        columns: &[(String, Option<Conversion>)],
        by: Option<usize>,
        others: impl Fn(&str) -> bool,
    ) -> Self {
        let mut layout = Layout::default();
        let used: Vec<&str> = bench.sensors.iter().flat_map(|sensor| sensor.model.names()).collect();
        for (place, (key, conversion)) in columns.iter().enumerate() {
            let kind = match part(bench, &used, key) {
                _ if Some(place) == by => continue,
                Some(kind) => kind,
                None if others(key) => Use::Other,
                None => {
                    if key == "position" && layout.position.is_none() {
                        layout.position = Some(place);
                    }
                    continue;
                }
            };
            if layout.keys.iter().any(|other| other == key) {
                continue;
            }
            layout.keys.push(key.to_string());
            layout.columns.push(place);
            layout.uses.push(kind);
            layout.conversions.push(*conversion);
        }
        layout
    }

    /// Numbers of a block in the units of their keys; labels stay.
    pub(crate) fn convert(&self, block: &mut Block) {
        for ((column, conversion), kind) in block.columns.iter_mut().zip(&self.conversions).zip(&self.uses) {
            if let Some(conversion) = conversion.filter(|_| *kind != Use::Other) {
                let numbers = column.iter_mut().filter(|v| !v.is_nan());
                numbers.for_each(|v| *v = conversion.apply(*v));
            }
        }
    }

    /// How each column is read; numbers of `Other` columns are labels.
    pub(crate) fn selection(&self) -> Vec<(usize, As)> {
        let read = |kind: &Use| if *kind == Use::Other { As::Label } else { As::Cell };
        self.columns.iter().zip(&self.uses).map(|(place, kind)| (*place, read(kind))).collect()
    }

    /// The sensors whose values are read, in the order of a device's values.
    pub fn sensors(&self) -> impl Iterator<Item = usize> {
        self.uses.iter().filter_map(|kind| if let Use::Value(k) = kind { Some(*k) } else { None })
    }

    /// Names of the numeric columns: what a model line may use.
    pub fn numeric(&self, bench: &Bench) -> Vec<String> {
        let weights = |key: &str| key == "n" || bench.sensors.iter().any(|s| key.strip_suffix("_u") == Some(&s.id));
        let columns = self.keys.iter().zip(&self.uses).filter(|(key, kind)| **kind == Use::Input && !weights(key));
        columns.map(|(key, _)| key.clone()).collect()
    }
}

/// What a key is to this bench.
fn part(bench: &Bench, used: &[&str], key: &str) -> Option<Use> {
    if let Some(k) = bench.sensors.iter().position(|sensor| sensor.id == key) {
        return Some(Use::Value(k));
    }
    let of_sensor = bench.sensors.iter().any(|sensor| key.strip_suffix("_u") == Some(&sensor.id));
    (key == "n" || of_sensor || bench.is_of_joint(key) || used.contains(&key)).then_some(Use::Input)
}
