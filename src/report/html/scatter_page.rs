//! What scatters, as a section of a page.

use super::{Align, Section, Table};
use crate::language::{Language, say};
use crate::report::scatter::{ScatterReport, cells, heads, is_worth_a_table, source_name};

/// Every source of scatter with its size and where that comes from; empty where there is only the readings' own noise.
pub(super) fn scatter(sources: &[ScatterReport], lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "what-scatters"));
    if !is_worth_a_table(sources) {
        return section;
    }
    let aligned = [Align::Left, Align::Right, Align::Right, Align::Left, Align::Right, Align::Left];
    let heads: Vec<(&str, Align)> = heads(lang).into_iter().zip(aligned).collect();
    let mut table = Table::new(&heads);
    table.small = true;
    for source in sources {
        table.row(cells(source, lang));
    }
    table.caption = say!(lang, "sources-of-scatter").into();
    table.note = say!(lang, "sd-standard-deviation-of-one-deviation-a").into();
    section = section.table(table);
    for source in sources {
        if let Some(note) = &source.note {
            section =
                section.prose(say!(lang, "source-note-sentence", source = source_name(&source.source, lang), note));
        }
    }
    section
}
