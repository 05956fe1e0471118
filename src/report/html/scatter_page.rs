//! What scatters, as a section of a page.

use super::{Align, Section, Table};
use crate::report::scatter::{HEADS, ScatterReport, cells, is_worth_a_table};

/// Every source of scatter with its size and where that comes from; empty where there is only the readings' own noise.
pub(super) fn scatter(sources: &[ScatterReport]) -> Section {
    let mut section = Section::new("What scatters");
    if !is_worth_a_table(sources) {
        return section;
    }
    let aligned = [Align::Left, Align::Right, Align::Right, Align::Left, Align::Right, Align::Left];
    let heads: Vec<(&str, Align)> = HEADS.iter().copied().zip(aligned).collect();
    let mut table = Table::new(&heads);
    for source in sources {
        table.row(cells(source));
    }
    table.caption = "Sources of scatter".into();
    table.note = "sd: standard deviation of one deviation. A source is stated by the campaign or estimated from these readings (restricted \
                  maximum likelihood); each is a line of every budget."
        .into();
    section = section.table(table);
    for source in sources {
        if let Some(note) = &source.note {
            section = section.prose(format!("`{}`: {note}.", source.source));
        }
    }
    section
}
