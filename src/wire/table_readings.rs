//! Readings from a table of any format that a record may have.

use super::columns::columns;
use super::device_readings::{number, text};
use super::locate::table_place;
use super::readings_file::{Cell, MOST_READINGS, from_cells, too_many};
use super::{Named, Table, csv_readings};
use crate::batch::{Layout, Use};
use crate::bench::Bench;
use crate::campaign::Readings;
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::record::{Block, Record};

/// The readings of a table; `map` has the titles of columns with names of their own.
///
/// Errors: those of a CSV of readings; rows of other formats are counted from 1.
pub(super) fn read(bench: &Bench, table: Table, map: &Named<String>) -> Result<Readings> {
    match table {
        Table::Text(source) => csv_readings::read(bench, &source, map),
        Table::Record(record) => of_record(bench, record, map),
    }
}

fn of_record(bench: &Bench, mut record: Record, map: &Named<String>) -> Result<Readings> {
    let layout = table_layout(bench, &record, None, map, |_| true)?;
    if layout.keys.is_empty() {
        return Err(Malformed::new(Fault::Missing, "the table has no column").in_file(record.name()));
    }
    record.select(&layout.selection());
    let (mut block, mut rows) = (Block::default(), Vec::new());
    while record.next(&mut block)? {
        layout.convert(&mut block);
        for k in 0..block.rows() {
            let place = table_place(rows.len() + 1, record.name());
            let mut cells = Vec::with_capacity(layout.keys.len());
            for ((key, kind), column) in layout.keys.iter().zip(&layout.uses).zip(&block.columns) {
                let own = column.at(k);
                let cell = match kind {
                    Use::Input | Use::Value(_) => number(Some(own)),
                    Use::Other if own.is_nan() => Cell::Nothing(()),
                    Use::Other => text(key, record.labels().get(crate::number::count(own)).map_or("", String::as_str)),
                };
                cells.push((key.clone(), cell));
            }
            // a spreadsheet has empty rows below its table, too
            if cells.iter().all(|(_, cell)| matches!(cell, Cell::Nothing(()))) {
                continue;
            }
            rows.push((place, Named(cells)));
            if rows.len() as f64 > MOST_READINGS {
                return Err(too_many(rows.len()).in_file(record.name()));
            }
        }
    }
    from_cells(bench, rows)
}

/// The columns of a table that matter to a campaign, under the keys that `map` gives them.
///
/// Errors: a column that the map names and the table has not, two columns for one key, a unit that does not convert.
pub fn table_layout(
    bench: &Bench,
    record: &Record,
    by: Option<usize>,
    map: &Named<String>,
    others: impl Fn(&str) -> bool,
) -> Result<Layout> {
    let titles: Vec<&str> = record.columns().iter().map(|column| column.title.as_str()).collect();
    let keys = columns(bench, &titles, map, record.name())?;
    let keys: Vec<_> = keys.into_iter().map(|column| (column.key, column.conversion)).collect();
    Ok(Layout::keyed(bench, &keys, by, others))
}
